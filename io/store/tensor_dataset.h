// Tensors of a mesh from a dataset of any HDF5 file.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "kernels/tensor/make_tensor_field.h"

namespace meander {

// The dataset of that path inside the file: V x 6 (xx, xy, xz, yy, yz, zz) or V x 3 (a vector) numbers of any
// type that HDF5 turns into doubles, one row per vertex of the mesh, see make_tensor_field. Throws
// ItemError(unreadable): no such file or dataset, another shape or number of rows than `vertices` (found
// before memory is taken: a dataset may claim any extent), numbers that cannot be read. One lock around the
// HDF5 library: calls from several threads wait for each other.
TensorTable read_tensor_dataset(const std::filesystem::path& path, const std::string& dataset,
                                std::size_t vertices);

}  // namespace meander
