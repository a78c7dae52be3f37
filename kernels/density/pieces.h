// Pieces of triangles by longest-edge bisection: what curve elements are (docs/METHODS.md 6.1).
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <type_traits>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/core/parallel.h"
#include "kernels/core/random.h"
#include "kernels/density/density.h"
#include "kernels/mesh/measured_mesh.h"

namespace meander {

// The three corners of a piece in the barycentric weights (of corners 1 and 2) of its triangle. Exact
// (dyadic).
struct Piece {
  double b1[3], b2[3];
};
// corners: bisection_corners of the triangle. O(bisections).
Piece piece_of(const std::array<Vector3, 3>& corners, std::uint32_t path);
// The triangle whose longest edge is bisected: the one in space, or, where the mesh has a metric, a flat one
// of those lengths.
std::array<Vector3, 3> bisection_corners(const MeasuredMesh& surface, std::uint32_t triangle);

// A path is 1 followed by one bit a bisection. A triangle has 2^30 pieces at most; what asks for more gets
// heavier ones.
inline constexpr int most_bisections = 30;
inline constexpr std::uint32_t deepest_path = 1u << most_bisections;

// A piece while it is being bisected: where its corners lie, and the squared lengths of its edges (k from
// corner k to the next), of which the longest is bisected next.
struct PlainPiece {
  std::array<Vector3, 3> corner;
  std::array<double, 3> squared_edge;
  std::uint32_t path;
};
// The same with the barycentric weights of its corners.
struct WorkPiece : PlainPiece {
  Piece weights;
};

PlainPiece plain_triangle(const std::array<Vector3, 3>& corners);
WorkPiece whole_triangle(const std::array<Vector3, 3>& corners);

// The longest edge, the lowest one of equals.
inline std::size_t longest_edge(const PlainPiece& piece) {
  const auto& e = piece.squared_edge;
  return e[0] >= e[1] ? (e[0] >= e[2] ? 0 : 2) : (e[1] >= e[2] ? 1 : 2);
}

// Bisects edge a: child 0 keeps the edge's first end, child 1 its second. Lengths are handed down, so that
// the pieces of a path are the same wherever it is followed.
inline void bisect_edge(const PlainPiece& piece, std::size_t a, PlainPiece& first, PlainPiece& second) {
  const std::size_t b = (a + 1) % 3, c = (a + 2) % 3;
  const Vector3 middle = 0.5 * (piece.corner[a] + piece.corner[b]), median = middle - piece.corner[c];
  const double half = 0.25 * piece.squared_edge[a], cut = dot(median, median);
  first.corner = second.corner = piece.corner;
  first.corner[b] = second.corner[a] = middle;
  first.squared_edge[a] = second.squared_edge[a] = half;
  first.squared_edge[b] = cut;
  first.squared_edge[c] = piece.squared_edge[c];
  second.squared_edge[b] = piece.squared_edge[b];
  second.squared_edge[c] = cut;
  first.path = piece.path << 1;
  second.path = first.path | 1;
}
inline std::array<PlainPiece, 2> bisect(const PlainPiece& piece) {
  std::array<PlainPiece, 2> children;
  bisect_edge(piece, longest_edge(piece), children[0], children[1]);
  return children;
}
std::array<WorkPiece, 2> bisect(const WorkPiece& piece);

// The weights of one half: a middle in place of one end of the edge.
template <std::size_t a>
Piece half_of(const Piece& piece, bool second) {
  constexpr std::size_t b = (a + 1) % 3;
  Piece half = piece;
  half.b1[second ? a : b] = 0.5 * (piece.b1[a] + piece.b1[b]);
  half.b2[second ? a : b] = 0.5 * (piece.b2[a] + piece.b2[b]);
  return half;
}
// One half of a piece, made where it is kept: were it copied there, large sets would take a fifth longer.
template <std::size_t a>
void take_half(const WorkPiece& piece, bool second, WorkPiece& half) {
  constexpr std::size_t b = (a + 1) % 3, c = (a + 2) % 3;
  const Vector3 middle = 0.5 * (piece.corner[a] + piece.corner[b]), median = middle - piece.corner[c];
  const double b1 = 0.5 * (piece.weights.b1[a] + piece.weights.b1[b]),
               b2 = 0.5 * (piece.weights.b2[a] + piece.weights.b2[b]);
  half = piece;
  half.squared_edge[a] = 0.25 * piece.squared_edge[a];
  half.squared_edge[second ? c : b] = dot(median, median);
  half.corner[second ? a : b] = middle;
  half.weights.b1[second ? a : b] = b1;
  half.weights.b2[second ? a : b] = b2;
  half.path = piece.path << 1 | (second ? 1u : 0u);
}

// The piece at the end of a path that begins with the whole triangle.
template <class AnyPiece>
AnyPiece followed(AnyPiece piece, std::uint32_t path) {
  for (int bit = std::bit_width(path) - 2; bit >= 0; --bit) piece = bisect(piece)[path >> bit & 1u];
  return piece;
}

// Geometry and density of one triangle, from which masses and points of its pieces follow.
struct TriangleSource {
  std::array<Vector3, 3> corner;  // in space
  double density[3];
  double area;
  bool uniform;  // density 1 everywhere
  // Where the density is one in pieces: their means by path, and how many bisections they are made by.
  const double* means = nullptr;
  int piece_bisections = 0;

