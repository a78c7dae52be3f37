#include "kernels/describe/describe_samples.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "kernels/core/setting.h"
#include "kernels/describe/geodesic_histogram.h"
#include "kernels/describe/heat_geodesics.h"
#include "kernels/describe/outward_normals.h"
#include "kernels/describe/shape_functions.h"
#include "kernels/solve/sparse_cholesky.h"

namespace meander {

namespace {

std::vector<float> to_float(const std::vector<double>& shares) { return {shares.begin(), shares.end()}; }

std::vector<float> shape_function(const DescriptorInput& input, ShapeFunction function) {
  ShapeFunctionParameters histogram;
  histogram.bins = input.parameters.bins;
  histogram.tuples = input.parameters.tuples;
  return to_float(
      shape_function_histogram(input.samples.points, function, input.key, histogram, input.cancel).shares);
}

}  // namespace

std::string take_descriptors(std::string_view text, std::vector<Descriptor>& descriptors) {
  descriptors.clear();
  if (text == "none") return "";
  std::string problems;
  for_each_word(text, [&](std::string_view name) {
    const auto at = std::find(descriptor_names.begin(), descriptor_names.end(), name);
    if (at == descriptor_names.end()) {
      const std::string near = nearest(name, descriptor_names);
      problems += (problems.empty() ? "" : "; ") + ("no descriptor `" + std::string(name)) + "` (" +
                  joined_texts(descriptor_names) + ")" +
                  (near.empty() ? "" : ", did you mean `" + near + "`?");
      return;
    }
    const auto descriptor = static_cast<Descriptor>(at - descriptor_names.begin());
    if (std::find(descriptors.begin(), descriptors.end(), descriptor) == descriptors.end())
      descriptors.push_back(descriptor);
  });
  return problems;
}

namespace descriptor_makers {

std::vector<std::vector<float>> d2(const DescriptorInput& input) {
  DistanceHistogramParameters histogram;
  histogram.bins = input.parameters.bins;
  histogram.scale = input.parameters.scale;
  return {to_float(distance_histogram(input.samples.points, histogram, input.cancel).shares)};
}

std::vector<std::vector<float>> a3(const DescriptorInput& input) {
  return {shape_function(input, ShapeFunction::angle)};
}

std::vector<std::vector<float>> d1(const DescriptorInput& input) {
  return {shape_function(input, ShapeFunction::centroid)};
}

std::vector<std::vector<float>> d3(const DescriptorInput& input) {
  return {shape_function(input, ShapeFunction::triangle)};
}

std::vector<std::vector<float>> d4(const DescriptorInput& input) {
  return {shape_function(input, ShapeFunction::tetrahedron)};
}

std::vector<std::vector<float>> geodesic(const DescriptorInput& input) {
  const DescribeParameters& parameters = input.parameters;
  PointsOnMeshArrays points;
  points.triangle = input.samples.triangle;
  points.barycentric.assign(input.samples.barycentric.begin(), input.samples.barycentric.end());
  GeodesicHistogramParameters histogram;
  histogram.bins = parameters.bins;
  histogram.sources = parameters.geodesic_sources;
  histogram.scale = parameters.scale;
  const std::size_t sources = histogram.sources == 0
                                  ? points.triangle.size()
                                  : std::min<std::size_t>(histogram.sources, points.triangle.size());
  const HeatGeodesics geodesics(input.mesh, {}, input.cancel, std::span(points.triangle).first(sources));
  const GeodesicHistogram made = geodesic_histogram(geodesics, points, histogram, input.cancel);
  return {made.share, {static_cast<float>(made.disconnected_share)}};
}

std::vector<std::vector<float>> basics(const DescriptorInput& input) {
  const PreparedMesh& mesh = input.mesh;
  const ShapeMoments moments = shape_moments(mesh.x, mesh.y, mesh.z, mesh.triangles);
  std::vector<float> values;
  for (const double value : shape_basics(moments))
    values.push_back(std::isfinite(value) ? static_cast<float>(value) : 0.0f);
  values[1] = std::abs(values[1]);
  values.push_back(moments.closed ? 1.0f : 0.0f);
  return {values};
}

std::vector<std::vector<float>> pairs(const DescriptorInput& input) {
  const OutwardNormals outward = outward_normals(input.mesh, input.samples.triangle);
  return {oriented_pair_histogram(input.samples.points, outward.normals, {}, input.cancel).roots,
          {static_cast<float>(outward.unoriented_share)}};
}

std::vector<std::vector<float>> pairs_unsigned(const DescriptorInput& input) {
  return {oriented_pair_histogram(input.samples.points, input.samples.normals,
                                  {.sense = NormalSense::either_side}, input.cancel)
              .roots};
}

std::vector<std::vector<float>> harmonics(const DescriptorInput& input) {
  return {shell_harmonics(input.samples.points, input.cancel)};
}

std::vector<std::vector<float>> views(const DescriptorInput& input) {
  return {depth_views(input.mesh, input.cancel)};
}

std::vector<std::vector<float>> shapedna(const DescriptorInput& input) {
  const Samples& samples = input.samples;
  return {shape_dna(input.mesh, {samples.triangle, samples.barycentric, samples.curve_rank}, input.cancel)};
}

}  // namespace descriptor_makers

namespace descriptor_bytes {

// Heat geodesics and their histogram.
double geodesic(const DescribeParameters& parameters, const ModelSizes& sizes) {
  constexpr double most_kept_distances = 1 << 25;
  constexpr double bytes_per_factor_entry = 12;  // double and index
  constexpr double bytes_per_triangle = 180;
  constexpr double bytes_per_component = 2048;  // small arrays
  const double sources = parameters.geodesic_sources == 0
                             ? sizes.samples
                             : std::min<double>(sizes.samples, parameters.geodesic_sources);
  // Two factors, three with a boundary.
  const double factors = 3 * most_factor_entries(sizes.unknowns()) * bytes_per_factor_entry +
                         sizes.triangles * bytes_per_triangle +
                         std::min(sizes.triangles, sources) * bytes_per_component;
  const auto vertices = static_cast<std::size_t>(sizes.unknowns());
  const double lanes =
      std::min({static_cast<double>(sizes.threads), static_cast<double>(geodesic_lanes(vertices)),
                std::ceil(sources / geodesic_batch)});
  return std::min(sources * sizes.samples, most_kept_distances) * sizeof(double) + factors +
         lanes * static_cast<double>(geodesic_batch_bytes(vertices));
}

// The surface while it is remeshed; of the remeshed one the factor and a basis of about a hundred vectors, of
// all components at most as many vertices as are allowed.
double shapedna(const DescribeParameters&, const ModelSizes& sizes) {
  constexpr double bytes_per_remeshed_triangle = 120, bytes_per_vertex = 360, basis_vectors = 110;
  constexpr double most_vertices = shape_dna_max_vertices, vertices_per_triangle = 3;  // of soups
  constexpr double bytes_per_factor_entry = 12;
  const double vertices =
      std::min(most_vertices, shape_dna_samples + vertices_per_triangle * sizes.triangles);
  return sizes.triangles * bytes_per_remeshed_triangle +
         vertices * (bytes_per_vertex + basis_vectors * sizeof(double)) +
         most_factor_entries(vertices) * bytes_per_factor_entry;
}

}  // namespace descriptor_bytes

namespace {

// How the corners of a sample match those of a triangle: two of them are exchanged where its winding has been
// turned.
enum class Corners : std::uint8_t { others, same, turned };
Corners corners_of(const PolygonMesh& file, const PreparedMesh& mesh, std::uint32_t triangle,
                   const Samples& samples, std::size_t sample) {
  const std::uint32_t* const wanted = samples.corners.data() + 3 * sample;
  const auto corner = [&](std::size_t k) {
    return file.corners[mesh.corner_slot[3 * std::size_t{triangle} + k]];
  };
  if (corner(0) != wanted[0]) return Corners::others;
  if (corner(1) == wanted[1] && corner(2) == wanted[2]) return Corners::same;
  return corner(1) == wanted[2] && corner(2) == wanted[1] ? Corners::turned : Corners::others;
}

// The corners that corners_of compares, in either winding.
using CornerKey = std::array<std::uint32_t, 3>;
CornerKey key_of(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  return {a, std::min(b, c), std::max(b, c)};
}
CornerKey key_of(const PolygonMesh& file, const PreparedMesh& mesh, std::uint32_t triangle) {
  const auto corner = [&](std::size_t k) {
    return file.corners[mesh.corner_slot[3 * std::size_t{triangle} + k]];
  };
  return key_of(corner(0), corner(1), corner(2));
}

constexpr std::size_t many_triangles = 16;  // polygons of more triangles are sorted and searched

}  // namespace

std::vector<std::uint32_t> sample_triangles(const PolygonMesh& file, const PreparedMesh& mesh,
                                            const Samples& samples, const CancelToken& cancel) {
  std::vector<std::uint32_t> begin(file.polygon_count() + 1, 0), triangles(mesh.triangle_count());
  for (const std::uint32_t polygon : mesh.polygon) ++begin[polygon + 1];
  for (std::size_t p = 0; p + 1 < begin.size(); ++p) begin[p + 1] += begin[p];
  std::vector<std::uint32_t> at(begin.begin(), begin.end() - 1);
  for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) triangles[at[mesh.polygon[t]]++] = t;
  std::vector<std::uint32_t> sorted = triangles;
  for (std::size_t p = 0; p + 1 < begin.size(); ++p)
    if (begin[p + 1] - begin[p] > many_triangles)
      std::sort(sorted.begin() + begin[p], sorted.begin() + begin[p + 1],
                [&](std::uint32_t a, std::uint32_t b) {
                  return std::pair(key_of(file, mesh, a), a) < std::pair(key_of(file, mesh, b), b);
                });
  std::vector<std::uint32_t> result(samples.count());
  for (std::size_t i = 0; i < result.size(); ++i) {
    if (i % 4096 == 0) cancel.check();
    const std::uint32_t polygon = samples.face[i];
    if (polygon + std::size_t{1} >= begin.size() || begin[polygon] == begin[polygon + 1])
      throw std::invalid_argument("a sample on polygon " + std::to_string(polygon) +
                                  ", which the mesh does not have");
    result[i] = triangles[begin[polygon]];
    if (begin[polygon + 1] - begin[polygon] > many_triangles) {
      const auto last = sorted.begin() + begin[polygon + 1];
      const std::uint32_t* const wanted = samples.corners.data() + 3 * i;
      const auto behind = std::upper_bound(
          sorted.begin() + begin[polygon], last, key_of(wanted[0], wanted[1], wanted[2]),
          [&](const CornerKey& key, std::uint32_t triangle) { return key < key_of(file, mesh, triangle); });
      if (behind != sorted.begin() + begin[polygon] &&
          corners_of(file, mesh, *(behind - 1), samples, i) != Corners::others)
        result[i] = *(behind - 1);
      continue;
    }
    for (std::uint32_t k = begin[polygon]; k < begin[polygon + 1]; ++k)
      if (corners_of(file, mesh, triangles[k], samples, i) != Corners::others) result[i] = triangles[k];
  }
  return result;
}

