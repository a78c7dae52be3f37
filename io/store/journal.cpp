#include "io/store/journal.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>

#include "io/file/atomic_file.h"
#include "io/file/directory.h"
#include "io/store/crc32c.h"

namespace meander::store {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t most_open_files = 64;
constexpr std::size_t begun_record_bytes = 16;

std::array<std::byte, begun_record_bytes> begun_record(std::uint64_t row) {
  std::array<std::byte, begun_record_bytes> record{};
  std::memcpy(record.data(), &row, sizeof row);
  // The complement: sixteen zero bytes, which a power cut may leave behind, are not a valid record.
  const std::uint32_t check = ~crc32c(std::span<const std::byte>(record).first(12));
  std::memcpy(record.data() + 12, &check, sizeof check);
  return record;
}

// Checks the payload that follows a record header.
bool payload_is_whole(const FileDescriptor& file, const RecordHeader& header, std::uint64_t offset,
                      std::vector<std::byte>& buffer, const fs::path& path) {
  std::uint32_t checksum = 0;
  for (std::uint64_t left = header.payload_bytes; left > 0;) {
    const std::size_t count = static_cast<std::size_t>(std::min<std::uint64_t>(left, buffer.size()));
    if (read_at(file, std::span(buffer).first(count), offset, path) < count) return false;
    checksum = crc32c(std::span<const std::byte>(buffer).first(count), checksum);
    offset += count;
    left -= count;
  }
  return checksum == header.payload_crc32c;
}

// Calls visit(header, offset of the record) for the records from the beginning of a file of `size` bytes, up
// to the first that is damaged or not whole by its length.
template <class Visit>
void walk_records(const FileDescriptor& file, const fs::path& path, std::uint64_t size,
                  std::uint64_t first_row, std::uint64_t end_row, const Visit& visit) {
  std::array<std::byte, record_header_bytes> head;
  std::uint64_t offset = 0;
  while (offset + record_header_bytes <= size) {
    if (read_at(file, head, offset, path) < head.size()) return;
    const auto header = read_record_header(head);
    if (!header || header->row < first_row || header->row >= end_row) return;
    if (header->payload_bytes > size - offset - record_header_bytes) return;
    visit(*header, offset);
    offset += record_header_bytes + header->payload_bytes;
  }
}

}  // namespace

Journals::Journals(fs::path folder, std::uint64_t count)
    : folder_(std::move(folder)), sizes_(count, 0), dirty_(count, false) {}

fs::path Journals::path(std::uint64_t journal) const {
  return folder_ / fmt::format("rows-{:06}.wal", journal);
}

const Journals::OpenFile& Journals::open(std::uint64_t journal) {
  ++uses_;
  for (OpenFile& file : open_)
    if (file.journal == journal) {
      file.last_use = uses_;
      return file;
    }
  fs::path name = path(journal);
  FileDescriptor opened = open_file(name, O_RDWR | O_CREAT);
  const auto is_older = [](const OpenFile& a, const OpenFile& b) { return a.last_use < b.last_use; };
  OpenFile& file = open_.size() < most_open_files ? open_.emplace_back()
                                                  : *std::min_element(open_.begin(), open_.end(), is_older);
  file = {journal, uses_, std::move(opened), std::move(name)};
  return file;
}

void Journals::replay(std::uint64_t journal, std::uint64_t first_row, std::uint64_t end_row,
                      const std::function<void(const RecordHeader&, std::uint64_t)>& found) {
  sizes_[journal] = 0;
  if (!fs::exists(path(journal))) return;
  const OpenFile& opened = open(journal);
  const std::uint64_t size = file_size(opened.file, opened.path);
  std::vector<std::byte> buffer(std::size_t{1} << 20);
  std::uint64_t end = 0;  // of the last whole record
  walk_records(opened.file, opened.path, size, first_row, end_row,
               [&](const RecordHeader& header, std::uint64_t offset) {
                 const std::uint64_t payload = offset + record_header_bytes;
                 // The records behind a damaged one may be whole.
                 if (!payload_is_whole(opened.file, header, payload, buffer, opened.path)) return;
                 found(header, offset);
                 end = payload + header.payload_bytes;
               });
  sizes_[journal] = end;
  dirty_[journal] = end > 0;  // nobody knows whether the process that wrote it came to sync it
  if (end < size) truncate_file(opened.file, end, opened.path);
}

