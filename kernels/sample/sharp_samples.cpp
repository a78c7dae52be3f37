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

void append_vector(std::vector<float>& values, Vector3 v) {
  // Without negative zeros.
  for (const double x : {v.x, v.y, v.z}) values.push_back(static_cast<float>(x) + 0.0f);
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
      samples.sharp_points.push_back(samples.points[3 * i + k]);
      samples.sharp_normals.push_back(samples.normals[3 * i + k]);
    }
    const std::uint32_t* const corner = &mesh.triangles[3 * std::size_t{samples.triangle[i]}];
    append_vector(samples.sharp_tangents, unit_vector(mesh.position(corner[1]) - mesh.position(corner[0])));
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
  for (auto* const values : {&samples.sharp_points, &samples.sharp_normals, &samples.sharp_tangents}) {
    values->clear();
    values->reserve(3 * std::size_t{count});
  }
  samples.sharp_edge.clear();
  row.report.sharp_edges = 0;
  row.report.sharp_length = edges.length() * mesh.unit;
  if (!(row.report.sharp_length > 0)) {
    row.report.sharp_length = 0;
    return fill_without_edges(mesh, parameters, samples);
  }
  row.report.sharp_edges = static_cast<std::uint32_t>(edges.count());
  const RandomKey own = sharp_key(key);
  std::vector<double> points;
  points.reserve(3 * std::size_t{count});
  samples.sharp_edge.reserve(count);
  const auto append = [&](Vector3 point, std::uint32_t e) {
    points.insert(points.end(), {point.x, point.y, point.z});
    append_vector(samples.sharp_normals, edge_normal(mesh, edges, e));
    append_vector(samples.sharp_tangents, along_edge(mesh, edges, e));
    samples.sharp_edge.push_back(e);
  };
  std::uint32_t at_corners = 0;
  if (parameters.corners) {
    const std::vector<EdgeEnd> corners = sharp_corners(mesh, edges, parameters.angle);
    at_corners = static_cast<std::uint32_t>(std::min<std::size_t>(count, corners.size()));
    for (const std::uint32_t rank : ranks_in_order(at_corners, order, own)) {
      const EdgeEnd& corner = corners[corners.size() * rank / at_corners];
      append(mesh.position((corner.is_start ? edges.start : edges.end)[corner.edge]), corner.edge);
    }
    cancel.check();
  }
  const std::uint32_t others = count - at_corners;
  const std::vector<double> shares = sample_sequence(SequenceKind::shifted, others, jitter, own);
  const EdgePoints at = points_on_edges(mesh, edges, shares);
  cancel.check();
  for (const std::uint32_t rank : ranks_in_order(others, order, own)) {
    const double* const point = &at.point[3 * std::size_t{rank}];
    append({point[0], point[1], point[2]}, at.edge[rank]);
  }
  const ItemReport& report = row.report;
  samples.sharp_points =
      stored_points(points, mesh, {{report.loc[0], report.loc[1], report.loc[2]}, report.scale});
}

}  // namespace meander
