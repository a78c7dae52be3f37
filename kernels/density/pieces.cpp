#include "kernels/density/pieces.h"

#include <algorithm>
#include <cmath>

namespace meander {

PlainPiece plain_triangle(const std::array<Vector3, 3>& corners) {
  PlainPiece piece{corners, {}, 1};
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector3 edge = corners[(k + 1) % 3] - corners[k];
    piece.squared_edge[k] = dot(edge, edge);
  }
  return piece;
}

WorkPiece whole_triangle(const std::array<Vector3, 3>& corners) {
  return {plain_triangle(corners), {{0, 1, 0}, {0, 0, 1}}};
}

std::array<WorkPiece, 2> bisect(const WorkPiece& piece) {
  std::array<WorkPiece, 2> halves;
  at_longest_edge(piece, [&](auto edge) {
    take_half<edge>(piece, false, halves[0]);
    take_half<edge>(piece, true, halves[1]);
  });
  return halves;
}

const Piece& PieceWalk::to(std::uint32_t triangle, std::uint32_t path) {
  static constexpr Piece whole = {{0, 1, 0}, {0, 0, 1}};
  if (path == 1) return whole;
  const int bisections = std::bit_width(path) - 1;
  const auto leading = [](std::uint32_t of_path, int count) { return of_path << (most_bisections - count); };
  int common = 0;
  if (bisections_ >= 0 && triangle == triangle_) {
    const std::uint32_t differ =
        leading(path, bisections) ^ leading(held_[static_cast<std::size_t>(bisections_)].path, bisections_);
    common = std::min({bisections, bisections_, most_bisections - static_cast<int>(std::bit_width(differ))});
  } else {
    held_[0] = whole_triangle(bisection_corners(surface_, triangle));
  }
  for (int level = common; level < bisections; ++level) {
    const WorkPiece& piece = held_[static_cast<std::size_t>(level)];
    WorkPiece& half = held_[static_cast<std::size_t>(level) + 1];
    const bool second = (path >> (bisections - 1 - level) & 1u) != 0;
    at_longest_edge(piece, [&](auto edge) { take_half<edge>(piece, second, half); });
  }
  triangle_ = triangle;
  bisections_ = bisections;
  return held_[static_cast<std::size_t>(bisections)].weights;
}

TriangleSource source_of(const PreparedMesh& mesh, const Density& density, std::size_t triangle) {
  TriangleSource source;
  for (std::size_t k = 0; k < 3; ++k) {
    source.corner[k] = mesh.position(mesh.triangles[3 * triangle + k]);
    source.density[k] = density.corner.empty() ? 1.0 : density.corner[3 * triangle + k];
  }
  source.area = mesh.area[triangle];
  source.uniform = density.uniform();
  if (density.in_pieces()) {
    const std::size_t begin = density.piece_begin[triangle], held = density.piece_begin[triangle + 1] - begin;
    source.means = density.piece_mean.data() + begin;
    source.piece_bisections = static_cast<int>(std::bit_width(held)) - 2;
  }
  return source;
}

std::uint32_t TriangleSource::piece_at(double b1, double b2) const {
  PlainPiece piece = plain_triangle(corner);
  std::array<double, 3> weight = {1 - b1 - b2, b1, b2};
  for (int level = 0; level < piece_bisections; ++level) {
    const std::size_t a = longest_edge(piece), b = (a + 1) % 3;
    const bool in_second = weight[b] > weight[a];
    // The weights of the ends and of the middle of the edge: w A + v B = (w - v) A + 2 v M.
    const double less = std::min(weight[a], weight[b]), more = std::max(weight[a], weight[b]);
    weight[in_second ? b : a] = more - less;
    weight[in_second ? a : b] = 2 * less;
    piece = bisect(piece)[in_second ? 1 : 0];
  }
  return piece.path;
}

