// The splats of a sampled model and their sizes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "kernels/data/samples.h"
#include "kernels/mesh/prepared_mesh.h"
#include "kernels/render/oriented_splats.h"

namespace meander {

inline constexpr SrgbColor splat_color = {232, 196, 158};  // if colors have no meaning

struct SplatSizes {
  double cover = 4;    // area of a splat over the area that its sample represents, 0.05..16
  bool round = false;  // discs, even if the samples have tensors
};

// The area of the surface that each of the first `count` samples represents, in squared units of the stored
// points: the reciprocal of the density, or s1 s2 of the tensor, for a set of `count`. It is at most 64 times
// the mean, since the splats of sparser samples would hide the shape. Finite and positive. O(count).
std::vector<float> sample_areas(const Row& row, std::size_t count);

// The 2 n half-axes of splats for samples that represent these areas, with the ratio of the tensor.
std::vector<float> splat_half_axes(const Row& row, std::span<const float> areas, const SplatSizes& sizes);

// The splats of the first samples of a row, one for each pair of half-axes; samples and half-axes must
// outlive the result. Scales all half-axes down by one factor if they would overlap more than draw_splats
// accepts.
OrientedSplats splats_of(const Row& row, std::span<float> half_axes, std::span<const SrgbColor> colors,
                         const SplatView& view);
void limit_overlap(std::span<float> half_axes, const SplatView& view);

// Whether the samples are those of a closed mesh with outward normals, on which no splat that faces away is
// visible: by the boundaries of the mesh and the sign of the volume that the samples enclose.
bool is_closed(const Row& row);

// surface_depth of the mesh of a row, in units of the stored points.
std::vector<float> mesh_depth(const Row& row, const PreparedMesh& mesh, const SplatView& view);

}  // namespace meander
