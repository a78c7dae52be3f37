#include "io/store/store_merge.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <memory>

#include "io/store/chunk_codec.h"

namespace meander::store {

namespace fs = std::filesystem;

namespace {

[[noreturn]] void refuse_source(const fs::path& path, std::string_view why) {
  throw RunError(RunError::Kind::unusable,
                 fmt::format("{} is damaged ({}): remove it and run again, its rows will be computed again",
                             path.string(), why));
}

bool is_text(const DatasetLayout& dataset) {
  return dataset.spec.role == Role::id || dataset.spec.role == Role::reason;
}

// An open source with the statuses of its rows.
struct OpenSource {
  OpenSource(const MergeSource& source, const StoreLayout& layout, const StoreHeader& header)
      : path(source.path),
        rows(source.rows),
        first(source.rows_before),
        more(source.rows_after),
        reader(source.path) {
    if (!reader.problems().empty()) refuse_source(source.path, reader.problems().front());
    const StoreFacts& facts = reader.facts();
    if (reader.layout().rows != first + rows.size() + more || reader.layout().samples != layout.samples ||
        !(reader.layout().columns == layout.columns) || facts.seed != header.seed ||
        facts.parameters_json != header.parameters_json || facts.method_version != header.method_version ||
        reader.layout().datasets.size() != layout.datasets.size())
      refuse_source(source.path, "it belongs to another run");
    statuses.resize(rows.size());
    reader.read_rows(layout.index_of(status_path), first, rows.size(), statuses);
    if (layout.columns->has_names()) name_ends = reader.read_name_ends();
  }

  // The bytes of the longest text of a column in these rows; at least 1.
  std::uint32_t longest_text(std::size_t dataset) const {
    const std::uint64_t width = reader.layout().datasets[dataset].row_bytes;
    std::vector<std::byte> texts;
    std::size_t longest = 1;
    for (std::uint64_t row = 0; row < rows.size(); row += column_chunk_rows) {
      const std::uint64_t count = std::min(column_chunk_rows, rows.size() - row);
      texts.resize(count * width);
      reader.read_rows(dataset, first + row, count, texts);
      for (std::uint64_t i = 0; i < count; ++i)
        longest = std::max(longest, ::strnlen(reinterpret_cast<const char*>(&texts[i * width]), width));
    }
    return static_cast<std::uint32_t>(longest);
  }

  std::uint64_t row_in_file(std::uint64_t row) const { return row - rows.begin + first; }

  fs::path path;
  RowRange rows;
  std::uint64_t first, more;  // rows of the file before and after them
  StoreFileReader reader;
  std::vector<std::byte> statuses;
  std::vector<std::uint64_t> name_ends;  // of all rows of the file, of stores that have names
};

class RowMerger {
 public:
  RowMerger(const StoreHeader& header, const StoreLayout& layout, const std::vector<MergeSource>& sources)
      : header_(header), layout_(layout), sources_(sources) {}

  void write(const fs::path& path) {
    const std::uint64_t bytes = look_at_sources();
    StoreFileWriter store(path, layout_, header_, bytes);
    // Small columns first, so that they are contiguous at the front of the file; then the samples.
    for_each_part({0, layout_.rows}, column_chunk_rows, [&](RowRange block) {
      with_sources(block, [&] {
        for (std::size_t d = 0; d < layout_.datasets.size(); ++d)
          if (!per_sample(layout_.datasets[d].spec)) write_column(store, d, 0, block);
        if (layout_.columns->has_names()) write_names(store, block);
      });
    });
    for_each_part({0, layout_.rows}, column_chunk_rows, [&](RowRange block) {
      with_sources(block, [&] {
        for_each_part(block, sample_group_rows(layout_), [&](RowRange group) { write_group(store, group); });
      });
    });
    open_.clear();
    store.seal();
  }

