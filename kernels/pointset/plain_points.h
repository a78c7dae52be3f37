// Plain point sets on the unit square and the unit sphere, to compare samplings with.
#pragma once

#include <cstddef>
#include <vector>

namespace meander {

struct PlanarPoints {
  std::vector<double> x, y;  // in [0, 1)
  std::size_t count() const { return x.size(); }
};

struct SpherePoints {
  std::vector<double> x, y, z;  // unit vectors
  std::size_t count() const { return x.size(); }
};

}  // namespace meander
