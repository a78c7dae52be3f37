// Pieces of triangles with their centroids: what is put in order without curve keys.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <vector>

#include "kernels/core/large_vector.h"
#include "kernels/core/random.h"
#include "kernels/density/pieces.h"
#include "kernels/partition/balanced_order.h"
#include "kernels/partition/chart_places.h"
#include "kernels/partition/elements.h"

namespace meander {

// How a piece that weighs more than `limit`, and whose path does not end, is split into parts of at most
// that.
inline ElementSplit split_of(const PlainPiece& piece, double mass, double limit) {
  ElementSplit split;
  split.levels = 0.5 * mass > limit && piece.path << 1 < deepest_path ? 2 : 1;
  const auto store = [](const Vector3& way, float(&to)[3]) {
    to[0] = static_cast<float>(way.x);
    to[1] = static_cast<float>(way.y);
    to[2] = static_cast<float>(way.z);
  };
  const std::size_t edge = longest_edge(piece);
  store(way_to_first_half(piece, edge), split.half);
  if (split.levels == 1) return split;
  std::array<PlainPiece, 2> half;
  bisect_edge(piece, edge, half[0], half[1]);
  for (std::size_t h = 0; h < 2; ++h)
    store(way_to_first_half(half[h], longest_edge(half[h])), split.quarter[h]);
  return split;
}

// The corners of a piece in space.
struct PieceCorners {
  float at[3][3];
};

// What else is kept of pieces, and which of them are cut.
struct KeptOfPieces {
  bool vertices = false;   // their curve vertices
  bool corners = false;    // of plain ones that are no whole triangles, the corners
  double split_limit = 0;  // unless 0, the splits of plain pieces into parts of at most this mass
  double stratum = 0;      // unless 0, the mass of a sample: wide plain pieces are not cut
};

// Pieces with their centroids (see cut_all).
class PlacedPieces {
 public:
  PlacedPieces(const ChartPlaces& places, RandomKey key, const KeptOfPieces& kept)
      : places_(&places),
        key_(key),
        keep_vertices_(kept.vertices),
        keep_corners_(kept.corners),
        split_limit_(kept.split_limit),
        stratum_(kept.stratum) {}

  static constexpr bool takes_plain_pieces = true;
  bool wants_weights() const { return keep_vertices_ || places_->any(); }

  std::size_t size() const { return point.size(); }
  void reserve(std::size_t pieces, double mass) {
    point.reserve(pieces);
    triangle.reserve(pieces);
    path.reserve(pieces);
    if (keep_vertices_) vertex.reserve(2 * pieces);
    // More pieces than this cannot weigh more than the limit.
    if (split_limit_ > 0)
      most_splits_ = static_cast<std::size_t>(std::min(mass / split_limit_, static_cast<double>(pieces)));
  }
  void append(const PlacedPieces& next) {
    wide += next.wide;
    if (!next.split.empty()) {
      make_room_for_splits();
      for (const std::uint32_t piece : next.split_piece)
        split_piece.push_back(static_cast<std::uint32_t>(point.size()) + piece);
      split.insert(split.end(), next.split.begin(), next.split.end());
    }
    append_large(point, next.point);
    append_large(triangle, next.triangle);
    append_large(path, next.path);
    vertex.insert(vertex.end(), next.vertex.begin(), next.vertex.end());
    if (!next.corners.empty()) {
      corners.resize(point.size() - next.point.size());
      corners.insert(corners.end(), next.corners.begin(), next.corners.end());
    }
  }

  void operator()(std::size_t t, const TriangleSource& source, const WorkPiece& piece, double mass) {
    const auto [b1, b2] = centroid(piece.weights);
    Vector3 at = source.at(b1, b2);
    std::array<double, 3> u, v;
    if (places_->find(t, u, v)) {
      const double b0 = 1 - b1 - b2;
      at = {b0 * u[0] + b1 * u[1] + b2 * u[2], b0 * v[0] + b1 * v[1] + b2 * v[2], 0};
    }
    add(t, at, piece.path, mass);
    if (!keep_vertices_) return;
    const auto [v1, v2] = random_point(piece.weights, t, piece.path, key_);
    vertex.push_back(static_cast<float>(v1));
    vertex.push_back(static_cast<float>(v2));
  }