 private:
  // Checks every byte of them, and finds the width of the reasons. Returns an upper bound of the store's
  // length.
  std::uint64_t look_at_sources() {
    const std::size_t reason = layout_.index_of(Role::reason);
    std::uint32_t width = 1;
    std::uint64_t bytes = std::uint64_t{256} * 1024, row = 0;
    for (const MergeSource& source : sources_) {
      if (source.rows.begin != row)
        throw ItemError(Status::internal, fmt::format("row {} follows row {}", source.rows.begin, row));
      row = source.rows.end;
      if (const std::string damage = check_whole_file(source.path); !damage.empty())
        refuse_source(source.path, damage);
      const Hdf5Lock lock;
      std::uint64_t names = 0;  // which need not be spread evenly over its rows
      guarded(source.path, [&] {
        const OpenSource open(source, layout_, header_);
        names = open.reader.names_bytes();
        const std::uint32_t whole = open.reader.layout().datasets[reason].text_width;
        const bool is_whole = source.rows_before == 0 && source.rows_after == 0;
        width = std::max(width, is_whole || whole <= width ? whole : open.longest_text(reason));
      });
      const std::uint64_t all_rows = source.rows_before + source.rows.size() + source.rows_after;
      bytes += names;
      bytes += fs::file_size(source.path) / std::max<std::uint64_t>(all_rows, 1) * source.rows.size();
    }
    if (row != layout_.rows)
      throw ItemError(Status::internal, fmt::format("{} of {} rows have a source", row, layout_.rows));
    set_text_width(layout_.datasets[reason], width);
    for (const DatasetLayout& dataset : layout_.datasets)
      if (!per_sample(dataset.spec)) bytes += (layout_.rows / dataset.chunk.rows + 1) * dataset.chunk_bytes;
    return bytes;
  }

  // What cannot be read is damage to the source.
  template <class Body>
  static void guarded(const fs::path& path, const Body& body) {
    try {
      body();
    } catch (const Hdf5Error& error) {
      refuse_source(path, error.what());
    }
  }

  // Calls body while the sources of the block, and no others, are open.
  template <class Body>
  void with_sources(RowRange block, const Body& body) {
    const Hdf5Lock lock;
    std::erase_if(open_, [&](const auto& entry) { return entry.second->rows.end <= block.begin; });
    auto at = std::lower_bound(sources_.begin(), sources_.end(), block.begin,
                               [](const MergeSource& s, std::uint64_t row) { return s.rows.end <= row; });
    for (; at != sources_.end() && at->rows.begin < block.end; ++at)
      if (at->rows.size() > 0 && !open_.contains(at->rows.begin))
        guarded(at->path,
                [&] { open_.emplace(at->rows.begin, std::make_unique<OpenSource>(*at, layout_, header_)); });
    body();
  }

  // The names of the rows of a block, which are one stretch of each of its sources.
  void write_names(StoreFileWriter& store, RowRange block) {
    std::vector<std::byte> names;
    for (std::uint64_t row = block.begin; row < block.end;) {
      const OpenSource& source = source_of(row);
      const std::uint64_t end = std::min(block.end, source.rows.end), first = source.row_in_file(row);
      const std::uint64_t stop = source.name_ends.at(source.row_in_file(end - 1));
      std::uint64_t at = first == 0 ? 0 : source.name_ends.at(first - 1);
      for (; at < stop; at += names.size()) {
        names.resize(static_cast<std::size_t>(std::min<std::uint64_t>(stop - at, 16 * names_chunk)));
        guarded(source.path, [&] { source.reader.read_names(at, names); });
        store.append_names(names);
      }
      row = end;
    }
  }

  // The source of a row: one that is open.
  const OpenSource& source_of(std::uint64_t row) const { return *std::prev(open_.upper_bound(row))->second; }

  void write_group(StoreFileWriter& store, RowRange group) {
    const std::uint32_t parts = most_chunks_per_row(layout_.columns, layout_.rows, layout_.samples);
    for (std::uint32_t part = 0; part < parts; ++part)
      for (std::size_t d = 0; d < layout_.datasets.size(); ++d)
        if (per_sample(layout_.datasets[d].spec) && part < layout_.datasets[d].chunk.chunks_per_row)
          write_column(store, d, part, group);
  }

