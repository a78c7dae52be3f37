#include "io/store/schema.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <memory>
#include <type_traits>

#include "io/utf8.h"
#include "kernels/core/half.h"

namespace meander::store {

static_assert(std::endian::native == std::endian::little, "values are stored as they stand in memory");
static_assert(sizeof(RepairCounts) == 4 * repair_count);

namespace {

// Returns use(array) for the array of a dataset of samples; an attribute must exist.
template <class AnySamples, class Use>
decltype(auto) with_array_of(const DatasetSpec& spec, AnySamples& samples, const Use& use) {
  if (spec.column != nullptr) return with_array(*spec.column, samples, use);
  if (spec.type == ElementType::i32) return use(samples.classes[spec.attribute]);
  return use(samples.attributes[spec.attribute]);
}

bool has_array(const DatasetSpec& spec, const Samples& samples) {
  return spec.column != nullptr ||
         spec.attribute <
             (spec.type == ElementType::i32 ? samples.classes.size() : samples.attributes.size());
}

}  // namespace

std::span<const std::byte> DatasetSpec::view(const Samples& samples) const {
  if (!has_array(*this, samples)) return {};
  return with_array_of(*this, samples, [](const auto& values) { return std::as_bytes(std::span(values)); });
}

std::span<std::byte> DatasetSpec::room(Samples& samples, std::size_t count) const {
  if (!has_array(*this, samples)) {
    if (type == ElementType::i32)
      samples.classes.resize(attribute + 1);
    else
      samples.attributes.resize(attribute + 1);
  }
  return with_array_of(*this, samples, [&](auto& values) {
    values.resize(count);
    return std::as_writable_bytes(std::span(values));
  });
}

std::size_t DatasetSpec::count(const Samples& samples) const {
  if (!has_array(*this, samples)) return 0;
  return with_array_of(*this, samples, [](const auto& values) { return values.size(); });
}

std::span<const std::byte> DatasetSpec::stored(const Samples& samples, std::size_t begin, std::size_t end,
                                               std::vector<std::byte>& scratch) const {
  const std::span<const std::byte> all = view(samples);
  if (type != ElementType::f16)
    return all.subspan(begin * element_size(type), (end - begin) * element_size(type));
  scratch.resize((end - begin) * sizeof(std::uint16_t));
  // Writes to bytes may alias the vectors, so their addresses are read once.
  const std::byte* const from = all.data() + begin * sizeof(float);
  std::byte* const to = scratch.data();
  for (std::size_t i = 0; i < end - begin; ++i) {
    float value;
    std::memcpy(&value, from + i * sizeof value, sizeof value);
    const std::uint16_t half = half_of(value);
    std::memcpy(to + i * sizeof half, &half, sizeof half);
  }
  return scratch;
}

void DatasetSpec::put(std::span<const std::byte> values, std::size_t begin, std::size_t count,
                      Samples& samples) const {
  const std::span<std::byte> to = room(samples, count);
  if (type != ElementType::f16) {
    std::memcpy(to.data() + begin * element_size(type), values.data(), values.size());
    return;
  }
  for (std::size_t i = 0; i < values.size() / sizeof(std::uint16_t); ++i) {
    std::uint16_t half;
    std::memcpy(&half, values.data() + i * sizeof half, sizeof half);
    const float value = value_of_half(half);
    std::memcpy(to.data() + (begin + i) * sizeof value, &value, sizeof value);
  }
}

void DatasetSpec::free(Samples& samples) const {
  with_array_of(*this, samples, [](auto& values) { const auto freed = std::move(values); });
}

void DatasetSpec::put_item(const ItemReport& report, std::byte* out) const {
  std::visit(
      [&]<class Member>(Member member) {
        if constexpr (std::is_same_v<Member, std::string ItemReport::*>) {
          const std::string text = clean_line(report.*member, width);
          std::memset(out, 0, width);
          std::memcpy(out, text.data(), text.size());
        } else if constexpr (!std::is_same_v<Member, ItemKey>) {
          std::memcpy(out, &(report.*member), sizeof(report.*member));
        }
      },
      item->member);
}

void DatasetSpec::get_item(const std::byte* in, ItemReport& report) const {
  std::visit(
      [&]<class Member>(Member member) {
        if constexpr (std::is_same_v<Member, std::string ItemReport::*>) {
          const auto* text = reinterpret_cast<const char*>(in);
          (report.*member).assign(text, ::strnlen(text, width));
        } else if constexpr (!std::is_same_v<Member, ItemKey>) {
          std::memcpy(&(report.*member), in, sizeof(report.*member));
        }
      },
      item->member);
}

std::string DatasetSpec::path_in(std::uint32_t version) const {
  return column == nullptr ? path : "/" + std::string(column->name_in(version));
}

namespace {

DatasetSpec dataset_of(const StoreColumns& columns, std::size_t number) {
  const SampleColumn& column = sample_columns[number];
  DatasetSpec spec;
  spec.path = "/" + std::string(column.name);
  spec.role = Role::samples;
  spec.type = column.halves && columns.halves ? ElementType::f16 : type_of(column).element;
  spec.width = column.width;
  spec.fill = spec.type == ElementType::f32   ? fill_nan
              : spec.type == ElementType::f16 ? fill_half_nan
                                              : fill_ones;
  spec.unit = column.unit;
  spec.doc = column.doc;
  if (!column.link.empty()) spec.link = "/" + std::string(column.link);
  spec.column = &column;
  spec.set = column.set;
  spec.lacks_bit = columns.lacks_bit(number);
  return spec;
}

DatasetSpec dataset_of(const AttributeColumn& column, std::size_t number) {
  DatasetSpec spec;
  spec.path = "/" + std::string(attribute_prefix) + column.name;
  spec.role = Role::samples;
  spec.type = column.is_classes() ? ElementType::i32 : ElementType::f32;
  spec.width = column.width == 1 ? 0 : column.width;
  spec.fill = column.is_classes() ? fill_ones : fill_nan;
  spec.doc = std::string("with --attribute only: the attribute of this name at the point, ") +
             (column.is_classes() ? "-1 where there is none" : "NaN where there is none");
  spec.attribute = number;
  spec.lacks_bit = static_cast<std::uint32_t>(number);
  return spec;
}

Role role_of(const ItemColumn& column) {
  const ItemKey* const key = std::get_if<ItemKey>(&column.member);
  if (key == nullptr) return Role::item;
  return *key == ItemKey::label   ? Role::label
         : *key == ItemKey::id    ? Role::id
         : *key == ItemKey::split ? Role::split
                                  : Role::reason;
}

DatasetSpec dataset_of(const ItemColumn& column) {
  const ColumnType type = type_of(column);
  DatasetSpec spec;
  spec.path = "/" + std::string(column.name);
  spec.role = role_of(column);
  spec.type = type.element;
  spec.width = type.width;
  spec.fill = column.fill;
  spec.unit = column.unit;
  spec.doc = column.doc;
  spec.words = type.words;
  spec.value_names = type.names;
  spec.item = &column;
  spec.since = column.since;
  return spec;
}

std::vector<DatasetSpec> make_datasets(const StoreColumns& columns) {
  std::vector<DatasetSpec> datasets;
  for (std::size_t c = 0; c < sample_columns.size(); ++c)
    if (columns.has(c)) datasets.push_back(dataset_of(columns, c));
  for (std::size_t i = 0; i < columns.attributes.size(); ++i)
    datasets.push_back(dataset_of(columns.attributes[i], i));
  for (const ItemColumn& column : item_columns)
    if (columns.has(column)) datasets.push_back(dataset_of(column));
  return datasets;
}

// The line of the table of docs/STORE.md that stands for the columns of all attributes.
bool is_any_attribute(const DatasetSpec& spec) {
  return spec.role == Role::samples && spec.path.ends_with("<name>");
}

std::string shape_text(const DatasetSpec& spec) {
  if (spec.type == ElementType::text) return "(M)";
  if (is_any_attribute(spec)) return "(M, N) or (M, N, W)";
  const char* const points = spec.set == PointSet::sharp ? "S" : spec.set == PointSet::queries ? "Q" : "N";
  return per_sample(spec) ? (spec.width > 0 ? fmt::format("(M, {}, {})", points, spec.width)
                                            : fmt::format("(M, {})", points))
                          : (spec.width > 0 ? fmt::format("(M, {})", spec.width) : "(M)");
}

std::shared_ptr<const ColumnTable> make_table(StoreColumns columns) {
  auto table = std::make_shared<ColumnTable>();
  table->datasets = make_datasets(columns);
  table->columns = std::move(columns);
  ItemRecord& items = table->items;
  for (const DatasetSpec& spec : table->datasets) {
    if (spec.role != Role::item) continue;
    if (spec.path == status_path) items.status_offset = items.bytes;
    if (spec.path == names_bytes_path) items.names_offset = items.bytes;
    items.columns.emplace_back(&spec, items.bytes);
    items.bytes += value_bytes(spec);
  }
  return table;
}

void check_columns(const StoreColumns& columns) {
  const auto refuse = [](const std::string& what) { throw ItemError(Status::internal, what); };
  if (columns.chosen_count() > most_chosen_columns)
    refuse(fmt::format("a store of {} chosen columns", columns.chosen_count()));
  for (std::size_t i = 0; i < columns.attributes.size(); ++i) {
    const AttributeColumn& column = columns.attributes[i];
    if (const std::string problem = attribute_name_problem(column.name); !problem.empty())
      refuse(fmt::format("the attribute `{}` {}", column.name, problem));
    if (column.width < 1 || column.width > 4)
      refuse(fmt::format("the attribute `{}` has the width {}", column.name, column.width));
    if (i > 0 && columns.attributes[i - 1].name >= column.name)
      refuse(fmt::format("the attribute `{}` precedes `{}`", columns.attributes[i - 1].name, column.name));
  }
}

// The columns that format version 3 knows, with the names of the root attribute `content`.
struct NamedColumns {
  std::string_view name;
  StoreColumns columns;
};
const std::array<NamedColumns, 5>& plain_columns() {
  static const ColumnSet colors(&Samples::rgb);
  static const std::array<NamedColumns, 5> all = {
      {{"meshes", {}},
       {"surfaces", {.rows = RowKind::surfaces}},
       {"anisotropic meshes", {.tensors = true}},
       {"coloured meshes", {.asked = colors}},
       {"coloured anisotropic meshes", {.tensors = true, .asked = colors}}}};
  return all;
}

}  // namespace

std::string_view content_name(const StoreColumns& columns) {
  for (const NamedColumns& plain : plain_columns())
    if (plain.columns.rows == columns.rows && plain.columns.tensors == columns.tensors &&
        plain.columns.has(&Samples::rgb) == columns.has(&Samples::rgb))
      return plain.name;
  throw ItemError(Status::internal, "surfaces have neither tensors nor colors");
}

std::optional<StoreColumns> columns_of_content(std::string_view name) {
  for (const NamedColumns& plain : plain_columns())
    if (plain.name == name) return plain.columns;
  return std::nullopt;
}

std::vector<std::string> column_list(const StoredColumns& columns, std::uint32_t version) {
  std::vector<std::string> names;
  for (const DatasetSpec& spec : datasets_of(columns))
    if (spec.role == Role::samples) names.push_back(spec.path_in(version).substr(1));
  return names;
}

std::uint32_t ItemRecord::names_bytes(std::span<const std::byte> items) const {
  std::uint32_t length = 0;
  if (names_offset) std::memcpy(&length, items.data() + *names_offset, sizeof length);
  return length;
}

std::uint64_t row_bytes(const StoredColumns& columns, std::uint32_t samples) {
  std::uint64_t bytes = 0;
  for (const DatasetSpec& spec : datasets_of(columns))
    if (spec.role == Role::samples) bytes += columns->points_of(spec.set, samples) * value_bytes(spec);
  return bytes;
}

DatasetSpec descriptor_dataset(const DescriptorSchema& descriptor) {
  DatasetSpec spec;
  spec.path = "/" + descriptor.group + "/" + descriptor.name;
  spec.role = Role::descriptor;
  spec.width = descriptor.width;
  spec.fill = fill_nan;
  spec.unit = "1";
  spec.doc = "descriptor; its attributes explain the bins";
  return spec;
}

std::size_t element_size(ElementType type) {
  constexpr std::array<std::size_t, 9> sizes = {4, 8, 4, 1, 4, 8, 1, 1, 2};
  return sizes[static_cast<std::size_t>(type)];
}

std::string_view element_name(ElementType type) {
  constexpr std::array<std::string_view, 9> names = {
      "f32", "f64", "i32", "u8", "u32", "u64", "enum u8", "UTF-8, fixed width", "f16"};
  return names[static_cast<std::size_t>(type)];
}

std::string clean_line(std::string_view text, std::size_t max_bytes) {
  std::string clean;
  while (!text.empty()) {
    const std::size_t length = utf8_sequence_length(text);
    const std::size_t step = length == 0 ? 1 : length;
    if (clean.size() + step > max_bytes) break;
    if (length == 0)
      clean += '?';
    else if (length == 1 && (static_cast<unsigned char>(text[0]) < 0x20 || text[0] == 0x7F))
      clean += ' ';
    else
      clean += text.substr(0, length);
    text.remove_prefix(step);
  }
  return clean;
}

std::size_t value_bytes(const DatasetSpec& spec) {
  return element_size(spec.type) * std::max<std::size_t>(spec.width, 1);
}

bool per_sample(const DatasetSpec& spec) { return spec.role == Role::samples; }

void write_fill(const DatasetSpec& spec, std::span<std::byte> values) {
  // Copies of a page, which stays in the cache, instead of a call for every value.
  constexpr std::size_t page = 4096;
  const std::size_t size = element_size(spec.type), whole = values.size() / size * size;
  if (whole == 0) return;
  std::memcpy(values.data(), &spec.fill, size);
  for (std::size_t at = size; at < whole;) {
    const std::size_t bytes = std::min({at, page, whole - at});
    std::memcpy(values.data() + at, values.data(), bytes);
    at += bytes;
  }
}

std::string fill_text(const DatasetSpec& spec) {
  if (spec.type == ElementType::text) return "empty";
  if (spec.type == ElementType::word) return std::string(spec.words[spec.fill]);
  if (spec.type == ElementType::u8 && spec.fill == fill_ones) return "255";
  if (spec.type == ElementType::f32 && spec.fill == fill_nan) return "NaN";
  if (spec.type == ElementType::f16 && spec.fill == fill_half_nan) return "NaN";
  if (spec.type == ElementType::i32 && spec.fill == fill_ones) return "-1";
  return spec.fill == fill_ones ? "0xFFFFFFFF" : fmt::format("{}", spec.fill);
}

ChunkShape sample_chunk(std::uint64_t rows, std::uint32_t samples) {
  constexpr std::uint64_t bytes_per_sample = 12, smallest_chunk = 16384, largest_row = std::uint64_t{1} << 20;
  constexpr std::uint32_t longest = 65536;
  ChunkShape shape;
  while (shape.rows < sample_chunk_rows && shape.rows * samples * bytes_per_sample < smallest_chunk)
    shape.rows *= 2;
  shape.rows = std::clamp<std::uint64_t>(rows, 1, shape.rows);
  if (samples * bytes_per_sample > largest_row) shape.chunks_per_row = (samples + longest - 1) / longest;
  // Equal parts: a last chunk of a few samples would be padded to 65536 of them.
  shape.samples = (samples + shape.chunks_per_row - 1) / shape.chunks_per_row;
  return shape;
}

namespace {

// The chunks of the largest set of points.
ChunkShape largest_set_chunk(const StoredColumns& columns, std::uint64_t rows, std::uint32_t samples) {
  return sample_chunk(rows,
                      std::max(samples, *std::max_element(columns->counts.begin(), columns->counts.end())));
}

}  // namespace

ChunkShape set_chunk(const StoredColumns& columns, std::uint64_t rows, std::uint32_t samples, PointSet set) {
  ChunkShape shape = sample_chunk(rows, columns->points_of(set, samples));
  shape.rows = largest_set_chunk(columns, rows, samples).rows;
  return shape;
}

std::uint32_t most_chunks_per_row(const StoredColumns& columns, std::uint64_t rows, std::uint32_t samples) {
  return largest_set_chunk(columns, rows, samples).chunks_per_row;
}

ChunkShape descriptor_chunk(std::uint64_t rows, std::uint32_t width) {
  constexpr std::uint64_t largest_chunk = std::uint64_t{1} << 20;
  std::uint64_t chunk_rows = sample_chunk_rows;
  while (chunk_rows > 1 && chunk_rows * width * sizeof(float) > largest_chunk) chunk_rows /= 2;
  return {std::clamp<std::uint64_t>(rows, 1, chunk_rows), 0, 1};
}

void set_text_width(DatasetLayout& dataset, std::uint32_t width) {
  dataset.text_width = width;
  dataset.element_bytes = dataset.row_bytes = width;
  dataset.chunk_bytes = dataset.chunk.rows * width;
}

std::size_t StoreLayout::index_of(Role role) const {
  const auto found = std::find_if(datasets.begin(), datasets.end(),
                                  [&](const DatasetLayout& dataset) { return dataset.spec.role == role; });
  return static_cast<std::size_t>(found - datasets.begin());
}

std::size_t StoreLayout::index_of(std::string_view path) const {
  const auto found = std::find_if(datasets.begin(), datasets.end(),
                                  [&](const DatasetLayout& dataset) { return dataset.spec.path == path; });
  return static_cast<std::size_t>(found - datasets.begin());
}

StoreLayout make_layout(const StoreHeader& header) {
  std::size_t id_width = 1;
  for (const std::string& id : header.ids) id_width = std::max(id_width, id.size());
  return make_layout(header.columns, header.ids.size(), header.samples, header.compression,
                     header.descriptors, static_cast<std::uint32_t>(id_width), 1);
}

StoreLayout make_layout(const StoredColumns& columns, std::uint64_t rows, std::uint32_t samples,
                        Compression compression, const std::vector<DescriptorSchema>& descriptors,
                        std::uint32_t id_width, std::uint32_t reason_width) {
  StoreLayout layout{columns, rows, samples, compression, id_width, {}};
  const auto add = [&](const DatasetSpec& spec) {
    DatasetLayout dataset;
    dataset.spec = spec;
    dataset.element_bytes = element_size(spec.type);
    if (per_sample(spec)) dataset.points = columns->points_of(spec.set, samples);
    dataset.row_bytes = value_bytes(spec) * (per_sample(spec) ? dataset.points : 1);
    dataset.chunk = per_sample(spec) ? set_chunk(columns, rows, samples, spec.set)
                    : spec.role == Role::descriptor
                        ? descriptor_chunk(rows, spec.width)
                        : ChunkShape{std::clamp<std::uint64_t>(rows, 1, column_chunk_rows), 0, 1};
    dataset.chunk_bytes =
        dataset.chunk.rows * value_bytes(spec) * (per_sample(spec) ? dataset.chunk.samples : 1);
    if (spec.role == Role::item && spec.type == ElementType::text) set_text_width(dataset, spec.width);
    if (spec.role == Role::id) set_text_width(dataset, id_width);
    if (spec.role == Role::reason) set_text_width(dataset, reason_width);
    layout.datasets.push_back(std::move(dataset));
  };
  for (const DatasetSpec& spec : datasets_of(columns)) {
    add(spec);
    if (spec.role == Role::label)
      for (const DescriptorSchema& descriptor : descriptors) add(descriptor_dataset(descriptor));
  }
  return layout;
}

std::uint64_t sample_group_rows(const StoreLayout& layout) {
  constexpr std::uint64_t about = std::uint64_t{4} << 20;
  std::uint64_t bytes = 0, whole = 1;
  for (const DatasetLayout& dataset : layout.datasets) {
    if (!per_sample(dataset.spec)) continue;
    if (dataset.chunk.chunks_per_row > 1) return 1;
    bytes += dataset.row_bytes;
    whole = std::max(whole, dataset.chunk.rows);
  }
  std::uint64_t rows = sample_chunk_rows;
  while (rows > whole && rows * bytes > about) rows /= 2;
  return rows;
}

std::string layout_markdown() {
  std::string table = "| dataset | type | shape | fill | unit | meaning |\n|---|---|---|---|---|---|\n";
  const auto add = [&](const DatasetSpec& spec, const std::string& shape) {
    const std::string link = spec.link.empty() ? "" : fmt::format(", also `{}`", spec.link);
    const bool any = is_any_attribute(spec);
    const bool halves = spec.column != nullptr && spec.column->halves;
    const std::string type = any      ? "f32 or i32"
                             : halves ? "f32 or f16"
                                      : std::string(element_name(spec.type));
    table +=
        fmt::format("| `{}`{} | {} | {} | {} | {} | {} |\n", spec.path, link, type, shape,
                    any ? "NaN or -1" : fill_text(spec), spec.unit,
                    any ? "with --attribute only: the attribute of this name at the point, the fill where "
                          "there is none; i32: classes"
                        : spec.doc);
  };
  StoreColumns all{.tensors = true};
  for (std::size_t c = 0; c < sample_columns.size(); ++c) all.asked[c] = sample_columns[c].is_asked_for();
  all.attributes = {{"<name>", 1}, {"object", 1, AttributeKind::classes}};
  all.counts.fill(1);
  all.sides = all.nearest = true;
  const StoredColumns columns(std::move(all));
  for (const DatasetSpec& spec : datasets_of(columns)) {
    if (spec.path != "/attributes/object") add(spec, shape_text(spec));
    if (spec.role == Role::label) add(descriptor_dataset({"<name>", 1, {}}), "(M, B)");
  }
  table += fmt::format("| `{}` | u8 | (T) | 0 | 1 | {} |\n", names_path, names_doc);
  return table;
}

}  // namespace meander::store

namespace meander {

StoredColumns::StoredColumns(StoreColumns columns) {
  for (AttributeColumn& column : columns.attributes)
    if (column.kind == AttributeKind::linear) column.kind = AttributeKind::plain;
  static const auto plain = [] {
    std::array<std::shared_ptr<const store::ColumnTable>, 5> tables;
    for (std::size_t i = 0; i < tables.size(); ++i)
      tables[i] = store::make_table(store::plain_columns()[i].columns);
    return tables;
  }();
  store::check_columns(columns);
  for (const auto& table : plain)
    if (table->columns == columns) {
      table_ = table;
      return;
    }
  table_ = store::make_table(std::move(columns));
}

const StoreColumns& StoredColumns::operator*() const { return table_->columns; }

const StoreColumns* StoredColumns::operator->() const { return &table_->columns; }

}  // namespace meander
