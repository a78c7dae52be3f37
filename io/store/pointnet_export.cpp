// Files that the loaders of PointNet, PointNet++ and DGCNN read as they are: ply_data_train<k>.h5 with data,
// normal and label, the list of them, the names of the classes, and which id stands in which row.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>

#include "io/json_writer.h"
#include "io/store/hdf5_handles.h"
#include "io/store/posix_file.h"
#include "io/store/store.h"

namespace meander {

namespace fs = std::filesystem;
using namespace store;

namespace {

constexpr std::size_t most_classes = 256;  // labels are u8 in this format

struct PointnetShard {
  std::vector<std::uint64_t> rows;
  std::vector<std::uint8_t> labels;
};

Hdf5Dataset make_dataset(const Hdf5File& file, const char* name, hid_t type,
                         const std::vector<hsize_t>& extents, hsize_t chunk_rows, unsigned level) {
  const Hdf5Space space(H5Screate_simple(static_cast<int>(extents.size()), extents.data(), nullptr),
                        "make a space");
  const Hdf5Properties creation(H5Pcreate(H5P_DATASET_CREATE), "make creation properties");
  std::vector<hsize_t> chunk = extents;
  chunk[0] = std::min(chunk[0], chunk_rows);
  hdf5_check(H5Pset_chunk(creation.get(), static_cast<int>(chunk.size()), chunk.data()),
             "set the chunk shape");
  hdf5_check(H5Pset_deflate(creation.get(), level), "set the deflate filter");
  hdf5_check(H5Pset_obj_track_times(creation.get(), false), "leave out times");
  return Hdf5Dataset(
      H5Dcreate2(file.get(), name, type, space.get(), H5P_DEFAULT, creation.get(), H5P_DEFAULT),
      std::string("create ") + name);
}

void write_rows(const Hdf5Dataset& dataset, hid_t type, const std::vector<hsize_t>& begin,
                const std::vector<hsize_t>& count, const void* values) {
  const Hdf5Space file_space(H5Dget_space(dataset.get()), "read a space");
  hdf5_check(
      H5Sselect_hyperslab(file_space.get(), H5S_SELECT_SET, begin.data(), nullptr, count.data(), nullptr),
      "select rows");
  const Hdf5Space memory(H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr),
                         "make a space");
  hdf5_check(H5Dwrite(dataset.get(), type, memory.get(), file_space.get(), H5P_DEFAULT, values),
             "write rows");
}

void write_datasets(const Hdf5File& file, const StoreReader& store, const PointnetShard& shard) {
  constexpr hsize_t chunk_bytes = hsize_t{1} << 20;
  const hsize_t rows = shard.rows.size(), samples = store.samples();
  const hsize_t batch = std::max<hsize_t>(1, chunk_bytes / (samples * 12));
  const Hdf5Dataset data = make_dataset(file, "data", H5T_IEEE_F32LE, {rows, samples, 3}, batch, 4);
  const Hdf5Dataset normal = make_dataset(file, "normal", H5T_IEEE_F32LE, {rows, samples, 3}, batch, 4);
  const Hdf5Dataset label = make_dataset(file, "label", H5T_STD_U8LE, {rows, 1}, rows, 1);
  write_rows(label, H5T_NATIVE_UINT8, {0, 0}, {rows, 1}, shard.labels.data());
  for (hsize_t begin = 0; begin < rows; begin += batch) {
    const hsize_t count = std::min(batch, rows - begin);
    std::vector<float> points, normals;
    for (hsize_t i = 0; i < count; ++i) {
      const Samples row = store.read_row(shard.rows[begin + i]).samples;
      points.insert(points.end(), row.points.begin(), row.points.end());
      normals.insert(normals.end(), row.normals.begin(), row.normals.end());
    }
    write_rows(data, H5T_NATIVE_FLOAT, {begin, 0, 0}, {count, samples, 3}, points.data());
    write_rows(normal, H5T_NATIVE_FLOAT, {begin, 0, 0}, {count, samples, 3}, normals.data());
  }
}

void write_hdf5(const fs::path& path, const StoreReader& store, const PointnetShard& shard) {
  fs::path temporary = path;
  temporary += ".new";
  const Hdf5Lock lock;
  try {
    const Hdf5Properties creation(H5Pcreate(H5P_FILE_CREATE), "make file properties");
    hdf5_check(H5Pset_obj_track_times(creation.get(), false), "leave out times");
    Hdf5File file(H5Fcreate(temporary.c_str(), H5F_ACC_TRUNC, creation.get(), H5P_DEFAULT),
                  "create " + temporary.string());
    try {
      write_datasets(file, store, shard);
      hdf5_check(H5Fflush(file.get(), H5F_SCOPE_LOCAL), "write " + temporary.string());
    } catch (...) {
      // Emptied, the file can be closed on a full disk too.
      if (::truncate(temporary.c_str(), 0) == 0) file.close();
      ::unlink(temporary.c_str());
      throw;
    }
    if (!file.close()) throw_hdf5_error("close " + temporary.string());
  } catch (const Hdf5Error& error) {
    throw RunError(RunError::Kind::stopped, error.what());
  }
  sync_file(open_file(temporary, 0), temporary);
  rename_file(temporary, path);
}

void write_id_list(const fs::path& path, const StoreReader& store, const PointnetShard& shard) {
  JsonWriter json;
  json.begin_array();
  for (const std::uint64_t row : shard.rows) json.value(store.id(row));
  json.end_array();
  const std::string text = json.text() + "\n";
  replace_file(path, std::as_bytes(std::span(text)));
}

}  // namespace

void export_pointnet(const StoreReader& store, const fs::path& folder, std::uint32_t shard_rows) {
  if (shard_rows == 0) throw RunError(RunError::Kind::unusable, "a PointNet file needs one row or more");
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw_file_error(error.value(), "create", folder);

  std::vector<std::string> names = store.label_names();
  const std::size_t known = names.size();
  std::vector<PointnetShard> shards;
  for (std::uint64_t row = 0; row < store.rows(); ++row) {
    if (store.report(row).status != Status::ok) continue;
    if (shards.empty() || shards.back().rows.size() == shard_rows) shards.emplace_back();
    const std::int32_t label = store.label(row);
    // The format has no "unknown": such rows are a class of their own, the last one.
    if (label < 0 && names.size() == known) names.emplace_back("unknown");
    shards.back().rows.push_back(row);
    shards.back().labels.push_back(
        static_cast<std::uint8_t>(label < 0 ? known : static_cast<std::size_t>(label)));
  }
  if (names.size() > most_classes)
    throw RunError(
        RunError::Kind::unusable,
        fmt::format("PointNet files hold at most {} classes, the store has {}", most_classes, names.size()));

  std::string files, classes;
  for (std::size_t k = 0; k < shards.size(); ++k) {
    const std::string name = fmt::format("ply_data_train{}.h5", k);
    write_hdf5(folder / name, store, shards[k]);
    write_id_list(folder / fmt::format("ply_data_train_{}_id2file.json", k), store, shards[k]);
    files += (folder / name).generic_string() + "\n";
  }
  for (const std::string& name : names) classes += name + "\n";
  replace_file(folder / "shape_names.txt", std::as_bytes(std::span(classes)));
  replace_file(folder / "train_files.txt", std::as_bytes(std::span(files)));
}

}  // namespace meander
