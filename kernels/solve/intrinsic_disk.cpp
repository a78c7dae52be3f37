#include "kernels/solve/intrinsic_disk.h"

#include <algorithm>
#include <numbers>

#include "kernels/core/portable_angles.h"

namespace meander {

double mollify(std::span<double> length) {
  double mean = 0;
  for (const double l : length) mean += l;
  mean /= static_cast<double>(std::max<std::size_t>(length.size(), 1));
  if (!(mean > 0)) mean = 1;  // every edge has length 0, so any size works
  double missing = 0;
  for (std::size_t t = 0; t + 2 < length.size(); t += 3) {
    const double a = length[t], b = length[t + 1], c = length[t + 2];
    const double longest = std::max({a, b, c});
    const double slack = std::min({(a + b) - c, (b + c) - a, (c + a) - b});
    missing = std::max(missing, std::max(1e-9 * mean, 1e-12 * longest) - slack);
  }
  if (missing > 0)
    for (double& l : length) l += missing;
  return missing;
}

CornerGeometry corner_geometry(std::span<const double> length) {
  CornerGeometry corners;
  corners.angle.resize(length.size());
  corners.half_cotangent.resize(length.size());
  for (std::size_t t = 0; t + 2 < length.size(); t += 3) {
    double angle[3], squared[3];
    for (int k = 0; k < 3; ++k) squared[k] = length[t + k] * length[t + k];
    const double longest = std::max({squared[0], squared[1], squared[2]});
    const double area4 =
        std::max(4 * area_from_lengths(length[t], length[t + 1], length[t + 2]), 1e-12 * longest);
    int widest = 0;
    for (int k = 0; k < 3; ++k) {
      // Corner k lies between edges k and k + 2; edge k + 1 is opposite to it.
      const double cosine = squared[k] + squared[(k + 2) % 3] - squared[(k + 1) % 3];
      corners.half_cotangent[t + (k + 1) % 3] = 0.5 * cosine / area4;
      angle[k] = upper_angle(area4, cosine);
      if (angle[k] > angle[widest]) widest = k;
    }
    angle[widest] = std::numbers::pi - angle[(widest + 1) % 3] - angle[(widest + 2) % 3];
    for (int k = 0; k < 3; ++k) corners.angle[t + k] = angle[k];
  }
  return corners;
}

std::vector<std::uint32_t> boundary_half_edges(std::span<const std::uint32_t> triangles,
                                               std::span<const std::uint32_t> opposite,
                                               std::uint32_t vertex_count) {
  std::vector<std::uint32_t> outgoing(vertex_count, no_index), loop;
  std::uint32_t start = no_index;
  for (std::uint32_t h = static_cast<std::uint32_t>(opposite.size()); h-- > 0;)
    if (opposite[h] == no_index) outgoing[triangles[h]] = start = h;
  for (std::uint32_t h = start; h != no_index;) {
    loop.push_back(h);
    h = outgoing[triangles[next_half_edge(h)]];
    if (h == start || loop.size() > opposite.size()) break;
  }
  return loop;
}

}  // namespace meander
