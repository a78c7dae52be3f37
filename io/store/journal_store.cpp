#include "io/store/journal_store.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "io/store/chunk_codec.h"
#include "io/store/crc32c.h"
#include "io/store/row_codec.h"
#include "io/store/store_file.h"
#include "kernels/core/parallel.h"

namespace meander::store {

namespace {

constexpr std::uint64_t stretch_bytes = std::uint64_t{4} << 20;  // of a column of descriptors
constexpr std::size_t payload_stretch = std::size_t{1} << 20;    // of a row of many chunks

bool is_item(const DatasetSpec& spec) { return spec.role != Role::samples && spec.role != Role::descriptor; }

// Whether the samples come as filtered chunks of one row.
bool samples_are_filtered(const StoreLayout& layout) {
  return layout.datasets[layout.index_of(Role::samples)].chunk.rows == 1;
}

// Several rows of a column, as one chunk.
struct Chunk {
  std::uint64_t row = 0;
  std::vector<std::byte> raw, filtered;
};

// The largest size of a chunk: compression may add a little to incompressible bytes, and there is a checksum.
std::uint64_t most_filtered_bytes(const DatasetLayout& dataset) {
  constexpr std::uint64_t frame = 64;
  return dataset.chunk_bytes + dataset.chunk_bytes / 1000 + frame;
}

class JournalStoreWriter {
 public:
  JournalStoreWriter(const std::filesystem::path& path, const StoreHeader& header, const StoreLayout& layout,
                     Journals& journals, std::span<const std::uint8_t> statuses,
                     std::span<const RecordPlace> places)
      : path_(path),
        header_(header),
        layout_(layout),
        journals_(journals),
        statuses_(statuses),
        places_(places) {
    samples_begin_ = head_bytes();
    for (std::size_t d = 0; d < layout_.datasets.size(); ++d) {
      if (layout_.datasets[d].spec.role == Role::descriptor) samples_begin_ += layout_.datasets[d].row_bytes;
      if (!per_sample(layout_.datasets[d].spec)) continue;
      sample_columns_.push_back(d);
      parts_ = std::max(parts_, layout_.datasets[d].chunk.chunks_per_row);
    }
  }

  void write() {
    set_text_width(layout_.datasets[layout_.index_of(Role::reason)], longest_reason_width());
    StoreFileWriter file(path_, layout_, header_, file_bytes());
    const RowRange all{0, layout_.rows};
    // Small columns first, so that they are contiguous at the front of the file; then the samples.
    for_each_part(all, column_chunk_rows, [&](RowRange rows) { write_small_columns(file, rows); });
    for_each_part(all, sample_group_rows(layout_), [&](RowRange rows) {
      if (parts_ > 1)
        write_parts(file, rows);
      else
        write_samples(file, rows);
    });
    file.seal();
  }

 private:
  // Only rows that failed have a reason.
  std::uint32_t longest_reason_width() {
    std::size_t width = 1;
    for (std::uint64_t row = 0; row < layout_.rows; ++row)
      if (!is_ok(row)) width = std::max(width, head(row).reason.size());
    return static_cast<std::uint32_t>(width);
  }

  // An upper bound of the length of the file.
  std::uint64_t file_bytes() const {
    // The library takes room for its tables by the MiB where a store is large.
    constexpr std::uint64_t slack = 256 * 1024, index_entry = 64, large = std::uint64_t{32} << 20;
    const bool filtered = samples_are_filtered(layout_);
    std::uint64_t bytes = slack;
    for (const RecordPlace& place : places_) bytes += filtered ? place.payload_bytes : 0;
    for (const DatasetLayout& dataset : layout_.datasets) {
      const std::uint64_t chunks = (layout_.rows + dataset.chunk.rows - 1) / dataset.chunk.rows;
      bytes += chunks * dataset.chunk.chunks_per_row * index_entry;
      if (dataset.spec.role != Role::samples || !filtered) bytes += chunks * most_filtered_bytes(dataset);
    }
    bytes += names_bytes();
    return bytes > large ? bytes + (std::uint64_t{2} << 20) : bytes;
  }