  // O(1); in pieces O(bisections).
  double density_at(double b1, double b2) const {
    if (means != nullptr) return means[piece_at(b1, b2)];
    return (1 - b1 - b2) * density[0] + b1 * density[1] + b2 * density[2];
  }
  // In pieces: no piece is denser.
  double largest_piece() const { return means[0]; }
  // The path of the piece of the density that holds the point.
  std::uint32_t piece_at(double b1, double b2) const;
  // The mean of a density in pieces over the piece of this path.
  double mean_of(std::uint32_t path) const {
    const int bisections = static_cast<int>(std::bit_width(path)) - 1;
    return means[path >> std::max(0, bisections - piece_bisections)];
  }
  Vector3 at(double b1, double b2) const {
    return (1 - b1 - b2) * corner[0] + b1 * corner[1] + b2 * corner[2];
  }
};
TriangleSource source_of(const PreparedMesh& mesh, const Density& density, std::size_t triangle);

// 2^-bisections, exact; a call of ldexp costs more than what it is for.
inline double share_after(int bisections) {
  return std::bit_cast<double>(static_cast<std::uint64_t>(1023 - bisections) << 52);
}

// Chooses, by mass and one number in [0, 1), the part of a piece on which the density of its source is
// constant; the piece itself if nothing lies below it.
WorkPiece part_by_mass(const TriangleSource& source, std::uint32_t path, double choice);

// Mass of the piece of this path: area x mean of the linear density at its corners (exact for a linear
// density), or of its density in pieces.
inline double piece_mass(const TriangleSource& source, const Piece& piece, std::uint32_t path) {
  const double share = share_after(std::bit_width(path) - 1);
  if (source.uniform) return source.area * share;
  if (source.means != nullptr) return source.area * share * source.mean_of(path);
  double mean = 0;
  for (std::size_t k = 0; k < 3; ++k) mean += source.density_at(piece.b1[k], piece.b2[k]);
  return source.area * share * mean / 3;
}

// The weights of a piece's centroid (of corners 1 and 2 of its triangle).
inline std::array<double, 2> centroid(const Piece& piece) {
  return {(piece.b1[0] + piece.b1[1] + piece.b1[2]) / 3, (piece.b2[0] + piece.b2[1] + piece.b2[2]) / 3};
}

inline Vector3 centroid(const std::array<Vector3, 3>& corner) {
  return (1.0 / 3) * (corner[0] + corner[1] + corner[2]);
}
// From a piece's centroid to that of the half that bisect_edge makes first.
inline Vector3 way_to_first_half(const PlainPiece& piece, std::size_t edge) {
  return (1.0 / 6) * (piece.corner[edge] - piece.corner[(edge + 1) % 3]);
}

// Those of the point of it that two uniform numbers in [0, 1) choose: uniform over the piece.
inline std::array<double, 2> uniform_point(const Piece& piece, double first, double second) {
  const double root = std::sqrt(first);
  const double w1 = root * (1 - second), w2 = root * second, w0 = 1 - root;
  return {w0 * piece.b1[0] + w1 * piece.b1[1] + w2 * piece.b1[2],
          w0 * piece.b2[0] + w1 * piece.b2[1] + w2 * piece.b2[2]};
}

// The same of a convex polygon, by the weights of its corners (one or more).
std::array<double, 2> uniform_point(std::span<const std::array<float, 2>> polygon, double first,
                                    double second);

// Those of a uniformly random point of it; a pure function of (key, triangle, path).
std::array<double, 2> random_point(const Piece& piece, std::size_t triangle, std::uint32_t path,
                                   RandomKey key);

// Whether a piece is much longer, where lengths are measured, than a well-shaped one of mass `limit` would be
// there: samples would be spread along it. Never for pieces of less than limit / 8, so that their number is
// bounded.
bool is_needle(const PlainPiece& piece, double mass, double limit);

// Whether the samples' parts of a plain piece, each of the mass `stratum`, can be about as wide as they are
// long: its height over the longest edge is at least the side of a square of that mass. Halves of a narrower
// piece are no wider.
inline bool is_wide(const PlainPiece& piece, double mass, double stratum) {
  return 4 * mass * mass >= stratum * piece.squared_edge[longest_edge(piece)];
}

// use(edge) with the number of the longest edge as a constant: corners that are found by variable numbers
// would go by way of memory.
template <class Use>
void at_longest_edge(const PlainPiece& piece, const Use& use) {
  switch (longest_edge(piece)) {
    case 0:
      return use(std::integral_constant<std::size_t, 0>());
    case 1:
      return use(std::integral_constant<std::size_t, 1>());
    default:
      return use(std::integral_constant<std::size_t, 2>());
  }
}

// Bisects a piece, its halves and so on, `times` (>= 1) in all. halves(piece, edge) is called in path order
// for the pieces that the last bisections are of.
template <class Halves>
void bisect_times(const PlainPiece& piece, int times, const Halves& halves) {
  at_longest_edge(piece, [&](auto edge) {
    if (times == 1) {
      halves(piece, edge);
      return;
    }
    PlainPiece first, second;
    bisect_edge(piece, edge, first, second);
    bisect_times(first, times - 1, halves);
    bisect_times(second, times - 1, halves);
  });
}

// The pieces of many triangles by their paths, one after the other. What the path of a piece has in common
// with the path before it is not followed again.
class PieceWalk {
 public:
  explicit PieceWalk(const MeasuredMesh& surface) : surface_(surface) {}
  // piece_of(bisection_corners(surface, triangle), path). O(bisections that are not in common).
  const Piece& to(std::uint32_t triangle, std::uint32_t path);

