#include "io/store/journal.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>

#include "io/file/atomic_file.h"
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

}  // namespace

Journals::Journals(fs::path folder, std::uint64_t shards)
    : folder_(std::move(folder)), sizes_(shards, 0), dirty_(shards, false) {}

fs::path Journals::path(std::uint64_t shard) const { return folder_ / fmt::format("shard-{:06}.wal", shard); }

const FileDescriptor& Journals::open(std::uint64_t shard) {
  ++uses_;
  for (OpenFile& file : open_)
    if (file.shard == shard) {
      file.last_use = uses_;
      return file.file;
    }
  OpenFile opened{shard, uses_, open_file(path(shard), O_RDWR | O_CREAT)};
  if (open_.size() < most_open_files) return open_.emplace_back(std::move(opened)).file;
  const auto oldest = std::min_element(open_.begin(), open_.end(), [](const OpenFile& a, const OpenFile& b) {
    return a.last_use < b.last_use;
  });
  *oldest = std::move(opened);
  return oldest->file;
}

void Journals::replay(std::uint64_t shard, std::uint64_t begin, std::uint64_t end,
                      const std::function<void(const RecordHeader&, std::uint64_t)>& found) {
  sizes_[shard] = 0;
  if (!fs::exists(path(shard))) return;
  const FileDescriptor& file = open(shard);
  const std::uint64_t size = file_size(file, path(shard));
  std::vector<std::byte> buffer(std::size_t{1} << 20);
  std::array<std::byte, record_header_bytes> head;
  std::uint64_t offset = 0;
  while (offset + record_header_bytes <= size) {
    read_at(file, head, offset, path(shard));
    const auto header = read_record_header(head);
    if (!header || header->row < begin || header->row >= end) break;
    if (header->payload_bytes > size - offset - record_header_bytes) break;
    if (!payload_is_whole(file, *header, offset + record_header_bytes, buffer, path(shard))) break;
    found(*header, offset);
    offset += record_header_bytes + header->payload_bytes;
  }
  sizes_[shard] = offset;
  if (offset < size) truncate_file(file, offset, path(shard));
}

template <class Write>
std::uint64_t Journals::append_by(std::uint64_t shard, const Write& write) {
  const FileDescriptor& file = open(shard);
  const std::uint64_t offset = sizes_[shard];
  try {
    sizes_[shard] += write(file, offset);
  } catch (...) {
    // Room for others; if even this fails, the next record overwrites the torn one or replay cuts it off.
    if (::ftruncate(file.get(), static_cast<off_t>(offset)) != 0) dirty_[shard] = true;
    throw;
  }
  dirty_[shard] = true;
  return offset;
}

std::uint64_t Journals::append(std::uint64_t shard, std::span<const std::byte> record) {
  return append_by(shard, [&](const FileDescriptor& file, std::uint64_t offset) {
    write_at(file, record, offset, path(shard));
    return record.size();
  });
}

std::uint64_t Journals::append_in_parts(std::uint64_t shard, std::size_t head_bytes,
                                        const std::function<std::span<const std::byte>()>& next,
                                        const std::function<std::vector<std::byte>()>& head) {
  return append_by(shard, [&](const FileDescriptor& file, std::uint64_t offset) {
    std::uint64_t end = offset + head_bytes;
    for (std::span<const std::byte> part = next(); !part.empty(); part = next()) {
      write_at(file, part, end, path(shard));
      end += part.size();
    }
    write_at(file, head(), offset, path(shard));
    return end - offset;
  });
}

std::size_t Journals::read(std::uint64_t shard, std::uint64_t offset, std::span<std::byte> bytes) {
  return read_at(open(shard), bytes, offset, path(shard));
}

void Journals::sync() {
  for (std::uint64_t shard = 0; shard < dirty_.size(); ++shard) {
    if (!dirty_[shard]) continue;
    sync_data(open(shard), path(shard));
    dirty_[shard] = false;
  }
}

void Journals::remove(std::uint64_t shard) {
  std::erase_if(open_, [&](const OpenFile& file) { return file.shard == shard; });
  ::unlink(path(shard).c_str());
  sizes_[shard] = 0;
  dirty_[shard] = false;
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