  // An upper bound of what all names take: what records have beside their samples.
  std::uint64_t names_bytes() const {
    if (!record_.names_offset) return 0;
    std::uint64_t samples = 0, bytes = 0;
    for (const std::size_t d : sample_columns_) samples += layout_.datasets[d].row_bytes;
    for (const RecordPlace& place : places_)
      bytes +=
          place.payload_bytes - (samples_are_filtered(layout_) ? 0 : std::min(samples, place.payload_bytes));
    return bytes + bytes / 1000 + 2 * names_chunk;
  }

  bool is_ok(std::uint64_t row) const { return statuses_[row] == static_cast<std::uint8_t>(Status::ok); }
  bool any_ok(RowRange rows) const {
    for (std::uint64_t row = rows.begin; row < rows.end; ++row)
      if (is_ok(row)) return true;
    return false;
  }

  // Bytes of the payload of a row that is ok, before its descriptors: such a row has no reason.
  std::uint64_t head_bytes() const { return record_.bytes + 4; }

  // Reads from the record of a row, which begins with its header.
  void read_record(std::uint64_t row, std::uint64_t begin, std::span<std::byte> bytes) const {
    if (begin + bytes.size() > record_header_bytes + places_[row].payload_bytes)
      throw ItemError(Status::internal, fmt::format("the record of row {} ends too early", row));
    if (journals_.read(row / journal_rows, places_[row].offset + begin, bytes) < bytes.size()) damaged(row);
  }

  [[noreturn]] void damaged(std::uint64_t row) const {
    throw RunError(
        RunError::Kind::stopped,
        fmt::format("{} has changed since row {} was written to it; what is damaged will be computed "
                    "again",
                    journals_.path(row / journal_rows).string(), row));
  }

  // The header that the record of a row begins with.
  RecordHeader checked_header(std::uint64_t row, std::span<const std::byte> record) const {
    const std::optional<RecordHeader> header = read_record_header(record);
    if (!header || header->row != row || header->payload_bytes != places_[row].payload_bytes ||
        static_cast<std::uint8_t>(header->status) != statuses_[row])
      damaged(row);
    return *header;
  }
  void check(std::uint64_t row, std::span<const std::byte> record) const {
    if (crc32c(record.subspan(record_header_bytes)) != checked_header(row, record).payload_crc32c)
      damaged(row);
  }

  // The same of a record of any length, in stretches.
  void check_in_stretches(std::uint64_t row) const {
    std::vector<std::byte> stretch(record_header_bytes);
    read_record(row, 0, stretch);
    const RecordHeader header = checked_header(row, stretch);
    std::uint32_t checksum = 0;
    for (std::uint64_t at = 0; at < header.payload_bytes; at += stretch.size()) {
      stretch.resize(
          static_cast<std::size_t>(std::min<std::uint64_t>(header.payload_bytes - at, payload_stretch)));
      read_record(row, record_header_bytes + at, stretch);
      checksum = crc32c(std::span<const std::byte>(stretch), checksum);
    }
    if (checksum != header.payload_crc32c) damaged(row);
  }

  // Runs `body` on a record that was not checked. If it throws, the record is checked first, so that damage
  // is reported as damage.
  template <class Body>
  auto taking_apart(std::uint64_t row, const Body& body) {
    try {
      return body();
    } catch (const std::exception&) {
      check_in_stretches(row);
      throw;
    }
  }

  // What stands before the samples of a row, valid until the next call. The samples, and with them the
  // checksum of a row that has any, are looked at later.
  RecordParts head(std::uint64_t row) {
    const std::uint64_t payload = places_[row].payload_bytes;
    const auto bytes = is_ok(row) ? std::min<std::uint64_t>(payload, payload_head_bytes(header_)) : payload;
    buffer_.resize(record_header_bytes + static_cast<std::size_t>(bytes));
    read_record(row, 0, buffer_);
    if (is_ok(row))
      checked_header(row, buffer_);
    else
      check(row, buffer_);
    return taking_apart(row, [&] {
      RecordParts parts =
          split_record_head(header_, std::span<const std::byte>(buffer_).subspan(record_header_bytes));
      if (is_ok(row) && !parts.reason.empty())
        throw ItemError(Status::internal, fmt::format("row {} is ok and has a reason", row));
      return parts;
    });
  }