 private:
  const MeasuredMesh& surface_;
  std::array<WorkPiece, most_bisections + 1> held_;  // by bisections, as far as the last path goes
  std::uint32_t triangle_ = 0;
  int bisections_ = -1;  // of the last path; none yet
};

// Bisections of a piece of uniform density, all of whose parts weigh the same, until they weigh at most
// `limit` or paths end. Halves `mass` as often.
inline int bisections_to(std::uint32_t path, double limit, double& mass) {
  int times = 0;
  for (std::uint32_t deepest = std::bit_floor(path); mass > limit && deepest < deepest_path; deepest *= 2) {
    mass *= 0.5;
    ++times;
  }
  return times;
}

// Depth-first bisection of a piece until every piece weighs at most `limit` (and, where asked for, none is a
// needle) and there are at least `wanted` of them; `emit` is called in path order.
template <class Emit>
void cut_piece(const TriangleSource& source, const WorkPiece& start, double limit, std::uint32_t wanted,
               bool no_needles, std::vector<WorkPiece>& stack, const Emit& emit) {
  const auto bisections_of = [](const WorkPiece& piece) { return std::bit_width(piece.path) - 1; };
  const int least = bisections_of(start) + (wanted > 1 ? std::bit_width(wanted - 1) : 0);
  const double whole_mass = piece_mass(source, start.weights, start.path);
  if (!(whole_mass > 0)) return;
  const auto too_large = [&](const WorkPiece& piece, double mass) {
    return mass > limit || (no_needles && is_needle(piece, mass, limit));
  };
  if (!too_large(start, whole_mass) && wanted <= 1) {  // most triangles of a fine mesh
    emit(start, whole_mass);
    return;
  }
  stack.push_back(start);
  while (!stack.empty()) {
    const WorkPiece piece = stack.back();
    stack.pop_back();
    const int bisections = bisections_of(piece);
    const double mass = piece_mass(source, piece.weights, piece.path);
    if ((too_large(piece, mass) || bisections < least) && mass > 0 && piece.path < deepest_path) {
      const auto children = bisect(piece);
      stack.push_back(children[1]);
      stack.push_back(children[0]);
    } else if (mass > 0) {
      emit(piece, mass);
    }
  }
}

// A share of the mass of a piece of a triangle.
struct SurfacePiece {
  std::uint32_t triangle, path;
  double share;  // (0, 1]
};

// Cuts pieces into lighter ones and hands them to a record (see cut_all) with the shares of their masses.
template <class Record>
class PieceCutter {
 public:
  // wanted: by triangle, the least number of pieces; may be empty.
  PieceCutter(const MeasuredMesh& surface, const Density& density, std::span<const std::uint32_t> wanted,
              double limit, Record& record)
      : surface_(surface), density_(density), wanted_(wanted), limit_(limit), record_(record) {
    if constexpr (Record::takes_plain_pieces) {
      plain_ = density.uniform() && surface.in_space() && wanted.empty() && !record.wants_weights();
      whole_limit_ = std::min(limit, record.whole_limit());
      stratum_ = record.stratum();
    }
  }

