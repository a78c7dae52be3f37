#include "io/store/ann_file_writer.h"

#include <unistd.h>

#include <array>
#include <string>

#include "io/file/atomic_file.h"
#include "io/store/hdf5_handles.h"
#include "io/store/store_file.h"

namespace meander {

using namespace store;

namespace {

constexpr std::uint64_t overhead_bytes = 16384;  // of headers and attributes: 8,192 are needed

// A dataset of rows that is filled from its front.
struct Filling {
  Hdf5Dataset dataset;
  hid_t type = -1;
  hsize_t rows = 0, width = 0, filled = 0;
};

Filling make_dataset(const Hdf5File& file, const char* name, hid_t type, std::uint64_t rows,
                     std::uint32_t width) {
  const std::array<hsize_t, 2> extents{rows, width};
  const Hdf5Space space(H5Screate_simple(2, extents.data(), nullptr), "make a space");
  const Hdf5Properties creation(H5Pcreate(H5P_DATASET_CREATE), "make creation properties");
  hdf5_check(H5Pset_obj_track_times(creation.get(), false), "leave out times");
  Filling made;
  made.dataset =
      Hdf5Dataset(H5Dcreate2(file.get(), name, type, space.get(), H5P_DEFAULT, creation.get(), H5P_DEFAULT),
                  std::string("create ") + name);
  made.type = type;
  made.rows = rows;
  made.width = width;
  return made;
}

void append(Filling& to, const void* values, std::size_t count) {
  const std::array<hsize_t, 2> begin{to.filled, 0}, extents{count / to.width, to.width};
  if (extents[0] == 0) return;
  const Hdf5Space space(H5Dget_space(to.dataset.get()), "open a space");
  hdf5_check(H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, begin.data(), nullptr, extents.data(), nullptr),
             "select rows");
  const Hdf5Space memory(H5Screate_simple(2, extents.data(), nullptr), "make a space");
  hdf5_check(H5Dwrite(to.dataset.get(), to.type, memory.get(), space.get(), H5P_DEFAULT, values),
             "write vectors");
  to.filled += extents[0];
}

}  // namespace

struct AnnFileWriter::State {
  explicit State(const std::filesystem::path& path) : pending(path, FullDisk::ends_command) {}

  PendingFile pending;
  Hdf5File file;
  Filling train, test, neighbors, distances;

  // Runs with the library locked, its errors turned into RunError(unusable): no second start continues.
  template <class Body>
  void guarded(const Body& body) {
    const Hdf5Lock lock;
    try {
      body();
    } catch (const Hdf5Error& error) {
      throw RunError(RunError::Kind::unusable, error.what());
    }
  }

  void close_datasets() {
    for (Filling* const filling : {&train, &test, &neighbors, &distances}) filling->dataset.close();
  }

  ~State() {
    if (!file) return;
    const Hdf5Lock lock;
    // Emptied, the file can be closed on a full disk too.
    const bool emptied = ::truncate(pending.temporary().c_str(), 0) == 0;
    close_datasets();
    if (emptied) file.close();
  }
};

AnnFileWriter::AnnFileWriter(const std::filesystem::path& path, const AnnFileShape& shape,
                             std::string_view distance)
    : state_(std::make_unique<State>(path)) {
  State& state = *state_;
  const std::filesystem::path& temporary = state.pending.temporary();
  state.pending.create();  // says what is wrong with the place, if anything
  // Asked before HDF5 holds the file: 1.10 crashes at the end of a process that could not close one.
  const std::uint64_t numbers =
      (shape.train + shape.test) * shape.width + 2 * shape.test * std::uint64_t{shape.neighbors};
  reserve_space(temporary, sizeof(float) * numbers + overhead_bytes, FullDisk::ends_command);
  state.guarded([&] {
    const Hdf5Properties creation(H5Pcreate(H5P_FILE_CREATE), "make file properties");
    hdf5_check(H5Pset_obj_track_times(creation.get(), false), "leave out times");
    state.file =
        Hdf5File(H5Fcreate(temporary.c_str(), H5F_ACC_TRUNC, creation.get(), access_without_locks().get()),
                 "create " + temporary.string());
    const Hdf5Group root(H5Gopen2(state.file.get(), "/", H5P_DEFAULT), "open the root group");
    write_attribute(root.get(), "distance", distance);
    write_attribute(root.get(), "dimension", shape.width);
    write_attribute(root.get(), "point_type", "float");
    write_attribute(root.get(), "type", "dense");
    state.train = make_dataset(state.file, "train", H5T_IEEE_F32LE, shape.train, shape.width);
    state.test = make_dataset(state.file, "test", H5T_IEEE_F32LE, shape.test, shape.width);
    state.neighbors = make_dataset(state.file, "neighbors", H5T_STD_I32LE, shape.test, shape.neighbors);
    state.distances = make_dataset(state.file, "distances", H5T_IEEE_F32LE, shape.test, shape.neighbors);
  });
}

AnnFileWriter::~AnnFileWriter() = default;

void AnnFileWriter::append_train(std::span<const float> vectors) {
  state_->guarded([&] { append(state_->train, vectors.data(), vectors.size()); });
}

void AnnFileWriter::append_test(std::span<const float> vectors) {
  state_->guarded([&] { append(state_->test, vectors.data(), vectors.size()); });
}

void AnnFileWriter::append_neighbors(std::span<const std::int32_t> positions,
                                     std::span<const float> distances) {
  state_->guarded([&] {
    append(state_->neighbors, positions.data(), positions.size());
    append(state_->distances, distances.data(), distances.size());
  });
}

void AnnFileWriter::finish() {
  State& state = *state_;
  for (const Filling* const filling : {&state.train, &state.test, &state.neighbors, &state.distances})
    if (filling->filled != filling->rows)
      throw ItemError(Status::internal, "a dataset of " + state.pending.path().string() + " was not filled");
  state.guarded([&] {
    // While the datasets are open: what their caches hold and cannot be written is only dropped when they
    // close.
    hdf5_check(H5Fflush(state.file.get(), H5F_SCOPE_LOCAL), "write " + state.pending.temporary().string());
    state.close_datasets();
    hdf5_check(H5Fflush(state.file.get(), H5F_SCOPE_LOCAL), "write " + state.pending.temporary().string());
    if (!state.file.close()) throw_hdf5_error("close " + state.pending.temporary().string());
  });
  state.pending.commit();
}

}  // namespace meander
