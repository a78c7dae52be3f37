#include <algorithm>
#include <cstring>

#include "io/store/chunk_codec.h"
#include "io/store/row_codec.h"
#include "io/store/store_merge.h"
#include "kernels/core/parallel.h"

namespace meander::store {

namespace {

constexpr std::uint64_t stretch_bytes = std::uint64_t{4} << 20;

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
        read_(row, SIZE_MAX, payload);
        const RecordParts parts = split_record(header_, payload);
        put_samples(file, row, row - stretch.begin, parts, samples);
        put_descriptors(row - block.begin, parts, descriptors);
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

  // Filtered chunks go straight to the file, raw arrays to their place in the stretch.
  void put_samples(StoreFileWriter& file, std::uint64_t row, std::uint64_t row_in_stretch,
                   const RecordParts& parts, std::vector<std::vector<std::byte>>& raw) {
    std::size_t sample = 0;
    for (std::size_t d = 0; d < raw.size(); ++d) {
      const DatasetLayout& dataset = layout_.datasets[d];
      if (!per_sample(dataset.spec)) continue;
      if (samples_are_filtered(layout_)) {
        for (std::uint32_t part = 0; part < dataset.chunk.chunks_per_row; ++part)
          file.write_chunk(d, row - rows_.begin, part, parts.samples[sample++]);
        continue;
      }
      const auto bytes = parts.samples[sample++];
      std::memcpy(raw[d].data() + row_in_stretch * dataset.row_bytes, bytes.data(), bytes.size());
    }
  }

  void put_descriptors(std::uint64_t row_in_block, const RecordParts& parts,
                       std::vector<std::vector<std::byte>>& raw) const {
    std::size_t descriptor = 0;
    for (std::size_t d = 0; d < raw.size(); ++d) {
      const DatasetLayout& dataset = layout_.datasets[d];
      if (dataset.spec.role != Role::descriptor) continue;
      const auto bytes = parts.descriptors[descriptor++];
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
  // A row as the journal has it; where its chunks are not yet filtered, a stretch raw and filtered, too.
  const std::uint64_t stretch =
      store::samples_are_filtered(layout) ? 0 : std::min(store::rows_of_stretch(layout), layout.rows);
  return (2 * stretch + 1) * samples + 2 * std::min(store::block_rows, layout.rows) * descriptors;
}

}  // namespace meander
