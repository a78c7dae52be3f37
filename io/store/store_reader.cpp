#include "io/store/store_reader.h"

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
  begin_ = row / column_chunk_rows * column_chunk_rows;
  const std::uint64_t count = std::min<std::uint64_t>(column_chunk_rows, layout_->rows - begin_);
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
  return columns_[layout_->index_of(status_path)][row - begin_] == static_cast<std::byte>(Status::ok);
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
    if (spec.type == ElementType::word && number >= spec.words.size())
      throw RunError(RunError::Kind::unusable,
                     fmt::format("row {} has the unknown value {} in {}", row, number, spec.path));
    spec.get_item(value.data(), report);
  }
  report.reason = text(Role::reason, row);
  return report;
}

}  // namespace store

namespace store {

// One file with rows: a store, or a pack of one. Rows are counted from its first one.
struct StorePart {
  std::filesystem::path path;
  std::unique_ptr<StoreFileReader> file;
  mutable ItemBlock items;
  mutable std::string ids;  // of the chunk that begins at ids_begin
  mutable std::uint64_t ids_begin = 0;
  mutable std::size_t searches = 0;
  mutable std::vector<std::string> first_ids;
  mutable std::vector<std::uint64_t> name_ends;  // of all rows, once a name is asked for

  StorePart(const std::filesystem::path& store, StoreCheck check);
  StorePart(const StorePart&) = delete;
  StorePart& operator=(const StorePart&) = delete;
  ~StorePart() {
    const Hdf5Lock lock;
    file.reset();
  }

  std::optional<std::uint64_t> find(std::string_view wanted) const;
  void read_row(std::uint64_t row, Row& result) const;
  std::string names(std::uint64_t row, std::uint32_t bytes) const;
  Samples read_samples(std::uint64_t row, std::uint64_t begin, std::uint64_t end) const;
  void read_descriptor(std::string_view name, std::uint64_t row, std::span<float> values) const;
  std::uint32_t width_of(std::string_view name) const;

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

  std::size_t dataset_of(std::string_view name) const;
  void read_chunks(std::size_t dataset, RowRange rows, std::uint64_t begin, std::span<float> values) const;

