#include "io/image/webp_codes.h"

#include <algorithm>
#include <array>
#include <vector>

#include "kernels/core/status.h"

namespace meander {

namespace {

constexpr std::size_t longest_webp_code = 15;
constexpr std::uint32_t webp_bytes_of_values = 256, webp_length_codes = 24, webp_distance_codes = 40;
// Entries of four bytes in the tables of one group, by the bits of the cache of colors, and what leads to
// the tables.
constexpr std::array<std::uint64_t, 12> webp_group_entries = {2954, 2956, 2958, 2962, 2970, 2986,
                                                              3018, 3082, 3212, 3468, 3980, 5004};
constexpr std::uint64_t webp_group_bytes = 768;
// A tile names a group by its number. Up to this number libwebp makes room for those that no tile names.
constexpr std::uint64_t most_unnamed_webp_groups = 1000, most_webp_groups = 65536;
// Five codes of one symbol each.
constexpr std::uint64_t bits_of_shortest_webp_group = 20;

[[noreturn]] void fail_webp_codes(const char* what) {
  throw ItemError(Status::unreadable, std::string("the WebP file ") + what);
}

class WebpBits {
 public:
  explicit WebpBits(std::span<const std::byte> bytes) : bytes_(bytes) {}

  std::uint32_t take(unsigned count) {
    std::uint32_t value = 0;
    for (unsigned k = 0; k < count; ++k) value |= bit() << k;
    return value;
  }
  std::uint32_t bit() {
    if (at_ / 8 >= bytes_.size()) fail_webp_codes("ends too early");
    const std::uint32_t bit = std::to_integer<std::uint32_t>(bytes_[at_ / 8]) >> (at_ % 8) & 1;
    ++at_;
    return bit;
  }
  std::uint64_t left() const { return std::uint64_t{8} * bytes_.size() - at_; }

 private:
  std::span<const std::byte> bytes_;
  std::uint64_t at_ = 0;
};

// A canonical prefix code: one symbol alone takes no bits, any other code is complete.
class WebpPrefixCode {
 public:
  explicit WebpPrefixCode(std::span<const std::uint8_t> lengths) {
    for (const std::uint8_t length : lengths) ++counts_[length];
    counts_[0] = 0;
    std::array<std::uint32_t, longest_webp_code + 2> begin{};
    std::int64_t open = 1;
    for (std::size_t length = 1; length <= longest_webp_code; ++length) {
      open = 2 * open - counts_[length];
      begin[length + 1] = begin[length] + counts_[length];
    }
    symbols_.resize(begin.back());
    for (std::uint32_t symbol = 0; symbol < lengths.size(); ++symbol)
      if (lengths[symbol] != 0) symbols_[begin[lengths[symbol]]++] = symbol;
    if (symbols_.empty() || (symbols_.size() > 1 && open != 0)) fail_webp_codes("has a code that is none");
  }

  std::uint32_t read(WebpBits& bits) const {
    if (symbols_.size() == 1) return symbols_.front();
    std::uint32_t code = 0, first = 0, at = 0;
    for (std::size_t length = 1; length <= longest_webp_code; ++length) {
      code |= bits.bit();
      if (code - first < counts_[length]) return symbols_[at + code - first];
      at += counts_[length];
      first = (first + counts_[length]) << 1;
      code <<= 1;
    }
    fail_webp_codes("has a code that is none");
  }

