#include <fcntl.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <cstring>

#include "io/file/file_descriptor.h"
#include "io/store/store_file.h"
#include "io/store/store_reader.h"

namespace meander::store {

namespace {

constexpr const char* group_name = "/packs";
constexpr std::uint64_t most_packs = 65536;
constexpr std::size_t longest_text = 65536;  // of a name or an id, in bytes

Hdf5Type text_type(std::size_t width) {
  Hdf5Type type(H5Tcopy(H5T_C_S1), "make a type");
  hdf5_check(H5Tset_size(type.get(), std::max<std::size_t>(width, 1)), "make a type");
  hdf5_check(H5Tset_strpad(type.get(), H5T_STR_NULLPAD), "make a type");
  hdf5_check(H5Tset_cset(type.get(), H5T_CSET_UTF8), "make a type");
  return type;
}

void write_list(hid_t group, const char* name, hid_t type, std::uint64_t count, const void* values) {
  const std::string action = std::string("write /packs/") + name;
  const hsize_t extent = count;
  const Hdf5Space space(H5Screate_simple(1, &extent, nullptr), action);
  const Hdf5Properties creation(H5Pcreate(H5P_DATASET_CREATE), action);
  hdf5_check(H5Pset_obj_track_times(creation.get(), false), action);
  const Hdf5Dataset list(H5Dcreate2(group, name, type, space.get(), H5P_DEFAULT, creation.get(), H5P_DEFAULT),
                         action);
  hdf5_check(H5Dwrite(list.get(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values), action);
}

void write_texts(hid_t group, const char* name, std::span<const StorePack> packs,
                 std::string StorePack::*member) {
  std::size_t width = 1;
  for (const StorePack& pack : packs) width = std::max(width, (pack.*member).size());
  std::string values(width * packs.size(), '\0');
  for (std::size_t p = 0; p < packs.size(); ++p) (packs[p].*member).copy(&values[p * width], width);
  write_list(group, name, text_type(width).get(), packs.size(), values.data());
}

template <class Value>
void write_numbers(hid_t group, const char* name, hid_t type, std::span<const StorePack> packs,
                   Value StorePack::*member) {
  std::vector<Value> values;
  for (const StorePack& pack : packs) values.push_back(pack.*member);
  write_list(group, name, type, packs.size(), values.data());
}

// Calls read(dataset, type, count) for a list of `count` values, which is not longer than most_packs.
template <class Read>
void with_list(hid_t group, const char* name, const Read& read) {
  const std::string action = std::string("read /packs/") + name;
  const Hdf5Dataset list(H5Dopen2(group, name, H5P_DEFAULT), action);
  const Hdf5Space space(H5Dget_space(list.get()), action);
  const auto count =
      static_cast<std::uint64_t>(hdf5_check(H5Sget_simple_extent_npoints(space.get()), action));
  if (count == 0 || count > most_packs) throw Hdf5Error(fmt::format("cannot {}: {} values", action, count));
  read(list.get(), Hdf5Type(H5Dget_type(list.get()), action), count, action);
}

std::vector<std::string> read_texts_of(hid_t group, const char* name) {
  std::vector<std::string> texts;
  with_list(group, name,
            [&](hid_t list, const Hdf5Type& stored, std::uint64_t count, const std::string& action) {
              const std::size_t width = H5Tget_size(stored.get());
              if (H5Tget_class(stored.get()) != H5T_STRING || width == 0 || width > longest_text)
                throw Hdf5Error("cannot " + action + ": not texts of fixed width");
              std::string values(width * count, '\0');
              hdf5_check(H5Dread(list, stored.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), action);
              for (std::size_t i = 0; i < count; ++i) {
                const std::string_view text = std::string_view(values).substr(i * width, width);
                texts.emplace_back(text.substr(0, text.find('\0')));
              }
            });
  return texts;
}

std::vector<std::uint64_t> read_numbers_of(hid_t group, const char* name) {
  std::vector<std::uint64_t> numbers;
  with_list(
      group, name, [&](hid_t list, const Hdf5Type& stored, std::uint64_t count, const std::string& action) {
        if (H5Tget_class(stored.get()) != H5T_INTEGER) throw Hdf5Error("cannot " + action + ": not numbers");
        numbers.resize(count);
        hdf5_check(H5Dread(list, H5T_NATIVE_UINT64, H5S_ALL, H5S_ALL, H5P_DEFAULT, numbers.data()), action);
      });
  return numbers;
}

// The library takes %b in the name of a source for the number of a block.
std::string source_name(const std::string& file) {
  std::string name;
  for (const char c : file) name += c == '%' ? std::string("%%") : std::string(1, c);
  return name;
}

}  // namespace

std::string difference_to_pack(const std::filesystem::path& path, const StorePack& pack) {
  if (!std::filesystem::is_regular_file(path))
    return fmt::format("its pack {} is missing; all packs must lie beside it", path.string());
  const StorePack found = sealed_pack(path);
  if (found.bytes == pack.bytes && found.crc32c == pack.crc32c) return {};
  return fmt::format(
      "its pack {} is another file: {} bytes with the checksum {:08x} instead of {} with {:08x}",
      path.string(), found.bytes, found.crc32c, pack.bytes, pack.crc32c);
}

StorePack sealed_pack(const std::filesystem::path& path) {
  const FileDescriptor file = open_file(path, O_RDONLY);
  std::string block(user_block_bytes, '\0');
  const std::size_t read =
      read_at(file, std::as_writable_bytes(std::span(block.data(), block.size())), 0, path);
  StorePack pack;
  unsigned long long bytes = 0;
  if (read < block.size() ||
      std::sscanf(block.c_str(), "meander store\nbytes %20llu\ncrc32c %8x\n", &bytes, &pack.crc32c) != 2)
    throw RunError(RunError::Kind::unusable, fmt::format("{} does not begin as a store does", path.string()));
  pack.bytes = bytes;
  return pack;
}

std::vector<std::filesystem::path> packs_of_store(const std::filesystem::path& store) {
  // The library is not asked to parse bytes that nobody has checked, and an index is small.
  constexpr std::uint64_t largest_index = std::uint64_t{256} << 20;
  std::error_code error;
  const std::uint64_t bytes = std::filesystem::file_size(store, error);
  std::vector<std::filesystem::path> paths;
  if (error || bytes > largest_index || !check_whole_file(store).empty()) return paths;
  const Hdf5Lock lock;
  try {
    const StoreFileReader file(store);
    for (const StorePack& pack : file.facts().packs)
      if (std::filesystem::path path = store.parent_path() / pack.file;
          difference_to_pack(path, pack).empty())
        paths.push_back(std::move(path));
  } catch (const std::runtime_error&) {  // RunError and Hdf5Error
  }
  return paths;
}

void remove_packs(const std::vector<std::filesystem::path>& packs) {
  std::error_code ignored;
  for (const std::filesystem::path& path : packs) std::filesystem::remove(path, ignored);
}

void write_packs(hid_t file, std::span<const StorePack> packs) {
  const Hdf5Properties creation(H5Pcreate(H5P_GROUP_CREATE), "make group properties");
  hdf5_check(H5Pset_obj_track_times(creation.get(), false), "leave out times");
  const Hdf5Group group(H5Gcreate2(file, group_name, H5P_DEFAULT, creation.get(), H5P_DEFAULT),
                        "create group /packs");
  write_texts(group.get(), "file", packs, &StorePack::file);
  write_texts(group.get(), "first_id", packs, &StorePack::first_id);
  write_numbers(group.get(), "rows", H5T_STD_U64LE, packs, &StorePack::rows);
  write_numbers(group.get(), "bytes", H5T_STD_U64LE, packs, &StorePack::bytes);
  write_numbers(group.get(), "crc32c", H5T_STD_U32LE, packs, &StorePack::crc32c);
}

std::vector<StorePack> read_packs(hid_t file) {
  if (hdf5_check(H5Lexists(file, "packs", H5P_DEFAULT), "look for /packs") == 0) return {};
  const Hdf5Group group(H5Gopen2(file, group_name, H5P_DEFAULT), "open /packs");
  const std::vector<std::string> files = read_texts_of(group.get(), "file"),
                                 first_ids = read_texts_of(group.get(), "first_id");
  const std::vector<std::uint64_t> rows = read_numbers_of(group.get(), "rows"),
                                   bytes = read_numbers_of(group.get(), "bytes"),
                                   checksums = read_numbers_of(group.get(), "crc32c");
  for (const std::size_t count : {first_ids.size(), rows.size(), bytes.size(), checksums.size()})
    if (count != files.size()) throw Hdf5Error("the lists of /packs have different lengths");
  std::vector<StorePack> packs;
  for (std::size_t p = 0; p < files.size(); ++p) {
    // Names lead to no other folder, whoever made the index.
    if (files[p].empty() || files[p] == "." || files[p] == ".." || files[p].find('/') != std::string::npos)
      throw Hdf5Error(fmt::format("/packs/file {} is no name of a file: \"{}\"", p, files[p]));
    if (rows[p] == 0) throw Hdf5Error(fmt::format("pack {} of /packs has no rows", files[p]));
    packs.push_back({files[p], first_ids[p], rows[p], bytes[p], static_cast<std::uint32_t>(checksums[p])});
  }
  return packs;
}

Hdf5Properties make_virtual_creation(const DatasetLayout& dataset, const StoreLayout& layout,
                                     std::span<const StorePack> packs) {
  Hdf5Properties creation(H5Pcreate(H5P_DATASET_CREATE), "make creation properties");
  const hid_t id = creation.get();
  hdf5_check(H5Pset_obj_track_times(id, false), "leave out times");
  hdf5_check(H5Pset_attr_creation_order(id, H5P_CRT_ORDER_TRACKED), "keep the order of attributes");
  if (dataset.spec.type != ElementType::text) {
    const Hdf5Type type = make_type(dataset);
    hdf5_check(H5Pset_fill_value(id, type.get(), &dataset.spec.fill), "set the fill value");
  }
  const std::string action = "map " + dataset.spec.path + " to the packs";
  const std::string oldest_path = dataset.spec.path_in(0);  // packs may be of an earlier format version
  const std::vector<hsize_t> extents = make_extents(dataset, layout);
  const Hdf5Space all(H5Screate_simple(static_cast<int>(extents.size()), extents.data(), nullptr), action);
  std::vector<hsize_t> begin(extents.size(), 0), part = extents;
  for (const StorePack& pack : packs) {
    part[0] = pack.rows;
    const Hdf5Space source(H5Screate_simple(static_cast<int>(part.size()), part.data(), nullptr), action);
    hdf5_check(H5Sselect_hyperslab(all.get(), H5S_SELECT_SET, begin.data(), nullptr, part.data(), nullptr),
               action);
    hdf5_check(
        H5Pset_virtual(id, all.get(), source_name(pack.file).c_str(), oldest_path.c_str(), source.get()),
        action);
    begin[0] += pack.rows;
  }
  return creation;
}

Hdf5Properties make_virtual_names(std::span<const StorePack> packs) {
  const std::string action = "map /names to the packs";
  Hdf5Properties creation(H5Pcreate(H5P_DATASET_CREATE), action);
  hdf5_check(H5Pset_obj_track_times(creation.get(), false), action);
  hsize_t total = 0, begin = 0;
  for (const StorePack& pack : packs) total += pack.names_bytes;
  const Hdf5Space all(H5Screate_simple(1, &total, nullptr), action);
  for (const StorePack& pack : packs) {
    const hsize_t bytes = pack.names_bytes;
    if (bytes == 0) continue;
    const Hdf5Space source(H5Screate_simple(1, &bytes, nullptr), action);
    hdf5_check(H5Sselect_hyperslab(all.get(), H5S_SELECT_SET, &begin, nullptr, &bytes, nullptr), action);
    hdf5_check(
        H5Pset_virtual(creation.get(), all.get(), source_name(pack.file).c_str(), names_path, source.get()),
        action);
    begin += bytes;
  }
  return creation;
}

}  // namespace meander::store

namespace meander {

std::uint32_t stated_checksum(const std::filesystem::path& store) { return store::sealed_pack(store).crc32c; }

}  // namespace meander
