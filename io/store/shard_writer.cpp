#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "io/store/chunk_codec.h"
#include "io/store/row_codec.h"
#include "io/store/store_merge.h"
#include "kernels/core/parallel.h"

namespace meander::store {

namespace {

constexpr std::uint64_t stretch_bytes = std::uint64_t{4} << 20;
constexpr std::size_t payload_stretch = std::size_t{1} << 20;  // of a row that is read back

bool is_item(const DatasetSpec& spec) { return spec.role != Role::samples && spec.role != Role::descriptor; }

// Whether the samples come as filtered chunks of one row.
bool samples_are_filtered(const StoreLayout& layout) {
  return layout.datasets[layout.index_of(Role::samples)].chunk.rows == 1;
}

// Rows whose samples are in memory at once: whole chunks, a power of two, about stretch_bytes.
std::uint64_t rows_of_stretch(const StoreLayout& layout) {
  if (samples_are_filtered(layout)) return 1;
  std::uint64_t bytes = 0, whole = 1;
  for (const DatasetLayout& dataset : layout.datasets) {
    if (!per_sample(dataset.spec)) continue;
    bytes += dataset.row_bytes;
    whole = std::max<std::uint64_t>(whole, dataset.chunk.rows);
  }
  std::uint64_t rows = block_rows;
  while (rows > whole && rows * bytes > stretch_bytes) rows /= 2;
  return rows;
}

// Takes a payload apart from the front, in stretches.
class PayloadCursor {
 public:
  PayloadCursor(const ReadPayload& read, std::uint64_t row, std::vector<std::byte>& buffer)
      : read_(read), row_(row), buffer_(buffer) {}

  // The next bytes, valid until the next call. Running out of them is a bug, as the checksums were right.
  std::span<const std::byte> take(std::size_t count) {
    if (end_ - begin_ < count) refill(count);
    const std::span<const std::byte> taken = std::span<const std::byte>(buffer_).subspan(begin_, count);
    begin_ += count;
    return taken;
  }
  std::uint32_t take_length() {
    std::uint32_t length;
    std::memcpy(&length, take(sizeof length).data(), sizeof length);
    return length;
  }
  bool at_end() {
    std::byte more{};
    return begin_ == end_ && read_(row_, next_, std::span(&more, 1)) == 0;
  }

 private:
  void refill(std::size_t count) {
    std::copy(buffer_.begin() + static_cast<std::ptrdiff_t>(begin_),
              buffer_.begin() + static_cast<std::ptrdiff_t>(end_), buffer_.begin());
    end_ -= begin_;
    begin_ = 0;
    buffer_.resize(std::max(count, payload_stretch));
    const std::size_t got = read_(row_, next_, std::span(buffer_).subspan(end_));
    end_ += got;
    next_ += got;
    if (end_ < count)
      throw ItemError(Status::internal, fmt::format("the record of row {} ends too early", row_));
  }

  const ReadPayload& read_;
  std::uint64_t row_, next_ = 0;  // the next byte that is read
  std::vector<std::byte>& buffer_;
  std::size_t begin_ = 0, end_ = 0;  // what the buffer holds
};

// A chunk that is ready to be written.
struct FilteredChunk {
  std::size_t dataset = 0;
  std::uint64_t row = 0;  // in the file
  std::vector<std::byte> bytes;
};

class ShardWriter {
 public:
  ShardWriter(const std::filesystem::path& path, const StoreHeader& header, const StoreLayout& layout,
              RowRange rows, const ReadPayload& read)
      : path_(path),
        header_(header),
        layout_(layout),
        rows_(rows),
        read_(read),
        columns_(layout.datasets.size()) {}

  void write(std::uint64_t journal_bytes) {
    gather_items();
    StoreFileWriter file(path_, layout_, header_, rows_, file_bytes(journal_bytes));
    write_items(file);
    for (std::uint64_t begin = rows_.begin; begin < rows_.end; begin += block_rows)
      write_block(file, {begin, std::min(begin + block_rows, rows_.end)});
    file.seal();
  }