template <class Write>
std::uint64_t Journals::append_by(std::uint64_t journal, const Write& write) {
  const OpenFile& file = open(journal);
  const std::uint64_t offset = sizes_[journal];
  try {
    sizes_[journal] += write(file, offset);
  } catch (...) {
    // Room for others; if even this fails, the next record overwrites the torn one or replay cuts it off.
    if (::ftruncate(file.file.get(), static_cast<off_t>(offset)) != 0) dirty_[journal] = true;
    throw;
  }
  dirty_[journal] = true;
  return offset;
}

std::uint64_t Journals::append(std::uint64_t journal, std::span<const std::byte> record) {
  return append_by(journal, [&](const OpenFile& file, std::uint64_t offset) {
    write_at(file.file, record, offset, file.path);
    return record.size();
  });
}

std::uint64_t Journals::append_in_parts(std::uint64_t journal, std::size_t head_bytes,
                                        const std::function<std::span<const std::byte>()>& next,
                                        const std::function<std::vector<std::byte>()>& head) {
  return append_by(journal, [&](const OpenFile& file, std::uint64_t offset) {
    std::uint64_t end = offset + head_bytes;
    for (std::span<const std::byte> part = next(); !part.empty(); part = next()) {
      write_at(file.file, part, end, file.path);
      end += part.size();
    }
    write_at(file.file, head(), offset, file.path);
    return end - offset;
  });
}

std::size_t Journals::read(std::uint64_t journal, std::uint64_t offset, std::span<std::byte> bytes) {
  const OpenFile& file = open(journal);
  return read_at(file.file, bytes, offset, file.path);
}

void Journals::sync(std::uint64_t first, std::uint64_t last) {
  bool any = false;
  for (std::uint64_t journal = first; journal < last; ++journal) {
    if (!dirty_[journal]) continue;
    const OpenFile& file = open(journal);
    sync_data(file.file, file.path);
    dirty_[journal] = false;
    any = true;
  }
  if (any) sync_folder(folder_);  // their names
}

void read_record_headers(const fs::path& journal, std::uint64_t first_row, std::uint64_t end_row,
                         const std::function<void(const RecordHeader&)>& found) {
  if (!fs::exists(journal)) return;
  const FileDescriptor file = open_file(journal, O_RDONLY);
  walk_records(file, journal, file_size(file, journal), first_row, end_row,
               [&](const RecordHeader& header, std::uint64_t) { found(header); });
}

BegunLog::BegunLog(fs::path path) : path_(std::move(path)), file_(open_file(path_, O_RDWR | O_CREAT)) {
  size_ = file_size(file_, path_) / begun_record_bytes * begun_record_bytes;
}

std::vector<std::uint64_t> BegunLog::read(std::uint64_t rows) const {
  std::vector<std::byte> bytes(size_);
  bytes.resize(read_at(file_, bytes, 0, path_) / begun_record_bytes * begun_record_bytes);
  std::vector<std::uint64_t> begun;
  for (std::size_t at = 0; at < bytes.size(); at += begun_record_bytes) {
    std::uint64_t row;
    std::memcpy(&row, &bytes[at], sizeof row);
    const auto expected = begun_record(row);
    if (row < rows && std::equal(expected.begin(), expected.end(), &bytes[at])) begun.push_back(row);
  }
  return begun;
}

void BegunLog::replace(std::span<const std::uint64_t> rows) {
  std::vector<std::byte> bytes;
  for (const std::uint64_t row : rows) {
    const auto record = begun_record(row);
    bytes.insert(bytes.end(), record.begin(), record.end());
  }
  replace_file(path_, bytes, FullDisk::stops_run);
  file_ = open_file(path_, O_RDWR | O_CREAT);
  size_ = bytes.size();
}

void BegunLog::append(std::uint64_t row) {
  write_at(file_, begun_record(row), size_, path_);  // a torn record is overwritten by the next
  size_ += begun_record_bytes;
}

}  // namespace meander::store
