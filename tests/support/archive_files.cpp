#include "support/archive_files.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <stdexcept>

#include "support/mesh_files.h"

namespace meander::test {

namespace {

std::string packed(std::string_view content, int window_bits, int level) {
  z_stream z{};
  if (deflateInit2(&z, level, Z_DEFLATED, window_bits, 8, Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::runtime_error("cannot deflate");
  std::string bytes(deflateBound(&z, content.size()) + 32, '\0');
  z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(content.data()));
  z.avail_in = static_cast<uInt>(content.size());
  z.next_out = reinterpret_cast<Bytef*>(bytes.data());
  z.avail_out = static_cast<uInt>(bytes.size());
  const int code = deflate(&z, Z_FINISH);
  bytes.resize(z.total_out);
  deflateEnd(&z);
  if (code != Z_STREAM_END) throw std::runtime_error("cannot deflate");
  return bytes;
}

void put(std::string& bytes, std::uint64_t value, int count) {
  for (int k = 0; k < count; ++k) bytes += static_cast<char>(value >> (8 * k) & 0xFF);
}

constexpr std::uint64_t wide = 0xFFFFFFFF;

struct Written {
  std::string data;
  std::uint64_t offset = 0, bytes = 0;
  std::uint32_t crc = 0;
  std::uint16_t method = 0;
};

// What local and central headers have in common.
void put_facts(std::string& bytes, const ArchiveEntry& entry, const Written& w, bool zip64) {
  put(bytes, entry.flags, 2);
  put(bytes, w.method, 2);
  put(bytes, 0, 4);
  put(bytes, w.crc, 4);
  put(bytes, zip64 ? wide : w.data.size(), 4);
  put(bytes, zip64 ? wide : w.bytes, 4);
  put(bytes, entry.name.size(), 2);
}

void put_central(std::string& bytes, const ArchiveEntry& entry, const Written& w, bool zip64) {
  bytes += "PK\1\2";
  put(bytes, entry.dos ? 20 : 3 << 8 | 20, 2);
  put(bytes, 20, 2);
  put_facts(bytes, entry, w, zip64);
  put(bytes, zip64 ? 28 + 5 : 0, 2);
  put(bytes, 0, 2 + 2 + 2);
  put(bytes, std::uint64_t{entry.mode} << 16, 4);
  put(bytes, zip64 ? wide : w.offset, 4);
  bytes += entry.name;
  if (!zip64) return;
  bytes += std::string("\x99\x99\1\0x", 5);  // a part of another kind is before
  put(bytes, 1, 2);
  put(bytes, 24, 2);
  put(bytes, w.bytes, 8);
  put(bytes, w.data.size(), 8);
  put(bytes, w.offset, 8);
}

void put_end64(std::string& bytes, std::uint64_t members, std::uint64_t length, std::uint64_t offset) {
  const std::uint64_t at = bytes.size();
  bytes += "PK\6\6";
  put(bytes, 44, 8);
  put(bytes, 45, 2);
  put(bytes, 45, 2);
  put(bytes, 0, 4 + 4);
  put(bytes, members, 8);
  put(bytes, members, 8);
  put(bytes, length, 8);
  put(bytes, offset, 8);
  bytes += "PK\6\7";
  put(bytes, 0, 4);
  put(bytes, at, 8);
  put(bytes, 1, 4);
}

std::string tar_header(const ArchiveEntry& entry, std::string name, std::uint64_t bytes) {
  std::string header(512, '\0');
  const auto set = [&](std::size_t at, std::string_view text) { header.replace(at, text.size(), text); };
  std::string prefix;
  if (name.size() > 100) {
    const std::size_t cut = name.find('/', name.size() - 101);
    prefix = name.substr(0, cut);
    name = name.substr(cut + 1);
  }
  set(0, name);
  set(100, "0000644");
  set(108, "0000000");
  set(116, "0000000");
  if (bytes < std::uint64_t{1} << 33)
    set(124, fmt::format("{:011o}", bytes));
  else
    for (int k = 0; k < 12; ++k)
      header[static_cast<std::size_t>(135 - k)] = k == 11 ? '\x80'
                                                  : k < 8 ? static_cast<char>(bytes >> (8 * k))
                                                          : '\0';
  set(136, "00000000000");
  header[156] = entry.type;
  set(157, entry.link.substr(0, 100));
  set(257, std::string_view("ustar\00000", 8));
  set(345, prefix);
  set(148, "        ");
  unsigned sum = 0;
  for (const char c : header) sum += static_cast<unsigned char>(c);
  set(148, fmt::format("{:06o}", sum));
  header[154] = '\0';
  return header;
}

void put_padded(std::string& bytes, std::string_view content) {
  bytes += content;
  bytes.resize((bytes.size() + 511) / 512 * 512);
}

std::string pax_record(std::string_view key, std::string_view value) {
  const std::size_t rest = key.size() + value.size() + 3;
  std::size_t length = rest + 1;
  while (std::to_string(length).size() + rest != length) ++length;
  return fmt::format("{} {}={}\n", length, key, value);
}

}  // namespace

std::string gzip_bytes(std::string_view content, int level) { return packed(content, 15 + 16, level); }

std::string zip_bytes(const std::vector<ArchiveEntry>& entries, bool zip64, std::string_view comment) {
  std::string bytes, central;
  for (const ArchiveEntry& entry : entries) {
    Written w;
    w.offset = bytes.size();
    w.data = entry.deflate ? packed(entry.content, -15, 1) : entry.content;
    w.bytes = entry.stated_bytes.value_or(entry.content.size());
    w.crc = entry.stated_crc.value_or(static_cast<std::uint32_t>(::crc32(
        0, reinterpret_cast<const Bytef*>(entry.content.data()), static_cast<uInt>(entry.content.size()))));
    w.method = entry.method != 8 ? entry.method : entry.deflate ? 8 : 0;
    bytes += "PK\3\4";
    put(bytes, 20, 2);
    put_facts(bytes, entry, w, false);
    put(bytes, 0, 2);
    bytes += entry.name + w.data;
    w.offset = entry.stated_offset.value_or(w.offset);
    put_central(central, entry, w, zip64);
  }
  const std::uint64_t offset = bytes.size();
  bytes += central;
  if (zip64) put_end64(bytes, entries.size(), central.size(), offset);
  bytes += "PK\5\6";
  put(bytes, 0, 4);
  put(bytes, entries.size(), 2);
  put(bytes, entries.size(), 2);
  put(bytes, zip64 ? wide : central.size(), 4);
  put(bytes, zip64 ? wide : offset, 4);
  put(bytes, comment.size(), 2);
  return bytes + std::string(comment);
}

std::string tar_bytes(const std::vector<ArchiveEntry>& entries, LongNames names) {
  std::string bytes;
  for (const ArchiveEntry& entry : entries) {
    const std::uint64_t size = entry.stated_bytes.value_or(entry.content.size());
    const bool is_long = entry.name.size() > 100;
    if (names == LongNames::pax) {
      const std::string records = pax_record("path", entry.name) + pax_record("size", std::to_string(size)) +
                                  (entry.link.empty() ? "" : pax_record("linkpath", entry.link));
      ArchiveEntry header;
      header.name = "pax";
      header.type = 'x';
      bytes += tar_header(header, header.name, records.size());
      put_padded(bytes, records);
    } else if (names == LongNames::gnu && is_long) {
      ArchiveEntry header;
      header.name = "././@LongLink";
      header.type = 'L';
      bytes += tar_header(header, header.name, entry.name.size() + 1);
      put_padded(bytes, entry.name + '\0');
    }
    const bool shortened = names != LongNames::ustar && is_long;
    bytes += tar_header(entry, shortened ? entry.name.substr(0, 100) : entry.name,
                        names == LongNames::pax ? 0 : size);
    put_padded(bytes, entry.content);
  }
  return bytes + std::string(1024, '\0');
}

std::vector<ArchiveEntry> entries_of(const std::filesystem::path& folder, const std::string& prefix) {
  std::vector<ArchiveEntry> entries;
  for (const auto& file : std::filesystem::recursive_directory_iterator(folder))
    if (file.is_regular_file()) {
      ArchiveEntry& entry = entries.emplace_back();
      entry.name = prefix + file.path().lexically_relative(folder).generic_string();
      entry.content = read_file(file.path());
    }
  std::sort(entries.begin(), entries.end(),
            [](const ArchiveEntry& a, const ArchiveEntry& b) { return a.name < b.name; });
  return entries;
}

}  // namespace meander::test