  // Items and descriptors.
  void write_small_columns(StoreFileWriter& file, RowRange block) {
    const std::vector<std::vector<std::byte>> items = gather_items(block);
    std::vector<std::vector<std::byte>> filtered(items.size());
    parallel_tasks(items.size(), [&](std::size_t d) {
      const DatasetLayout& dataset = layout_.datasets[d];
      if (is_item(dataset.spec) && is_stored(dataset, items[d]))
        append_filtered(items[d], dataset.element_bytes, layout_.compression, filtered[d]);
    });
    std::uint64_t begin = head_bytes();
    for (std::size_t d = 0; d < layout_.datasets.size(); ++d) {
      const DatasetLayout& dataset = layout_.datasets[d];
      if (!filtered[d].empty()) {
        file.write_chunk(d, block.begin, 0, filtered[d]);
      } else if (dataset.spec.role == Role::descriptor) {
        write_descriptors(file, d, begin, block);
        begin += dataset.row_bytes;
      }
    }
    if (record_.names_offset) write_names(file, block, items);
  }

  // What stands at the end of the records of rows that are ok.
  void write_names(StoreFileWriter& file, RowRange block, const std::vector<std::vector<std::byte>>& items) {
    const std::vector<std::byte>& lengths = items[layout_.index_of(names_bytes_path)];
    for (std::uint64_t row = block.begin; row < block.end; ++row) {
      std::uint32_t bytes = 0;
      std::memcpy(&bytes, lengths.data() + (row - block.begin) * sizeof bytes, sizeof bytes);
      if (bytes == 0) continue;
      if (bytes > places_[row].payload_bytes) damaged(row);
      buffer_.resize(bytes);
      read_record(row, record_header_bytes + places_[row].payload_bytes - bytes, buffer_);
      file.append_names(buffer_);
    }
  }

  // The item columns of a block, one chunk each.
  std::vector<std::vector<std::byte>> gather_items(RowRange block) {
    std::vector<std::vector<std::byte>> columns(layout_.datasets.size());
    for (std::size_t d = 0; d < columns.size(); ++d) {
      const DatasetLayout& dataset = layout_.datasets[d];
      if (!is_item(dataset.spec)) continue;
      columns[d].resize(dataset.chunk_bytes);
      if (dataset.spec.role != Role::reason) write_fill(dataset.spec, columns[d]);
    }
    for (std::uint64_t row = block.begin; row < block.end; ++row) {
      const RecordParts parts = head(row);
      std::size_t item = 0;
      for (std::size_t d = 0; d < columns.size(); ++d) {
        const DatasetLayout& dataset = layout_.datasets[d];
        if (!is_item(dataset.spec)) continue;
        std::byte* at = columns[d].data() + (row - block.begin) * dataset.row_bytes;
        const auto put = [&](const auto& bytes) { std::memcpy(at, bytes.data(), bytes.size()); };
        if (dataset.spec.role == Role::item)
          put(parts.items.subspan(record_.columns[item++].second, dataset.row_bytes));
        else if (dataset.spec.role == Role::label)
          std::memcpy(at, &header_.labels[row], dataset.row_bytes);
        else if (dataset.spec.role == Role::split)
          *at = static_cast<std::byte>(header_.split(row));
        else if (dataset.spec.role == Role::reason)
          put(parts.reason);
        else
          put(header_.ids[row]);
      }
    }
    return columns;
  }

