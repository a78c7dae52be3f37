// TGA, by lines of our own: stb_image, which Debian packages, takes mirrored pictures as they are stored,
// skips bytes where the first colors of a palette are left out, and fills what a cut file lacks with memory
// that nobody set.
#include <algorithm>
#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include "io/image/color_formats.h"
#include "io/image/image_cursor.h"
#include "io/utf8.h"

namespace meander {

namespace {

constexpr std::size_t tga_header_bytes = 18, tga_footer_bytes = 26;
constexpr std::uint64_t longest_tga_run = 128;

enum class TgaPixels : std::uint8_t { palette = 1, colors = 2, gray = 3 };

struct TgaHeader {
  TgaPixels pixels = TgaPixels::colors;
  bool runs = false, from_below = false, from_right = false;
  std::uint32_t width = 0, height = 0;
  std::size_t pixel_bytes = 0;
  std::uint32_t first_color = 0, colors = 0;  // of the palette
  std::size_t color_bytes = 0;                // of an entry of the palette
  std::size_t palette_at = 0, pixels_at = 0;
};

[[noreturn]] void fail_tga(const std::string& what) {
  throw ItemError(Status::unreadable, "the TGA file " + what);
}

bool has_tga_footer(std::span<const std::byte> bytes) {
  using namespace std::string_view_literals;
  constexpr std::string_view mark = "TRUEVISION-XFILE.\0"sv;
  if (bytes.size() < tga_header_bytes + tga_footer_bytes) return false;
  return text_of(bytes).ends_with(mark);
}

// Bytes of a color of so many bits, or 0.
std::size_t tga_color_bytes(std::uint32_t bits) {
  return bits == 15 || bits == 16 ? 2 : bits == 24 ? 3 : bits == 32 ? 4 : 0;
}

// None where the bytes cannot be a header. Sizes are not looked at, but that there are some.
std::optional<TgaHeader> tga_header(std::span<const std::byte> bytes) {
  if (bytes.size() < tga_header_bytes) return {};
  ImageCursor cursor(bytes, "TGA");
  const std::uint32_t id_bytes = cursor.u8(), has_palette = cursor.u8(), kind = cursor.u8();
  TgaHeader header;
  header.first_color = cursor.u16();
  header.colors = cursor.u16();
  const std::uint32_t palette_bits = cursor.u8();
  cursor.skip(4);  // where on a screen
  header.width = cursor.u16();
  header.height = cursor.u16();
  const std::uint32_t bits = cursor.u8(), descriptor = cursor.u8(), alpha_bits = descriptor & 15;

  header.runs = (kind & 8) != 0;
  if ((kind & ~8u) < 1 || (kind & ~8u) > 3 || has_palette > 1) return {};
  header.pixels = static_cast<TgaPixels>(kind & ~8u);
  switch (header.pixels) {
    case TgaPixels::palette:
      header.pixel_bytes = bits == 8 ? 1 : bits == 16 ? 2 : 0;
      if (has_palette == 0) return {};
      break;
    case TgaPixels::colors:
      header.pixel_bytes = tga_color_bytes(bits);
      break;
    case TgaPixels::gray:
      header.pixel_bytes = bits == 8 ? 1 : bits == 16 ? 2 : 0;
      break;
  }
  if (header.pixel_bytes == 0 || header.width == 0 || header.height == 0) return {};
  // Two bits for interleaved rows, which no program wrote.
  if ((descriptor & 0xC0) != 0 || (alpha_bits != 0 && alpha_bits != 1 && alpha_bits != 8)) return {};
  if (has_palette == 1) {
    header.color_bytes = tga_color_bytes(palette_bits);
    if (header.color_bytes == 0 || header.colors == 0) return {};
  } else if ((header.first_color != 0 || header.colors != 0) && !has_tga_footer(bytes)) {
    return {};
  }
  header.from_right = (descriptor & 0x10) != 0;
  header.from_below = (descriptor & 0x20) == 0;
  header.palette_at = tga_header_bytes + id_bytes;
  header.pixels_at = header.palette_at + (has_palette == 1 ? header.colors * header.color_bytes : 0);
  return header;
}

TgaHeader checked_tga_header(std::span<const std::byte> bytes) {
  const std::optional<TgaHeader> header = tga_header(bytes);
  if (!header) fail_tga("has a header that is none");
  check_image_size(header->width, header->height);
  if (header->pixels_at > bytes.size()) fail_tga("ends too early");
  const std::uint64_t pixels = std::uint64_t{header->width} * header->height,
                      left = bytes.size() - header->pixels_at;
  const std::uint64_t most =
      header->runs ? left / (1 + header->pixel_bytes) * longest_tga_run : left / header->pixel_bytes;
  if (pixels > most) fail_tga("ends too early");
  return *header;
}

std::array<std::uint8_t, 3> tga_color(std::span<const std::byte> bytes) {
  const auto byte = [&](std::size_t k) { return std::to_integer<std::uint32_t>(bytes[k]); };
  if (bytes.size() == 2) {
    const std::uint32_t color = byte(0) | byte(1) << 8;
    return {byte_of_value(color >> 10 & 31, 31), byte_of_value(color >> 5 & 31, 31),
            byte_of_value(color & 31, 31)};
  }
  return {static_cast<std::uint8_t>(byte(2)), static_cast<std::uint8_t>(byte(1)),
          static_cast<std::uint8_t>(byte(0))};
}

class TgaDecoder {
 public:
  TgaDecoder(const TgaHeader& header, std::span<const std::byte> bytes) : header_(header) {
    if (header.pixels != TgaPixels::palette) return;
    for (std::uint32_t k = 0; k < header.colors; ++k)
      palette_.push_back(
          tga_color(bytes.subspan(header.palette_at + k * header.color_bytes, header.color_bytes)));
  }