  // Whether any row of a chunk is ok; its rows lie in one block of item columns.
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
                          begin = row / column_chunk_rows * column_chunk_rows;
      if (ids_begin != begin || ids.empty()) {
        ids.resize(width * std::min<std::uint64_t>(column_chunk_rows, file->layout().rows - begin));
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
      for (std::uint64_t row = first_ids.size() * column_chunk_rows; row < rows; row += column_chunk_rows)
        first_ids.push_back(id(row));
      const auto behind = std::upper_bound(first_ids.begin(), first_ids.end(), wanted);
      const auto number = static_cast<std::uint64_t>(behind - first_ids.begin());
      return {number == 0 ? 0 : (number - 1) * column_chunk_rows, std::min(rows, number * column_chunk_rows)};
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
void StorePart::read_chunks(std::size_t dataset, RowRange rows, std::uint64_t begin,
                            std::span<float> values) const {
  const DatasetLayout& layout = file->layout().datasets[dataset];
  const std::uint64_t width = layout.spec.width, end = begin + values.size() / width;
  std::vector<std::vector<std::byte>> filtered((rows.end - rows.begin + layout.chunk.rows - 1) /
                                               layout.chunk.rows);
  const auto part_of = [&](std::size_t chunk) {
    const std::uint64_t first = rows.begin + chunk * layout.chunk.rows;
    return RowRange{std::max(first, begin), std::min(first + layout.chunk.rows, end)};
  };
  const auto room_of = [&](RowRange part) {
    return std::as_writable_bytes(
        values.subspan((part.begin - begin) * width, (part.end - part.begin) * width));
  };
  guarded([&] {
    for (std::size_t c = 0; c < filtered.size(); ++c) {
      const RowRange part = part_of(c);
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
    const RowRange part = part_of(c);
    const std::uint64_t skipped = (part.begin - rows.begin - c * layout.chunk.rows) * layout.row_bytes;
    const std::span<std::byte> room = room_of(part);
    std::copy_n(chunk.begin() + static_cast<std::ptrdiff_t>(skipped), room.size(), room.begin());
  });
  if (!whole)
    throw RunError(RunError::Kind::unusable,
                   fmt::format("{}: a chunk of {} fails its checksum: see meander verify", path.string(),
                               layout.spec.path));
}

StorePart::StorePart(const std::filesystem::path& store, StoreCheck check) : path(store) {
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
  guarded([&] {
    file = std::make_unique<StoreFileReader>(store);
    if (!file->problems().empty())
      throw Hdf5Error(fmt::format("cannot read {}: {}", store.string(), file->problems().front()));
  });
}

std::optional<std::uint64_t> StorePart::find(std::string_view wanted) const {
  const auto [first, last] = rows_around(wanted);
  std::uint64_t begin = first, end = last;
  while (begin < end) {
    const std::uint64_t middle = begin + (end - begin) / 2;
    const std::string at_middle = id(middle);
    if (at_middle == wanted) return middle;
    if (at_middle < wanted)
      begin = middle + 1;
    else
      end = middle;
  }
  return std::nullopt;
}

void StorePart::read_row(std::uint64_t row, Row& result) const {
  guarded([&] {
    const StoreLayout& layout = file->layout();
    for (std::size_t d = 0; d < layout.datasets.size(); ++d) {
      const DatasetSpec& spec = layout.datasets[d].spec;
      if (spec.role == Role::samples) {
        const std::size_t elements = layout.datasets[d].points * std::max<std::size_t>(spec.width, 1);
        if (spec.type == ElementType::f16) {
          std::vector<std::byte> halves(layout.datasets[d].row_bytes);
          file->read_rows(d, row, 1, halves);
          spec.put(halves, 0, elements, result.samples);
        } else {
          file->read_rows(d, row, 1, spec.room(result.samples, elements));
        }
      } else if (spec.role == Role::descriptor) {
        DescriptorRow& descriptor = result.descriptors.emplace_back();
        descriptor.name = spec.path.substr(spec.path.rfind('/') + 1);
        descriptor.values.resize(spec.width);
        file->read_rows(d, row, 1, std::as_writable_bytes(std::span(descriptor.values)));
      }
    }
  });
}

std::string StorePart::names(std::uint64_t row, std::uint32_t bytes) const {
  std::string text;
  if (bytes == 0) return text;
  guarded([&] {
    if (name_ends.empty()) name_ends = file->read_name_ends();
    if (bytes > most_name_bytes || bytes > name_ends[row])
      throw Hdf5Error(fmt::format("row {} of {} has {} bytes of names", row, path.string(), bytes));
    text.resize(bytes);
    file->read_names(name_ends[row] - bytes, std::as_writable_bytes(std::span(text)));
  });
  return text;
}

Samples StorePart::read_samples(std::uint64_t row, std::uint64_t begin, std::uint64_t end) const {
  Samples samples;
  guarded([&] {
    const StoreLayout& layout = file->layout();
    for (std::size_t d = 0; d < layout.datasets.size(); ++d) {
      const DatasetSpec& spec = layout.datasets[d].spec;
      if (spec.role != Role::samples || spec.set != PointSet::samples) continue;
      const std::size_t elements = (end - begin) * std::max<std::size_t>(spec.width, 1);
      file->read_samples(d, row, begin, end - begin, spec.room(samples, elements));
    }
  });
  return samples;
}

// Whole chunks are decoded outside the library and its lock, in parallel.
void StorePart::read_descriptor(std::string_view name, std::uint64_t row, std::span<float> values) const {
  if (values.empty()) return;
  const std::size_t dataset = dataset_of(name);
  const DatasetLayout& layout = file->layout().datasets[dataset];
  const std::uint64_t count = values.size() / layout.spec.width, chunk_rows = layout.chunk.rows;
  if (count < chunk_rows) {
    guarded([&] { file->read_rows(dataset, row, count, std::as_writable_bytes(values)); });
    return;
  }
  constexpr std::uint64_t at_once = 32;
  for (std::uint64_t first = row / chunk_rows * chunk_rows; first < row + count;
       first += at_once * chunk_rows)
    read_chunks(dataset, {first, std::min(row + count, first + at_once * chunk_rows)}, row, values);
}

std::size_t StorePart::dataset_of(std::string_view name) const {
  const StoreLayout& layout = file->layout();
  const auto at = std::find_if(layout.datasets.begin(), layout.datasets.end(), [&](const DatasetLayout& d) {
    return d.spec.role == Role::descriptor && d.spec.path.substr(d.spec.path.rfind('/') + 1) == name;
  });
  if (at == layout.datasets.end())
    throw RunError(RunError::Kind::unusable, fmt::format("{} has no descriptor {}", path.string(), name));
  return static_cast<std::size_t>(at - layout.datasets.begin());
}

std::uint32_t StorePart::width_of(std::string_view name) const {
  return file->layout().datasets[dataset_of(name)].spec.width;
}

}  // namespace store

std::uint64_t StoreShard::begin_of(std::uint64_t part, std::uint64_t rows) const {
  constexpr std::uint64_t blocks_of_part = 16;
  std::uint64_t block = sample_chunk_rows;
  while (block > 1 && rows < block * blocks_of_part * count) block /= 2;
  return part >= count ? rows : (rows / count * part + rows % count * part / count) / block * block;
}

// The file that was named and, where it is an index, its packs: opened and checked when the first of their
// rows is asked for, and no more than most_open of them at once.
struct StoreReader::State {
  StoreCheck check;
  StorePart named;
  std::uint64_t begin = 0, end = 0;       // the rows of the shard
  std::vector<std::uint64_t> first_rows;  // of the packs; none: the rows are those of `named`
  mutable std::vector<std::shared_ptr<const StorePart>> open;
  mutable std::vector<std::size_t> by_age;  // those that are open, the one opened first in front
  mutable std::vector<bool> checked;

  State(const std::filesystem::path& store, StoreCheck how, const StoreShard& shard)
      : check(how), named(store, how) {
    begin = shard.begin_of(shard.number, facts().rows);
    end = shard.begin_of(shard.number + 1, facts().rows);
    std::uint64_t row = 0;
    for (const StorePack& pack : facts().packs) {
      first_rows.push_back(row);
      row += pack.rows;
    }
    if (!facts().packs.empty() && row != facts().rows)
      throw RunError(RunError::Kind::unusable, fmt::format("{} is damaged: its packs have {} rows of {}",
                                                           store.string(), row, facts().rows));
    open.resize(first_rows.size());
    checked.resize(first_rows.size());
  }

  const StoreFacts& facts() const { return named.file->facts(); }

  // A file, kept open as long as the pointer lives, and where its rows are among all.
  struct Place {
    std::shared_ptr<const StorePart> part;
    std::uint64_t first_row = 0, row = 0, end = 0;  // `row` and `end` within the part
  };

  Place pack(std::size_t number) const {
    const Hdf5Lock lock;
    if (!open[number]) {
      const StorePack& pack = facts().packs[number];
      const std::filesystem::path path = named.path.parent_path() / pack.file;
      const std::string differs = difference_to_pack(path, pack);
      if (!differs.empty())
        throw RunError(RunError::Kind::unusable, fmt::format("{}: {}", named.path.string(), differs));
      auto part = std::make_shared<const StorePart>(path, checked[number] ? StoreCheck::none : check);
      if (part->file->facts().rows != pack.rows ||
          part->file->facts().parameters_json != facts().parameters_json)
        throw RunError(RunError::Kind::unusable, fmt::format("{}: its pack {} belongs to another store",
                                                             named.path.string(), pack.file));
      constexpr std::size_t most_open = 64;
      if (by_age.size() == most_open) {
        open[by_age.front()].reset();
        by_age.erase(by_age.begin());
      }
      open[number] = std::move(part);
      by_age.push_back(number);
      checked[number] = true;
    }
    return {open[number], first_rows[number], 0, facts().packs[number].rows};
  }

  Place place_of(std::uint64_t row) const {
    if (row >= end - begin)
      throw ItemError(Status::internal, fmt::format("row {} of a store of {} rows", row, end - begin));
    row += begin;
    if (first_rows.empty())  // no owner: it lives as long as this
      return {std::shared_ptr<const StorePart>(std::shared_ptr<const StorePart>(), &named), 0, row,
              facts().rows};
    const auto behind = std::upper_bound(first_rows.begin(), first_rows.end(), row);
    Place place = pack(static_cast<std::size_t>(behind - first_rows.begin()) - 1);
    place.row = row - place.first_row;
    return place;
  }

  // Among all rows of the store.
  std::optional<std::uint64_t> find(std::string_view wanted) const {
    const std::vector<StorePack>& packs = facts().packs;
    if (packs.empty()) return named.find(wanted);
    const auto behind =
        std::upper_bound(packs.begin(), packs.end(), wanted,
                         [](std::string_view id, const StorePack& pack) { return id < pack.first_id; });
    if (behind == packs.begin()) return std::nullopt;
    const Place place = pack(static_cast<std::size_t>(behind - packs.begin()) - 1);
    const std::optional<std::uint64_t> row = place.part->find(wanted);
    return row ? std::optional(place.first_row + *row) : std::nullopt;
  }

  template <class Body>
  auto with_items(std::uint64_t row, const Body& body) const {
    const Place place = place_of(row);
    return place.part->with_items(place.row, [&](const ItemBlock& items) { return body(items, place.row); });
  }
};

StoreReader::StoreReader(const std::filesystem::path& store, StoreCheck check)
    : StoreReader(store, check, StoreShard{}) {}

StoreReader::StoreReader(const std::filesystem::path& store, StoreCheck check, const StoreShard& shard)
    : state_(std::make_unique<State>(store, check, shard)) {}

StoreReader::~StoreReader() = default;

std::uint64_t StoreReader::rows() const { return state_->end - state_->begin; }
const StoreHeader& StoreReader::stated() const { return state_->facts(); }
std::uint32_t StoreReader::format_version() const { return state_->facts().format_version; }

void StoreReader::require(std::size_t column, std::string_view user) const {
  if (columns().has(column)) return;
  const std::string_view word = sample_columns.at(column).word();
  const std::string why =
      columns().applies(column)
          ? fmt::format(
                "it was made with a --store that leaves it out (sample again without --store, or with "
                "--store ...,{})",
                word)
          : columns().why_without(column);
  throw RunError(RunError::Kind::unusable, fmt::format("{} has no `{}`, which {} needs: {}",
                                                       state_->named.path.string(), word, user, why));
}

StoreHeader StoreReader::header() const {
  StoreHeader header = stated();
  for (std::uint64_t row = 0; row < rows(); ++row) {
    header.ids.push_back(id(row));
    header.labels.push_back(label(row));
    header.splits.push_back(split(row));
  }
  return header;
}

std::string StoreReader::id(std::uint64_t row) const {
  return state_->with_items(row, [](const ItemBlock& items, std::uint64_t at) { return items.id(at); });
}

std::optional<std::uint64_t> StoreReader::find(std::string_view wanted) const {
  const std::optional<std::uint64_t> row = state_->find(wanted);
  if (!row || *row < state_->begin || *row >= state_->end) return std::nullopt;
  return *row - state_->begin;
}

ItemReport StoreReader::report(std::uint64_t row) const {
  return state_->with_items(row, [](const ItemBlock& items, std::uint64_t at) { return items.report(at); });
}

std::int32_t StoreReader::label(std::uint64_t row) const {
  return state_->with_items(row, [](const ItemBlock& items, std::uint64_t at) { return items.label(at); });
}

Split StoreReader::split(std::uint64_t row) const {
  return state_->with_items(row, [](const ItemBlock& items, std::uint64_t at) { return items.split(at); });
}

Row StoreReader::read_row(std::uint64_t row) const {
  Row result;
  result.report = report(row);
  if (result.report.status != Status::ok) return result;
  const State::Place place = state_->place_of(row);
  place.part->read_row(place.row, result);
  result.names = place.part->names(place.row, result.report.names_bytes);
  return result;
}

std::string StoreReader::names(std::uint64_t row) const {
  const std::uint32_t bytes = report(row).names_bytes;
  const State::Place place = state_->place_of(row);
  return place.part->names(place.row, bytes);
}

Samples StoreReader::read_samples(std::uint64_t row, std::uint64_t begin, std::uint64_t end) const {
  const State::Place place = state_->place_of(row);
  return place.part->read_samples(place.row, begin, end);
}

CopiedRow StoreReader::copy_row(std::uint64_t row) const {
  const bool has_many = samples() > most_copied_samples && descriptors().empty() && !columns().has_sets();
  CopiedRow copied;
  copied.row = has_many ? Row{report(row), {}, {}, names(row)} : read_row(row);
  if (has_many && copied.row.report.status == Status::ok)
    copied.blocks = [this, row](std::uint64_t begin, std::uint64_t end) {
      return read_samples(row, begin, end);
    };
  return copied;
}

std::vector<float> StoreReader::read_descriptor(std::string_view name) const {
  return read_descriptor(name, 0, rows());
}

std::vector<float> StoreReader::read_descriptor(std::string_view name, std::uint64_t row,
                                                std::uint64_t count) const {
  const std::uint64_t width = state_->named.width_of(name);
  std::vector<float> values(count * width);  // rows that are not ok hold the fill value, NaN
  for (std::uint64_t done = 0; done < count;) {
    const State::Place place = state_->place_of(row + done);
    const std::uint64_t here = std::min(count - done, place.end - place.row);
    place.part->read_descriptor(name, place.row, std::span(values).subspan(done * width, here * width));
    done += here;
  }
  return values;
}

}  // namespace meander
