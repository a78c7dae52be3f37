#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cstring>

#include "io/store/chunk_codec.h"
#include "io/store/item_block.h"
#include "io/store/store_file.h"
#include "kernels/core/parallel.h"

namespace meander {

using namespace store;

namespace store {

void ItemBlock::read(const StoreFileReader& reader, std::uint64_t row) {
  count_ = 0;  // holds nothing should a read fail
  layout_ = &reader.layout();
  begin_ = row / shard_rows * shard_rows;
  const std::uint64_t count = std::min<std::uint64_t>(shard_rows, layout_->rows - begin_);
  columns_.resize(layout_->datasets.size());
  for (std::size_t d = 0; d < columns_.size(); ++d) {
    const DatasetLayout& dataset = layout_->datasets[d];
    if (dataset.spec.role == Role::samples || dataset.spec.role == Role::descriptor) continue;
    columns_[d].resize(count * dataset.row_bytes);
    reader.read_rows(d, begin_, count, columns_[d]);
  }
  count_ = count;
}

std::string ItemBlock::text(Role role, std::uint64_t row) const {
  const std::size_t d = layout_->index_of(role);
  const std::size_t width = layout_->datasets[d].text_width;
  const char* begin = reinterpret_cast<const char*>(columns_[d].data()) + (row - begin_) * width;
  return std::string(begin, std::find(begin, begin + width, '\0'));
}

std::int32_t ItemBlock::label(std::uint64_t row) const {
  std::int32_t label;
  std::memcpy(&label, columns_[layout_->index_of(Role::label)].data() + (row - begin_) * sizeof label,
              sizeof label);
  return label;
}

Split ItemBlock::split(std::uint64_t row) const {
  const std::size_t d = layout_->index_of(Role::split);
  if (d == layout_->datasets.size()) return Split::none;
  const auto number = std::to_integer<std::size_t>(columns_[d][row - begin_]);
  if (number >= split_names.size())
    throw RunError(RunError::Kind::unusable,
                   fmt::format("row {} has the unknown value {} in /items/split", row, number));
  return static_cast<Split>(number);
}

bool ItemBlock::is_ok(std::uint64_t row) const {
  return columns_[layout_->index_of(ElementType::status)][row - begin_] == static_cast<std::byte>(Status::ok);
}

ItemReport ItemBlock::report(std::uint64_t row) const {
  ItemReport report;
  std::size_t item = 0;
  for (std::size_t d = 0; d < columns_.size(); ++d) {
    const DatasetLayout& dataset = layout_->datasets[d];
    if (dataset.spec.role != Role::item) continue;
    // An older store may lack columns, or have a shorter list of repairs: the rest of the value is zero.
    while (item_record(layout_->columns).columns[item].first->path != dataset.spec.path) ++item;
    const DatasetSpec& spec = *item_record(layout_->columns).columns[item].first;
    std::vector<std::byte> value(value_bytes(spec));
    std::memcpy(value.data(), columns_[d].data() + (row - begin_) * dataset.row_bytes, dataset.row_bytes);
    const auto number = std::to_integer<std::size_t>(value[0]);
    if ((spec.type == ElementType::status && number >= status_names.size()) ||
        (spec.type == ElementType::method && number >= method_names.size()) ||
        (spec.type == ElementType::order_reason && number >= order_reason_names.size()) ||
        (spec.type == ElementType::color_source && number >= color_source_names.size()))
      throw RunError(RunError::Kind::unusable,
                     fmt::format("row {} has the unknown value {} in {}", row, number, spec.path));
    spec.get_item(value.data(), report);
  }
  report.reason = text(Role::reason, row);
  return report;
}

}  // namespace store

struct ChunkedRows {
  std::uint64_t begin = 0, end = 0;
};

struct StoreReader::State {
  std::filesystem::path path;
  std::unique_ptr<StoreFileReader> file;
  mutable ItemBlock items;
  mutable std::string ids;  // of the chunk that begins at ids_begin
  mutable std::uint64_t ids_begin = 0;
  mutable std::size_t searches = 0;
  mutable std::vector<std::string> first_ids;

  ~State() {
    const Hdf5Lock lock;
    file.reset();
  }

