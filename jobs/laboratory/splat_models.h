// The splats of a sampled model: how large each is.
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

inline constexpr SrgbColor splat_color = {232, 196, 158};  // where colors say nothing

struct SplatSizes {
  double cover = 4;    // area of a splat over that of the surface its sample stands for, 0.05..16
  bool round = false;  // discs, whatever tensors the samples carry
};

// The area of the surface that each of the first `count` samples stands for, in units of the stored points
// squared: the reciprocal of the density, or s1 s2 of its tensor, of a set of `count`. No more than 64 times
// the mean: what is sparser than that would hide the shape. Finite and positive. O(count).
std::vector<float> sample_areas(const Row& row, std::size_t count);

// 2 n half-axes of the splats of samples that stand for these areas; the ratio is that of the tensor.
std::vector<float> splat_half_axes(const Row& row, std::span<const float> areas, const SplatSizes& sizes);

// The first samples of a row, as many as there are half-axes, which must outlive what comes back. Makes the
// half-axes smaller, all by the same factor, where they would overlap more than draw_splats takes.
OrientedSplats splats_of(const Row& row, std::span<float> half_axes, std::span<const SrgbColor> colors,
                         const SplatView& view);
void limit_overlap(std::span<float> half_axes, const SplatView& view);

// Whether the samples are those of a closed mesh with normals that point outwards: then no splat that faces
// away can be seen. By the boundaries of the mesh and the sign of the volume that the samples tell of.
bool is_closed(const Row& row);

// Of the surface of a row and the mesh of its file, in units of the stored points: surface_depth.
std::vector<float> mesh_depth(const Row& row, const PreparedMesh& mesh, const SplatView& view);

}  // namespace meander
