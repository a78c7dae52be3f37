// Append-only files of a run directory: one journal of finished rows per internal shard, and the log of begun
// rows. Every record carries checksums; what a kill left half-written is cut off at the next start.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "io/file/file_descriptor.h"
#include "io/store/row_codec.h"

namespace meander::store {

// The journals journal/shard-NNNNNN.wal of all shards that are not sealed. At most 64 are open at a time.
class Journals {
 public:
  Journals(std::filesystem::path folder, std::uint64_t shards);

  // Calls found(header, offset of the record) for every whole record of the shard's journal whose row lies in
  // [begin, end), in the order of the file, and cuts off what follows the last one. Reads the whole file.
  void replay(std::uint64_t shard, std::uint64_t begin, std::uint64_t end,
              const std::function<void(const RecordHeader&, std::uint64_t)>& found);
  // Appends one record in one write; returns its offset. When the disk is full nothing has changed.
  std::uint64_t append(std::uint64_t shard, std::span<const std::byte> record);
  // Appends a record whose parts are made while it is written: `next` gives one after the other, an empty one
  // at the end; then `head`, which is written last, what stands before them, head_bytes long. Without it the
  // record is none, whenever this process is killed. Returns its offset. When anything throws, nothing has
  // changed.
  std::uint64_t append_in_parts(std::uint64_t shard, std::size_t head_bytes,
                                const std::function<std::span<const std::byte>()>& next,
                                const std::function<std::vector<std::byte>()>& head);
  // Reads up to bytes.size() bytes from `offset` on; returns how many.
  std::size_t read(std::uint64_t shard, std::uint64_t offset, std::span<std::byte> bytes);
  std::uint64_t bytes(std::uint64_t shard) const { return sizes_[shard]; }
  void sync();  // of everything appended since the last sync
  void remove(std::uint64_t shard);

 private:
  struct OpenFile {
    std::uint64_t shard = 0, last_use = 0;
    FileDescriptor file;
  };
  std::filesystem::path path(std::uint64_t shard) const;
  const FileDescriptor& open(std::uint64_t shard);
  // Calls write(file, offset) for the end of the journal; returns the offset.
  template <class Write>
  std::uint64_t append_by(std::uint64_t shard, const Write& write);

  std::filesystem::path folder_;
  std::vector<OpenFile> open_;
  std::vector<std::uint64_t> sizes_;
  std::vector<bool> dirty_;
  std::uint64_t uses_ = 0;
};

// begun.log: a record of 16 bytes for every row that was begun.
class BegunLog {
 public:
  explicit BegunLog(std::filesystem::path path);
  // All rows below `rows` in the log, in its order; records that a crash damaged are left out.
  std::vector<std::uint64_t> read(std::uint64_t rows) const;
  void replace(std::span<const std::uint64_t> rows);  // by these rows alone, in one step
  void append(std::uint64_t row);

 private:
  std::filesystem::path path_;
  FileDescriptor file_;
  std::uint64_t size_ = 0;
};

}  // namespace meander::store
