#include "io/store/chunk_codec.h"

#include <zlib.h>

#include <algorithm>
#include <cstring>

namespace meander::store {

namespace {

constexpr std::size_t checksum_bytes = 4;

// Byte b of every element stands together, for b = 0, 1, ... (H5Z_FILTER_SHUFFLE; bytes after the last whole
// element stay where they are).
void shuffle(std::span<const std::byte> in, std::size_t element_size, std::byte* out) {
  const std::size_t elements = in.size() / element_size;
  if (element_size == 4) {
    for (std::size_t i = 0; i < elements; ++i) {
      std::uint32_t word;
      std::memcpy(&word, in.data() + 4 * i, 4);
      out[i] = static_cast<std::byte>(word);
      out[elements + i] = static_cast<std::byte>(word >> 8);
      out[2 * elements + i] = static_cast<std::byte>(word >> 16);
      out[3 * elements + i] = static_cast<std::byte>(word >> 24);
    }
  } else {
    for (std::size_t byte = 0; byte < element_size; ++byte)
      for (std::size_t i = 0; i < elements; ++i) out[byte * elements + i] = in[i * element_size + byte];
  }
  const std::size_t whole = elements * element_size;
  std::copy(in.begin() + static_cast<std::ptrdiff_t>(whole), in.end(), out + whole);
}

void unshuffle(std::span<const std::byte> in, std::size_t element_size, std::byte* out) {
  const std::size_t elements = in.size() / element_size;
  for (std::size_t byte = 0; byte < element_size; ++byte)
    for (std::size_t i = 0; i < elements; ++i) out[i * element_size + byte] = in[byte * elements + i];
  const std::size_t whole = elements * element_size;
  std::copy(in.begin() + static_cast<std::ptrdiff_t>(whole), in.end(), out + whole);
}

void append_checksum(std::vector<std::byte>& out, std::size_t begin) {
  const std::uint32_t checksum = fletcher32(std::span<const std::byte>(out).subspan(begin));
  for (int shift = 0; shift < 32; shift += 8) out.push_back(static_cast<std::byte>(checksum >> shift));
}

}  // namespace

std::uint32_t fletcher32(std::span<const std::byte> bytes) {
  // The sums must end in 1 .. 65535 for data that is not all zero, as the folding of HDF5 leaves them. 64-bit
  // accumulators need no folding for 2^16 words, and the sum of sums is taken from weights so that the loop
  // has no chain of dependent additions.
  constexpr std::size_t block_words = std::size_t{1} << 12;
  const auto fold = [](std::uint64_t sum) {
    while (sum >> 16) sum = (sum & 0xFFFF) + (sum >> 16);
    return sum;
  };
  const std::byte* at = bytes.data();
  std::size_t words = bytes.size() / 2;
  std::uint64_t sum1 = 0, sum2 = 0;
  while (words > 0) {
    const std::size_t count = std::min(words, block_words);
    std::uint64_t plain = 0, weighted = 0;
    for (std::size_t i = 0; i < count; ++i) {
      std::uint16_t little;
      std::memcpy(&little, at + 2 * i, 2);
      const std::uint32_t word = static_cast<std::uint16_t>(little << 8 | little >> 8);
      plain += word;
      weighted += word * static_cast<std::uint32_t>(count - i);  // < 2^16 * 2^12
    }
    sum2 = fold(sum2 + count * sum1 + weighted);
    sum1 = fold(sum1 + plain);
    at += 2 * count;
    words -= count;
  }
  if (bytes.size() % 2 != 0) {
    sum1 = fold(sum1 + (std::to_integer<std::uint64_t>(*at) << 8));
    sum2 = fold(sum2 + sum1);
  }
  return static_cast<std::uint32_t>(sum2 << 16 | sum1);
}

void append_filtered(std::span<const std::byte> chunk, std::size_t element_size, Compression compression,
                     std::vector<std::byte>& out) {
  const std::size_t begin = out.size();
  if (compression == Compression::none) {
    out.insert(out.end(), chunk.begin(), chunk.end());
    append_checksum(out, begin);
    return;
  }
  std::vector<std::byte> shuffled;
  std::span<const std::byte> source = chunk;
  if (element_size > 1) {
    shuffled.resize(chunk.size());
    shuffle(chunk, element_size, shuffled.data());
    source = shuffled;
  }
  uLongf length = compressBound(static_cast<uLong>(source.size()));
  out.resize(begin + length);
  // Cannot fail but for memory: the output has room for the worst case.
  if (compress2(reinterpret_cast<Bytef*>(out.data() + begin), &length,
                reinterpret_cast<const Bytef*>(source.data()), static_cast<uLong>(source.size()), 1) != Z_OK)
    throw std::bad_alloc();
  out.resize(begin + length);
  append_checksum(out, begin);
}

bool unfilter(std::span<const std::byte> filtered, std::size_t element_size, Compression compression,
              std::span<std::byte> chunk) {
  if (filtered.size() < checksum_bytes) return false;
  const std::span<const std::byte> body = filtered.first(filtered.size() - checksum_bytes);
  std::uint32_t checksum = 0;
  for (std::size_t i = 0; i < checksum_bytes; ++i)
    checksum |= std::to_integer<std::uint32_t>(filtered[body.size() + i]) << (8 * i);
  if (checksum != fletcher32(body)) return false;
  if (compression == Compression::none) {
    if (body.size() != chunk.size()) return false;
    std::copy(body.begin(), body.end(), chunk.begin());
    return true;
  }
  std::vector<std::byte> shuffled(element_size > 1 ? chunk.size() : 0);
  std::byte* target = element_size > 1 ? shuffled.data() : chunk.data();
  uLongf length = static_cast<uLongf>(chunk.size());
  if (uncompress(reinterpret_cast<Bytef*>(target), &length, reinterpret_cast<const Bytef*>(body.data()),
                 static_cast<uLong>(body.size())) != Z_OK ||
      length != chunk.size())
    return false;
  if (element_size > 1) unshuffle(shuffled, element_size, chunk.data());
  return true;
}

}  // namespace meander::store
