// HDF5 types, spaces, properties and attributes of the schema, as writer and reader both need them.
#include <algorithm>

#include "io/store/store_file.h"

namespace meander::store {

namespace {

Hdf5Type make_enum(std::span<const std::string_view> names) {
  Hdf5Type type(H5Tenum_create(H5T_STD_U8LE), "make an enum type");
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto value = static_cast<std::uint8_t>(i);
    hdf5_check(H5Tenum_insert(type.get(), std::string(names[i]).c_str(), &value), "name an enum value");
  }
  return type;
}

Hdf5Type copy_type(hid_t type) { return Hdf5Type(H5Tcopy(type), "copy a type"); }

Hdf5Type make_half_type() {
  Hdf5Type type = copy_type(H5T_IEEE_F32LE);
  hdf5_check(H5Tset_fields(type.get(), 15, 10, 5, 0, 10), "set the fields of a type");
  hdf5_check(H5Tset_size(type.get(), 2), "set the size of a type");
  hdf5_check(H5Tset_ebias(type.get(), 15), "set the bias of a type");
  return type;
}

Hdf5Type make_text_type(std::size_t width) {
  Hdf5Type type = copy_type(H5T_C_S1);
  hdf5_check(H5Tset_size(type.get(), width), "set the width of a text");
  hdf5_check(H5Tset_strpad(type.get(), H5T_STR_NULLPAD), "set the padding of a text");
  hdf5_check(H5Tset_cset(type.get(), H5T_CSET_UTF8), "set the encoding of a text");
  return type;
}

// Attributes are strings of variable length: h5py then gives `str`, not bytes.
Hdf5Type make_attribute_text_type() {
  Hdf5Type type = copy_type(H5T_C_S1);
  hdf5_check(H5Tset_size(type.get(), H5T_VARIABLE), "set the width of a text");
  hdf5_check(H5Tset_cset(type.get(), H5T_CSET_UTF8), "set the encoding of a text");
  return type;
}

void write_value(hid_t object, const char* name, hid_t type, hid_t memory_type, const Hdf5Space& space,
                 const void* value) {
  const Hdf5Attribute attribute(H5Acreate2(object, name, type, space.get(), H5P_DEFAULT, H5P_DEFAULT),
                                std::string("create attribute ") + name);
  hdf5_check(H5Awrite(attribute.get(), memory_type, value), std::string("write attribute ") + name);
}

Hdf5Space scalar_space() { return Hdf5Space(H5Screate(H5S_SCALAR), "make a scalar space"); }

}  // namespace

Hdf5Type make_type(const DatasetLayout& dataset) {
  switch (dataset.spec.type) {
    case ElementType::f32:
      return copy_type(H5T_IEEE_F32LE);
    case ElementType::f64:
      return copy_type(H5T_IEEE_F64LE);
    case ElementType::f16:
      return make_half_type();
    case ElementType::i32:
      return copy_type(H5T_STD_I32LE);
    case ElementType::u8:
      return copy_type(H5T_STD_U8LE);
    case ElementType::u32:
      return copy_type(H5T_STD_U32LE);
    case ElementType::u64:
      return copy_type(H5T_STD_U64LE);
    case ElementType::word:
      return make_enum(dataset.spec.words);
    case ElementType::text:
      return make_text_type(dataset.text_width);
  }
  return {};
}

std::vector<hsize_t> make_extents(const DatasetLayout& dataset, const StoreLayout& layout) {
  std::vector<hsize_t> extents{layout.rows};
  if (per_sample(dataset.spec)) extents.push_back(dataset.points);
  if (has_value_axis(dataset.spec)) extents.push_back(dataset.spec.width);
  return extents;
}

std::vector<hsize_t> make_chunk_extents(const DatasetLayout& dataset) {
  std::vector<hsize_t> extents{dataset.chunk.rows};
  if (per_sample(dataset.spec)) extents.push_back(dataset.chunk.samples);
  if (has_value_axis(dataset.spec)) extents.push_back(dataset.spec.width);
  return extents;
}

std::vector<hsize_t> chunk_offset(const DatasetLayout& dataset, std::uint64_t row, std::uint32_t part) {
  std::vector<hsize_t> offset{row};
  if (per_sample(dataset.spec)) offset.push_back(hsize_t{part} * dataset.chunk.samples);
  if (has_value_axis(dataset.spec)) offset.push_back(0);
  return offset;
}

