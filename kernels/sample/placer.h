// Points of the elements that samples lie in: what all sets of samples on meshes share.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "kernels/core/exact_division.h"
#include "kernels/core/random.h"
#include "kernels/density/pieces.h"
#include "kernels/mesh/measured_mesh.h"
#include "kernels/mesh/polygon_mesh.h"
#include "kernels/mesh/surface_walk.h"
#include "kernels/sample/place_samples.h"
#include "kernels/sample/sample_sites.h"

namespace meander {

// Redraws of a point that is there already.
inline constexpr int max_redraws = 64;
// Acceptance of a linear density is at least 1/3 a trial: 64 misses in a row happen once in 10^11 draws.
inline constexpr int max_draws = 64;

// Where a triangle lies, for points by their weights.
struct CornerFrame {
  double origin[3], first[3], second[3];
};

struct Draw {
  double b1, b2;
  std::uint32_t next_counter;
};

// Everything that placing one sample needs; const, shared by all threads.
struct Placer : PlaceContext {
  const SampleSites& sites;
  const OutputFrame& frame;
  const Density& density = measure.density;
  const PreparedMesh& mesh = surface.mesh();
  ExactDivision in_units{mesh.unit};
  double scale_in_units = frame.scale / mesh.unit;

  // Whether the samples define the frame of their points (sample_frame.h).
  bool frame_follows() const { return parameters.normalize == NormalizeKind::pointnet; }

  double density_at(std::uint32_t triangle, double b1, double b2) const {
    if (density.uniform()) return 1.0;
    if (density.in_pieces()) return source_of(mesh, density, triangle).density_at(b1, b2);
    const double* corner = &density.corner[3 * std::size_t{triangle}];
    return (1 - b1 - b2) * corner[0] + b1 * corner[1] + b2 * corner[2];
  }

  Piece piece(std::size_t rank) const {
    return piece_of(bisection_corners(surface, sites.site[rank].triangle), sites.site[rank].path);
  }

  // A mu-uniform point of the piece: uniform, accepted with probability density / largest corner density.
  Draw draw(std::uint32_t triangle, const Piece& p, std::uint32_t rank, std::uint32_t counter) const {
    if (density.uniform()) {
      const auto weights = drawn_point(p, rank, key, counter);
      return {weights[0], weights[1], counter + 1};
    }
    double largest = 0, smallest = INFINITY;
    for (std::size_t k = 0; k < 3; ++k) {
      const double d = density_at(triangle, p.b1[k], p.b2[k]);
      largest = std::max(largest, d);
      smallest = std::min(smallest, d);
    }
    if (density.in_pieces()) {  // near a curve vertex: its corners say nothing about what is between them
      largest = source_of(mesh, density, triangle).largest_piece();
      smallest = 0;
    }
    Draw result{p.b1[0], p.b2[0], counter};
    for (int trial = 0; trial < max_draws; ++trial) {
      const auto weights = drawn_point(p, rank, key, result.next_counter++);
      result.b1 = weights[0];
      result.b2 = weights[1];
      if (smallest == largest) break;
      const double accept = random_pair(key, Stream::element_point, rank, result.next_counter++).first;
      if (accept * largest <= density_at(triangle, result.b1, result.b2)) break;
    }
    return result;
  }

  // A mu-uniform point of the element.
  Draw draw_in_element(std::uint32_t rank, const Piece& p, std::uint32_t counter) const {
    return density.in_pieces() ? draw_in_parts(rank, counter)
                               : draw(sites.site[rank].triangle, p, rank, counter);
  }
  // The same where the density is one in pieces: in one of them, chosen by mass.
  Draw draw_in_parts(std::uint32_t rank, std::uint32_t counter) const {
    const double choice = random_pair(key, Stream::element_point, rank, counter).first;
    const UnitPair uniform = random_pair(key, Stream::element_point, rank, counter + 1);
    const WorkPiece part =
        part_by_mass(source_of(mesh, density, sites.site[rank].triangle), sites.site[rank].path, choice);
    const auto weights = uniform_point(part.weights, uniform.first, uniform.second);
    return {weights[0], weights[1], counter + 2};
  }

