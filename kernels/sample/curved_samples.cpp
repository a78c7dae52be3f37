#include "kernels/sample/curved_samples.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "kernels/core/disjoint_sets.h"
#include "kernels/core/parallel.h"
#include "kernels/core/portable_angles.h"
#include "kernels/core/radix_sort.h"

namespace meander {

namespace {

void check_parameters(const CurvedSampleParameters& parameters) {
  if (!(parameters.crease_degrees >= 0 && parameters.crease_degrees <= 180))
    throw std::invalid_argument("crease_degrees lies between 0 and 180");
  if (!(parameters.lift_limit >= 0 && parameters.lift_limit <= 1))
    throw std::invalid_argument("lift_limit lies between 0 and 1");
}

Vector3 unit_or_zero(Vector3 v) {
  const double length = norm(v);
  return length > 0 ? (1 / length) * v : Vector3{};
}

std::size_t next_corner(std::size_t corner) { return corner % 3 == 2 ? corner - 2 : corner + 1; }

}  // namespace

std::vector<double> crease_normals(std::span<const double> x, std::span<const double> y,
                                   std::span<const double> z, std::span<const std::uint32_t> triangles,
                                   const CurvedSampleParameters& parameters) {
  check_parameters(parameters);
  const std::size_t corners = triangles.size() / 3 * 3;
  const auto position = [&](std::size_t corner) {
    const std::uint32_t v = triangles[corner];
    return Vector3{x[v], y[v], z[v]};
  };
  // Normals do not depend on the scale; this one keeps squares of squares within the range of double.
  double longest = 0;
  for (std::size_t c = 0; c < corners; ++c) {
    const Vector3 edge = position(next_corner(c)) - position(c);
    longest = std::max({longest, std::abs(edge.x), std::abs(edge.y), std::abs(edge.z)});
  }
  const double scale = longest > 0 ? longest : 1;
  const auto edge_of = [&](std::size_t from, std::size_t to) {
    const Vector3 edge = position(to) - position(from);
    return Vector3{edge.x / scale, edge.y / scale, edge.z / scale};
  };

  std::vector<Vector3> face_normal(corners / 3);
  for (std::size_t t = 0; t < face_normal.size(); ++t)
    face_normal[t] = unit_or_zero(cross(edge_of(3 * t, 3 * t + 1), edge_of(3 * t, 3 * t + 2)));

  std::vector<KeyIndex> edges(corners), scratch;
  for (std::size_t c = 0; c < corners; ++c) {
    const std::uint32_t from = triangles[c], to = triangles[next_corner(c)];
    edges[c] = {std::uint64_t{std::min(from, to)} << 32 | std::max(from, to), static_cast<std::uint32_t>(c)};
  }
  radix_sort(edges, scratch);
  const double least_cosine = direction_of(parameters.crease_degrees * (std::numbers::pi / 180)).cosine;
  DisjointSets sets(corners);  // corners that share a normal
  for (std::size_t begin = 0, end = 0; begin < corners; begin = end) {
    for (end = begin; end < corners && edges[end].key == edges[begin].key;) ++end;
    if (end - begin != 2) continue;
    const std::uint32_t a = edges[begin].index, b = edges[begin + 1].index;
    const Vector3 &na = face_normal[a / 3], &nb = face_normal[b / 3];
    // Both half-edges begin at one vertex where neighbors are turned against each other.
    if (a / 3 == b / 3 || triangles[a] == triangles[b]) continue;
    if (dot(na, na) == 0 || dot(nb, nb) == 0 || dot(na, nb) < least_cosine) continue;
    sets.join(a, static_cast<std::uint32_t>(next_corner(b)));
    sets.join(static_cast<std::uint32_t>(next_corner(a)), b);
  }

  std::vector<Vector3> sums(corners);
  for (std::size_t c = 0; c < corners; ++c) {
    const std::size_t after = next_corner(c), before = next_corner(after);
    const Vector3 e1 = edge_of(c, after), e2 = edge_of(c, before);
    const double weight = dot(e1, e1) * dot(e2, e2);
    if (!(weight > 0)) continue;
    Vector3& sum = sums[sets.find(static_cast<std::uint32_t>(c))];
    sum = sum + (1 / weight) * cross(e1, e2);
  }
  std::vector<double> normals(3 * corners);
  for (std::size_t c = 0; c < corners; ++c) {
    const bool flat = dot(face_normal[c / 3], face_normal[c / 3]) == 0;
    const Vector3 n = flat ? Vector3{} : unit_or_zero(sums[sets.find(static_cast<std::uint32_t>(c))]);
    normals[3 * c] = n.x;
    normals[3 * c + 1] = n.y;
    normals[3 * c + 2] = n.z;
  }
  return normals;
}

double curved_offset(const std::array<Vector3, 3>& corners, const std::array<Vector3, 3>& normals,
                     const std::array<double, 3>& weights, double lift_limit) {
  double offset = 0, longest = 0;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = i + 1; j < 3; ++j) {
      const Vector3 edge = corners[j] - corners[i];
      offset += 0.5 * weights[i] * weights[j] * dot(normals[j] - normals[i], edge);
      longest = std::max(longest, norm(edge));
    }
  return std::clamp(offset, -lift_limit * longest, lift_limit * longest);
}

std::vector<double> lift_samples(std::span<const double> x, std::span<const double> y,
                                 std::span<const double> z, std::span<const std::uint32_t> triangles,
                                 std::span<const double> normals, std::span<const std::uint32_t> triangle,
                                 std::span<const float> barycentric,
                                 const CurvedSampleParameters& parameters) {
  check_parameters(parameters);
  if (normals.size() != 3 * triangles.size() || barycentric.size() != 2 * triangle.size())
    throw std::invalid_argument("lift_samples needs nine numbers a triangle and two weights a sample");
  for (const std::uint32_t t : triangle)
    if (t >= triangles.size() / 3) throw std::invalid_argument("a sample on a triangle that is not there");
  std::vector<double> points(3 * triangle.size());
  parallel_blocks(triangle.size(), sum_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const double b1 = barycentric[2 * i], b2 = barycentric[2 * i + 1];
      const std::array<double, 3> weights{1 - b1 - b2, b1, b2};
      std::array<Vector3, 3> corner, normal;
      Vector3 point, direction;
      for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t c = 3 * std::size_t{triangle[i]} + k;
        const std::uint32_t v = triangles[c];
        corner[k] = {x[v], y[v], z[v]};
        normal[k] = {normals[3 * c], normals[3 * c + 1], normals[3 * c + 2]};
        point = point + weights[k] * corner[k];
        direction = direction + weights[k] * normal[k];
      }
      point = point + curved_offset(corner, normal, weights, parameters.lift_limit) * unit_or_zero(direction);
      points[3 * i] = point.x;
      points[3 * i + 1] = point.y;
      points[3 * i + 2] = point.z;
    }
  });
  return points;
}

}  // namespace meander
