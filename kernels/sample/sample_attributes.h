// Attributes and texture coordinates of samples from those of the mesh.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/mesh/polygon_mesh.h"
#include "kernels/sample/samples.h"

namespace meander {

// N values of `width` numbers, in the order of the samples; NaN where the mesh has none.
struct SampleValues {
  std::vector<float> values;
  bool lacks_some = false;  // a sample has NaN
};

// The attribute at each sample, which `face`, `corners` and `barycentric` name. An attribute of vertices is
// interpolated linearly between the three corners, which are the file's own; one of faces is that of the
// polygon. Where vertices and faces have attributes of one name, that of the vertices is taken. A column of
// width W > 1 takes the attributes NAME_0 to NAME_(W - 1) or, where there is no NAME_0, NAME_x, NAME_y,
// NAME_z and NAME_w; all W of them must be of vertices, or all of faces. A sample of which one number is not
// finite, or not as float32, has NaN in all of them. Throws RunCancelled and ItemError(timeout) by `cancel`.
// O(N).
SampleValues sample_attribute(const PolygonMesh& mesh, const AttributeColumn& column, const Samples& samples,
                              const CancelToken& cancel = {});

// The texture coordinates at each sample (width 2): those of the corners of its own polygon, interpolated
// linearly in the triangle of the sample, so that they are right beside seams; of corners with one vertex the
// first one's. v is as the file has it. Throws as sample_attribute. O(N), and of polygons with many corners
// once O(corners log corners).
SampleValues sample_coordinates(const PolygonMesh& mesh, const Samples& samples,
                                const CancelToken& cancel = {});

}  // namespace meander
