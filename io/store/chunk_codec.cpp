#include "io/store/chunk_codec.h"

#include <libdeflate.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <initializer_list>
#include <memory>
#include <new>
#include <string>

namespace meander::store {

namespace {

constexpr std::size_t checksum_bytes = 4;

// Groups byte b of all elements, for b = 0, 1, ... (H5Z_FILTER_SHUFFLE; bytes after the last whole
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

// True when coding the bytes one by one could not save a sixteenth of them: their collision entropy, which is
// a lower bound of Shannon's, is above 7.5 bits. Of many bytes a quarter is looked at, in pieces that
// hold all columns of short periods. Exact in integers, so that it decides alike everywhere.
bool hardly_compressible(std::span<const std::byte> bytes) {
  constexpr std::size_t piece = 256, few = 16384;
  const std::size_t step = bytes.size() > few ? 4 * piece : piece;
  std::array<std::array<std::uint32_t, 256>, 4> counts{};  // four, so that equal neighbors do not wait
  std::uint64_t total = 0;
  for (std::size_t begin = 0; begin < bytes.size(); begin += step) {
    const std::span<const std::byte> looked = bytes.subspan(begin, std::min(piece, bytes.size() - begin));
    for (std::size_t i = 0; i < looked.size(); ++i) ++counts[i % 4][std::to_integer<std::size_t>(looked[i])];
    total += looked.size();
  }
  std::uint64_t pairs = 0;  // equal bytes at two different places, ordered
  for (std::size_t value = 0; value < 256; ++value) {
    const std::uint64_t count =
        std::uint64_t{counts[0][value]} + counts[1][value] + counts[2][value] + counts[3][value];
    pairs += count * (count - (count > 0));
  }
  constexpr std::uint64_t two_to_7_5 = 181;
  return pairs * two_to_7_5 < total * total;
}

// One for each thread: it takes longer to set up than a chunk to compress.
libdeflate_compressor& thread_compressor() {
  struct Free {
    void operator()(libdeflate_compressor* c) const { libdeflate_free_compressor(c); }
  };
  static thread_local const std::unique_ptr<libdeflate_compressor, Free> compressor(
      libdeflate_alloc_compressor(1));
  if (!compressor) throw std::bad_alloc();
  return *compressor;
}
libdeflate_decompressor& thread_decompressor() {
  struct Free {
    void operator()(libdeflate_decompressor* d) const { libdeflate_free_decompressor(d); }
  };
  static thread_local const std::unique_ptr<libdeflate_decompressor, Free> decompressor(
      libdeflate_alloc_decompressor());
  if (!decompressor) throw std::bad_alloc();
  return *decompressor;
}

void append_bytes(std::vector<std::byte>& out, std::initializer_list<unsigned> bytes) {
  for (const unsigned byte : bytes) out.push_back(static_cast<std::byte>(byte));
}

// Blocks of bytes as they are (RFC 1951, 3.2.4), none of them the last; the stream must be at a whole byte.
void append_stored_blocks(std::span<const std::byte> bytes, std::vector<std::byte>& out) {
  constexpr std::size_t largest = 65535;
  for (std::size_t at = 0; at < bytes.size(); at += largest) {
    const std::span<const std::byte> block = bytes.subspan(at, std::min(largest, bytes.size() - at));
    const auto length = static_cast<unsigned>(block.size());
    append_bytes(out, {0, length & 255, length >> 8, ~length & 255, ~length >> 8 & 255});
    out.insert(out.end(), block.begin(), block.end());
  }
}

// Appends one zlib stream (RFC 1950): leading planes of random mantissa bits, three of four in points and
// normals, are stored, the others compressed at level 1. Any inflate reads it; the size is that of level 1
// throughout, the time a fraction.
void deflate_planes(std::span<const std::byte> bytes, std::size_t plane_bytes, std::vector<std::byte>& out) {
  append_bytes(out, {0x78, 0x01});
  std::size_t stored = 0;
  while (stored < bytes.size() &&
         hardly_compressible(bytes.subspan(stored, std::min(plane_bytes, bytes.size() - stored))))
    stored += std::min(plane_bytes, bytes.size() - stored);
  append_stored_blocks(bytes.first(stored), out);
  const std::span<const std::byte> rest = bytes.subspan(stored);
  libdeflate_compressor& compressor = thread_compressor();
  const std::size_t begin = out.size();
  out.resize(begin + libdeflate_deflate_compress_bound(&compressor, rest.size()));
  const std::size_t length = libdeflate_deflate_compress(&compressor, rest.data(), rest.size(),
                                                         out.data() + begin, out.size() - begin);
  if (length == 0 || out.size() - begin < length)
    throw ItemError(Status::internal, "libdeflate found its own bound too small");
  out.resize(begin + length);
  const std::uint32_t check = libdeflate_adler32(1, bytes.data(), bytes.size());
  append_bytes(out, {check >> 24, check >> 16 & 255, check >> 8 & 255, check & 255});
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
  deflate_planes(source, std::max<std::size_t>(1, source.size() / element_size), out);
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
  if (libdeflate_zlib_decompress(&thread_decompressor(), body.data(), body.size(), target, chunk.size(),
                                 nullptr) != LIBDEFLATE_SUCCESS)
    return false;
  if (element_size > 1) unshuffle(shuffled, element_size, chunk.data());
  return true;
}

}  // namespace meander::store