  void operator()(std::size_t t, const PlainPiece& piece, double mass) {
    if (split_limit_ > 0 && mass > split_limit_ && piece.path < deepest_path) {
      make_room_for_splits();
      split_piece.push_back(static_cast<std::uint32_t>(point.size()));
      split.push_back(split_of(piece, mass, split_limit_));
    }
    add(t, centroid(piece.corner), piece.path, mass);
    if (keep_corners_ && piece.path != 1) store_corners(piece.corner);
  }

  // Both halves of a piece at that edge.
  template <class Edge>
  void add_halves(std::size_t t, const PlainPiece& piece, Edge edge, double mass) {
    if (keep_corners_ || split_limit_ > 0) {
      PlainPiece first, second;
      bisect_edge(piece, edge, first, second);
      (*this)(t, first, mass);
      (*this)(t, second, mass);
      return;
    }
    // Their edges do not matter any more.
    constexpr std::size_t a = edge, b = (a + 1) % 3;
    std::array<Vector3, 3> corner = piece.corner;
    const Vector3 middle = 0.5 * (corner[a] + corner[b]);
    corner[b] = middle;
    add(t, centroid(corner), piece.path << 1, mass);
    corner[b] = piece.corner[b];
    corner[a] = middle;
    add(t, centroid(corner), piece.path << 1 | 1, mass);
  }

  // Wide pieces as wholes.
  double stratum() const { return stratum_; }
  void add_wide(std::size_t t, const PlainPiece& piece, double mass) {
    add(t, centroid(piece.corner), piece.path, mass);
    ++wide;
  }

  // Whole triangles that are not split.
  double whole_limit() const { return split_limit_ > 0 ? split_limit_ : INFINITY; }
  void operator()(std::size_t t, const std::array<Vector3, 3>& whole, double mass) {
    add(t, centroid(whole), 1, mass);
  }
  void add_whole(const PreparedMesh& mesh, std::size_t begin, std::size_t end) {
    const std::size_t first = size(), count = end - begin;
    if (count == 0) return;
    point.resize(first + count);
    triangle.resize(first + count);
    path.resize(first + count, 1);
    MassPoint* const to = point.data() + first;
    std::iota(triangle.begin() + static_cast<std::ptrdiff_t>(first), triangle.end(),
              static_cast<std::uint32_t>(begin));
    const std::uint32_t* const corner = mesh.triangles.data() + 3 * begin;
    for (std::size_t i = 0; i < count; ++i) {
      const Vector3 at = centroid(
          {mesh.position(corner[3 * i]), mesh.position(corner[3 * i + 1]), mesh.position(corner[3 * i + 2])});
      to[i] = mass_point(at, mesh.area[begin + i]);
    }
  }

  std::vector<MassPoint> point;
  std::vector<std::uint32_t> triangle, path;
  std::vector<float> vertex;
  std::vector<std::uint32_t> split_piece;  // the pieces that are split, and
  std::vector<ElementSplit> split;         // how each of them is
  std::size_t wide = 0;                    // so many are wide
  std::vector<PieceCorners> corners;       // by piece up to the last that is no whole triangle; of those only

 private:
  static MassPoint mass_point(const Vector3& at, double mass) {
    return {{static_cast<float>(at.x), static_cast<float>(at.y), static_cast<float>(at.z)}, mass};
  }
  // Only once there is one: most meshes of small triangles have none.
  void make_room_for_splits() {
    if (!split.empty()) return;
    split_piece.reserve(most_splits_);
    split.reserve(most_splits_);
  }
  void add(std::size_t t, const Vector3& at, std::uint32_t piece_path, double mass) {
    point.push_back(mass_point(at, mass));
    triangle.push_back(static_cast<std::uint32_t>(t));
    path.push_back(piece_path);
  }

  // Stores the corners of the piece that was added last.
  void store_corners(const std::array<Vector3, 3>& corner) {
    if (corners.empty()) corners.reserve(point.capacity());
    corners.resize(point.size());
    for (std::size_t k = 0; k < 3; ++k) {
      corners.back().at[k][0] = static_cast<float>(corner[k].x);
      corners.back().at[k][1] = static_cast<float>(corner[k].y);
      corners.back().at[k][2] = static_cast<float>(corner[k].z);
    }
  }

  const ChartPlaces* places_;
  RandomKey key_;
  bool keep_vertices_, keep_corners_;
  double split_limit_, stratum_;
  std::size_t most_splits_ = 0;
};

}  // namespace meander