  // Runs a read with the library locked and its errors turned into RunError(unusable).
  template <class Body>
  auto guarded(const Body& body) const {
    const Hdf5Lock lock;
    try {
      return body();
    } catch (const Hdf5Error& error) {
      throw RunError(RunError::Kind::unusable, error.what());
    }
  }

  void read_chunks(std::size_t dataset, ChunkedRows rows, std::uint64_t begin, std::span<float> values) const;

  // Of the rows of a chunk, which lie in one block of item columns.
  bool any_ok(std::uint64_t row, std::uint64_t count) const {
    if (!items.holds(row)) items.read(*file, row);
    for (const std::uint64_t end = std::min(row + count, file->layout().rows); row < end; ++row)
      if (items.is_ok(row)) return true;
    return false;
  }

  // All ids of a chunk, without the other columns.
  std::string id(std::uint64_t row) const {
    return guarded([&] {
      if (items.holds(row)) return items.id(row);
      const std::size_t dataset = file->layout().index_of(Role::id);
      const std::uint64_t width = file->layout().datasets[dataset].row_bytes,
                          begin = row / shard_rows * shard_rows;
      if (ids_begin != begin || ids.empty()) {
        ids.resize(width * std::min<std::uint64_t>(shard_rows, file->layout().rows - begin));
        ids_begin = begin;
        file->read_rows(dataset, begin, ids.size() / width, std::as_writable_bytes(std::span(ids)));
      }
      const std::string_view text = std::string_view(ids).substr((row - begin) * width, width);
      return std::string(text.substr(0, text.find('\0')));
    });
  }

  // The rows among which an id stands, if there is one of it. The first ids of all chunks are read once many
  // have been asked for.
  std::pair<std::uint64_t, std::uint64_t> rows_around(std::string_view wanted) const {
    return guarded([&]() -> std::pair<std::uint64_t, std::uint64_t> {
      const std::uint64_t rows = file->layout().rows;
      constexpr std::size_t many = 8;
      if (searches < many && ++searches < many) return {0, rows};
      for (std::uint64_t row = first_ids.size() * shard_rows; row < rows; row += shard_rows)
        first_ids.push_back(id(row));
      const auto behind = std::upper_bound(first_ids.begin(), first_ids.end(), wanted);
      const auto number = static_cast<std::uint64_t>(behind - first_ids.begin());
      return {number == 0 ? 0 : (number - 1) * shard_rows, std::min(rows, number * shard_rows)};
    });
  }