void locate_on_mesh(const PolygonMesh& file, const PreparedMesh& mesh, Samples& samples,
                    const CancelToken& cancel) {
  samples.triangle = sample_triangles(file, mesh, samples, cancel);
  for (std::size_t i = 0; i < samples.triangle.size(); ++i) {
    if (corners_of(file, mesh, samples.triangle[i], samples, i) != Corners::turned) continue;
    std::swap(samples.corners[3 * i + 1], samples.corners[3 * i + 2]);
    std::swap(samples.barycentric[2 * i], samples.barycentric[2 * i + 1]);
  }
}

std::vector<DescriptorRow> describe_samples(const PreparedMesh& mesh, const Samples& samples, RandomKey key,
                                            const DescribeParameters& parameters, const CancelToken& cancel) {
  const DescriptorInput input{mesh, samples, key, parameters, cancel};
  std::vector<DescriptorRow> rows;
  for (const Descriptor descriptor : parameters.descriptors) {
    cancel.check();
    const DescriptorGroup& group = group_of(descriptor);
    std::vector<std::vector<float>> values = group.make(input);
    if (values.size() != 1 + group.companions.size())
      throw std::logic_error("the maker of " + std::string(group.name) + " made another number of rows");
    for (std::size_t i = 0; i < values.size(); ++i)
      rows.push_back({std::string(i == 0 ? group.name : group.companions[i - 1].name), std::move(values[i])});
  }
  return rows;
}

}  // namespace meander
