// Attributes and texture coordinates of samples from those of the mesh.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/data/samples.h"
#include "kernels/mesh/polygon_mesh.h"

namespace meander {

// N values of `width` numbers, in the order of the samples; NaN where the mesh has none.
struct SampleValues {
  std::vector<float> values;
  std::vector<std::int32_t>
      classes;                   // of a column of classes, in place of `values`; no_sample_class where none
  bool lacks_some = false;       // a sample has NaN, or no class
  bool is_missing = false;       // the mesh has nothing of that name and width
  bool is_nearest = false;       // values of vertices are those of a corner, never between two
  std::uint64_t bad_values = 0;  // of the mesh: integers that the column cannot hold
};

// The attribute at each sample, which `face`, `corners` and `barycentric` name. An attribute of vertices is
// interpolated linearly between the three corners, which are the file's own; one of faces is that of the
// polygon. One that the mesh declares as integers, and any in a column of classes, is that of the corner with
// the largest weight, of equal ones the first, unless the column is linear. Where vertices and faces have
// attributes of one name, that of the vertices is taken. A column of width W > 1 takes the attributes NAME_0
// to NAME_(W - 1) or, where there is no NAME_0, NAME_x, NAME_y, NAME_z and NAME_w; all W of them must be of
// vertices, or all of faces, and they are integers where all W are. A sample of which one number is not
// finite, or not as float32 (an integer: not exactly), has NaN in all of them; in a column of classes one of
// which a number is not whole, or not within int32, has no_sample_class. Throws RunCanceled and
// ItemError(timeout) by `cancel`. O(N), of integers O(N + V).
SampleValues sample_attribute(const PolygonMesh& mesh, const AttributeColumn& column, const Samples& samples,
                              const CancelToken& cancel = {});

// The texture coordinates at each sample (width 2): those of the corners of its own polygon, interpolated
// linearly in the triangle of the sample, so that they are right beside seams; of corners with one vertex the
// first one's. v is as the file has it. Throws as sample_attribute. O(N), and of polygons with many corners
// once O(corners log corners).
SampleValues sample_coordinates(const PolygonMesh& mesh, const Samples& samples,
                                const CancelToken& cancel = {});

}  // namespace meander
