#include "kernels/describe/describe_samples.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "kernels/describe/geodesic_histogram.h"
#include "kernels/describe/heat_geodesics.h"
#include "kernels/describe/shape_functions.h"

namespace meander {

namespace {

std::vector<float> to_float(const std::vector<double>& shares) { return {shares.begin(), shares.end()}; }

ShapeFunction function_of(Descriptor descriptor) {
  switch (descriptor) {
    case Descriptor::a3:
      return ShapeFunction::angle;
    case Descriptor::d1:
      return ShapeFunction::centroid;
    case Descriptor::d3:
      return ShapeFunction::triangle;
    default:
      return ShapeFunction::tetrahedron;
  }
}

GeodesicHistogram geodesics_of(const PreparedMesh& mesh, const Samples& samples,
                               const DescribeParameters& parameters, const CancelToken& cancel) {
  PointsOnMeshArrays points;
  points.triangle = samples.triangle;
  points.barycentric.assign(samples.barycentric.begin(), samples.barycentric.end());
  GeodesicHistogramParameters histogram;
  histogram.bins = parameters.bins;
  histogram.sources = parameters.geodesic_sources;
  histogram.scale = parameters.scale == HistogramScale::mean ? GeodesicScale::mean : GeodesicScale::largest;
  const std::size_t sources = histogram.sources == 0
                                  ? points.triangle.size()
                                  : std::min<std::size_t>(histogram.sources, points.triangle.size());
  const HeatGeodesics geodesics(mesh, {}, cancel, std::span(points.triangle).first(sources));
  return geodesic_histogram(geodesics, points, histogram, cancel);
}

std::vector<float> basics_of(const PreparedMesh& mesh) {
  const ShapeMoments moments = shape_moments(mesh.x, mesh.y, mesh.z, mesh.triangles);
  std::vector<float> values;
  for (const double value : shape_basics(moments))
    values.push_back(std::isfinite(value) ? static_cast<float>(value) : 0.0f);
  values[1] = std::abs(values[1]);
  values.push_back(moments.closed ? 1.0f : 0.0f);
  return values;
}

}  // namespace

std::vector<std::uint32_t> sample_triangles(const PolygonMesh& file, const PreparedMesh& mesh,
                                            const Samples& samples) {
  std::vector<std::uint32_t> begin(file.polygon_count() + 1, 0), triangles(mesh.triangle_count());
  for (const std::uint32_t polygon : mesh.polygon) ++begin[polygon + 1];
  for (std::size_t p = 0; p + 1 < begin.size(); ++p) begin[p + 1] += begin[p];
  std::vector<std::uint32_t> at(begin.begin(), begin.end() - 1);
  for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) triangles[at[mesh.polygon[t]]++] = t;
  std::vector<std::uint32_t> result(samples.count());
  for (std::size_t i = 0; i < result.size(); ++i) {
    const std::uint32_t polygon = samples.face[i];
    if (polygon + std::size_t{1} >= begin.size() || begin[polygon] == begin[polygon + 1])
      throw std::invalid_argument("a sample on polygon " + std::to_string(polygon) +
                                  ", which the mesh does not have");
    result[i] = triangles[begin[polygon]];
    for (std::uint32_t k = begin[polygon]; k < begin[polygon + 1]; ++k) {
      const std::uint32_t* const slots = mesh.corner_slot.data() + 3 * std::size_t{triangles[k]};
      const std::uint32_t* const corners = samples.corners.data() + 3 * i;
      if (file.corners[slots[0]] == corners[0] && file.corners[slots[1]] == corners[1] &&
          file.corners[slots[2]] == corners[2])
        result[i] = triangles[k];
    }
  }
  return result;
}

std::vector<DescriptorRow> describe_samples(const PreparedMesh& mesh, const Samples& samples, RandomKey key,
                                            const DescribeParameters& parameters, const CancelToken& cancel) {
  std::vector<DescriptorRow> rows;
  for (const Descriptor descriptor : parameters.descriptors) {
    cancel.check();
    DescriptorRow row{std::string(name_of(descriptor)), {}};
    if (descriptor == Descriptor::d2) {
      DistanceHistogramParameters histogram;
      histogram.bins = parameters.bins;
      histogram.scale = parameters.scale;
      row.values = to_float(distance_histogram(samples.points, histogram).shares);
    } else if (descriptor == Descriptor::geodesic) {
      const GeodesicHistogram geodesics = geodesics_of(mesh, samples, parameters, cancel);
      row.values = geodesics.share;
      rows.push_back(std::move(row));
      row = {std::string(geodesic_disconnected_name), {static_cast<float>(geodesics.disconnected_share)}};
    } else if (descriptor == Descriptor::basics) {
      row.values = basics_of(mesh);
    } else {
      ShapeFunctionParameters histogram;
      histogram.bins = parameters.bins;
      histogram.tuples = parameters.tuples;
      row.values =
          to_float(shape_function_histogram(samples.points, function_of(descriptor), key, histogram).shares);
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace meander
