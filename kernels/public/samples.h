// <meander/samples.h>: what sampling a model gives: arrays of samples, descriptors and a report.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "status.h"

namespace meander {

inline constexpr std::int32_t no_sample_class = -1;
inline constexpr std::uint32_t no_sharp_edge = 0xFFFFFFFFu;

// N samples, ordered so that every prefix covers the surface evenly or, where that was asked for, along the
// curve. Samples of a mesh are named by face, corners and barycentric weights, samples of a parametric
// surface by uv. Arrays that were not asked for, or that do not apply, are empty.
struct Samples {
  std::vector<float> points;              // N x 3; coordinates of the model = loc + scale * point
  std::vector<float> normals;             // N x 3 unit vectors
  std::vector<std::uint32_t> face;        // N numbers of polygons, as the model numbers them
  std::vector<std::uint32_t> corners;     // N x 3 numbers of vertices, as the model numbers them
  std::vector<std::uint32_t> triangle;    // N; of use to the library alone, and not stored
  std::vector<float> barycentric;         // N x 2 weights of corners 1 and 2; corner 0 has the rest
  std::vector<float> uv;                  // N x 2 parameters in [0, 1]
  std::vector<std::uint32_t> curve_rank;  // N positions along the curve, a permutation of 0 .. N - 1
  std::vector<float> density;             // N values of the density; empty when it is uniform
  std::vector<float> tensor_direction;  // N x 3 unit vectors along the long spacing; anisotropic samples only
  std::vector<float> tensor_spacing;    // N x 2 wanted spacings along and across it, in units of the points
  std::vector<std::uint8_t> rgb;        // N x 3 red, green, blue as displayed (sRGB)
  std::vector<float> texcoord;          // N x 2 texture coordinates, NaN where there are none
  std::vector<float> sharp_points;      // S x 3 points on sharp edges, as `points`
  std::vector<float> sharp_normals;     // S x 3 unit vectors: the mean of the two faces at the edge
  std::vector<float> sharp_tangents;    // S x 3 unit vectors along the edge
  std::vector<std::uint32_t> sharp_edge;     // S numbers of edges, no_sharp_edge where the model has none
  std::vector<float> query_points;           // Q x 3 points in space, as `points`
  std::vector<std::uint8_t> query_kind;      // Q numbers of kinds and sizes, in the order they were asked for
  std::vector<float> query_distance;         // Q distances from the surface, negative inside
  std::vector<std::uint8_t> query_inside;    // Q: 0 or 1
  std::vector<float> query_winding;          // Q winding numbers, NaN where sides are decided without
  std::vector<std::uint8_t> query_certain;   // Q: 1 where the side is certain
  std::vector<std::uint32_t> query_face;     // Q, of the nearest point: as `face`,
  std::vector<std::uint32_t> query_corners;  // Q x 3 as `corners`
  std::vector<float> query_barycentric;      // and Q x 2 as `barycentric`
  std::vector<std::vector<float>> attributes;  // those asked for, in their order: N x width, NaN as above
  // The same of columns of classes, whose place in `attributes` stays empty; no_sample_class where there is
  // none. Each list ends with its last column.
  std::vector<std::vector<std::int32_t>> classes;

  std::size_t count() const { return points.size() / 3; }
};

// What was found out about a model, whatever its status. Lengths and areas are in units of the model, areas 0
// when unknown.
struct SampleReport {
  Status status = Status::internal;
  std::string reason;            // one sentence; empty when ok
  Method method = Method::none;  // the weakest method that any component of positive area needed,
  OrderReason order_reason = OrderReason::as_asked;         // and why
  std::uint64_t vertices = 0, faces = 0;                    // as given
  std::uint32_t components = 0, genus = 0, boundaries = 0;  // after repairs
  double area = 0, measure = 0;                             // area; integral of the density over it
  std::array<double, 6> bbox{};                             // min x, y, z, max x, y, z
  std::array<double, 3> loc{};                              // coordinates of the model = loc + scale * point
  double scale = 1;
  std::uint32_t flips = 0;                   // triangles that charts turn over
  double overlap = 0, area_scale_range = 1;  // of charts: share of the area; largest over smallest scale
  double distortion = 1;                     // mean of sigma1/sigma2 over charts, weighted by area
  RepairCounts repairs;
};

// One descriptor of a model: a histogram, moments or a spectrum. Its name is the word of the setting
// `describe`; some are followed by a companion of another name (docs/STORE.md has their values).
struct DescriptorRow {
  std::string name;
  std::vector<float> values;
};

struct SampledModel {
  SampleReport report;
  Samples samples;  // empty arrays unless the status is ok
  std::vector<DescriptorRow> descriptors;
};

}  // namespace meander
