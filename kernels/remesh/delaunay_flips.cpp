#include "kernels/remesh/delaunay_flips.h"

#include <algorithm>
#include <cmath>

namespace meander {

namespace {

constexpr double least_upright = 0.25;  // cosine between a new triangle and the quadrilateral
constexpr double least_smooth = 0.5;    // cosine over the new edge
constexpr double margin = 1e-9;         // of the sum of angles: four vertices on a circle stay as they are

}  // namespace

double least_angle_cosine(Vector3 a, Vector3 b, Vector3 c) {
  const auto cosine = [](Vector3 u, Vector3 v) {
    const double l = norm(u) * norm(v);
    return l > 0 ? dot(u, v) / l : 1.0;
  };
  return std::max({cosine(b - a, c - a), cosine(a - b, c - b), cosine(a - c, b - c)});
}

bool can_flip_in_topology(const EditedMesh& mesh, std::uint32_t h) {
  if (mesh.is_line(h)) return false;
  const std::uint32_t c = mesh.apex(h), d = mesh.apex(mesh.opposite[h]);
  return c != d && !mesh.are_neighbors(c, d);
}

bool can_flip(const EditedMesh& mesh, std::uint32_t h) {
  if (mesh.is_line(h)) return false;
  const std::uint32_t g = mesh.opposite[h];
  const std::uint32_t c = mesh.apex(h), d = mesh.apex(g);
  if (c == d) return false;
  const Vector3 a = mesh.position[mesh.start(h)], b = mesh.position[mesh.end(h)];
  const Vector3 pc = mesh.position[c], pd = mesh.position[d];
  const Vector3 n1 = cross(b - pd, pc - pd), n2 = cross(a - pc, pd - pc);
  const double l1 = norm(n1), l2 = norm(n2);
  const Vector3 whole = n1 + n2;
  const double l = norm(whole);
  if (!(l1 > 0) || !(l2 > 0) || dot(n1, whole) < least_upright * l1 * l ||
      dot(n2, whole) < least_upright * l2 * l)
    return false;
  const double smooth = dot(n1, n2) / (l1 * l2);
  if (smooth < least_smooth) {
    const Vector3 o1 = cross(b - a, pc - a), o2 = cross(a - b, pd - b);
    const double before = norm(o1) * norm(o2);
    if (before > 0 && smooth < dot(o1, o2) / before) return false;
  }
  return can_flip_in_topology(mesh, h);
}

bool is_longer_diagonal(const EditedMesh& mesh, std::uint32_t h) {
  const Vector3 a = mesh.position[mesh.start(h)], b = mesh.position[mesh.end(h)];
  const Vector3 c = mesh.position[mesh.apex(h)], d = mesh.position[mesh.apex(mesh.opposite[h])];
  const double cos1 = dot(a - c, b - c), sin1 = norm(cross(a - c, b - c));
  const double cos2 = dot(a - d, b - d), sin2 = norm(cross(a - d, b - d));
  return cos1 * sin2 + cos2 * sin1 < -margin * (std::abs(cos1) + sin1) * (std::abs(cos2) + sin2);
}

std::uint32_t flip_to_delaunay(EditedMesh& mesh, std::vector<std::uint32_t>& edges,
                               std::uint32_t most_flips) {
  std::uint32_t flips = 0;
  while (!edges.empty() && flips < most_flips) {
    const std::uint32_t h = edges.back();
    edges.pop_back();
    if (!mesh.exists(h / 3) || mesh.is_line(h) || !is_longer_diagonal(mesh, h) || !can_flip(mesh, h))
      continue;
    mesh.flip(h);
    ++flips;
    const std::uint32_t other = mesh.opposite[previous_half_edge(h)];
    edges.insert(edges.end(), {h, next_half_edge(h), next_half_edge(other), previous_half_edge(other)});
  }
  edges.clear();
  return flips;
}

std::uint32_t flip_all_to_delaunay(EditedMesh& mesh) {
  constexpr std::uint32_t flips_per_edge = 8;
  std::vector<std::uint32_t> edges;
  for (auto h = static_cast<std::uint32_t>(mesh.vertex.size()); h-- > 0;)
    if (mesh.exists(h / 3) && mesh.opposite[h] != no_index && h < mesh.opposite[h]) edges.push_back(h);
  const auto most =
      static_cast<std::uint32_t>(std::min<std::size_t>(edges.size() * flips_per_edge, no_index));
  return flip_to_delaunay(mesh, edges, most);
}

}  // namespace meander
