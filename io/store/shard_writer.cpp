#include <algorithm>
#include <cstring>

#include "io/store/chunk_codec.h"
#include "io/store/row_codec.h"
#include "io/store/store_merge.h"
#include "kernels/core/parallel.h"

namespace meander::store {

namespace {

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

 private:
  static bool is_item(const DatasetSpec& spec) {
    return spec.role != Role::samples && spec.role != Role::descriptor;
  }
  bool samples_are_filtered() const {
    return layout_.datasets[layout_.index_of(Role::samples)].chunk.rows == 1;
  }

  // An upper bound of the length of the file.
  std::uint64_t file_bytes(std::uint64_t journal_bytes) const {
    constexpr std::uint64_t slack = 256 * 1024, index_entry = 128;
    std::uint64_t bytes = slack + (samples_are_filtered() ? journal_bytes : 0);
    for (const DatasetLayout& dataset : layout_.datasets) {
      const std::uint64_t chunks = (rows_.size() + dataset.chunk.rows - 1) / dataset.chunk.rows;
      bytes += chunks * dataset.chunk.chunks_per_row * index_entry;
      if (dataset.spec.role != Role::samples || !samples_are_filtered())
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
      read_(row, head_bytes, payload);
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
        std::memcpy(at, parts.items.data() + item_record().columns[item++].second, dataset.row_bytes);
      else if (dataset.spec.role == Role::label)
        std::memcpy(at, &header_.labels[row], dataset.row_bytes);
      else if (dataset.spec.role == Role::split)
        *at = static_cast<std::byte>(header_.split(row));
      else
        std::memcpy(at, header_.ids[row].data(), header_.ids[row].size());
    }
  }

  void write_items(StoreFileWriter& file) {
    std::vector<FilteredChunk> chunks;
    for (std::size_t d = 0; d < columns_.size(); ++d) {
      if (columns_[d].empty()) continue;
      const bool all_zero =
          std::all_of(columns_[d].begin(), columns_[d].end(), [](std::byte b) { return b == std::byte{}; });
      // A shard without any reason stores none: the fill value is the empty text.
      if (layout_.datasets[d].spec.role == Role::reason && all_zero) continue;
      chunks.push_back({d, 0, {}});
    }
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

  // Samples and descriptors of at most 256 rows that begin at a multiple of 256.
  void write_block(StoreFileWriter& file, RowRange block) {
    std::vector<std::vector<std::byte>> raw(layout_.datasets.size());
    for (std::size_t d = 0; d < raw.size(); ++d) {
      const DatasetLayout& dataset = layout_.datasets[d];
      if (is_item(dataset.spec) || (per_sample(dataset.spec) && samples_are_filtered())) continue;
      const std::uint64_t chunks = (block.size() + dataset.chunk.rows - 1) / dataset.chunk.rows;
      raw[d].resize(chunks * dataset.chunk_bytes);
      write_fill(dataset.spec, raw[d]);
    }
    std::vector<std::byte> payload;
    for (std::uint64_t row = block.begin; row < block.end; ++row) {
      if (statuses_[row - rows_.begin] != Status::ok) continue;
      read_(row, SIZE_MAX, payload);
      put_row(file, row, row - block.begin, split_record(header_, payload), raw);
    }
    std::vector<FilteredChunk> chunks;
    for (std::size_t d = 0; d < raw.size(); ++d)
      for (std::uint64_t begin = 0; begin * layout_.datasets[d].row_bytes < raw[d].size();
           begin += layout_.datasets[d].chunk.rows)
        if (any_ok({block.begin + begin,
                    std::min(block.begin + begin + layout_.datasets[d].chunk.rows, block.end)}))
          chunks.push_back({d, block.begin - rows_.begin + begin, {}});
    filter_and_write(file, chunks, [&](const FilteredChunk& chunk) {
      const DatasetLayout& dataset = layout_.datasets[chunk.dataset];
      const std::uint64_t begin = chunk.row - (block.begin - rows_.begin);
      return std::span<const std::byte>(raw[chunk.dataset])
          .subspan(begin * dataset.row_bytes, dataset.chunk_bytes);
    });
  }

  // One row: its filtered chunks go straight to the file, its raw arrays to their place in the block.
  void put_row(StoreFileWriter& file, std::uint64_t row, std::uint64_t row_in_block, const RecordParts& parts,
               std::vector<std::vector<std::byte>>& raw) {
    std::size_t descriptor = 0, sample = 0;
    for (std::size_t d = 0; d < raw.size(); ++d) {
      const DatasetLayout& dataset = layout_.datasets[d];
      if (is_item(dataset.spec)) continue;
      if (per_sample(dataset.spec) && samples_are_filtered()) {
        for (std::uint32_t part = 0; part < dataset.chunk.chunks_per_row; ++part)
          file.write_chunk(d, row - rows_.begin, part, parts.samples[sample++]);
        continue;
      }
      const auto bytes = per_sample(dataset.spec) ? parts.samples[sample++] : parts.descriptors[descriptor++];
      std::memcpy(raw[d].data() + row_in_block * dataset.row_bytes, bytes.data(), bytes.size());
    }
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
};

}  // namespace

void write_shard(const std::filesystem::path& path, const StoreHeader& header, const StoreLayout& layout,
                 RowRange rows, std::uint64_t reserve, const ReadPayload& read) {
  ShardWriter(path, header, layout, rows, read).write(reserve);
}

}  // namespace meander::store
