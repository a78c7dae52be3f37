#include "io/store/schema.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <memory>
#include <type_traits>

#include "io/utf8.h"

namespace meander::store {

static_assert(std::endian::native == std::endian::little, "values are stored as they stand in memory");
static_assert(sizeof(RepairCounts) == 4 * repair_count);

namespace {

constexpr std::uint64_t all_ones = 0xFFFFFFFFu;  // u32 "nothing", i32 -1
constexpr std::uint64_t not_a_number = 0x7FC00000u;

template <class>
struct MemberType;
template <class Class, class Member>
struct MemberType<Member Class::*> {
  using type = Member;
};

template <auto Member>
void put(const ItemReport& report, std::byte* out) {
  static_assert(std::is_trivially_copyable_v<typename MemberType<decltype(Member)>::type>);
  std::memcpy(out, &(report.*Member), sizeof(report.*Member));
}

template <auto Member>
void get(const std::byte* in, ItemReport& report) {
  std::memcpy(&(report.*Member), in, sizeof(report.*Member));
}

template <auto Member>
std::span<const std::byte> view(const Samples& samples, std::size_t) {
  return std::as_bytes(std::span(samples.*Member));
}

template <auto Member>
std::span<std::byte> room(Samples& samples, std::size_t, std::size_t count) {
  (samples.*Member).resize(count);
  return std::as_writable_bytes(std::span(samples.*Member));
}

template <auto Member>
void free_array(Samples& samples, std::size_t) {
  auto freed = std::move(samples.*Member);
}

std::span<const std::byte> view_attribute(const Samples& samples, std::size_t attribute) {
  if (attribute >= samples.attributes.size()) return {};
  return std::as_bytes(std::span(samples.attributes[attribute]));
}

std::span<std::byte> attribute_room(Samples& samples, std::size_t attribute, std::size_t count) {
  if (attribute >= samples.attributes.size()) samples.attributes.resize(attribute + 1);
  samples.attributes[attribute].resize(count);
  return std::as_writable_bytes(std::span(samples.attributes[attribute]));
}

void free_attribute(Samples& samples, std::size_t attribute) {
  auto freed = std::move(samples.attributes[attribute]);
}

std::span<const std::byte> view_classes(const Samples& samples, std::size_t attribute) {
  if (attribute >= samples.classes.size()) return {};
  return std::as_bytes(std::span(samples.classes[attribute]));
}

std::span<std::byte> classes_room(Samples& samples, std::size_t attribute, std::size_t count) {
  if (attribute >= samples.classes.size()) samples.classes.resize(attribute + 1);
  samples.classes[attribute].resize(count);
  return std::as_writable_bytes(std::span(samples.classes[attribute]));
}

void free_classes(Samples& samples, std::size_t attribute) {
  auto freed = std::move(samples.classes[attribute]);
}

template <auto Member>
DatasetSpec sample_array(const char* path, ElementType type, std::uint32_t width, const char* unit,
                         const char* doc, const char* link = "") {
  DatasetSpec spec{path, Role::samples, type, width, type == ElementType::f32 ? not_a_number : all_ones,
                   unit, doc,           link};
  spec.samples_view = view<Member>;
  spec.samples_room = room<Member>;
  spec.samples_free = free_array<Member>;
  return spec;
}

template <auto Member>
DatasetSpec item_column(const char* name, ElementType type, std::uint32_t width, const char* unit,
                        const char* doc, std::uint64_t fill = 0, std::uint32_t since = 1) {
  DatasetSpec spec{std::string("/items/") + name, Role::item, type, width, fill, unit, doc, ""};
  spec.put_item = put<Member>;
  spec.get_item = get<Member>;
  spec.since = since;
  return spec;
}

DatasetSpec counts_by_name(DatasetSpec spec, std::span<const std::string_view> names) {
  spec.width = static_cast<std::uint32_t>(names.size());
  spec.value_names = names;
  return spec;
}

// A text of fixed width, filled up with zero bytes.
DatasetSpec note_text_column() {
  DatasetSpec spec{"/items/note_text",
                   Role::item,
                   ElementType::text,
                   note_text_width,
                   0,
                   "",
                   "the notes in words, with an example of each as far as there is room",
                   ""};
  spec.put_item = [](const ItemReport& report, std::byte* out) {
    const std::string text = clean_line(report.note_text, note_text_width);
    std::memset(out, 0, note_text_width);
    std::memcpy(out, text.data(), text.size());
  };
  spec.get_item = [](const std::byte* in, ItemReport& report) {
    const auto* text = reinterpret_cast<const char*>(in);
    report.note_text.assign(text, ::strnlen(text, note_text_width));
  };
  spec.since = 5;
  return spec;
}

DatasetSpec attribute_array(const AttributeColumn& column, std::size_t number) {
  DatasetSpec spec{"/" + std::string(attribute_prefix) + column.name,
                   Role::samples,
                   column.is_classes() ? ElementType::i32 : ElementType::f32,
                   column.width == 1 ? 0 : column.width,
                   column.is_classes() ? all_ones : not_a_number,
                   "",
                   std::string("with --attribute only: the attribute of this name at the point, ") +
                       (column.is_classes() ? "-1 where there is none" : "NaN where there is none"),
                   ""};
  spec.samples_view = column.is_classes() ? view_classes : view_attribute;
  spec.samples_room = column.is_classes() ? classes_room : attribute_room;
  spec.samples_free = column.is_classes() ? free_classes : free_attribute;
  spec.attribute = number;
  spec.lacks_bit = static_cast<std::uint32_t>(number);
  return spec;
}

std::vector<DatasetSpec> make_sample_datasets(const StoreColumns& columns) {
  using enum ElementType;
  using S = Samples;
  std::vector<DatasetSpec> datasets = {
      sample_array<&S::points>("/points", f32, 3, "length / scale",
                               "the points; file coordinates = loc + scale * point", "/data"),
  };
  const auto add = [&](SampleColumn column, DatasetSpec spec) {
    if (columns.has(column)) datasets.push_back(std::move(spec));
  };
  using C = SampleColumn;
  add(C::normals,
      sample_array<&S::normals>("/normals", f32, 3, "1", "unit normals at the points", "/normal"));
  add(C::uv, sample_array<&S::uv>("/uv", f32, 2, "1", "parameters of the point in [0, 1]"));
  add(C::face, sample_array<&S::face>("/face", u32, 0, "1", "number of the polygon in file order"));
  add(C::corners,
      sample_array<&S::corners>("/corners", u32, 3, "1", "vertex numbers of the file around the point"));
  add(C::barycentric, sample_array<&S::barycentric>("/barycentric", f32, 2, "1",
                                                    "weights of corners 1 and 2; corner 0 has the rest"));
  add(C::curve_rank,
      sample_array<&S::curve_rank>("/curve_rank", u32, 0, "1", "position along the curve, 0 .. N - 1"));
  add(C::density, sample_array<&S::density>("/density", f32, 0, "1", "value of the density at the point"));
  add(C::tensor, sample_array<&S::tensor_direction>(
                     "/tensor/direction", f32, 3, "1",
                     "anisotropic samples only: unit vector along the long spacing, of any sign"));
  add(C::tensor, sample_array<&S::tensor_spacing>(
                     "/tensor/spacing", f32, 2, "length / scale",
                     "anisotropic samples only: wanted spacings along and across the direction"));
  if (columns.colors)
    datasets.push_back(sample_array<&S::rgb>("/rgb", u8, 3, "1 / 255",
                                             "with --colors only: red, green and blue as displayed (sRGB)"));
  if (columns.texcoord) {
    datasets.push_back(sample_array<&S::texcoord>(
        "/texcoord", f32, 2, "1",
        "with --texcoord only: texture coordinates as the file has them, NaN where there are none"));
    datasets.back().lacks_bit = static_cast<std::uint32_t>(columns.attributes.size());
  }
  for (std::size_t i = 0; i < columns.attributes.size(); ++i)
    datasets.push_back(attribute_array(columns.attributes[i], i));
  return datasets;
}

DatasetSpec split_column() {
  DatasetSpec spec{"/items/split", Role::split, ElementType::split, 0, 0, "", "part of the data set", ""};
  spec.since = 2;
  return spec;
}

std::vector<DatasetSpec> make_item_datasets(const StoreColumns& columns) {
  using enum ElementType;
  using R = ItemReport;
  std::vector<DatasetSpec> datasets = {
      {"/label", Role::label, i32, 1, all_ones, "1", "class number, -1 where unknown", ""},
      {"/items/id", Role::id, text, 0, 0, "", "path of the item below the input root; ascending by bytes",
       ""},
      split_column(),
      item_column<&R::status>("status", status, 0, "", "how the item ended",
                              static_cast<std::uint64_t>(Status::internal)),
      {"/items/reason", Role::reason, text, 0, 0, "", "one sentence when the status is not ok", ""},
      item_column<&R::method>("method", method, 0, "", "the weakest method any component needed"),
      item_column<&R::order_reason>("order_reason", order_reason, 0, "",
                                    "why that method, where another one was asked for", 0, 3),
      item_column<&R::vertices>("vertices", u64, 0, "1", "vertices of the file"),
      item_column<&R::faces>("faces", u64, 0, "1", "polygons of the file"),
      item_column<&R::components>("components", u32, 0, "1", "connected components"),
      item_column<&R::genus>("genus", u32, 0, "1", "sum of the genera of the components"),
      item_column<&R::boundaries>("boundaries", u32, 0, "1", "boundary loops"),
      item_column<&R::area>("area", f64, 0, "length^2", "surface area"),
      item_column<&R::measure>("measure", f64, 0, "length^2", "area x density"),
      item_column<&R::bbox>("bbox", f64, 6, "length", "min x, y, z, max x, y, z"),
      item_column<&R::loc>("loc", f64, 3, "length", "file coordinates = loc + scale * point"),
      item_column<&R::scale>("scale", f64, 0, "length", "file coordinates = loc + scale * point"),
      item_column<&R::flips>("flips", u32, 0, "1", "flipped triangles of all charts"),
      item_column<&R::overlap>("overlap", f64, 0, "1", "share of the area where charts overlap themselves"),
      item_column<&R::area_scale_range>("area_scale_range", f64, 0, "1",
                                        "largest over smallest area scale, worst chart"),
      item_column<&R::distortion>("distortion", f64, 0, "1", "area-weighted mean quasi-conformal distortion"),
      counts_by_name(item_column<&R::repairs>("repairs", u32, 0, "1",
                                              "what was repaired, counted by name (attribute `names`)"),
                     repair_names),
      counts_by_name(item_column<&R::notes>(
                         "notes", u32, 0, "1",
                         "what the file asks for and did not get, counted by name (attribute `names`)", 0, 5),
                     note_names),
      note_text_column(),
      item_column<&R::file_bytes>("file_bytes", u64, 0, "byte",
                                  "length of the input; 0 where it was not read", 0, 2),
      item_column<&R::content_sha256>("content_sha256", u8, 32, "1", "SHA-256 of the bytes of the input"),
      item_column<&R::points_crc32c>("points_crc32c", u32, 0, "1",
                                     "CRC32C of the row of /points (little-endian); 0 unless ok"),
  };
  if (columns.colors) {
    datasets.push_back(item_column<&R::color_source>("color_source", color_source, 0, "",
                                                     "with --colors only: where the colours come from"));
    datasets.push_back(item_column<&R::color_fills>(
        "color_fills", u32, 0, "1", "with --colors only: samples without a colour, which have the fill 204"));
    datasets.push_back(item_column<&R::color_sha256>(
        "color_sha256", u8, 32, "1",
        "with --colors only: SHA-256 of the digests of the files read for colours alone; zeros: none"));
  }
  if (columns.chosen_count() > 0) {
    datasets.push_back(item_column<&R::lacks>("lacks", u32, 0, "1",
                                              "with --attribute or --texcoord: bit i: column i (attribute "
                                              "`names`) has no value at one sample or more"));
    datasets.push_back(
        item_column<&R::missing>("missing", u32, 0, "1",
                                 "with --attribute or --texcoord: bit i: the model has no such attribute, or "
                                 "no texture coordinates, at all",
                                 0, 5));
  }
  if (columns.has_names())
    datasets.push_back(item_column<&R::names_bytes>(
        "names_bytes", u32, 0, "byte",
        "with --attribute group, object, material or part only: length of the row's part of /names", 0, 5));
  return datasets;
}

// The line of the table of docs/STORE.md that stands for the columns of all attributes.
bool is_any_attribute(const DatasetSpec& spec) {
  return spec.role == Role::samples && spec.path.ends_with("<name>");
}

std::string shape_text(const DatasetSpec& spec) {
  if (spec.type == ElementType::text) return "(M)";
  if (is_any_attribute(spec)) return "(M, N) or (M, N, W)";
  return per_sample(spec) ? (spec.width > 0 ? fmt::format("(M, N, {})", spec.width) : "(M, N)")
                          : (spec.width > 0 ? fmt::format("(M, {})", spec.width) : "(M)");
}

}  // namespace

namespace {

std::shared_ptr<const ColumnTable> make_table(StoreColumns columns) {
  auto table = std::make_shared<ColumnTable>();
  table->datasets = make_sample_datasets(columns);
  for (DatasetSpec& spec : make_item_datasets(columns)) table->datasets.push_back(std::move(spec));
  table->columns = std::move(columns);
  ItemRecord& items = table->items;
  for (const DatasetSpec& spec : table->datasets) {
    if (spec.role != Role::item) continue;
    if (spec.type == ElementType::status) items.status_offset = items.bytes;
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
  static const std::array<NamedColumns, 5> all = {
      {{"meshes", {}},
       {"surfaces", {.rows = RowKind::surfaces}},
       {"anisotropic meshes", {.tensors = true}},
       {"coloured meshes", {.colors = true}},
       {"coloured anisotropic meshes", {.tensors = true, .colors = true}}}};
  return all;
}

}  // namespace

std::string_view content_name(const StoreColumns& columns) {
  for (const NamedColumns& plain : plain_columns())
    if (plain.columns.rows == columns.rows && plain.columns.tensors == columns.tensors &&
        plain.columns.colors == columns.colors)
      return plain.name;
  throw ItemError(Status::internal, "surfaces have neither tensors nor colours");
}

std::optional<StoreColumns> columns_of_content(std::string_view name) {
  for (const NamedColumns& plain : plain_columns())
    if (plain.name == name) return plain.columns;
  return std::nullopt;
}

std::vector<std::string> column_list(const StoredColumns& columns) {
  std::vector<std::string> names;
  for (const DatasetSpec& spec : datasets_of(columns))
    if (spec.role == Role::samples) names.push_back(spec.path.substr(1));
  return names;
}

std::uint32_t ItemRecord::names_bytes(std::span<const std::byte> items) const {
  std::uint32_t length = 0;
  if (names_offset) std::memcpy(&length, items.data() + *names_offset, sizeof length);
  return length;
}

std::uint64_t sample_bytes(const StoredColumns& columns) {
  std::uint64_t bytes = 0;
  for (const DatasetSpec& spec : datasets_of(columns))
    if (spec.role == Role::samples) bytes += value_bytes(spec);
  return bytes;
}

DatasetSpec descriptor_dataset(const DescriptorSchema& descriptor) {
  return {"/" + descriptor.group + "/" + descriptor.name,
          Role::descriptor,
          ElementType::f32,
          descriptor.width,
          not_a_number,
          "1",
          "descriptor; its attributes explain the bins",
          ""};
}

std::size_t element_size(ElementType type) {
  switch (type) {
    case ElementType::f64:
    case ElementType::u64:
      return 8;
    case ElementType::f32:
    case ElementType::i32:
    case ElementType::u32:
      return 4;
    case ElementType::u8:
    case ElementType::status:
    case ElementType::method:
    case ElementType::split:
    case ElementType::order_reason:
    case ElementType::color_source:
    case ElementType::text:
      return 1;
  }
  return 0;
}

std::string_view element_name(ElementType type) {
  constexpr std::array<std::string_view, 12> names = {"f32",     "f64",     "i32",     "u8",
                                                      "u32",     "u64",     "enum u8", "enum u8",
                                                      "enum u8", "enum u8", "enum u8", "UTF-8, fixed width"};
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
  if (spec.type == ElementType::status) return std::string(name_of(static_cast<Status>(spec.fill)));
  if (spec.type == ElementType::method) return std::string(name_of(static_cast<Method>(spec.fill)));
  if (spec.type == ElementType::split) return std::string(name_of(static_cast<Split>(spec.fill)));
  if (spec.type == ElementType::order_reason)
    return std::string(name_of(static_cast<OrderReason>(spec.fill)));
  if (spec.type == ElementType::color_source)
    return std::string(name_of(static_cast<ColorSource>(spec.fill)));
  if (spec.type == ElementType::u8 && spec.fill == all_ones) return "255";
  if (spec.type == ElementType::f32 && spec.fill == not_a_number) return "NaN";
  if (spec.type == ElementType::i32 && spec.fill == all_ones) return "-1";
  return spec.fill == all_ones ? "0xFFFFFFFF" : fmt::format("{}", spec.fill);
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

std::size_t StoreLayout::index_of(ElementType type) const {
  const auto found = std::find_if(datasets.begin(), datasets.end(),
                                  [&](const DatasetLayout& dataset) { return dataset.spec.type == type; });
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
    dataset.row_bytes = value_bytes(spec) * (per_sample(spec) ? samples : 1);
    dataset.chunk = per_sample(spec) ? sample_chunk(rows, samples)
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
    const std::string type = any ? "f32 or i32" : std::string(element_name(spec.type));
    table +=
        fmt::format("| `{}`{} | {} | {} | {} | {} | {} |\n", spec.path, link, type, shape,
                    any ? "NaN or -1" : fill_text(spec), spec.unit,
                    any ? "with --attribute only: the attribute of this name at the point, the fill where "
                          "there is none; i32: classes"
                        : spec.doc);
  };
  StoreColumns all{.tensors = true, .colors = true, .texcoord = true};
  all.attributes = {{"<name>", 1}, {"object", 1, AttributeKind::classes}};
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

bool StoreColumns::applies(SampleColumn column) const {
  switch (column) {
    case SampleColumn::face:
    case SampleColumn::corners:
    case SampleColumn::barycentric:
      return rows == RowKind::meshes;
    case SampleColumn::uv:
      return rows == RowKind::surfaces;
    case SampleColumn::tensor:
      return tensors;
    case SampleColumn::normals:
    case SampleColumn::curve_rank:
    case SampleColumn::density:
      return true;
  }
  return false;
}

bool StoreColumns::has(SampleColumn column) const {
  return applies(column) && (left_out >> static_cast<unsigned>(column) & 1) == 0;
}

std::string StoreColumns::chosen_name(std::size_t bit) const {
  if (bit < attributes.size()) return std::string(store::attribute_prefix) + attributes[bit].name;
  return "texcoord";
}

bool StoreColumns::has_names() const {
  return std::any_of(attributes.begin(), attributes.end(), [](const AttributeColumn& column) {
    return column.width == 1 && column.is_classes() &&
           std::find(numbered_attributes.begin(), numbered_attributes.end(), column.name) !=
               numbered_attributes.end();
  });
}

std::string attribute_name_problem(std::string_view name) {
  constexpr std::size_t longest = 200;
  if (name.empty()) return "has no name";
  if (name.size() > longest) return fmt::format("has a name of more than {} bytes", longest);
  if (name.find_first_not_of('.') == std::string_view::npos) return "is named by dots alone";
  for (std::string_view rest = name; !rest.empty();) {
    const std::size_t length = utf8_sequence_length(rest);
    if (length == 0) return "has a name that is not UTF-8";
    const auto byte = static_cast<unsigned char>(rest[0]);
    if (length == 1 && (byte < 0x20 || byte == 0x7F)) return "has a control character in its name";
    if (length == 1 && (byte == '/' || byte == ',' || byte == ':'))
      return fmt::format("has `{}` in its name", rest[0]);
    rest.remove_prefix(length);
  }
  return {};
}

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
