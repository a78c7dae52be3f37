#include "io/store/pointnet_export.h"

// Files that the loaders of PointNet, PointNet++ and DGCNN read as they are: ply_data_train<k>.h5 with data,
// normal and label, the list of them (the same for test and val), the names of the classes, and which id
// stands in which row.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>

#include "io/file/atomic_file.h"
#include "io/json_writer.h"
#include "io/store/hdf5_handles.h"
#include "io/store/store_file.h"
#include "kernels/sample/point_frames.h"

namespace meander {

namespace fs = std::filesystem;
using namespace store;

namespace {

constexpr std::size_t most_classes = 256;  // labels are u8 in this format

struct PointnetShard {
  std::vector<std::uint64_t> rows;
  std::vector<std::uint8_t> labels;
};

struct ExportSource {
  const StoreReader& store;
  const std::atomic<bool>* stop;
  PointFrame frame;

  // The bytes of a sample: three coordinates.
  std::uint64_t point_bytes() const {
    return 3 * (frame == PointFrame::file ? sizeof(double) : sizeof(float));
  }

  void check() const {
    if (stop != nullptr && *stop)
      throw RunError(RunError::Kind::stopped, "stopped before all PointNet files were written");
  }
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

// Rows of a chunk of points, of 12 bytes each.
hsize_t chunk_rows(const StoreReader& store) {
  constexpr hsize_t chunk_bytes = hsize_t{1} << 20;
  return std::max<hsize_t>(1, chunk_bytes / (hsize_t{store.samples()} * 12));
}

// What the file takes at most: chunks that do not shrink are stored as they are, and the last is whole.
std::uint64_t most_bytes(const ExportSource& source, std::uint64_t rows) {
  constexpr std::uint64_t overhead = 65536, chunk_overhead = 256, normal_bytes = 12;
  const std::uint64_t batch = chunk_rows(source.store), chunks = (rows + batch - 1) / batch;
  const std::uint64_t samples = std::min(batch, rows) * source.store.samples();
  return chunks * (samples * (source.point_bytes() + normal_bytes) + 2 * chunk_overhead) + rows + overhead;
}

// Points of rows one after the other, in the frame of the export.
struct PointRows {
  std::vector<float> stored;
  std::vector<double> file;