  // The sample of that rank: at the point of its piece, or at a mu-uniform one. Ranks that follow each other
  // often lie in one triangle: `walk` is best that of the rank before.
  Draw first_draw(std::uint32_t rank, PieceWalk& walk) const {
    const SampleSite& site = sites.site[rank];
    const Piece& p = walk.to(site.triangle, site.path);
    if (site.b1 == SampleSite::nowhere) return draw_in_element(rank, p, 0);
    const auto weights = point_in(p, site);
    return {weights[0], weights[1], 1};
  }

  // The piece to redraw a duplicate in: the element itself, or, for a curve vertex that stands for less than
  // the whole triangle, the triangle shrunk towards the vertex until it weighs what the vertex does.
  Piece redraw_piece(std::size_t rank) const {
    Piece p = piece(rank);
    if (parameters.place == PlaceKind::element || sites.site[rank].path != 1) return p;
    const std::uint32_t t = sites.site[rank].triangle;
    const double whole =
        density.in_pieces()
            ? piece_mass(source_of(mesh, density, t), {}, 1)
            : mesh.area[t] * (density_at(t, 0, 0) + density_at(t, 1, 0) + density_at(t, 0, 1)) / 3;
    const double shrink = whole > 0 ? std::sqrt(std::clamp(sites.mass[rank] / whole, 0.0, 1.0)) : 1.0;
    for (std::size_t k = 0; k < 3; ++k) {
      p.b1[k] = sites.site[rank].b1 + shrink * (p.b1[k] - sites.site[rank].b1);
      p.b2[k] = sites.site[rank].b2 + shrink * (p.b2[k] - sites.site[rank].b2);
    }
    return p;
  }

  std::array<std::uint32_t, 3> corners(std::uint32_t triangle) const {
    const std::uint32_t* const slot = &mesh.corner_slot[3 * std::size_t{triangle}];
    return {file.corners[slot[0]], file.corners[slot[1]], file.corners[slot[2]]};
  }

  // Corner 0, and the ways from there to the other two: in units of the mesh, where nothing leaves the range
  // of double.
  CornerFrame corner_frame(std::uint32_t triangle) const { return corner_frame(triangle, frame.loc); }
  // The same from another place of the file.
  CornerFrame corner_frame(std::uint32_t triangle, const Vector3& from) const {
    const auto [v0, v1, v2] = corners(triangle);
    CornerFrame result;
    const auto set = [&, v0 = v0, v1 = v1, v2 = v2](const std::vector<double>& c, double loc, std::size_t k) {
      result.origin[k] = in_units(c[v0] - loc);
      result.first[k] = in_units(c[v1] - c[v0]);
      result.second[k] = in_units(c[v2] - c[v0]);
    };
    set(file.x, from.x, 0);
    set(file.y, from.y, 1);
    set(file.z, from.z, 2);
    return result;
  }

  // The point that float32 weights name, in stored coordinates: what a reader recomputes from corners and
  // weights.
  std::array<float, 3> stored_point(const CornerFrame& from, float b1, float b2) const {
    std::array<float, 3> point;
    for (std::size_t k = 0; k < 3; ++k) {
      const double at = from.origin[k] + b1 * from.first[k] + b2 * from.second[k];
      point[k] = static_cast<float>(at / scale_in_units) + 0.0f;  // no negative zero
    }
    return point;
  }
  std::array<float, 3> stored_point(std::uint32_t triangle, float b1, float b2) const {
    return stored_point(corner_frame(triangle), b1, b2);
  }

  // Where a sample lies from that place of the file, in units of the mesh.
  Vector3 place_from(const Vector3& from, std::size_t rank) const {
    const SampleSite& site = sites.site[rank];
    const CornerFrame corner = corner_frame(site.triangle, from);
    const auto at = [&](std::size_t k) {
      return corner.origin[k] + site.b1 * corner.first[k] + site.b2 * corner.second[k];
    };
    return {at(0), at(1), at(2)};
  }