  // Whole triangles.
  void cut_range(std::size_t begin, std::size_t end) {
    const PreparedMesh& mesh = surface_.mesh();
    for (std::size_t t = begin; t < end; ++t) {
      if constexpr (Record::takes_plain_pieces)
        if (plain_) {  // most triangles of a fine mesh are whole
          const std::size_t first = t;
          while (t < end && mesh.area[t] > 0 && mesh.area[t] <= whole_limit_) ++t;
          record_.add_whole(mesh, first, t);
          if (t == end) return;
        }
      cut({static_cast<std::uint32_t>(t), 1, 1.0});
    }
  }

  void cut(const SurfacePiece& piece) {
    const PreparedMesh& mesh = surface_.mesh();
    const std::size_t t = piece.triangle;
    if (!(mesh.area[t] > 0)) return;
    const std::array<Vector3, 3> corners = bisection_corners(surface_, piece.triangle);
    if constexpr (Record::takes_plain_pieces)
      if (plain_) {
        if (piece.path == 1 && mesh.area[t] <= whole_limit_) {
          record_(t, corners, mesh.area[t] * piece.share);
          return;
        }
        const double mass = mesh.area[t] * share_after(std::bit_width(piece.path) - 1);
        if (mass > 0) cut_plain(t, followed(plain_triangle(corners), piece.path), mass, piece.share);
        return;
      }
    const TriangleSource source = source_of(mesh, density_, t);
    cut_piece(source, followed(whole_triangle(corners), piece.path), limit_, wanted_.empty() ? 0 : wanted_[t],
              !surface_.in_space(), stack_, [&](const WorkPiece& part, double part_mass) {
                record_(t, source, part, part_mass * piece.share);
              });
  }

