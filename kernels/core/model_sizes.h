// What is known of a model before it is read, for upper bounds of its memory.
#pragma once

#include <algorithm>

namespace meander {

struct ModelSizes {
  double triangles = 0, vertices = 0, samples = 0;
  int threads = 1;  // that may work on the one model
  // Unknowns of a linear system over the surface: soups have three vertices a triangle, which are welded.
  double unknowns() const { return std::max(vertices, 0.5 * triangles); }
};

}  // namespace meander