WorkPiece part_by_mass(const TriangleSource& source, std::uint32_t path, double choice) {
  WorkPiece piece = followed(whole_triangle(source.corner), path);
  while (source.means != nullptr && piece.path < 1u << source.piece_bisections) {
    const double first = source.means[2 * piece.path], second = source.means[2 * piece.path + 1];
    const double at = choice * (first + second);
    const bool in_second = second > 0 && at >= first;
    choice = in_second ? (at - first) / second : at / first;
    piece = bisect(piece)[in_second ? 1 : 0];
  }
  return piece;
}

std::array<double, 2> random_point(const Piece& piece, std::size_t triangle, std::uint32_t path,
                                   RandomKey key) {
  const UnitPair uniform =
      random_pair(key, Stream::element_key, static_cast<std::uint64_t>(triangle) << 32 | path);
  return uniform_point(piece, uniform.first, uniform.second);
}

// In one of the triangles around its first corner.
std::array<double, 2> uniform_point(std::span<const std::array<float, 2>> polygon, double first,
                                    double second) {
  const auto corner = [&](std::size_t k) {
    return std::array<double, 2>{double(polygon[k][0]), double(polygon[k][1])};
  };
  const std::array<double, 2> a = corner(0);
  if (polygon.size() < 3) return a;
  const auto area = [&](std::size_t k) {
    const std::array<double, 2> b = corner(k), c = corner(k + 1);
    return std::abs((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]));
  };
  double whole = 0;
  for (std::size_t k = 1; k + 1 < polygon.size(); ++k) whole += area(k);
  double left = first * whole;
  std::size_t k = 1;
  for (; k + 2 < polygon.size() && left >= area(k); ++k) left -= area(k);
  const std::array<double, 2> b = corner(k), c = corner(k + 1);
  const double twice = area(k);
  return uniform_point(Piece{{a[0], b[0], c[0]}, {a[1], b[1], c[1]}},
                       twice > 0 ? std::min(left / twice, 1.0) : 0, second);
}

bool is_needle(const PlainPiece& piece, double mass, double limit) {
  if (!(8 * mass > limit)) return false;
  const double longest = piece.squared_edge[longest_edge(piece)];
  // 2.3 for an equilateral triangle of this mass, 4 for half a square.
  return longest * mass > 4.1 * triangle_area(piece.corner[0], piece.corner[1], piece.corner[2]) * limit;
}

std::array<Vector3, 3> bisection_corners(const MeasuredMesh& surface, std::uint32_t triangle) {
  const PreparedMesh& mesh = surface.mesh();
  const std::uint32_t h = 3 * triangle;
  if (surface.in_space())
    return {mesh.position(mesh.triangles[h]), mesh.position(mesh.triangles[h + 1]),
            mesh.position(mesh.triangles[h + 2])};
  const double a = surface.length(h), b = surface.length(h + 1), c = surface.length(h + 2);
  if (!(a > 0)) return {Vector3{}, Vector3{}, Vector3{b, 0, 0}};
  const double x = 0.5 * (a + (c - b) * (c + b) / a), y = 2 * area_from_lengths(a, b, c) / a;
  return {Vector3{}, Vector3{a, 0, 0}, Vector3{x, y, 0}};
}

Piece piece_of(const std::array<Vector3, 3>& corners, std::uint32_t path) {
  // As bisect does, in place: of the bisected edge one end moves to its middle.
  PlainPiece piece = plain_triangle(corners);
  Piece weights = {{0, 1, 0}, {0, 0, 1}};
  for (int bit = std::bit_width(path) - 2; bit >= 0; --bit) {
    const std::size_t a = longest_edge(piece), b = (a + 1) % 3, c = (a + 2) % 3;
    const std::size_t moved = (path >> bit & 1u) != 0 ? a : b;
    const Vector3 middle = 0.5 * (piece.corner[a] + piece.corner[b]), median = middle - piece.corner[c];
    piece.corner[moved] = middle;
    weights.b1[moved] = 0.5 * (weights.b1[a] + weights.b1[b]);
    weights.b2[moved] = 0.5 * (weights.b2[a] + weights.b2[b]);
    piece.squared_edge[a] *= 0.25;
    piece.squared_edge[moved == a ? c : b] = dot(median, median);
  }
  return weights;
}

}  // namespace meander
