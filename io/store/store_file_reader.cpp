#include <fcntl.h>
#include <fmt/format.h>

#include <algorithm>

#include "io/store/file_checksum.h"
#include "io/store/store_file.h"

namespace meander::store {

namespace fs = std::filesystem;

namespace {

herr_t take_name(hid_t, const char* name, const H5L_info_t*, void* target) {
  static_cast<std::vector<std::string>*>(target)->emplace_back(name);
  return 0;
}

herr_t take_attribute_name(hid_t, const char* name, const H5A_info_t*, void* target) {
  static_cast<std::vector<std::string>*>(target)->emplace_back(name);
  return 0;
}

std::vector<hsize_t> extents_of(hid_t dataset) {
  const Hdf5Space space(H5Dget_space(dataset), "read an extent");
  std::vector<hsize_t> extents(
      static_cast<std::size_t>(hdf5_check(H5Sget_simple_extent_ndims(space.get()), "read an extent")));
  hdf5_check(H5Sget_simple_extent_dims(space.get(), extents.data(), nullptr), "read an extent");
  return extents;
}

std::vector<hsize_t> chunk_extents_of(hid_t creation) {
  if (H5Pget_layout(creation) != H5D_CHUNKED) return {};
  std::vector<hsize_t> extents(H5S_MAX_RANK);
  const int rank = hdf5_check(H5Pget_chunk(creation, H5S_MAX_RANK, extents.data()), "read a chunk shape");
  extents.resize(static_cast<std::size_t>(rank));
  return extents;
}

std::vector<H5Z_filter_t> filters_of(hid_t creation) {
  std::vector<H5Z_filter_t> filters;
  const int count = hdf5_check(H5Pget_nfilters(creation), "read the filters");
  for (int i = 0; i < count; ++i) {
    unsigned flags = 0;
    std::size_t values = 0;
    filters.push_back(
        H5Pget_filter2(creation, static_cast<unsigned>(i), &flags, &values, nullptr, 0, nullptr, nullptr));
  }
  return filters;
}

bool fill_is(hid_t creation, const DatasetLayout& dataset, hid_t type) {
  if (dataset.spec.type == ElementType::text) return true;
  std::uint64_t fill = 0, expected = 0;
  std::copy_n(reinterpret_cast<const char*>(&dataset.spec.fill), dataset.element_bytes,
              reinterpret_cast<char*>(&expected));
  return H5Pget_fill_value(creation, type, &fill) >= 0 && fill == expected;
}

bool same_type(const DatasetLayout& dataset, hid_t stored) {
  // Lists of names grow: an older file may name fewer values.
  if (dataset.spec.type == ElementType::word)
    return H5Tget_class(stored) == H5T_ENUM && H5Tget_size(stored) == 1;
  return H5Tequal(make_type(dataset).get(), stored) > 0;
}

std::uint32_t text_width(hid_t type) {
  return H5Tget_class(type) == H5T_STRING ? static_cast<std::uint32_t>(H5Tget_size(type)) : 0;
}

}  // namespace

std::string check_whole_file(const fs::path& path) {
  const FileDescriptor file = open_file(path, O_RDONLY);
  const std::uint64_t bytes = file_size(file, path);
  std::string block(user_block_bytes, '\0');
  if (bytes < user_block_bytes ||
      read_at(file, std::as_writable_bytes(std::span(block.data(), block.size())), 0, path) < block.size() ||
      !block.starts_with("meander store\n"))
    return "it does not begin as a store does";
  const std::string expected = user_block_text(bytes, checksum_of_file(file, user_block_bytes, path));
  if (block == expected) return {};
  const auto facts = [](const std::string& text) {  // the lines of the block after the first
    std::string line = text.substr(0, text.find('\0'));
    while (line.ends_with('\n')) line.pop_back();
    std::replace(line.begin(), line.end(), '\n', ' ');
    return line.substr(std::min<std::size_t>(line.size(), 14));
  };
  return fmt::format("its first block says \"{}\", but it has \"{}\"", facts(block), facts(expected));
}

StoreFileReader::StoreFileReader(const fs::path& path) : path_(path) {
  file_ =
      Hdf5File(H5Fopen(path.c_str(), H5F_ACC_RDONLY, access_without_locks().get()), "open " + path.string());
  read_facts();
  if (facts_.format_version > store_format_version) {
    problems_.push_back(fmt::format("{} has format version {}, this program reads up to {}", path.string(),
                                    facts_.format_version, store_format_version));
    return;
  }
  read_descriptors();
  layout_ =
      make_layout(facts_.columns, facts_.rows, facts_.samples, facts_.compression, facts_.descriptors, 1, 1);
  std::erase_if(layout_.datasets,
                [&](const DatasetLayout& dataset) { return dataset.spec.since > facts_.format_version; });
  for (DatasetLayout& dataset : layout_.datasets) {
    DatasetSpec& spec = dataset.spec;
    spec.path = spec.path_in(facts_.format_version);
    if (spec.path == spec.link) spec.link.clear();
    open_dataset(dataset);
  }
  if (layout_.index_of(names_bytes_path) < layout_.datasets.size()) open_names();
  layout_.id_width = layout_.datasets[layout_.index_of(Role::id)].text_width;
}

void StoreFileReader::read_facts() {
  const Hdf5Group root(H5Gopen2(file_.get(), "/", H5P_DEFAULT), "open the root group");
  const hid_t id = root.get();
  if (!has_attribute(id, "format") || read_text_attribute(id, "format") != "meander")
    throw Hdf5Error(path_.string() + " is an HDF5 file, but not a store of this program");
  facts_.format_version = static_cast<std::uint32_t>(read_number(id, "format_version"));
  facts_.method_version = static_cast<std::uint32_t>(read_number(id, "method_version"));
  facts_.tool_version = read_text_attribute(id, "tool_version");
  facts_.seed = read_number(id, "seed");
  facts_.samples = static_cast<std::uint32_t>(read_number(id, "samples"));
  facts_.rows = read_number(id, "rows");
  facts_.parameters_json = read_text_attribute(id, "parameters");
  const std::string compression = read_text_attribute(id, "compression");
  if (compression != "standard" && compression != "none")
    problems_.push_back(fmt::format("attribute compression is \"{}\"", compression));
  facts_.compression = compression == "none" ? Compression::none : Compression::standard;
  if (facts_.format_version <= store_format_version) facts_.columns = read_columns(id);
  facts_.packs = read_packs(file_.get());
  const Hdf5Dataset points(H5Dopen2(file_.get(), "/points", H5P_DEFAULT), "open /points");
  facts_.order = read_text_attribute(points.get(), "order");
  const Hdf5Dataset label(H5Dopen2(file_.get(), "/label", H5P_DEFAULT), "open /label");
  facts_.label_names = read_texts(label.get(), "names");
}

StoredColumns StoreFileReader::read_columns(hid_t root) const {
  const auto refuse = [&](const std::string& what) {
    throw Hdf5Error(path_.string() + " holds " + what + ", which this version does not know");
  };
  StoreColumns columns;
  if (has_attribute(root, "content")) {  // older stores hold meshes and do not say so
    const std::string content = read_text_attribute(root, "content");
    const std::optional<StoreColumns> named = columns_of_content(content);
    if (!named) refuse("`" + content + "`");
    columns = *named;
  }
  if (!has_attribute(root, "columns")) return StoredColumns(std::move(columns));
  for (std::size_t s = 0; s < point_set_names.size(); ++s)
    if (const std::string name(point_set_names[s]);
        static_cast<PointSet>(s) != PointSet::samples && has_attribute(root, name.c_str()))
      columns.counts[s] = static_cast<std::uint32_t>(read_number(root, name.c_str()));
  const std::vector<std::string> list = read_texts(root, "columns");
  const auto lists = [&](std::string_view name) {
    return std::find(list.begin(), list.end(), name) != list.end();
  };
  if (columns.points_of(PointSet::queries, 0) > 0) read_query_facts(lists, columns);
  for (std::size_t c = 0; c < sample_columns.size(); ++c) {
    const bool is_listed = lists(sample_columns[c].name_in(facts_.format_version));
    if (sample_columns[c].is_asked_for()) columns.asked[c] = columns.asked[c] || is_listed;
    columns.left_out[c] = columns.applies(c) && !is_listed;
  }
  for (const std::string& name : list) {
    if (!name.starts_with(attribute_prefix)) continue;
    const Hdf5Dataset dataset(H5Dopen2(file_.get(), name.c_str(), H5P_DEFAULT), "open /" + name);
    const std::vector<hsize_t> extents = extents_of(dataset.get());
    const hsize_t width = extents.size() == 3 ? extents[2] : 1;
    if (width > 4) refuse("/" + name + " of the width " + std::to_string(width));
    const Hdf5Type type(H5Dget_type(dataset.get()), "read the type of /" + name);
    const AttributeKind kind =
        H5Tget_class(type.get()) == H5T_INTEGER ? AttributeKind::classes : AttributeKind::plain;
    columns.attributes.push_back(
        {name.substr(attribute_prefix.size()), static_cast<std::uint32_t>(width), kind});
  }
  try {
    StoredColumns stored(std::move(columns));
    if (column_list(stored, facts_.format_version) != list) refuse("columns that differ from their list");
    return stored;
  } catch (const ItemError& error) {
    throw Hdf5Error(path_.string() + ": " + error.what());
  }
}

void StoreFileReader::read_query_facts(const std::function<bool(std::string_view)>& lists,
                                       StoreColumns& columns) const {
  columns.sides = lists(sample_columns[column_of(&Samples::query_inside)].name);
  columns.nearest = lists(sample_columns[column_of(&Samples::query_face)].name);
  const Hdf5Dataset points(H5Dopen2(file_.get(), "/queries/points", H5P_DEFAULT), "open /queries/points");
  const Hdf5Type type(H5Dget_type(points.get()), "read the type of /queries/points");
  columns.halves = H5Tget_size(type.get()) == sizeof(std::uint16_t);
  const Hdf5Dataset kind(H5Dopen2(file_.get(), "/queries/kind", H5P_DEFAULT), "open /queries/kind");
  columns.query_groups = read_texts(kind.get(), "names");
}

void StoreFileReader::read_descriptors() {
  for (const char* const group : {"descriptors", "anisotropy", "certificate"})
    if (H5Lexists(file_.get(), group, H5P_DEFAULT) > 0) read_descriptors(group);
}

void StoreFileReader::read_descriptors(const std::string& folder) {
  const Hdf5Group group(H5Gopen2(file_.get(), folder.c_str(), H5P_DEFAULT), "open /" + folder);
  std::vector<std::string> names;
  hdf5_check(H5Literate(group.get(), H5_INDEX_CRT_ORDER, H5_ITER_INC, nullptr, take_name, &names),
             "list /" + folder);
  for (const std::string& name : names) {
    const Hdf5Dataset dataset(H5Dopen2(group.get(), name.c_str(), H5P_DEFAULT), "open descriptor " + name);
    const std::vector<hsize_t> extents = extents_of(dataset.get());
    DescriptorSchema& schema = facts_.descriptors.emplace_back();
    schema.name = name;
    schema.group = folder;
    schema.width = extents.size() == 2 ? static_cast<std::uint32_t>(extents[1]) : 1;
    std::vector<std::string> attributes;
    hdf5_check(H5Aiterate2(dataset.get(), H5_INDEX_CRT_ORDER, H5_ITER_INC, nullptr, take_attribute_name,
                           &attributes),
               "list the attributes of " + name);
    for (const std::string& attribute : attributes)
      schema.attributes.emplace_back(attribute, read_text_attribute(dataset.get(), attribute.c_str()));
  }
}

void StoreFileReader::open_dataset(DatasetLayout& dataset) {
  DatasetSpec& spec = dataset.spec;
  const auto complain = [&](const std::string& what) {
    problems_.push_back(fmt::format("{} {}", spec.path, what));
  };
  datasets_.emplace_back();
  types_.emplace_back();
  const htri_t there = H5Lexists(file_.get(), spec.path.c_str(), H5P_DEFAULT);
  if (there <= 0) return complain("is missing");
  datasets_.back() = Hdf5Dataset(H5Dopen2(file_.get(), spec.path.c_str(), H5P_DEFAULT), "open " + spec.path);
  const hid_t id = datasets_.back().get();
  types_.back() = Hdf5Type(H5Dget_type(id), "read the type of " + spec.path);
  const std::vector<hsize_t> extents = extents_of(id);
  if (spec.type == ElementType::text) {
    const std::uint32_t width = text_width(types_.back().get());
    if (width == 0) return complain("is not a text of fixed width");
    if (spec.role == Role::item && width != spec.width) return complain("has another width than the schema");
    set_text_width(dataset, width);
  }
  if (!spec.value_names.empty() && extents.size() == 2 && extents[1] < spec.width) {
    spec.width = static_cast<std::uint32_t>(extents[1]);  // of a version that knew fewer names
    dataset.row_bytes = value_bytes(spec);
    dataset.chunk_bytes = dataset.chunk.rows * dataset.row_bytes;
  }
  if (!same_type(dataset, types_.back().get())) return complain("has another type than the schema");
  if (extents != make_extents(dataset, layout_)) return complain("has another shape than the schema");
  const Hdf5Properties creation(H5Dget_create_plist(id), "read the properties of " + spec.path);
  if (facts_.packs.empty()) {
    if (chunk_extents_of(creation.get()) != make_chunk_extents(dataset))
      complain("has other chunks than the schema");
    std::vector<H5Z_filter_t> expected{H5Z_FILTER_FLETCHER32};
    if (layout_.compression == Compression::standard)
      expected = {H5Z_FILTER_SHUFFLE, H5Z_FILTER_DEFLATE, H5Z_FILTER_FLETCHER32};
    if (filters_of(creation.get()) != expected) complain("has other filters than the schema");
  } else if (H5Pget_layout(creation.get()) != H5D_VIRTUAL) {
    complain("does not lead to the packs");
  }
  if (!fill_is(creation.get(), dataset, types_.back().get()))
    complain("has another fill value than the schema");
  if (spec.link.empty()) return;
  H5O_info_t first{}, second{};
  if (H5Lexists(file_.get(), spec.link.c_str(), H5P_DEFAULT) <= 0 ||
      H5Oget_info_by_name2(file_.get(), spec.path.c_str(), &first, H5O_INFO_BASIC, H5P_DEFAULT) < 0 ||
      H5Oget_info_by_name2(file_.get(), spec.link.c_str(), &second, H5O_INFO_BASIC, H5P_DEFAULT) < 0 ||
      first.addr != second.addr)
    complain(fmt::format("has no second name {}", spec.link));
}

void StoreFileReader::open_names() {
  const auto complain = [&](const std::string& what) {
    problems_.push_back(fmt::format("{} {}", names_path, what));
  };
  if (H5Lexists(file_.get(), names_path, H5P_DEFAULT) <= 0) return complain("is missing");
  names_dataset_ =
      Hdf5Dataset(H5Dopen2(file_.get(), names_path, H5P_DEFAULT), std::string("open ") + names_path);
  const hid_t id = names_dataset_.get();
  const std::vector<hsize_t> extents = extents_of(id);
  const Hdf5Type type(H5Dget_type(id), std::string("read the type of ") + names_path);
  if (extents.size() != 1 || H5Tequal(type.get(), H5T_STD_U8LE) <= 0) return complain("is no list of bytes");
  names_bytes_ = extents[0];
  const Hdf5Properties creation(H5Dget_create_plist(id), std::string("read the properties of ") + names_path);
  const std::vector<hsize_t> chunk = chunk_extents_of(creation.get());
  if (facts_.packs.empty() && chunk != std::vector<hsize_t>{names_chunk})
    complain("has other chunks than the schema");
}

void StoreFileReader::read_names(std::uint64_t begin, std::span<std::byte> names) const {
  const std::string action = fmt::format("read {} of {}", names_path, path_.string());
  if (names.empty()) return;
  if (begin > names_bytes_ || names.size() > names_bytes_ - begin)
    throw Hdf5Error(fmt::format("cannot {}: it has {} bytes", action, names_bytes_));
  const hsize_t all = names_bytes_, from = begin, count = names.size();
  const Hdf5Space file_space(H5Screate_simple(1, &all, nullptr), action);
  hdf5_check(H5Sselect_hyperslab(file_space.get(), H5S_SELECT_SET, &from, nullptr, &count, nullptr), action);
  const Hdf5Space memory(H5Screate_simple(1, &count, nullptr), action);
  hdf5_check(
      H5Dread(names_dataset_.get(), H5T_STD_U8LE, memory.get(), file_space.get(), H5P_DEFAULT, names.data()),
      action);
}

std::vector<std::uint64_t> StoreFileReader::read_name_ends() const {
  const std::size_t dataset = layout_.index_of(names_bytes_path);
  std::vector<std::uint64_t> ends(layout_.rows, 0);
  if (dataset == layout_.datasets.size()) return ends;
  std::uint64_t end = 0;
  std::vector<std::uint32_t> lengths;
  for_each_part({0, layout_.rows}, column_chunk_rows, [&](RowRange rows) {
    lengths.resize(rows.size());
    read_rows(dataset, rows.begin, rows.size(), std::as_writable_bytes(std::span(lengths)));
    for (std::uint64_t row = rows.begin; row < rows.end; ++row) ends[row] = end += lengths[row - rows.begin];
  });
  return ends;
}

void StoreFileReader::read_rows(std::size_t dataset, std::uint64_t row, std::uint64_t count,
                                std::span<std::byte> values) const {
  const DatasetLayout& layout = layout_.datasets[dataset];
  read_block(dataset, {row}, {count}, count * layout.row_bytes, values);
}

void StoreFileReader::read_samples(std::size_t dataset, std::uint64_t row, std::uint64_t begin,
                                   std::uint64_t count, std::span<std::byte> values) const {
  const DatasetLayout& layout = layout_.datasets[dataset];
  read_block(dataset, {row, begin}, {1, count}, count * value_bytes(layout.spec), values);
}

// A block that begins there along the first axes, and has so many entries along these and all along others.
void StoreFileReader::read_block(std::size_t dataset, std::initializer_list<std::uint64_t> first,
                                 std::initializer_list<std::uint64_t> counts, std::uint64_t bytes,
                                 std::span<std::byte> values) const {
  const DatasetLayout& layout = layout_.datasets[dataset];
  const std::string action =
      fmt::format("read {} row {} of {}", layout.spec.path, *first.begin(), path_.string());
  std::vector<hsize_t> extents = make_extents(layout, layout_);
  std::vector<hsize_t> begin(extents.size(), 0);
  const Hdf5Space file_space(H5Screate_simple(static_cast<int>(extents.size()), extents.data(), nullptr),
                             action);
  std::copy(first.begin(), first.end(), begin.begin());
  std::copy(counts.begin(), counts.end(), extents.begin());
  hdf5_check(
      H5Sselect_hyperslab(file_space.get(), H5S_SELECT_SET, begin.data(), nullptr, extents.data(), nullptr),
      action);
  const Hdf5Space memory(H5Screate_simple(static_cast<int>(extents.size()), extents.data(), nullptr), action);
  if (values.size() != bytes) throw Hdf5Error("cannot " + action + ": wrong room");
  // The stored type is also the one in memory: all of them are little-endian.
  hdf5_check(H5Dread(datasets_[dataset].get(), types_[dataset].get(), memory.get(), file_space.get(),
                     H5P_DEFAULT, values.data()),
             action);
}

bool StoreFileReader::has_chunk(std::size_t dataset, std::uint64_t row, std::uint32_t part) const {
  const DatasetLayout& layout = layout_.datasets[dataset];
  hsize_t bytes = 0;
  // Libraries differ in whether a chunk that was never written is an error.
  return H5Dget_chunk_storage_size(datasets_[dataset].get(), chunk_offset(layout, row, part).data(),
                                   &bytes) >= 0 &&
         bytes > 0;
}

void StoreFileReader::read_chunk(std::size_t dataset, std::uint64_t row, std::uint32_t part,
                                 std::vector<std::byte>& filtered) const {
  const DatasetLayout& layout = layout_.datasets[dataset];
  const std::vector<hsize_t> offset = chunk_offset(layout, row, part);
  const std::string action = fmt::format("read chunk {} of {} in {}", row, layout.spec.path, path_.string());
  const hid_t id = datasets_[dataset].get();
  hsize_t bytes = 0;
  std::uint32_t mask = 0;
  hdf5_check(H5Dget_chunk_storage_size(id, offset.data(), &bytes), action);
  filtered.resize(bytes);
  if (bytes == 0) throw Hdf5Error("cannot " + action + ": it was never written");
  hdf5_check(H5Dread_chunk(id, H5P_DEFAULT, offset.data(), &mask, filtered.data()), action);
  if (mask != 0) throw Hdf5Error("cannot " + action + ": a filter was left out");
}

}  // namespace meander::store