  // Without any reason none is stored: the fill value is the empty text.
  static bool is_stored(const DatasetLayout& dataset, std::span<const std::byte> column) {
    return dataset.spec.role != Role::reason ||
           std::any_of(column.begin(), column.end(), [](std::byte b) { return b != std::byte{}; });
  }

  // The records of all rows of a group that are ok, in memory, checked: they end there in records_.
  void read_records(RowRange rows) {
    record_ends_.assign(1, 0);
    std::uint64_t bytes = 0;
    for (std::uint64_t row = rows.begin; row < rows.end; ++row) {
      bytes += is_ok(row) ? record_header_bytes + places_[row].payload_bytes : 0;
      record_ends_.push_back(static_cast<std::size_t>(bytes));
    }
    if (records_.size() < bytes) records_.resize(static_cast<std::size_t>(bytes));
    for (std::uint64_t row = rows.begin; row < rows.end; ++row) {
      const std::size_t begin = record_ends_[row - rows.begin], end = record_ends_[row - rows.begin + 1];
      if (begin == end) continue;
      read_record(row, 0, std::span(records_).subspan(begin, end - begin));
      check(row, std::span<const std::byte>(records_).subspan(begin, end - begin));
    }
  }
  std::span<const std::byte> payload(std::size_t row_in_group) const {
    const std::size_t begin = record_ends_[row_in_group] + record_header_bytes;
    return std::span<const std::byte>(records_).subspan(begin, record_ends_[row_in_group + 1] - begin);
  }

  // Rows whose chunks hold a whole row or several.
  void write_samples(StoreFileWriter& file, RowRange rows) {
    if (!any_ok(rows)) return;
    read_records(rows);
    std::vector<std::size_t> at(rows.size(), static_cast<std::size_t>(samples_begin_));  // in the payloads
    for (const std::size_t d : sample_columns_) {
      if (samples_are_filtered(layout_))
        copy_chunks(file, d, rows, at);
      else
        write_column(file, d, rows, at);
    }
    for (std::uint64_t row = rows.begin; row < rows.end; ++row)
      if (is_ok(row)) require_end(row, at[row - rows.begin] + record_.names_bytes(payload(row - rows.begin)));
  }

  std::span<const std::byte> take(std::uint64_t row, std::span<const std::byte> payload, std::size_t count,
                                  std::size_t& at) const {
    if (at + count > payload.size())
      throw ItemError(Status::internal, fmt::format("the record of row {} ends too early", row));
    at += count;
    return payload.subspan(at - count, count);
  }
  void require_end(std::uint64_t row, std::uint64_t end) const {
    if (end != places_[row].payload_bytes)
      throw ItemError(Status::internal, fmt::format("the record of row {} is longer than its parts", row));
  }

  // Chunks of one row: as they are in the journal.
  void copy_chunks(StoreFileWriter& file, std::size_t d, RowRange rows, std::vector<std::size_t>& at) const {
    for (std::uint64_t row = rows.begin; row < rows.end; ++row) {
      if (!is_ok(row)) continue;
      const std::size_t i = row - rows.begin;
      std::uint32_t length;
      std::memcpy(&length, take(row, payload(i), sizeof length, at[i]).data(), sizeof length);
      file.write_chunk(d, row, 0, take(row, payload(i), length, at[i]));
    }
  }

  void write_column(StoreFileWriter& file, std::size_t d, RowRange rows, std::vector<std::size_t>& at) {
    const std::size_t bytes = layout_.datasets[d].row_bytes;
    filter_and_write(file, d, rows, [&](std::uint64_t row, std::span<std::byte> to) {
      const std::size_t i = row - rows.begin;
      std::memcpy(to.data(), take(row, payload(i), bytes, at[i]).data(), bytes);
    });
  }