namespace {

Hdf5Properties make_chunked(const std::vector<hsize_t>& chunk, Compression compression) {
  Hdf5Properties creation(H5Pcreate(H5P_DATASET_CREATE), "make creation properties");
  const hid_t id = creation.get();
  hdf5_check(H5Pset_chunk(id, static_cast<int>(chunk.size()), chunk.data()), "set the chunk shape");
  if (compression == Compression::standard) {
    hdf5_check(H5Pset_shuffle(id), "set the shuffle filter");
    hdf5_check(H5Pset_deflate(id, 1), "set the deflate filter");
  }
  hdf5_check(H5Pset_fletcher32(id), "set the fletcher32 filter");
  hdf5_check(H5Pset_alloc_time(id, H5D_ALLOC_TIME_INCR), "set the allocation time");
  hdf5_check(H5Pset_obj_track_times(id, false), "leave out times");
  hdf5_check(H5Pset_attr_creation_order(id, H5P_CRT_ORDER_TRACKED), "keep the order of attributes");
  return creation;
}

}  // namespace

Hdf5Properties make_names_creation(Compression compression) {
  return make_chunked({names_chunk}, compression);
}

Hdf5Properties make_creation(const DatasetLayout& dataset, Compression compression) {
  Hdf5Properties creation = make_chunked(make_chunk_extents(dataset), compression);
  const hid_t id = creation.get();
  if (dataset.spec.type != ElementType::text) {
    const Hdf5Type type = make_type(dataset);
    hdf5_check(H5Pset_fill_value(id, type.get(), &dataset.spec.fill), "set the fill value");
  }
  return creation;
}

void write_attribute(hid_t object, const char* name, std::string_view text) {
  const Hdf5Type type = make_attribute_text_type();
  const std::string terminated(text);
  const char* const pointer = terminated.c_str();
  write_value(object, name, type.get(), type.get(), scalar_space(), &pointer);
}

void write_attribute(hid_t object, const char* name, std::uint32_t number) {
  write_value(object, name, H5T_STD_U32LE, H5T_NATIVE_UINT32, scalar_space(), &number);
}

void write_attribute(hid_t object, const char* name, std::uint64_t number) {
  write_value(object, name, H5T_STD_U64LE, H5T_NATIVE_UINT64, scalar_space(), &number);
}

void write_attribute(hid_t object, const char* name, const std::vector<std::string>& texts) {
  const Hdf5Type type = make_attribute_text_type();
  std::vector<const char*> pointers;
  for (const std::string& text : texts) pointers.push_back(text.c_str());
  const hsize_t count = texts.size();
  const Hdf5Space space(H5Screate_simple(1, &count, nullptr), "make a space");
  const char* const nothing = nullptr;
  write_value(object, name, type.get(), type.get(), space, texts.empty() ? &nothing : pointers.data());
}

std::vector<std::string> read_texts(hid_t object, const char* name) {
  const std::string action = std::string("read attribute ") + name;
  const Hdf5Attribute attribute(H5Aopen(object, name, H5P_DEFAULT), action);
  const Hdf5Space space(H5Aget_space(attribute.get()), action);
  const Hdf5Type stored(H5Aget_type(attribute.get()), action);
  if (hdf5_check(H5Tis_variable_str(stored.get()), action) == 0)
    throw Hdf5Error("cannot " + action + ": not a text");
  const auto count = static_cast<std::size_t>(hdf5_check(H5Sget_simple_extent_npoints(space.get()), action));
  std::vector<char*> pointers(count, nullptr);
  std::vector<std::string> texts;
  if (count == 0) return texts;
  const Hdf5Type type = make_attribute_text_type();
  hdf5_check(H5Aread(attribute.get(), type.get(), pointers.data()), action);
  for (const char* pointer : pointers) texts.emplace_back(pointer == nullptr ? "" : pointer);
  H5Dvlen_reclaim(type.get(), space.get(), H5P_DEFAULT, pointers.data());
  return texts;
}

std::string read_text_attribute(hid_t object, const char* name) {
  std::vector<std::string> texts = read_texts(object, name);
  if (texts.size() != 1) throw Hdf5Error(std::string("attribute ") + name + " is not one text");
  return texts.front();
}

std::uint64_t read_number(hid_t object, const char* name) {
  const std::string action = std::string("read attribute ") + name;
  const Hdf5Attribute attribute(H5Aopen(object, name, H5P_DEFAULT), action);
  const Hdf5Space space(H5Aget_space(attribute.get()), action);
  if (hdf5_check(H5Sget_simple_extent_npoints(space.get()), action) != 1)
    throw Hdf5Error(std::string("attribute ") + name + " is not one number");
  std::uint64_t number = 0;
  hdf5_check(H5Aread(attribute.get(), H5T_NATIVE_UINT64, &number), action);
  return number;
}

bool has_attribute(hid_t object, const char* name) {
  return hdf5_check(H5Aexists(object, name), std::string("look for attribute ") + name) > 0;
}

}  // namespace meander::store