  template <class Body>
  auto with_items(std::uint64_t row, const Body& body) const {
    return guarded([&] {
      if (row >= file->layout().rows)
        throw ItemError(Status::internal,
                        fmt::format("row {} of a store of {} rows", row, file->layout().rows));
      if (!items.holds(row)) items.read(*file, row);
      return body(items);
    });
  }
};

// The chunks that begin in `rows`, as far as they lie in the rows from `begin` on that `values` holds.
void StoreReader::State::read_chunks(std::size_t dataset, ChunkedRows rows, std::uint64_t begin,
                                     std::span<float> values) const {
  const DatasetLayout& layout = file->layout().datasets[dataset];
  const std::uint64_t width = layout.spec.width, end = begin + values.size() / width;
  std::vector<std::vector<std::byte>> filtered((rows.end - rows.begin + layout.chunk.rows - 1) /
                                               layout.chunk.rows);
  const auto part_of = [&](std::size_t chunk) {
    const std::uint64_t first = rows.begin + chunk * layout.chunk.rows;
    return ChunkedRows{std::max(first, begin), std::min(first + layout.chunk.rows, end)};
  };
  const auto room_of = [&](ChunkedRows part) {
    return std::as_writable_bytes(
        values.subspan((part.begin - begin) * width, (part.end - part.begin) * width));
  };
  guarded([&] {
    for (std::size_t c = 0; c < filtered.size(); ++c) {
      const ChunkedRows part = part_of(c);
      if (any_ok(rows.begin + c * layout.chunk.rows, layout.chunk.rows))
        file->read_chunk(dataset, rows.begin + c * layout.chunk.rows, 0, filtered[c]);
      else
        file->read_rows(dataset, part.begin, part.end - part.begin, room_of(part));  // fill
    }
  });
  std::atomic<bool> whole = true;
  parallel_tasks(filtered.size(), [&](std::size_t c) {
    if (filtered[c].empty()) return;
    std::vector<std::byte> chunk(layout.chunk_bytes);
    if (!unfilter(filtered[c], layout.element_bytes, file->facts().compression, chunk)) whole = false;
    const ChunkedRows part = part_of(c);
    const std::uint64_t skipped = (part.begin - rows.begin - c * layout.chunk.rows) * layout.row_bytes;
    const std::span<std::byte> room = room_of(part);
    std::copy_n(chunk.begin() + static_cast<std::ptrdiff_t>(skipped), room.size(), room.begin());
  });
  if (!whole)
    throw RunError(RunError::Kind::unusable,
                   fmt::format("{}: a chunk of {} fails its checksum: see meander verify", path.string(),
                               layout.spec.path));
}

StoreReader::StoreReader(const std::filesystem::path& store, StoreCheck check)
    : state_(std::make_unique<State>()) {
  state_->path = store;
  if (!std::filesystem::exists(store))
    throw RunError(RunError::Kind::unusable, fmt::format("the store {} does not exist", store.string()));
  if (!std::filesystem::is_regular_file(store))
    throw RunError(RunError::Kind::unusable,
                   fmt::format("{} is not a store: it is not a regular file", store.string()));
  if (check == StoreCheck::every_byte)
    if (const std::string damage = check_whole_file(store); !damage.empty())
      throw RunError(
          RunError::Kind::unusable,
          fmt::format("{} is not a whole store: {} (make it again or restore a copy; --trust reads it "
                      "unchecked)",
                      store.string(), damage));
  state_->guarded([&] {
    state_->file = std::make_unique<StoreFileReader>(store);
    if (!state_->file->problems().empty())
      throw Hdf5Error(fmt::format("cannot read {}: {}", store.string(), state_->file->problems().front()));
    if (state_->file->facts().shard)
      throw Hdf5Error(fmt::format("{} is a part of an unfinished run, not a store", store.string()));
  });
}

StoreReader::~StoreReader() = default;

std::uint64_t StoreReader::rows() const { return state_->file->facts().rows; }
std::uint32_t StoreReader::samples() const { return state_->file->facts().samples; }
std::uint32_t StoreReader::format_version() const { return state_->file->facts().format_version; }
const StoreColumns& StoreReader::columns() const { return *state_->file->facts().columns; }

void StoreReader::require(SampleColumn column, std::string_view user) const {
  if (columns().has(column)) return;
  const std::string_view name = name_of(column);
  if (!columns().applies(column))
    throw RunError(RunError::Kind::unusable,
                   fmt::format("{} has no `{}`, which {} needs: {}", state_->path.string(), name, user,
                               columns().rows == RowKind::surfaces ? "its models are parametric surfaces"
                               : column == SampleColumn::uv        ? "its models are meshes"
                                                                   : "its samples are not anisotropic"));
  throw RunError(RunError::Kind::unusable,
                 fmt::format("{} has no `{}`, which {} needs: it was made with a --store that leaves it out "
                             "(sample again without --store, or with --store ...,{})",
                             state_->path.string(), name, user, name));
}
std::uint32_t StoreReader::method_version() const { return state_->file->facts().method_version; }
std::string StoreReader::tool_version() const { return state_->file->facts().tool_version; }
std::uint64_t StoreReader::seed() const { return state_->file->facts().seed; }
const std::string& StoreReader::order() const { return state_->file->facts().order; }
Compression StoreReader::compression() const { return state_->file->facts().compression; }
const std::string& StoreReader::parameters_json() const { return state_->file->facts().parameters_json; }
const std::vector<std::string>& StoreReader::label_names() const { return state_->file->facts().label_names; }
const std::vector<DescriptorSchema>& StoreReader::descriptors() const {
  return state_->file->facts().descriptors;
}

StoreHeader StoreReader::header() const {
  StoreHeader header;
  header.columns = state_->file->facts().columns;
  header.samples = samples();
  header.compression = compression();
  header.seed = seed();
  header.order = order();
  header.parameters_json = parameters_json();
  header.label_names = label_names();
  header.descriptors = descriptors();
  header.method_version = method_version();
  header.tool_version = tool_version();
  for (std::uint64_t row = 0; row < rows(); ++row) {
    header.ids.push_back(id(row));
    header.labels.push_back(label(row));
    header.splits.push_back(split(row));
  }
  return header;
}

std::string StoreReader::id(std::uint64_t row) const {
  return state_->with_items(row, [&](const ItemBlock& items) { return items.id(row); });
}

std::optional<std::uint64_t> StoreReader::find(std::string_view wanted) const {
  const auto [first, last] = state_->rows_around(wanted);
  std::uint64_t begin = first, end = last;
  while (begin < end) {
    const std::uint64_t middle = begin + (end - begin) / 2;
    const std::string at_middle = state_->id(middle);
    if (at_middle == wanted) return middle;
    if (at_middle < wanted)
      begin = middle + 1;
    else
      end = middle;
  }
  return std::nullopt;
}

ItemReport StoreReader::report(std::uint64_t row) const {
  return state_->with_items(row, [&](const ItemBlock& items) { return items.report(row); });
}

std::int32_t StoreReader::label(std::uint64_t row) const {
  return state_->with_items(row, [&](const ItemBlock& items) { return items.label(row); });
}

Split StoreReader::split(std::uint64_t row) const {
  return state_->with_items(row, [&](const ItemBlock& items) { return items.split(row); });
}

Row StoreReader::read_row(std::uint64_t row) const {
  Row result;
  result.report = report(row);
  result.label = label(row);
  if (result.report.status != Status::ok) return result;
  state_->guarded([&] {
    const StoreLayout& layout = state_->file->layout();
    for (std::size_t d = 0; d < layout.datasets.size(); ++d) {
      const DatasetSpec& spec = layout.datasets[d].spec;
      if (spec.role == Role::samples) {
        const std::size_t elements = layout.samples * std::max<std::size_t>(spec.width, 1);
        state_->file->read_rows(d, row, 1, spec.room(result.samples, elements));
      } else if (spec.role == Role::descriptor) {
        DescriptorRow& descriptor = result.descriptors.emplace_back();
        descriptor.name = spec.path.substr(spec.path.rfind('/') + 1);
        descriptor.values.resize(spec.width);
        state_->file->read_rows(d, row, 1, std::as_writable_bytes(std::span(descriptor.values)));
      }
    }
  });
  return result;
}

std::vector<float> StoreReader::read_descriptor(std::string_view name) const {
  return read_descriptor(name, 0, rows());
}

// Whole chunks are decoded outside the library and its lock, in parallel.
std::vector<float> StoreReader::read_descriptor(std::string_view name, std::uint64_t row,
                                                std::uint64_t count) const {
  const StoreLayout& layout = state_->file->layout();
  const auto at = std::find_if(layout.datasets.begin(), layout.datasets.end(), [&](const DatasetLayout& d) {
    return d.spec.role == Role::descriptor && d.spec.path.substr(d.spec.path.rfind('/') + 1) == name;
  });
  if (at == layout.datasets.end())
    throw RunError(RunError::Kind::unusable,
                   fmt::format("{} has no descriptor {}", state_->path.string(), name));
  std::vector<float> values(count * at->spec.width);  // rows that are not ok hold the fill value, NaN
  if (values.empty()) return values;
  const auto dataset = static_cast<std::size_t>(at - layout.datasets.begin());
  if (count < at->chunk.rows) {
    state_->guarded(
        [&] { state_->file->read_rows(dataset, row, count, std::as_writable_bytes(std::span(values))); });
    return values;
  }
  constexpr std::uint64_t at_once = 32;
  const std::uint64_t chunk_rows = at->chunk.rows;
  for (std::uint64_t first = row / chunk_rows * chunk_rows; first < row + count;
       first += at_once * chunk_rows)
    state_->read_chunks(dataset, {first, std::min(row + count, first + at_once * chunk_rows)}, row, values);
  return values;
}

}  // namespace meander
