// Reading tensors from a table beside a mesh.
#pragma once

#include <filesystem>

#include "kernels/core/cancel.h"
#include "kernels/tensor/make_tensor_field.h"

namespace meander {

// Text with one row per vertex of the mesh, in the file's order, blanks or tabs between numbers: six (xx xy
// xz yy yz zz) or three (a vector), see make_tensor_field. # begins a comment up to the end of its line;
// blank lines are skipped. Every row has as many numbers as the first. Numbers that are not finite are read
// as they are: whether they matter depends on the mesh. Throws ItemError with the line: unreadable (what is
// not a number, another count), empty (no row at all). RunCanceled and bad_alloc pass. Linear in the file.
TensorTable read_tensor_table(const std::filesystem::path& path, const CancelToken& cancel = {});

}  // namespace meander