  // Chunks of rows of a column, which read(row, bytes) gives for rows that are ok. Chunks without such a row
  // are not stored.
  template <class Read>
  void filter_and_write(StoreFileWriter& file, std::size_t d, RowRange rows, const Read& read) {
    const DatasetLayout& dataset = layout_.datasets[d];
    std::size_t count = 0;
    for (std::uint64_t row = rows.begin; row < rows.end; row += dataset.chunk.rows) {
      const RowRange of_chunk{row, std::min(row + dataset.chunk.rows, rows.end)};
      if (!any_ok(of_chunk)) continue;
      if (count == chunks_.size()) chunks_.emplace_back();
      Chunk& chunk = chunks_[count++];
      chunk.row = row;
      chunk.raw.resize(dataset.chunk_bytes);
      std::uint64_t ok = 0;
      for (std::uint64_t r = of_chunk.begin; r < of_chunk.end; ++r) ok += is_ok(r);
      if (ok < dataset.chunk.rows) write_fill(dataset.spec, chunk.raw);
      for (std::uint64_t r = of_chunk.begin; r < of_chunk.end; ++r)
        if (is_ok(r)) read(r, std::span(chunk.raw).subspan((r - row) * dataset.row_bytes, dataset.row_bytes));
    }
    // A chunk has 16 KiB or more: worth a task of its own.
    parallel_tasks(count, [&](std::size_t i) {
      chunks_[i].filtered.clear();
      append_filtered(chunks_[i].raw, dataset.element_bytes, layout_.compression, chunks_[i].filtered);
    });
    for (std::size_t i = 0; i < count; ++i) file.write_chunk(d, chunks_[i].row, 0, chunks_[i].filtered);
  }

  // A column of descriptors, which begin there in the payloads of rows that are ok.
  void write_descriptors(StoreFileWriter& file, std::size_t d, std::uint64_t begin, RowRange block) {
    const DatasetLayout& dataset = layout_.datasets[d];
    const std::uint64_t at_once =
        std::max<std::uint64_t>(1, stretch_bytes / dataset.chunk_bytes) * dataset.chunk.rows;
    for (std::uint64_t row = block.begin; row < block.end; row += at_once)
      filter_and_write(
          file, d, {row, std::min(row + at_once, block.end)},
          [&](std::uint64_t r, std::span<std::byte> to) { read_record(r, record_header_bytes + begin, to); });
  }

  // Rows of many chunks each, as they are in the journal: the first chunk of every column, then the second
  // ones, and so on.
  void write_parts(StoreFileWriter& file, RowRange rows) {
    for (std::uint64_t row = rows.begin; row < rows.end; ++row) {
      if (!is_ok(row)) continue;
      taking_apart(row, [&] {
        RecordStream record(*this, row);
        const std::uint32_t names =
            record_.names_bytes(record.take(static_cast<std::size_t>(samples_begin_)));
        for (std::uint32_t part = 0; part < parts_; ++part)
          for (const std::size_t d : sample_columns_)
            if (part < layout_.datasets[d].chunk.chunks_per_row)
              file.write_chunk(d, row, part, record.take_chunk(most_filtered_bytes(layout_.datasets[d])));
        record.take(names);
        record.end();
      });
    }
  }

  // Takes a record apart from the front, in stretches, and checks it at its end.
  class RecordStream {
   public:
    RecordStream(JournalStoreWriter& writer, std::uint64_t row) : writer_(writer), row_(row) {
      header_ = writer.checked_header(row, take(record_header_bytes));
      checksum_ = 0;
    }
    // Valid until the next call, as what take() gives.
    std::span<const std::byte> take_chunk(std::uint64_t most_bytes) {
      std::uint32_t length;
      std::memcpy(&length, take(sizeof length).data(), sizeof length);
      if (length == 0 || length > most_bytes)
        throw ItemError(Status::internal, fmt::format("row {} has a chunk of {} bytes", row_, length));
      return take(length);
    }
    std::span<const std::byte> take(std::size_t count) {
      if (end_ - begin_ < count) refill(count);
      const auto taken = std::span<const std::byte>(buffer()).subspan(begin_, count);
      checksum_ = crc32c(taken, checksum_);
      begin_ += count;
      return taken;
    }
    void end() {
      writer_.require_end(row_, next_ - (end_ - begin_) - record_header_bytes);
      if (checksum_ != header_.payload_crc32c) writer_.damaged(row_);
    }

