#include "kernels/sample/sharp_samples.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <vector>

#include "kernels/mesh/surface_walk.h"
#include "kernels/sample/point_frames.h"

namespace meander {

namespace {

// The key of the positions along edges, which has nothing to do with those of the samples.
RandomKey sharp_key(RandomKey key) {
  const PhiloxBlock words = random_words(key, Stream::sharp_edges, 0);
  return {{words[0], words[1]}};
}

Vector3 unit_vector(Vector3 v) {
  const double length = norm(v);
  return length > 0 ? (1 / length) * v : Vector3{};
}

Vector3 along_edge(const PreparedMesh& mesh, const SharpEdges& edges, std::size_t e) {
  return unit_vector(mesh.position(edges.end[e]) - mesh.position(edges.start[e]));
}

// Without negative zeros.
std::array<float, 3> stored_vector(Vector3 v) {
  return {static_cast<float>(v.x) + 0.0f, static_cast<float>(v.y) + 0.0f, static_cast<float>(v.z) + 0.0f};
}

// Sets the rows from `begin` on to the points of these ranks along the curves, their places in working units
// in `points`.
void set_rows(const PreparedMesh& mesh, const SharpEdges& edges, const EdgePoints& at,
              const std::vector<std::uint32_t>& ranks, std::size_t begin, std::vector<double>& points,
              Samples& samples) {
  // Normals in the order of the curves first, as neighbors lie on the same edges: rows are anywhere.
  struct Frame {
    std::array<float, 3> normal, tangent;
  };
  std::vector<Frame> frames(at.edge.size());
  for (std::size_t r = 0; r < frames.size(); ++r) {
    const std::uint32_t e = at.edge[r];
    frames[r] = r > 0 && at.edge[r - 1] == e ? frames[r - 1]
                                             : Frame{stored_vector(edge_normal(mesh, edges, e)),
                                                     stored_vector(along_edge(mesh, edges, e))};
  }
  for (std::size_t i = 0; i < ranks.size(); ++i) {
    const std::size_t row = begin + i, rank = ranks[i];
    for (std::size_t k = 0; k < 3; ++k) {
      points[3 * row + k] = at.point[3 * rank + k];
      samples.sharp_normals[3 * row + k] = frames[rank].normal[k];
      samples.sharp_tangents[3 * row + k] = frames[rank].tangent[k];
    }
    samples.sharp_edge[row] = at.edge[rank];
  }
}

// Ranks along the curve in the order of the file.
std::vector<std::uint32_t> ranks_in_order(std::uint32_t count, OrderKind order, RandomKey key) {
  if (order == OrderKind::progressive && count > 0) return progressive_order(count, key);
  std::vector<std::uint32_t> ranks(count);
  std::iota(ranks.begin(), ranks.end(), 0u);
  return ranks;
}

void fill_without_edges(const PreparedMesh& mesh, const SharpParameters& parameters, Samples& samples) {
  const std::size_t count = parameters.samples;
  samples.sharp_edge.assign(count, no_sharp_edge);
  if (parameters.fill == SharpFill::nan) {
    constexpr float nan = std::numeric_limits<float>::quiet_NaN();
    for (auto* const values : {&samples.sharp_points, &samples.sharp_normals, &samples.sharp_tangents})
      values->assign(3 * count, nan);
    return;
  }
  for (std::size_t s = 0; s < count; ++s) {
    const std::size_t i = s % samples.count();
    for (std::size_t k = 0; k < 3; ++k) {
      samples.sharp_points[3 * s + k] = samples.points[3 * i + k];
      samples.sharp_normals[3 * s + k] = samples.normals[3 * i + k];
    }
    const std::uint32_t* const corner = &mesh.triangles[3 * std::size_t{samples.triangle[i]}];
    const Vector3 along = unit_vector(mesh.position(corner[1]) - mesh.position(corner[0]));
    const std::array<float, 3> tangent = stored_vector(along);
    std::copy(tangent.begin(), tangent.end(),
              samples.sharp_tangents.begin() + 3 * static_cast<std::ptrdiff_t>(s));
  }
}

// The attribute of faces of that name, whether always read or asked for; null: there is none.
const ScalarAttribute* face_attribute(const PolygonMesh& file, const std::string& name) {
  for (const auto* const list : {&file.face_attributes, &file.asked_face_attributes})
    for (const ScalarAttribute& attribute : *list)
      if (attribute.name == name) return &attribute;
  return nullptr;
}

}  // namespace

SharpEdges sharp_edges_of(const PolygonMesh& file, const PreparedMesh& mesh,
                          const SharpParameters& parameters, Notes& notes) {
  SharpEdgeParameters wanted;
  std::vector<double> padded;
  if (const std::string& name = parameters.attribute; !name.empty()) {
    const ScalarAttribute* const attribute = face_attribute(file, name);
    if (attribute == nullptr) {
      notes.add(Note::feature_ignored, "sharp edges of the attribute `" + name +
                                           "`: the faces have none, so that edges by angle stay");
    } else if (attribute->values.size() < file.polygon_count()) {
      padded = attribute->values;
      padded.resize(file.polygon_count(), std::numeric_limits<double>::quiet_NaN());
      wanted.classes = padded;
    } else {
      wanted.classes = attribute->values;
    }
  }
  wanted.angle = parameters.angle;
  wanted.borders = parameters.borders;
  return find_sharp_edges(mesh, wanted);
}

Vector3 edge_normal(const PreparedMesh& mesh, const SharpEdges& edges, std::size_t e) {
  const std::uint32_t first = edges.triangle[2 * e], second = edges.triangle[2 * e + 1];
  const Vector3 of_first = triangle_normal(mesh, first);
  if (second == no_index) return of_first;
  Vector3 of_second = triangle_normal(mesh, second);
  const Vector3 start = mesh.position(edges.start[e]), along = along_edge(mesh, edges, e);
  // Both faces look to one side of the surface where their insides, seen along the edge, lie on different
  // sides of it: otherwise one of them is wound the other way.
  const auto side = [&](std::uint32_t t, Vector3 normal) {
    return dot(cross(along, mesh.centroid(t) - start), normal) > 0;
  };
  if (side(first, of_first) == side(second, of_second)) of_second = -1 * of_second;
  const Vector3 sum = of_first + of_second;
  constexpr double folded = 1e-6;  // the faces lie on each other
  return norm(sum) > folded ? unit_vector(sum) : of_first;
}

void add_sharp_samples(const PreparedMesh& mesh, const SharpEdges& edges, const SharpParameters& parameters,
                       OrderKind order, double jitter, RandomKey key, const CancelToken& cancel, Row& row) {
  const std::uint32_t count = parameters.samples;
  Samples& samples = row.samples;
  for (auto* const values : {&samples.sharp_points, &samples.sharp_normals, &samples.sharp_tangents})
    values->resize(3 * std::size_t{count});
  samples.sharp_edge.resize(count);
  row.report.sharp_edges = 0;
  row.report.sharp_length = edges.length() * mesh.unit;
  if (!(row.report.sharp_length > 0)) {
    row.report.sharp_length = 0;
    return fill_without_edges(mesh, parameters, samples);
  }
  row.report.sharp_edges = static_cast<std::uint32_t>(edges.count());
  const RandomKey own = sharp_key(key);
  std::vector<double> points(3 * std::size_t{count});
  std::uint32_t at_corners = 0;
  if (parameters.corners) {
    const std::vector<EdgeEnd> corners = sharp_corners(mesh, edges, parameters.angle);
    at_corners = static_cast<std::uint32_t>(std::min<std::size_t>(count, corners.size()));
    EdgePoints at;
    for (std::size_t i = 0; i < at_corners; ++i) {
      const EdgeEnd& corner = corners[corners.size() * i / at_corners];
      const Vector3 point = mesh.position((corner.is_start ? edges.start : edges.end)[corner.edge]);
      at.point.insert(at.point.end(), {point.x, point.y, point.z});
      at.edge.push_back(corner.edge);
    }
    set_rows(mesh, edges, at, ranks_in_order(at_corners, order, own), 0, points, samples);
    cancel.check();
  }
  const std::uint32_t others = count - at_corners;
  const EdgePoints at =
      points_on_edges(mesh, edges, sample_sequence(SequenceKind::shifted, others, jitter, own));
  cancel.check();
  set_rows(mesh, edges, at, ranks_in_order(others, order, own), at_corners, points, samples);
  const ItemReport& report = row.report;
  samples.sharp_points =
      stored_points(points, mesh, {{report.loc[0], report.loc[1], report.loc[2]}, report.scale});
}

}  // namespace meander
