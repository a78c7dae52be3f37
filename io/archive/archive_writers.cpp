#include "io/archive/archive_writers.h"

#include <fmt/format.h>
#include <libdeflate.h>

#include <limits>
#include <stdexcept>

#include "io/mesh/append_numbers.h"

namespace meander {

namespace {

constexpr std::uint64_t tar_block = 512;

std::uint64_t size_of_pieces(std::initializer_list<std::string_view> pieces) {
  std::uint64_t bytes = 0;
  for (const std::string_view piece : pieces) bytes += piece.size();
  return bytes;
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
  append_little_endian(common, std::uint16_t{20});       // version 2.0
  append_little_endian(common, std::uint16_t{1 << 11});  // names are UTF-8
  append_little_endian(common, std::uint16_t{0});        // stored
  append_little_endian(common, std::uint16_t{0});        // midnight
  append_little_endian(common, std::uint16_t{0x21});     // 1 January 1980
  append_little_endian(common, crc);
  append_little_endian(common, static_cast<std::uint32_t>(size));
  append_little_endian(common, static_cast<std::uint32_t>(size));
  append_little_endian(common, static_cast<std::uint16_t>(name.size()));
  append_little_endian(common, std::uint16_t{0});
  const std::uint64_t begin = written_;
  put("PK\x03\x04" + common + std::string(name));
  for (const std::string_view piece : pieces) put(piece);
  directory_ += "PK\x01\x02";
  append_little_endian(directory_, std::uint16_t{20});
  directory_ += common;
  append_little_endian(directory_, std::uint16_t{0});  // comment
  append_little_endian(directory_, std::uint16_t{0});  // disk
  append_little_endian(directory_, std::uint16_t{0});  // attributes
  append_little_endian(directory_, std::uint32_t{0});
  append_little_endian(directory_, static_cast<std::uint32_t>(begin));
  directory_ += name;
  ++members_;
}

void StoredZipWriter::finish() {
  const std::uint64_t begin = written_;
  if (begin + directory_.size() >= std::numeric_limits<std::uint32_t>::max())
    throw std::length_error("a zip archive without ZIP64 ends at 4 GiB");
  put(directory_);
  std::string end = "PK\x05\x06";
  append_little_endian(end, std::uint32_t{0});  // disks
  append_little_endian(end, members_);
  append_little_endian(end, members_);
  append_little_endian(end, static_cast<std::uint32_t>(directory_.size()));
  append_little_endian(end, static_cast<std::uint32_t>(begin));
  append_little_endian(end, std::uint16_t{0});
  put(end);
}

}  // namespace meander