   private:
    void refill(std::size_t count) {
      std::copy(buffer().begin() + static_cast<std::ptrdiff_t>(begin_),
                buffer().begin() + static_cast<std::ptrdiff_t>(end_), buffer().begin());
      end_ -= begin_;
      begin_ = 0;
      const std::uint64_t left = record_header_bytes + writer_.places_[row_].payload_bytes - next_;
      if (count > end_ + left)
        throw ItemError(Status::internal, fmt::format("the record of row {} ends too early", row_));
      const auto more =
          static_cast<std::size_t>(std::min<std::uint64_t>(std::max(count, payload_stretch) - end_, left));
      if (buffer().size() < end_ + more) buffer().resize(end_ + more);
      writer_.read_record(row_, next_, std::span(buffer()).subspan(end_, more));
      end_ += more;
      next_ += more;
    }
    std::vector<std::byte>& buffer() { return writer_.buffer_; }

    JournalStoreWriter& writer_;
    std::uint64_t row_, next_ = 0;     // the next byte of the record that is read
    std::size_t begin_ = 0, end_ = 0;  // what the buffer holds
    RecordHeader header_;
    std::uint32_t checksum_ = 0;
  };

  const std::filesystem::path& path_;
  const StoreHeader& header_;
  StoreLayout layout_;
  const ItemRecord& record_ = item_record(layout_.columns);
  Journals& journals_;
  std::span<const std::uint8_t> statuses_;
  std::span<const RecordPlace> places_;
  std::uint64_t samples_begin_ = 0;  // in the payload of a row that is ok
  std::vector<std::size_t> sample_columns_;
  std::uint32_t parts_ = 1;  // chunks of a row in the column that has the most
  std::vector<std::byte> records_, buffer_;
  std::vector<std::size_t> record_ends_;
  std::vector<Chunk> chunks_;
};

}  // namespace

void write_store_of_journals(const std::filesystem::path& path, const StoreHeader& header,
                             const StoreLayout& layout, Journals& journals,
                             std::span<const std::uint8_t> statuses, std::span<const RecordPlace> places) {
  JournalStoreWriter(path, header, layout, journals, statuses, places).write();
}

}  // namespace meander::store

namespace meander {

std::uint64_t store_writing_bytes(const StoreHeader& header) {
  const store::StoreLayout layout = store::make_layout(header);
  const store::DatasetLayout& points = layout.datasets[layout.index_of(store::Role::samples)];
  const std::uint64_t group_rows = std::min(store::sample_group_rows(layout), layout.rows);
  // The records of a group, and chunks of descriptors and of samples of several rows, raw and filtered.
  std::uint64_t records = group_rows * (store::record_header_bytes + store::payload_head_bytes(header));
  std::uint64_t descriptors = 0, samples = 0, widest = 0;
  std::uint32_t parts = 1;
  for (const store::DatasetLayout& dataset : layout.datasets) {
    if (store::per_sample(dataset.spec)) {
      const std::uint64_t bytes = (group_rows + dataset.chunk.rows) * dataset.row_bytes;
      records += bytes;
      widest = std::max(widest, dataset.chunk_bytes);
      parts = std::max(parts, dataset.chunk.chunks_per_row);
      if (points.chunk.rows > 1) samples = std::max(samples, 2 * bytes);
    } else if (dataset.spec.role == store::Role::descriptor) {
      descriptors =
          std::max(descriptors, 2 * std::min(std::max(store::stretch_bytes, dataset.chunk_bytes),
                                             (layout.rows + dataset.chunk.rows) * dataset.row_bytes));
    }
  }
  if (header.columns->has_names()) records += group_rows * most_name_bytes + 2 * store::names_chunk;
  // Rows of many chunks are read by stretches.
  if (parts > 1) records = 2 * std::max<std::uint64_t>(store::payload_stretch, widest);
  return records + descriptors + samples;
}

}  // namespace meander
