#include "io/archive/archive_writers.h"

#include <fmt/format.h>
#include <libdeflate.h>

#include <cstring>
#include <limits>
#include <stdexcept>

namespace meander {

namespace {

constexpr std::uint64_t tar_block = 512;

std::uint64_t size_of_pieces(std::initializer_list<std::string_view> pieces) {
  std::uint64_t bytes = 0;
  for (const std::string_view piece : pieces) bytes += piece.size();
  return bytes;
}

void append_little_endian(std::string& bytes, std::uint64_t value, std::size_t width) {
  for (std::size_t k = 0; k < width; ++k) bytes += static_cast<char>(value >> (8 * k) & 0xFF);
}

}  // namespace

void TarWriter::add(std::string_view name, std::initializer_list<std::string_view> pieces) {
  const std::uint64_t size = size_of_pieces(pieces);
  if (name.empty() || name.size() > 100)
    throw std::invalid_argument("TarWriter: a name of " + std::to_string(name.size()) + " bytes");
  if (size >> 33 != 0)
    throw std::invalid_argument("TarWriter: a member of " + std::to_string(size) + " bytes");
  std::string header(tar_block, '\0');
  const auto set = [&header](std::size_t at, std::string_view text) {
    header.replace(at, text.size(), text);
  };
  set(0, name);
  set(100, "0000644");
  set(108, "0000000");
  set(116, "0000000");
  set(124, fmt::format("{:011o}", size));
  set(136, "00000000000");
  set(148, "        ");  // counts as blanks in the sum
  set(156, "0");
  set(257, std::string_view("ustar\0"
                            "00",
                            8));
  unsigned sum = 0;
  for (const char c : header) sum += static_cast<unsigned char>(c);
  set(148, fmt::format("{:06o}", sum));
  header[154] = '\0';
  put_(header);
  for (const std::string_view piece : pieces) put_(piece);
  if (size % tar_block != 0) put_(std::string(tar_block - size % tar_block, '\0'));
}

void TarWriter::finish() { put_(std::string(2 * tar_block, '\0')); }

std::uint64_t TarWriter::member_bytes(std::uint64_t bytes) {
  return tar_block + (bytes + tar_block - 1) / tar_block * tar_block;
}

void StoredZipWriter::put(std::string_view bytes) {
  put_(bytes);
  written_ += bytes.size();
}

void StoredZipWriter::add(std::string_view name, std::initializer_list<std::string_view> pieces) {
  constexpr std::uint64_t limit = std::numeric_limits<std::uint32_t>::max();
  const std::uint64_t size = size_of_pieces(pieces);
  if (size >= limit || written_ + size + 30 + name.size() >= limit || name.size() > 0xFFFF ||
      members_ == 0xFFFE)
    throw std::length_error("a zip archive without ZIP64 ends at 4 GiB");
  std::uint32_t crc = 0;
  for (const std::string_view piece : pieces) crc = libdeflate_crc32(crc, piece.data(), piece.size());
  // From the version that is needed to the length of the extra field, as both headers have it.
  std::string common;
  append_little_endian(common, 20, 2);       // version 2.0
  append_little_endian(common, 1 << 11, 2);  // names are UTF-8
  append_little_endian(common, 0, 2);        // stored
  append_little_endian(common, 0, 2);        // midnight
  append_little_endian(common, 0x21, 2);     // 1 January 1980
  append_little_endian(common, crc, 4);
  append_little_endian(common, size, 4);
  append_little_endian(common, size, 4);
  append_little_endian(common, name.size(), 2);
  append_little_endian(common, 0, 2);
  const std::uint64_t begin = written_;
  put("PK\x03\x04" + common + std::string(name));
  for (const std::string_view piece : pieces) put(piece);
  directory_ += "PK\x01\x02";
  append_little_endian(directory_, 20, 2);
  directory_ += common;
  append_little_endian(directory_, 0, 2);  // comment
  append_little_endian(directory_, 0, 2);  // disk
  append_little_endian(directory_, 0, 2);  // attributes
  append_little_endian(directory_, 0, 4);
  append_little_endian(directory_, begin, 4);
  directory_ += name;
  ++members_;
}

void StoredZipWriter::finish() {
  const std::uint64_t begin = written_;
  if (begin + directory_.size() >= std::numeric_limits<std::uint32_t>::max())
    throw std::length_error("a zip archive without ZIP64 ends at 4 GiB");
  put(directory_);
  std::string end = "PK\x05\x06";
  append_little_endian(end, 0, 4);  // disks
  append_little_endian(end, members_, 2);
  append_little_endian(end, members_, 2);
  append_little_endian(end, directory_.size(), 4);
  append_little_endian(end, begin, 4);
  append_little_endian(end, 0, 2);
  put(end);
}

}  // namespace meander