  // Where a sample lies on the mesh as it is worked on, whatever the stored coordinates are.
  std::array<float, 3> place_in_mesh(std::size_t rank) const {
    const SampleSite& site = sites.site[rank];
    const std::uint32_t* const corner = &mesh.triangles[3 * std::size_t{site.triangle}];
    const double b1 = static_cast<double>(site.b1), b2 = static_cast<double>(site.b2);
    const Vector3 at = (1 - b1 - b2) * mesh.position(corner[0]) + b1 * mesh.position(corner[1]) +
                       b2 * mesh.position(corner[2]);
    return {static_cast<float>(at.x), static_cast<float>(at.y), static_cast<float>(at.z)};
  }

  Vector3 geometric_normal(std::uint32_t triangle) const {
    const Vector3 normal = triangle_normal(mesh, triangle);
    return dot(normal, normal) > 0 ? normal : Vector3{0, 0, 1};
  }

  // The file's normals interpolated, where all three corners have a usable one and they do not cancel.
  Vector3 normal(std::uint32_t triangle, float b1, float b2) const {
    if (file.normals.empty()) return geometric_normal(triangle);
    const double weight[3] = {1.0 - b1 - b2, b1, b2};
    Vector3 sum;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t slot = mesh.corner_slot[3 * std::size_t{triangle} + k];
      const std::size_t number = file.corner_normals.empty() ? file.corners[slot] : file.corner_normals[slot];
      if (3 * number + 2 >= file.normals.size()) return geometric_normal(triangle);
      const Vector3 n = {file.normals[3 * number], file.normals[3 * number + 1],
                         file.normals[3 * number + 2]};
      const double length = norm(n);
      if (!(length > 0) || !std::isfinite(length)) return geometric_normal(triangle);
      sum = sum + (weight[k] / length) * n;
    }
    const double length = norm(sum);
    return length > 1e-6 ? (1 / length) * sum : geometric_normal(triangle);
  }
};

// The same with points in another frame, which must outlive it.
inline Placer in_frame(const Placer& placer, const OutputFrame& frame) {
  return {static_cast<const PlaceContext&>(placer), placer.sites, frame};
}

// Normals of the file without a direction.
inline std::uint32_t count_bad_normals(const PolygonMesh& file) {
  std::uint32_t bad = 0;
  for (std::size_t i = 0; i + 2 < file.normals.size(); i += 3) {
    const double length = norm({file.normals[i], file.normals[i + 1], file.normals[i + 2]});
    bad += !(length > 0) || !std::isfinite(length);
  }
  return bad;
}

// Arrays for that many samples, but for curve_rank.
inline Samples room_for_samples(std::size_t count) {
  Samples samples;
  samples.points.resize(3 * count);
  samples.normals.resize(3 * count);
  samples.face.resize(count);
  samples.triangle.resize(count);
  samples.corners.resize(3 * count);
  samples.barycentric.resize(2 * count);
  samples.density.resize(count);
  return samples;
}

// What a sample takes from its triangle: the same for all of them, unless the file has normals.
struct TriangleRecord {
  std::array<float, 3> normal;
  std::array<std::uint32_t, 3> corners;
  std::uint32_t polygon;
};
inline std::array<float, 3> to_float(const Vector3& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

// Sample i: the one of this rank, at this point.
inline void set_sample(const Placer& placer, std::size_t rank, const std::array<float, 3>& point,
                       const TriangleRecord& record, std::size_t i, Samples& samples) {
  const auto [t, path, b1, b2] = placer.sites.site[rank];
  for (std::size_t k = 0; k < 3; ++k) {
    samples.points[3 * i + k] = point[k];
    samples.normals[3 * i + k] = record.normal[k];
    samples.corners[3 * i + k] = record.corners[k];
  }
  samples.face[i] = record.polygon;
  samples.triangle[i] = t;
  samples.barycentric[2 * i] = b1;
  samples.barycentric[2 * i + 1] = b2;
  samples.density[i] = static_cast<float>(placer.density_at(t, b1, b2));
}

inline void set_sample(const Placer& placer, std::size_t rank, const std::array<float, 3>& point,
                       std::size_t i, Samples& samples) {
  const SampleSite& site = placer.sites.site[rank];
  const TriangleRecord record{to_float(placer.normal(site.triangle, site.b1, site.b2)),
                              placer.corners(site.triangle), placer.mesh.polygon[site.triangle]};
  set_sample(placer, rank, point, record, i, samples);
}

}  // namespace meander
