#include "io/store/tensor_dataset.h"

#include <array>

#include "io/store/hdf5_handles.h"
#include "kernels/core/status.h"

namespace meander {

using namespace store;

TensorTable read_tensor_dataset(const std::filesystem::path& path, const std::string& dataset,
                                std::size_t vertices) {
  const Hdf5Lock lock;
  try {
    const Hdf5File file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, access_without_locks().get()),
                        "open " + path.string());
    const Hdf5Dataset data(H5Dopen2(file.get(), dataset.c_str(), H5P_DEFAULT), "open /" + dataset);
    const Hdf5Space space(H5Dget_space(data.get()), "open a space");
    std::array<hsize_t, 2> extents{};
    if (H5Sget_simple_extent_ndims(space.get()) != 2 ||
        H5Sget_simple_extent_dims(space.get(), extents.data(), nullptr) != 2 ||
        (extents[1] != 3 && extents[1] != 6))
      throw ItemError(Status::unreadable, "the tensor dataset /" + dataset + " of " + path.string() +
                                              " is not of the shape V x 6 or V x 3");
    if (extents[0] != vertices)
      throw ItemError(Status::unreadable, "the tensor dataset /" + dataset + " of " + path.string() +
                                              " has " + std::to_string(extents[0]) + " rows, but the mesh " +
                                              std::to_string(vertices) + " vertices");
    TensorTable table;
    table.columns = static_cast<unsigned>(extents[1]);
    table.values.resize(extents[0] * extents[1]);
    if (!table.values.empty())
      hdf5_check(H5Dread(data.get(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, table.values.data()),
                 "read /" + dataset);
    return table;
  } catch (const Hdf5Error& error) {
    throw ItemError(Status::unreadable, "the tensors of " + path.string() + ": " + error.what());
  }
}

}  // namespace meander