 private:
  void cut_plain(std::size_t t, const PlainPiece& piece, double mass, double share) {
    if (stratum_ > 0 && mass > limit_ && is_wide(piece, mass, stratum_)) {
      record_.add_wide(t, piece, mass * share);
      return;
    }
    const int times = bisections_to(piece.path, limit_, mass);
    mass *= share;
    if (times == 0)
      record_(t, piece, mass);
    else
      bisect_times(piece, times,
                   [&](const PlainPiece& whole, auto edge) { record_.add_halves(t, whole, edge, mass); });
  }

  const MeasuredMesh& surface_;
  const Density& density_;
  std::span<const std::uint32_t> wanted_;
  double limit_, stratum_ = 0;
  Record& record_;
  bool plain_ = false;
  double whole_limit_ = 0;
  std::vector<WorkPiece> stack_;
};

// Cuts all triangles of positive area, in their order. `record` is a class with
//   void operator()(std::size_t triangle, const TriangleSource&, const WorkPiece&, double mass);
// and, if its takes_plain_pieces is true, for pieces in space of uniform density
//   bool wants_weights() const;  // else plain pieces will do
//   void operator()(std::size_t triangle, const PlainPiece&, double mass);
//   void add_halves(std::size_t triangle, const PlainPiece&, Edge bisected, double mass_of_each);
//   double stratum() const;  // unless 0, the mass of a sample: wide pieces are not cut
//   void add_wide(std::size_t triangle, const PlainPiece&, double mass);
//   double whole_limit() const;  // whole triangles of at most this mass are handed over by their corners
//   void operator()(std::size_t triangle, const std::array<Vector3, 3>& corners, double mass);
//   void add_whole(const PreparedMesh&, std::size_t begin, std::size_t end);  // or many, each of its area
//   std::size_t size() const;
//   void reserve(std::size_t pieces, double mass_of_all);
//   void append(const Record& of_the_next_triangles);
// `make` makes an empty one. Parallel by blocks of triangles, appended in order.
template <class Make>
auto cut_all(const MeasuredMesh& surface, const Density& density, std::span<const std::uint32_t> wanted,
             double limit, const Make& make, const CancelToken& cancel) {
  const PreparedMesh& mesh = surface.mesh();
  const std::size_t triangles = mesh.triangle_count();
  using Record = decltype(make());
  // Large, so that a model of usual size is one block, whose pieces need no copying; of very large ones few,
  // so that an allocator gives the memory of each back while they are joined.
  constexpr std::size_t usual_block = 16384, most_blocks = 16;
  const std::size_t block = std::max(usual_block, (triangles + most_blocks - 1) / most_blocks);
  constexpr double most_reserved = 1 << 20;
  std::vector<Record> parts((triangles + block - 1) / block, make());
  std::vector<double> areas(parts.size());
  parallel_blocks(triangles, block, [&](std::size_t begin, std::size_t end) {
    cancel.check();
    auto& part = parts[begin / block];
    // Pieces of large triangles weigh between half the limit and all of it.
    double area = 0;
    for (std::size_t t = begin; t < end; ++t) area += mesh.area[t];
    const double more = density.uniform() && limit > 0 ? 1.5 * area / limit : 0.0;
    areas[begin / block] = area;
    part.reserve(end - begin + static_cast<std::size_t>(std::min(more, most_reserved)), area);
    PieceCutter cutter(surface, density, wanted, limit, part);
    cutter.cut_range(begin, end);
  });
  if (parts.size() == 1) return std::move(parts.front());
  Record all = make();
  std::size_t pieces = 0;
  for (const Record& part : parts) pieces += part.size();
  all.reserve(pieces, std::accumulate(areas.begin(), areas.end(), 0.0));
  for (Record& part : parts) {
    all.append(part);
    part = make();
  }
  return all;
}

}  // namespace meander