 private:
  std::array<std::uint32_t, longest_webp_code + 1> counts_{};
  std::vector<std::uint32_t> symbols_;
};

WebpPrefixCode read_webp_code(WebpBits& bits, std::uint32_t symbols) {
  std::vector<std::uint8_t> lengths(symbols, 0);
  const auto set = [&](std::uint32_t symbol) {
    if (symbol < symbols) lengths[symbol] = 1;
  };
  if (bits.bit() == 1) {
    const bool two = bits.bit() == 1;
    set(bits.take(bits.bit() == 1 ? 8 : 1));
    if (two) set(bits.take(8));
    return WebpPrefixCode(lengths);
  }
  constexpr std::array<std::uint8_t, 19> order = {17, 18, 0, 1,  2,  3,  4,  5,  16, 6,
                                                  7,  8,  9, 10, 11, 12, 13, 14, 15};
  std::array<std::uint8_t, 19> of_lengths{};
  const std::uint32_t count = bits.take(4) + 4;
  for (std::uint32_t k = 0; k < count; ++k) of_lengths[order[k]] = static_cast<std::uint8_t>(bits.take(3));
  std::uint32_t most = symbols;
  if (bits.bit() == 1) {
    const unsigned width = 2 + 2 * bits.take(3);
    most = 2 + bits.take(width);
    if (most > symbols) fail_webp_codes("has a code that is none");
  }
  const WebpPrefixCode code(of_lengths);
  std::uint8_t previous = 8;
  for (std::uint32_t symbol = 0; symbol < symbols && most > 0; --most) {
    const std::uint32_t length = code.read(bits);
    if (length < 16) {
      lengths[symbol++] = static_cast<std::uint8_t>(length);
      if (length != 0) previous = static_cast<std::uint8_t>(length);
      continue;
    }
    const std::uint32_t times = length == 16   ? 3 + bits.take(2)
                                : length == 17 ? 3 + bits.take(3)
                                               : 11 + bits.take(7);
    if (times > symbols - symbol) fail_webp_codes("has a code that is none");
    std::fill_n(lengths.begin() + symbol, times, length == 16 ? previous : std::uint8_t{0});
    symbol += times;
  }
  return WebpPrefixCode(lengths);
}

std::uint32_t read_webp_cache_bits(WebpBits& bits) {
  if (bits.bit() == 0) return 0;
  const std::uint32_t cache_bits = bits.take(4);
  if (cache_bits < 1 || cache_bits > 11) fail_webp_codes("has a cache of an unknown size");
  return cache_bits;
}

// Reads over pixels that are no picture.
void skip_webp_pixels(WebpBits& bits, std::uint64_t pixels) {
  const std::uint32_t cache_bits = read_webp_cache_bits(bits);
  const std::uint32_t colors = cache_bits == 0 ? 0 : 1u << cache_bits;
  const WebpPrefixCode green = read_webp_code(bits, webp_bytes_of_values + webp_length_codes + colors),
                       red = read_webp_code(bits, webp_bytes_of_values),
                       blue = read_webp_code(bits, webp_bytes_of_values),
                       alpha = read_webp_code(bits, webp_bytes_of_values),
                       distance = read_webp_code(bits, webp_distance_codes);
  const auto number = [&](std::uint32_t prefix) -> std::uint64_t {
    if (prefix < 4) return prefix + 1;
    const std::uint32_t extra = (prefix - 2) >> 1;
    return (std::uint64_t{2 + (prefix & 1)} << extra) + bits.take(extra) + 1;
  };
  for (std::uint64_t done = 0; done < pixels;) {
    const std::uint32_t symbol = green.read(bits);
    if (symbol < webp_bytes_of_values) {
      red.read(bits);
      blue.read(bits);
      alpha.read(bits);
      ++done;
    } else if (symbol < webp_bytes_of_values + webp_length_codes) {
      done += number(symbol - webp_bytes_of_values);
      number(distance.read(bits));
    } else {
      ++done;
    }
  }
}

}  // namespace

std::uint64_t bytes_of_webp_codes(std::span<const std::byte> stream) {
  WebpBits bits(stream);
  bits.take(8);
  std::uint64_t width = bits.take(14) + 1;
  const std::uint64_t height = bits.take(14) + 1;
  bits.take(4);
  const auto tiles = [&](std::uint32_t shift) {
    const std::uint64_t side = std::uint64_t{1} << shift;
    return ((width + side - 1) >> shift) * ((height + side - 1) >> shift);
  };
  std::uint64_t bytes = 0;
  std::array<bool, 4> used{};
  while (bits.bit() == 1) {
    const std::uint32_t kind = bits.take(2);
    if (used[kind]) fail_webp_codes("has a transformation twice");
    used[kind] = true;
    if (kind == 2) continue;
    if (kind == 3) {
      const std::uint32_t colors = bits.take(8) + 1;
      skip_webp_pixels(bits, colors);
      const std::uint32_t shift = colors > 16 ? 0 : colors > 4 ? 1 : colors > 2 ? 2 : 3;
      width = (width + (1u << shift) - 1) >> shift;
      continue;
    }
    const std::uint64_t pixels = tiles(bits.take(3) + 2);
    skip_webp_pixels(bits, pixels);
    bytes += 4 * pixels;
  }
  const std::uint32_t cache_bits = read_webp_cache_bits(bits);
  std::uint64_t groups = 1;
  if (bits.bit() == 1) {
    const std::uint64_t pixels = tiles(bits.take(3) + 2);
    bytes += 4 * pixels;
    groups = std::min({std::max(pixels, most_unnamed_webp_groups), most_webp_groups,
                       bits.left() / bits_of_shortest_webp_group + 1});
  }
  return bytes + groups * (4 * webp_group_entries[cache_bits] + webp_group_bytes);
}

}  // namespace meander
