// The files that `--tensor file:PATH` names.
#pragma once

#include <vector>

#include "kernels/tensor/make_tensor_field.h"
#include "pipeline/sampling_graph.h"

namespace meander {

// Where the tensors of each item of `--tensor file:PATH` are: one text file for all; in a folder ID.txt (or
// with .txt in place of the mesh's extension); in an HDF5 file (.h5, .hdf5) the dataset of the item's id.
void plan_tensor_files(const TensorParameters& tensor, std::vector<PlanItem>& items);

}  // namespace meander