  // The rows are all of the store: column by column, as merge_rows writes them.
  void write_store(std::uint64_t journal_bytes) {
    gather_items();
    if (samples_are_filtered(layout_)) find_chunks();
    StoreFileWriter file(path_, layout_, header_, std::nullopt, file_bytes(journal_bytes));
    // Small columns first, so that they are contiguous at the front of the file; then the samples.
    std::uint64_t begin = head_bytes();
    for (std::size_t d = 0; d < layout_.datasets.size(); ++d) {
      const DatasetLayout& dataset = layout_.datasets[d];
      if (is_item(dataset.spec)) {
        write_item_column(file, d);
      } else if (dataset.spec.role == Role::descriptor) {
        write_raw_column(file, d, begin);
        begin += dataset.row_bytes;
      }
    }
    std::size_t sample_column = 0;
    for (std::size_t d = 0; d < layout_.datasets.size(); ++d) {
      const DatasetLayout& dataset = layout_.datasets[d];
      if (!per_sample(dataset.spec)) continue;
      if (samples_are_filtered(layout_)) {
        write_chunk_column(file, d, sample_column++);
      } else {
        write_raw_column(file, d, begin);
        begin += dataset.row_bytes;
      }
    }
    // Raw arrays end where the last of them does.
    for (std::uint64_t row = 0; row < rows_.size() && !samples_are_filtered(layout_); ++row)
      if (statuses_[row] == Status::ok) require_end_at(row, begin);
    file.seal();
  }

 private:
  // An upper bound of the length of the file.
  std::uint64_t file_bytes(std::uint64_t journal_bytes) const {
    constexpr std::uint64_t slack = 256 * 1024, index_entry = 128;
    const bool filtered = samples_are_filtered(layout_);
    std::uint64_t bytes = slack + (filtered ? journal_bytes : 0);
    for (const DatasetLayout& dataset : layout_.datasets) {
      const std::uint64_t chunks = (rows_.size() + dataset.chunk.rows - 1) / dataset.chunk.rows;
      bytes += chunks * dataset.chunk.chunks_per_row * index_entry;
      if (dataset.spec.role != Role::samples || !filtered)
        bytes += chunks * (dataset.chunk_bytes + dataset.chunk_bytes / 1000);
    }
    return bytes;
  }

  // Columns of all rows of the shard, one chunk each, and the width of the reasons.
  void gather_items() {
    std::vector<std::string> reasons;
    std::vector<std::byte> payload;
    for (std::size_t d = 0; d < columns_.size(); ++d) {
      const DatasetLayout& dataset = layout_.datasets[d];
      if (!is_item(dataset.spec) || dataset.spec.role == Role::reason) continue;
      columns_[d].resize(dataset.chunk_bytes);
      write_fill(dataset.spec, columns_[d]);
    }
    statuses_.resize(rows_.size());
    const std::size_t head_bytes = payload_head_bytes(header_);
    for (std::uint64_t row = rows_.begin; row < rows_.end; ++row) {
      payload.resize(head_bytes);
      payload.resize(read_(row, 0, payload));
      const RecordParts parts = split_record_head(header_, payload);
      statuses_[row - rows_.begin] = parts.status;
      reasons.emplace_back(parts.reason);
      put_items(row, parts);
    }
    std::size_t width = 1;
    for (const std::string& reason : reasons) width = std::max(width, reason.size());
    const std::size_t reason_dataset = layout_.index_of(Role::reason);
    set_text_width(layout_.datasets[reason_dataset], static_cast<std::uint32_t>(width));
    columns_[reason_dataset].resize(layout_.datasets[reason_dataset].chunk_bytes);
    for (std::size_t i = 0; i < reasons.size(); ++i)
      std::memcpy(columns_[reason_dataset].data() + i * width, reasons[i].data(), reasons[i].size());
  }

  void put_items(std::uint64_t row, const RecordParts& parts) {
    std::size_t item = 0;
    for (std::size_t d = 0; d < columns_.size(); ++d) {
      const DatasetLayout& dataset = layout_.datasets[d];
      if (!is_item(dataset.spec) || dataset.spec.role == Role::reason) continue;
      std::byte* at = columns_[d].data() + (row - rows_.begin) * dataset.row_bytes;
      if (dataset.spec.role == Role::item)
        std::memcpy(at, parts.items.data() + item_record(layout_.columns).columns[item++].second,
                    dataset.row_bytes);
      else if (dataset.spec.role == Role::label)
        std::memcpy(at, &header_.labels[row], dataset.row_bytes);
      else if (dataset.spec.role == Role::split)
        *at = static_cast<std::byte>(header_.split(row));
      else
        std::memcpy(at, header_.ids[row].data(), header_.ids[row].size());
    }
  }