  std::array<std::uint8_t, 3> color(std::span<const std::byte> pixel) const {
    const auto first = std::to_integer<std::uint32_t>(pixel[0]);
    switch (header_.pixels) {
      case TgaPixels::gray: {
        const auto gray = static_cast<std::uint8_t>(first);
        return {gray, gray, gray};
      }
      case TgaPixels::colors:
        return tga_color(pixel);
      case TgaPixels::palette:
        break;
    }
    const std::uint32_t number =
        pixel.size() == 1 ? first : first | std::to_integer<std::uint32_t>(pixel[1]) << 8;
    if (number < header_.first_color || number - header_.first_color >= palette_.size())
      fail_tga("names a colour that its palette does not have");
    return palette_[number - header_.first_color];
  }

 private:
  const TgaHeader& header_;
  std::vector<std::array<std::uint8_t, 3>> palette_;
};

bool is_tga(std::span<const std::byte> bytes) { return tga_header(bytes).has_value(); }

ImageMemory memory_of_tga(std::span<const std::byte> bytes) {
  const TgaHeader header = checked_tga_header(bytes);
  return {std::uint64_t{3} * header.width * header.height, std::uint64_t{8} * header.colors + (1 << 16)};
}

ColorImage decode_color_tga(std::span<const std::byte> bytes, const CancelToken& cancel) {
  const TgaHeader header = checked_tga_header(bytes);
  const TgaDecoder decoder(header, bytes);
  ColorImage image;
  image.width = header.width;
  image.height = header.height;
  image.rgb.resize(std::size_t{3} * image.width * image.height);
  ImageCursor cursor(bytes, "TGA");
  cursor.skip(header.pixels_at);
  std::uint32_t left_of_packet = header.runs ? 0 : ~0u;
  bool repeats = false;
  std::array<std::uint8_t, 3> color{};
  for (std::size_t y = 0; y < image.height; ++y) {
    if (y % image_rows_between_checks == 0) cancel.check();
    const std::size_t row = header.from_below ? image.height - 1 - y : y;
    for (std::size_t x = 0; x < image.width; ++x) {
      bool is_new = !repeats;
      if (header.runs && left_of_packet == 0) {  // older programs let packets go on in the next row
        const std::uint32_t packet = cursor.u8();
        repeats = packet >= longest_tga_run;
        left_of_packet = packet % longest_tga_run + 1;
        is_new = true;
      }
      if (is_new) color = decoder.color(cursor.take(header.pixel_bytes));
      if (header.runs) --left_of_packet;
      const std::size_t column = header.from_right ? image.width - 1 - x : x;
      std::copy(color.begin(), color.end(), image.rgb.begin() + 3 * (row * image.width + column));
    }
  }
  return image;
}

}  // namespace

extern const ImageFormat tga_image_format = {"TGA", is_tga, memory_of_tga, decode_color_tga, false};

}  // namespace meander