  void add(const Row& row, PointFrame frame) {
    if (frame == PointFrame::stored) {
      stored.insert(stored.end(), row.samples.points.begin(), row.samples.points.end());
      return;
    }
    const std::vector<double> points = file_points(row.report, row.samples.points);
    file.insert(file.end(), points.begin(), points.end());
  }
};

void write_datasets(const Hdf5File& file, const ExportSource& source, const PointnetShard& shard,
                    const fs::path& path) {
  const StoreReader& store = source.store;
  const hsize_t rows = shard.rows.size(), samples = store.samples(), batch = chunk_rows(store);
  const bool of_file = source.frame == PointFrame::file;
  const Hdf5Dataset data =
      make_dataset(file, "data", of_file ? H5T_IEEE_F64LE : H5T_IEEE_F32LE, {rows, samples, 3}, batch, 4);
  write_attribute(data.get(), "frame", name_of(source.frame));
  const Hdf5Dataset normal = make_dataset(file, "normal", H5T_IEEE_F32LE, {rows, samples, 3}, batch, 4);
  const Hdf5Dataset label = make_dataset(file, "label", H5T_STD_U8LE, {rows, 1}, rows, 1);
  try {
    write_rows(label, H5T_NATIVE_UINT8, {0, 0}, {rows, 1}, shard.labels.data());
    for (hsize_t begin = 0; begin < rows; begin += batch) {
      const hsize_t count = std::min(batch, rows - begin);
      PointRows points;
      std::vector<float> normals;
      source.check();
      for (hsize_t i = 0; i < count; ++i) {
        const Row row = store.read_row(shard.rows[begin + i]);
        points.add(row, source.frame);
        normals.insert(normals.end(), row.samples.normals.begin(), row.samples.normals.end());
      }
      const void* const values =
          of_file ? static_cast<const void*>(points.file.data()) : points.stored.data();
      write_rows(data, of_file ? H5T_NATIVE_DOUBLE : H5T_NATIVE_FLOAT, {begin, 0, 0}, {count, samples, 3},
                 values);
      write_rows(normal, H5T_NATIVE_FLOAT, {begin, 0, 0}, {count, samples, 3}, normals.data());
    }
    // While the datasets are open: what their caches hold and cannot be written then is only dropped when
    // they close.
    hdf5_check(H5Fflush(file.get(), H5F_SCOPE_LOCAL), "write " + path.string());
  } catch (...) {
    // Emptied, the file has room for what the datasets hold and can be closed on a full disk too.
    if (::truncate(path.c_str(), 0) != 0) throw_file_error(errno, "truncate", path, FullDisk::stops_run);
    throw;
  }
}

void write_hdf5(const fs::path& path, const ExportSource& source, const PointnetShard& shard) {
  PendingFile pending(path, FullDisk::stops_run);
  pending.create();  // says what is wrong with the place, if anything
  const fs::path& temporary = pending.temporary();
  // Asked before HDF5 holds the file: 1.10 crashes at the end of a process that could not close one.
  reserve_space(temporary, most_bytes(source, shard.rows.size()), FullDisk::stops_run);
  const Hdf5Lock lock;
  try {
    const Hdf5Properties creation(H5Pcreate(H5P_FILE_CREATE), "make file properties");
    hdf5_check(H5Pset_obj_track_times(creation.get(), false), "leave out times");
    Hdf5File file(H5Fcreate(temporary.c_str(), H5F_ACC_TRUNC, creation.get(), access_without_locks().get()),
                  "create " + temporary.string());
    try {
      write_datasets(file, source, shard, temporary);
      hdf5_check(H5Fflush(file.get(), H5F_SCOPE_LOCAL), "write " + temporary.string());
    } catch (...) {
      // Emptied, the file can be closed on a full disk too.
      if (::truncate(temporary.c_str(), 0) == 0) file.close();
      throw;
    }
    if (!file.close()) throw_hdf5_error("close " + temporary.string());
  } catch (const Hdf5Error& error) {
    throw RunError(RunError::Kind::unusable, error.what());
  }
  pending.commit();
}

// The rows of one part of the data set, in shards, and the names of its files.
struct Part {
  const char* name;
  std::vector<PointnetShard> shards{};

  std::string shard_name(std::size_t k) const { return fmt::format("ply_data_{}{}.h5", name, k); }
  std::string ids_name(std::size_t k) const { return fmt::format("ply_data_{}_{}_id2file.json", name, k); }
  std::string list_name() const { return fmt::format("{}_files.txt", name); }
  bool is_written() const { return !shards.empty() || std::string_view(name) != "val"; }