  // Without any reason none is stored: the fill value is the empty text.
  bool is_stored(std::size_t d) const {
    const auto is_zero = [](std::byte b) { return b == std::byte{}; };
    return !columns_[d].empty() && (layout_.datasets[d].spec.role != Role::reason ||
                                    !std::all_of(columns_[d].begin(), columns_[d].end(), is_zero));
  }

  void write_item_column(StoreFileWriter& file, std::size_t d) {
    if (!is_stored(d)) return;
    std::vector<std::byte> filtered;
    append_filtered(columns_[d], layout_.datasets[d].element_bytes, layout_.compression, filtered);
    file.write_chunk(d, 0, 0, filtered);
  }

  void write_items(StoreFileWriter& file) {
    std::vector<FilteredChunk> chunks;
    for (std::size_t d = 0; d < columns_.size(); ++d)
      if (is_stored(d)) chunks.push_back({d, 0, {}});
    filter_and_write(file, chunks, [&](const FilteredChunk& chunk) {
      return std::span<const std::byte>(columns_[chunk.dataset]);
    });
    columns_.assign(columns_.size(), {});
  }

  // The filters of all chunks in parallel, then one write after the other.
  template <class ChunkBytes>
  void filter_and_write(StoreFileWriter& file, std::vector<FilteredChunk>& chunks,
                        const ChunkBytes& bytes_of) {
    // A chunk has 16 KiB or more: worth a task of its own.
    parallel_blocks(
        chunks.size() * parallel_threshold, parallel_threshold, [&](std::size_t begin, std::size_t end) {
          for (std::size_t i = begin / parallel_threshold; i < end / parallel_threshold; ++i)
            append_filtered(bytes_of(chunks[i]), layout_.datasets[chunks[i].dataset].element_bytes,
                            layout_.compression, chunks[i].bytes);
        });
    for (const FilteredChunk& chunk : chunks) file.write_chunk(chunk.dataset, chunk.row, 0, chunk.bytes);
  }

  // Bytes of the payload of a row that is ok, before its descriptors: such a row has no reason.
  std::uint64_t head_bytes() const { return item_record(layout_.columns).bytes + 4; }

  void read_part(std::uint64_t row, std::uint64_t begin, std::span<std::byte> bytes) const {
    if (read_(row, begin, bytes) < bytes.size())
      throw ItemError(Status::internal, fmt::format("the record of row {} ends too early", row));
  }

  static void require_end(std::uint64_t row, bool is_at_end) {
    if (!is_at_end)
      throw ItemError(Status::internal, fmt::format("the record of row {} is longer than its parts", row));
  }
  void require_end_at(std::uint64_t row, std::uint64_t at) const {
    std::byte more{};
    require_end(row, read_(row, at, std::span(&more, 1)) == 0);
  }

  // Lengths of the filtered chunks of all rows that are ok.
  void find_chunks() {
    std::uint64_t begin = head_bytes();
    for (const DatasetLayout& dataset : layout_.datasets) {
      if (dataset.spec.role == Role::descriptor) begin += dataset.row_bytes;
      sample_columns_ += per_sample(dataset.spec);
    }
    samples_begin_ = begin;
    chunks_per_row_ =
        sample_columns_ * layout_.datasets[layout_.index_of(Role::samples)].chunk.chunks_per_row;
    for (std::uint64_t row = 0; row < rows_.size(); ++row) {
      if (statuses_[row] != Status::ok) continue;
      std::uint64_t at = samples_begin_;
      for (std::size_t i = 0; i < chunks_per_row_; ++i) {
        std::uint32_t length = 0;
        read_part(row, at, std::as_writable_bytes(std::span(&length, 1)));
        chunk_lengths_.push_back(length);
        at += 4 + length;
      }
      require_end_at(row, at);
    }
  }

  // A column of samples whose chunks hold one row: as they are in the journal.
  void write_chunk_column(StoreFileWriter& file, std::size_t d, std::size_t sample_column) {
    std::vector<std::byte> chunk;
    std::size_t length = 0;  // its place in chunk_lengths_
    for (std::uint64_t row = 0; row < rows_.size(); ++row) {
      if (statuses_[row] != Status::ok) continue;
      std::uint64_t at = samples_begin_;
      for (std::size_t i = 0; i < chunks_per_row_; ++i, ++length) {
        if (i % sample_columns_ == sample_column) {
          chunk.resize(chunk_lengths_[length]);
          read_part(row, at + 4, chunk);
          file.write_chunk(d, row, static_cast<std::uint32_t>(i / sample_columns_), chunk);
        }
        at += 4 + chunk_lengths_[length];
      }
    }
  }

