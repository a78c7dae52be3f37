#include "kernels/remesh/surface_lines.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>
#include <vector>

#include "kernels/core/disjoint_sets.h"
#include "kernels/core/portable_angles.h"

namespace meander {

namespace {

// Twice the area of a triangle without a normal, at most, over its longest edge squared.
constexpr double flat = 1e-10;

// Unit normals, 0 for triangles that have none.
std::vector<Vector3> unit_normals(const EditedMesh& mesh) {
  std::vector<Vector3> normals(mesh.triangle_count());
  const auto length = [&](std::uint32_t h) {
    return distance(mesh.position[mesh.start(h)], mesh.position[mesh.end(h)]);
  };
  std::vector<std::uint32_t> without;
  for (std::uint32_t t = 0; t < normals.size(); ++t) {
    const Vector3 n = mesh.area_vector(t);
    const double longest = std::max({length(3 * t), length(3 * t + 1), length(3 * t + 2)});
    if (norm(n) > flat * longest * longest)
      normals[t] = (1 / norm(n)) * n;
    else
      without.push_back(t);
  }
  // Chains of such triangles are followed so far; in longer ones no crease is seen.
  for (int pass = 0; pass < 4; ++pass)
    for (const std::uint32_t t : without) {
      if (dot(normals[t], normals[t]) > 0) continue;
      std::uint32_t longest = 3 * t;
      for (std::uint32_t h = 3 * t; h < 3 * t + 3; ++h)
        if (length(h) > length(longest)) longest = h;
      if (mesh.opposite[longest] != no_index) normals[t] = normals[mesh.opposite[longest] / 3];
    }
  return normals;
}

}  // namespace

void mark_creases(EditedMesh& mesh, std::span<const double> spacing, const LineParameters& parameters) {
  if (parameters.crease_angle >= 180) return;
  const double limit = direction_of(parameters.crease_angle * std::numbers::pi / 180).cosine;
  const std::vector<Vector3> normals = unit_normals(mesh);
  std::vector<std::uint32_t> creases;
  DisjointSets joined(mesh.position.size());
  for (std::uint32_t h = 0; h < mesh.vertex.size(); ++h) {
    const std::uint32_t g = mesh.opposite[h];
    if (g == no_index || g < h) continue;
    const Vector3 a = normals[h / 3], b = normals[g / 3];
    if (dot(a, a) == 0 || dot(b, b) == 0 || dot(a, b) > limit) continue;
    creases.push_back(h);
    joined.join(mesh.start(h), mesh.end(h));
  }
  std::vector<double> length(mesh.position.size(), 0);  // over the spacing, of the creases in each set
  for (const std::uint32_t h : creases) {
    const std::uint32_t v = mesh.start(h), w = mesh.end(h);
    length[joined.find(v)] += distance(mesh.position[v], mesh.position[w]) / std::min(spacing[v], spacing[w]);
  }
  for (const std::uint32_t h : creases)
    if (length[joined.find(mesh.start(h))] >= parameters.shortest)
      mesh.crease[h] = mesh.crease[mesh.opposite[h]] = mark_crease;
}

bool split_lines(EditedMesh& mesh, std::span<const double> spacing, const LineParameters& parameters,
                 std::uint32_t most) {
  const auto edges = static_cast<std::uint32_t>(mesh.vertex.size());
  std::uint32_t cuts = 0;
  bool enough = true;
  for (std::uint32_t h = 0; h < edges; ++h) {
    const std::uint32_t g = mesh.opposite[h];
    if (!mesh.exists(h / 3) || !mesh.is_crease_or_boundary(h) || (g != no_index && g < h)) continue;
    const std::uint32_t v = mesh.start(h), w = mesh.end(h);
    if (v >= spacing.size() || w >= spacing.size()) continue;  // cut before
    const Vector3 a = mesh.position[v], b = mesh.position[w];
    const double parts = std::ceil(distance(a, b) / (parameters.spacing * std::min(spacing[v], spacing[w])));
    enough = enough && parts <= 1.0 + (most - cuts);
    const auto wanted = static_cast<std::uint32_t>(std::clamp(parts, 1.0, 1.0 + (most - cuts)));
    // From the far end, so that h stays the first part.
    for (std::uint32_t k = wanted; k-- > 1; ++cuts) {
      const double share = static_cast<double>(k) / wanted;
      mesh.cuts.push_back({mesh.add_vertex(a + share * (b - a)), v, w, share});
      mesh.split_edge(h, mesh.cuts.back().vertex);
    }
  }
  return enough;
}

void split_double_edges(EditedMesh& mesh) {
  struct Edge {
    std::uint32_t low, high, half_edge;
    bool operator==(const Edge& other) const { return low == other.low && high == other.high; }
  };
  std::vector<Edge> edges;
  for (std::uint32_t h = 0; h < mesh.vertex.size(); ++h) {
    if (!mesh.exists(h / 3) || (mesh.opposite[h] != no_index && mesh.opposite[h] < h)) continue;
    const auto [low, high] = std::minmax({mesh.start(h), mesh.end(h)});
    edges.push_back({low, high, h});
  }
  std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) {
    return std::tie(a.low, a.high, a.half_edge) < std::tie(b.low, b.high, b.half_edge);
  });
  // A cut leaves the half-edge its number, and all other edges their ends.
  for (std::size_t i = 1; i < edges.size(); ++i)
    if (edges[i] == edges[i - 1]) {
      const auto [low, high, h] = edges[i];
      mesh.cuts.push_back(
          {mesh.add_vertex(0.5 * (mesh.position[low] + mesh.position[high])), low, high, 0.5});
      mesh.split_edge(h, mesh.cuts.back().vertex);
    }
}

}  // namespace meander
