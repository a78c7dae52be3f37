// Append-only files of a run directory: journals of finished rows, and the log of begun rows. Every record
// carries checksums; what a kill left half-written is cut off at the next start.
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

// Rows of a journal: journal j has the rows from j * journal_rows on.
inline constexpr std::uint64_t journal_rows = 4096;

// The journals journal/rows-NNNNNN.wal of a run, by number. At most 64 are open at a time.
class Journals {
 public:
  Journals(std::filesystem::path folder, std::uint64_t count);

  // Calls found(header, offset of the record) for every whole record of the journal whose row lies in
  // [first_row, end_row), in the order of the file, up to the first whose header is damaged, and cuts off
  // what follows the last one. Reads the whole file.
  void replay(std::uint64_t journal, std::uint64_t first_row, std::uint64_t end_row,
              const std::function<void(const RecordHeader&, std::uint64_t)>& found);
  // Appends one record in one write; returns its offset. When the disk is full nothing has changed.
  std::uint64_t append(std::uint64_t journal, std::span<const std::byte> record);
  // Appends a record whose parts are made while it is written: `next` gives one after the other, an empty one
  // at the end; then `head`, which is written last, what stands before them, head_bytes long. Without it the
  // record is invalid, whenever this process is killed. Returns its offset. When anything throws, nothing has
  // changed.
  std::uint64_t append_in_parts(std::uint64_t journal, std::size_t head_bytes,
                                const std::function<std::span<const std::byte>()>& next,
                                const std::function<std::vector<std::byte>()>& head);
  // Reads up to bytes.size() bytes from `offset` on; returns how many.
  std::size_t read(std::uint64_t journal, std::uint64_t offset, std::span<std::byte> bytes);
  // Brings what was appended since the last sync to the disk: of one journal, or of all.
  void sync(std::uint64_t journal) { sync(journal, journal + 1); }
  void sync() { sync(0, sizes_.size()); }
  std::filesystem::path path(std::uint64_t journal) const;

 private:
  struct OpenFile {
    std::uint64_t journal = 0, last_use = 0;
    FileDescriptor file;
    std::filesystem::path path;
  };
  const OpenFile& open(std::uint64_t journal);
  void sync(std::uint64_t first, std::uint64_t last);
  // Calls write(file, offset) for the end of the journal; returns the offset.
  template <class Write>
  std::uint64_t append_by(std::uint64_t journal, const Write& write);

  std::filesystem::path folder_;
  std::vector<OpenFile> open_;
  std::vector<std::uint64_t> sizes_;
  std::vector<bool> dirty_;
  std::uint64_t uses_ = 0;
};

// Calls found(header) for every record of a journal of which all bytes are there, as `replay` does, but reads
// the headers alone and changes nothing: another process may be writing to it. A missing file has none.
void read_record_headers(const std::filesystem::path& journal, std::uint64_t first_row, std::uint64_t end_row,
                         const std::function<void(const RecordHeader&)>& found);

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
