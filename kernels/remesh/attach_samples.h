// Samples that stand beside a line become vertices of it.
#pragma once

#include <cstdint>
#include <span>

#include "kernels/remesh/edited_mesh.h"

namespace meander {

struct AttachParameters {
  double largest_shift = 0.15;  // of a sample, over the mean edge around it; 0..1
  double small_angle = 12;      // degrees: of a triangle beside a line whose sample is worth a shift
};

// A sample beside a boundary or a crease makes triangles with small angles there. It moves onto the line,
// which then runs through it: into the place of a vertex of the line that is no sample and goes, or to its
// foot on an edge. The lines stay where they are. Only where no triangle turns over and the angles around the
// sample get larger.
//   first .. last - 1: the samples
//   moved_to: W vertices, as remove_vertices returns them; those that go are entered
// Returns the largest shift over the mean edge around the sample. O(T).
double attach_samples(EditedMesh& mesh, std::uint32_t first, std::uint32_t last,
                      std::span<std::uint32_t> moved_to, const AttachParameters& parameters = {});

}  // namespace meander