  // A column of raw arrays that begin there in the payloads of rows that are ok.
  void write_raw_column(StoreFileWriter& file, std::size_t d, std::uint64_t begin) {
    const DatasetLayout& dataset = layout_.datasets[d];
    const std::uint64_t step =
        std::max<std::uint64_t>(1, stretch_bytes / dataset.chunk_bytes) * dataset.chunk.rows;
    std::vector<std::vector<std::byte>> raw(layout_.datasets.size());
    for (std::uint64_t first = 0; first < rows_.size(); first += step) {
      const RowRange stretch{first, std::min(first + step, rows_.size())};
      make_room(
          stretch, [&](const DatasetSpec& spec) { return &spec == &dataset.spec; }, raw);
      for (std::uint64_t row = stretch.begin; row < stretch.end; ++row)
        if (statuses_[row] == Status::ok)
          read_part(row, begin,
                    std::span(raw[d]).subspan((row - stretch.begin) * dataset.row_bytes, dataset.row_bytes));
      write_raw(file, stretch, raw);
    }
  }

  // Samples and descriptors of at most 256 rows that begin at a multiple of 256.
  void write_block(StoreFileWriter& file, RowRange block) {
    std::vector<std::vector<std::byte>> descriptors(layout_.datasets.size()),
        samples(layout_.datasets.size());
    const auto is_descriptor = [](const DatasetSpec& spec) { return spec.role == Role::descriptor; };
    make_room(block, is_descriptor, descriptors);
    const std::uint64_t step = rows_of_stretch(layout_);
    std::vector<std::byte> payload;
    for (std::uint64_t begin = block.begin; begin < block.end; begin += step) {
      const RowRange stretch{begin, std::min(begin + step, block.end)};
      if (!samples_are_filtered(layout_)) make_room(stretch, per_sample, samples);
      for (std::uint64_t row = stretch.begin; row < stretch.end; ++row) {
        if (statuses_[row - rows_.begin] != Status::ok) continue;
        put_row(file, row, row - block.begin, row - stretch.begin, payload, descriptors, samples);
      }
      write_raw(file, stretch, samples);
    }
    write_raw(file, block, descriptors);
  }

  // Room for the rows in every dataset of a kind, whole chunks, all fill.
  template <class Kind>
  void make_room(RowRange rows, const Kind& kind, std::vector<std::vector<std::byte>>& raw) const {
    for (std::size_t d = 0; d < raw.size(); ++d) {
      const DatasetLayout& dataset = layout_.datasets[d];
      if (!kind(dataset.spec)) continue;
      raw[d].resize((rows.size() + dataset.chunk.rows - 1) / dataset.chunk.rows * dataset.chunk_bytes);
      write_fill(dataset.spec, raw[d]);
    }
  }

  // Chunks without a row that is ok are not stored.
  void write_raw(StoreFileWriter& file, RowRange rows, const std::vector<std::vector<std::byte>>& raw) {
    std::vector<FilteredChunk> chunks;
    for (std::size_t d = 0; d < raw.size(); ++d) {
      const DatasetLayout& dataset = layout_.datasets[d];
      for (std::uint64_t begin = 0; begin * dataset.row_bytes < raw[d].size(); begin += dataset.chunk.rows)
        if (any_ok({rows.begin + begin, std::min(rows.begin + begin + dataset.chunk.rows, rows.end)}))
          chunks.push_back({d, rows.begin - rows_.begin + begin, {}});
    }
    filter_and_write(file, chunks, [&](const FilteredChunk& chunk) {
      const DatasetLayout& dataset = layout_.datasets[chunk.dataset];
      const std::uint64_t begin = chunk.row - (rows.begin - rows_.begin);
      return std::span<const std::byte>(raw[chunk.dataset])
          .subspan(begin * dataset.row_bytes, dataset.chunk_bytes);
    });
  }