  std::uint64_t rows() const {
    std::uint64_t sum = 0;
    for (const PointnetShard& shard : shards) sum += shard.rows.size();
    return sum;
  }
  void add(std::uint64_t row, std::int32_t label, std::uint32_t shard_rows) {
    if (shards.empty() || shards.back().rows.size() == shard_rows) shards.emplace_back();
    shards.back().rows.push_back(row);
    shards.back().labels.push_back(static_cast<std::uint8_t>(label));
  }
};

using Parts = std::array<Part, 3>;
Parts make_parts() { return {Part{"train"}, Part{"test"}, Part{"val"}}; }

Part& part_of(Split split, Parts& parts) {
  return parts[split == Split::test ? 1 : split == Split::validation ? 2 : 0];
}

// NAME<digits>SUFFIX
bool is_numbered(std::string_view text, std::string_view name, std::string_view suffix) {
  if (text.size() <= name.size() + suffix.size() || !text.starts_with(name) || !text.ends_with(suffix))
    return false;
  text.remove_prefix(name.size());
  text.remove_suffix(suffix.size());
  return text.find_first_not_of("0123456789") == std::string_view::npos;
}

// Returns the names of the files.
std::vector<std::string> write_part(const ExportSource& source, const fs::path& folder, const Part& part) {
  std::vector<std::string> written;
  std::string list;
  for (std::size_t k = 0; k < part.shards.size(); ++k) {
    written.push_back(part.shard_name(k));
    write_hdf5(folder / written.back(), source, part.shards[k]);
    list += (folder / written.back()).generic_string() + "\n";
    JsonWriter ids;
    ids.begin_array();
    for (const std::uint64_t row : part.shards[k].rows) ids.value(source.store.id(row));
    ids.end_array();
    written.push_back(part.ids_name(k));
    replace_file(folder / written.back(), ids.text() + "\n", FullDisk::stops_run);
  }
  written.push_back(part.list_name());
  replace_file(folder / written.back(), list, FullDisk::stops_run);
  return written;
}

}  // namespace

bool is_pointnet_file(const std::string& file) {
  if (file == "shape_names.txt") return true;
  for (const Part& part : make_parts())
    if (file == part.list_name() || is_numbered(file, fmt::format("ply_data_{}", part.name), ".h5") ||
        is_numbered(file, fmt::format("ply_data_{}_", part.name), "_id2file.json"))
      return true;
  return false;
}

std::vector<fs::path> pointnet_files(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error))
    if (is_pointnet_file(at->path().filename().string())) files.push_back(at->path());
  std::sort(files.begin(), files.end());
  return files;
}

void require_pointnet_rows(const StoreReader& store) {
  store.require(&Samples::normals, "--pointnet");
  if (store.label_names().size() > most_classes)
    throw RunError(RunError::Kind::unusable,
                   fmt::format("PointNet files hold at most {} classes, the store has {}", most_classes,
                               store.label_names().size()));
  for (std::uint64_t row = 0; row < store.rows(); ++row)
    if (store.label(row) >= 0 && store.report(row).status == Status::ok) return;
  throw RunError(RunError::Kind::unusable,
                 "PointNet files need classes, and no row of the store with points has one: `meander run` "
                 "takes them from --labels, --layout or --label-from-folder");
}

PointnetCounts export_pointnet(const StoreReader& store, const fs::path& folder, std::uint32_t shard_rows,
                               const std::atomic<bool>* stop, PointFrame frame) {
  if (shard_rows == 0) throw RunError(RunError::Kind::unusable, "a PointNet file needs one row or more");
  require_pointnet_rows(store);
  Parts parts = make_parts();
  PointnetCounts counts;
  for (std::uint64_t row = 0; row < store.rows(); ++row) {
    if (store.report(row).status != Status::ok) continue;
    const std::int32_t label = store.label(row);
    if (label < 0)
      ++counts.unlabeled;
    else
      part_of(store.split(row), parts).add(row, label, shard_rows);
  }
  counts.train = parts[0].rows();
  counts.test = parts[1].rows();
  counts.validation = parts[2].rows();

  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw_file_error(error.value(), "create", folder, FullDisk::stops_run);
  std::vector<std::string> written{"shape_names.txt"};
  std::string classes;
  for (const std::string& name : store.label_names()) classes += name + "\n";
  replace_file(folder / written.front(), classes, FullDisk::stops_run);
  for (const Part& part : parts) {
    if (!part.is_written()) continue;
    const std::vector<std::string> names = write_part({store, stop, frame}, folder, part);
    written.insert(written.end(), names.begin(), names.end());
  }
  // Loaders take every shard that they find.
  for (const fs::path& file : pointnet_files(folder))
    if (std::find(written.begin(), written.end(), file.filename().string()) == written.end())
      fs::remove(file, error);
  return counts;
}

}  // namespace meander