  void write_column(StoreFileWriter& store, std::size_t d, std::uint32_t part, RowRange block) {
    const DatasetLayout& dataset = layout_.datasets[d];
    const bool always = dataset.spec.role != Role::samples && dataset.spec.role != Role::descriptor;
    for (std::uint64_t row = block.begin; row < block.end; row += dataset.chunk.rows) {
      const RowRange rows{row, std::min(row + dataset.chunk.rows, block.end)};
      // Chunks of samples and descriptors without a row that is ok are never written.
      if (!always && !any_ok(rows)) continue;
      if (has_whole_chunk(source_of(row), d, rows))
        copy_chunk(store, d, row, part);
      else
        put_together(store, d, rows);
    }
  }

  bool any_ok(RowRange rows) const {
    for (std::uint64_t row = rows.begin; row < rows.end; ++row) {
      const OpenSource& source = source_of(row);
      if (source.statuses[row - source.rows.begin] == static_cast<std::byte>(Status::ok)) return true;
    }
    return false;
  }

  // Whether these rows are a chunk of the source as they are one of the store.
  bool has_whole_chunk(const OpenSource& source, std::size_t d, RowRange rows) const {
    const DatasetLayout &dataset = layout_.datasets[d], &theirs = source.reader.layout().datasets[d];
    return !is_text(dataset) && dataset.chunk == theirs.chunk && rows.end <= source.rows.end &&
           source.row_in_file(rows.begin) % dataset.chunk.rows == 0 &&
           (rows.size() == dataset.chunk.rows || (rows.end == source.rows.end && source.more == 0));
  }

  void copy_chunk(StoreFileWriter& store, std::size_t d, std::uint64_t row, std::uint32_t part) {
    const OpenSource& source = source_of(row);
    guarded(source.path, [&] { source.reader.read_chunk(d, source.row_in_file(row), part, filtered_); });
    store.write_chunk(d, row, part, filtered_);
  }

  void put_together(StoreFileWriter& store, std::size_t d, RowRange rows) {
    const DatasetLayout& dataset = layout_.datasets[d];
    std::vector<std::byte> values(dataset.chunk_bytes), theirs;
    if (!is_text(dataset)) write_fill(dataset.spec, values);
    for (std::uint64_t row = rows.begin; row < rows.end;) {
      const OpenSource& source = source_of(row);
      const std::uint64_t count = std::min(rows.end, source.rows.end) - row;
      const std::uint64_t width = source.reader.layout().datasets[d].row_bytes;
      theirs.resize(count * width);
      guarded(source.path, [&] { source.reader.read_rows(d, source.row_in_file(row), count, theirs); });
      // Texts are as wide as the longest of their file.
      for (std::uint64_t i = 0; i < count; ++i)
        std::memcpy(values.data() + (row - rows.begin + i) * dataset.row_bytes, theirs.data() + i * width,
                    std::min(width, dataset.row_bytes));
      row += count;
    }
    if (dataset.spec.role == Role::id) check_ids(values, rows);
    // A chunk without any reason is not stored: the fill value is the empty text.
    if (dataset.spec.role == Role::reason &&
        std::all_of(values.begin(), values.end(), [](std::byte b) { return b == std::byte{}; }))
      return;
    filtered_.clear();
    append_filtered(values, dataset.element_bytes, layout_.compression, filtered_);
    store.write_chunk(d, rows.begin, 0, filtered_);
  }

  void check_ids(const std::vector<std::byte>& values, RowRange rows) const {
    const std::uint64_t width = layout_.datasets[layout_.index_of(Role::id)].row_bytes;
    for (std::uint64_t row = rows.begin; row < rows.end; ++row) {
      const std::string& id = header_.ids[row];
      const auto* found = reinterpret_cast<const char*>(values.data()) + (row - rows.begin) * width;
      if (std::string_view(found, ::strnlen(found, width)) != id)
        refuse_source(source_of(row).path, fmt::format("it lacks the item \"{}\"", id));
    }
  }

  const StoreHeader& header_;
  StoreLayout layout_;
  const std::vector<MergeSource>& sources_;
  std::map<std::uint64_t, std::unique_ptr<OpenSource>> open_;  // by first row
  std::vector<std::byte> filtered_;
};

}  // namespace

void merge_rows(const fs::path& path, const StoreHeader& header, const StoreLayout& layout,
                const std::vector<MergeSource>& sources) {
  RowMerger(header, layout, sources).write(path);
}

}  // namespace meander::store