  // Descriptors and raw arrays to their place in block and stretch; filtered chunks go straight to the file.
  void put_row(StoreFileWriter& file, std::uint64_t row, std::uint64_t row_in_block,
               std::uint64_t row_in_stretch, std::vector<std::byte>& buffer,
               std::vector<std::vector<std::byte>>& descriptors,
               std::vector<std::vector<std::byte>>& samples) const {
    PayloadCursor cursor(read_, row, buffer);
    cursor.take(item_record(layout_.columns).bytes);
    cursor.take(cursor.take_length());  // the reason
    const auto copy_row = [&](std::size_t d, std::uint64_t to, std::vector<std::vector<std::byte>>& raw) {
      const std::uint64_t bytes = layout_.datasets[d].row_bytes;
      std::memcpy(raw[d].data() + to * bytes, cursor.take(bytes).data(), bytes);
    };
    for (std::size_t d = 0; d < layout_.datasets.size(); ++d)
      if (layout_.datasets[d].spec.role == Role::descriptor) copy_row(d, row_in_block, descriptors);
    const std::uint32_t parts = layout_.datasets[layout_.index_of(Role::samples)].chunk.chunks_per_row;
    for (std::uint32_t part = 0; part < parts; ++part)
      for (std::size_t d = 0; d < layout_.datasets.size(); ++d) {
        if (!per_sample(layout_.datasets[d].spec)) continue;
        if (samples_are_filtered(layout_))
          file.write_chunk(d, row - rows_.begin, part, cursor.take(cursor.take_length()));
        else
          copy_row(d, row_in_stretch, samples);
      }
    require_end(row, cursor.at_end());
  }

  bool any_ok(RowRange rows) const {
    const auto begin = statuses_.begin() + static_cast<std::ptrdiff_t>(rows.begin - rows_.begin);
    return std::find(begin, begin + static_cast<std::ptrdiff_t>(rows.size()), Status::ok) !=
           begin + static_cast<std::ptrdiff_t>(rows.size());
  }

  const std::filesystem::path& path_;
  const StoreHeader& header_;
  StoreLayout layout_;
  const RowRange rows_;
  const ReadPayload& read_;
  std::vector<std::vector<std::byte>> columns_;  // per dataset; empty but for item columns
  std::vector<Status> statuses_;
  // Of write_store, where chunks hold one row: lengths of those of rows that are ok, one behind the other.
  std::vector<std::uint32_t> chunk_lengths_;
  std::size_t sample_columns_ = 0, chunks_per_row_ = 0;
  std::uint64_t samples_begin_ = 0;
};

}  // namespace

void write_shard(const std::filesystem::path& path, const StoreHeader& header, const StoreLayout& layout,
                 RowRange rows, std::uint64_t reserve, const ReadPayload& read) {
  ShardWriter(path, header, layout, rows, read).write(reserve);
}

void write_store_of_journal(const std::filesystem::path& path, const StoreHeader& header,
                            const StoreLayout& layout, std::uint64_t reserve, const ReadPayload& read) {
  ShardWriter(path, header, layout, {0, layout.rows}, read).write_store(reserve);
}

}  // namespace meander::store

namespace meander {

std::uint64_t shard_writing_bytes(const StoreHeader& header) {
  const store::StoreLayout layout = store::make_layout(header);
  std::uint64_t samples = 0, descriptors = 0;
  for (const store::DatasetLayout& dataset : layout.datasets) {
    if (store::per_sample(dataset.spec))
      samples += dataset.row_bytes;
    else if (dataset.spec.role == store::Role::descriptor)
      descriptors += dataset.row_bytes;
  }
  // A stretch of a row as the journal has it, one chunk at least; where the chunks are not yet filtered, a
  // stretch of rows raw and filtered, too.
  const store::DatasetLayout& points = layout.datasets[layout.index_of(store::Role::samples)];
  const bool filtered = store::samples_are_filtered(layout);
  const std::uint64_t journal =
      (layout.rows > store::shard_rows ? store::payload_stretch : 0) + 2 * points.chunk_bytes;
  const std::uint64_t stretch = filtered ? 0 : std::min(store::rows_of_stretch(layout), layout.rows);
  // Of a column that is written from the journal, raw and filtered; or the lengths of all chunks.
  std::uint64_t column = 0;
  for (const store::DatasetLayout& dataset : layout.datasets)
    if (dataset.spec.role == store::Role::descriptor || (store::per_sample(dataset.spec) && !filtered))
      column = std::max(column, 2 * std::min(std::max(store::stretch_bytes, dataset.chunk_bytes),
                                             (layout.rows + dataset.chunk.rows) * dataset.row_bytes));
  const std::uint64_t lengths = filtered ? std::min(layout.rows, store::shard_rows) * layout.datasets.size() *
                                               points.chunk.chunks_per_row * sizeof(std::uint32_t)
                                         : 0;
  return std::max(2 * stretch * samples + 2 * std::min(store::block_rows, layout.rows) * descriptors,
                  column) +
         journal + lengths;
}

}  // namespace meander
