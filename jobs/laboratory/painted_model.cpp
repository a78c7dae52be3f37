#include "jobs/laboratory/painted_model.h"

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "io/archive/model_bytes.h"
#include "kernels/mesh/prepare_mesh.h"
#include "kernels/model/model.h"
#include "kernels/sample/point_frames.h"

namespace meander {

namespace {

void keep_samples(PaintedModel& painted, const Samples& samples, std::size_t count) {
  if (samples.tensor_direction.size() != samples.points.size())
    throw std::invalid_argument("samples without directions have no strokes");
  const auto first = [&](const std::vector<float>& values, std::size_t each) {
    return std::vector<float>(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(each * count));
  };
  painted.normals = first(samples.normals, 3);
  painted.directions = first(samples.tensor_direction, 3);
  painted.spacings = first(samples.tensor_spacing, 2);
}

void keep_surface(PaintedModel& painted, const PreparedMesh& surface) {
  painted.positions.reserve(3 * surface.vertex_count());
  for (std::size_t v = 0; v < surface.vertex_count(); ++v)
    painted.positions.insert(painted.positions.end(), {surface.x[v], surface.y[v], surface.z[v]});
  painted.faces = surface.triangles;
}

// Hexagons in the tangent planes, large enough to leave no gaps between even samples.
void keep_discs(PaintedModel& painted, const Row& row) {
  const std::vector<float>&points = row.samples.points, &normals = row.samples.normals;
  const std::size_t count = row.samples.count();
  const double area = row.report.area / (row.report.scale * row.report.scale);
  const double radius = 1.7 * std::sqrt(area / (std::numbers::pi * static_cast<double>(count)));
  constexpr std::uint32_t corners = 6;
  for (std::size_t i = 0; i < count; ++i) {
    const Vector3 p{points[3 * i], points[3 * i + 1], points[3 * i + 2]},
        n{normals[3 * i], normals[3 * i + 1], normals[3 * i + 2]};
    const Vector3 other = std::abs(n.x) < 0.6 ? Vector3{1, 0, 0} : Vector3{0, 1, 0};
    const Vector3 sideways = cross(n, other);
    if (!(norm(sideways) > 0)) continue;
    const Vector3 u = (radius / norm(sideways)) * sideways, v = cross(n, u);
    const auto first = static_cast<std::uint32_t>(painted.positions.size() / 3);
    for (std::uint32_t k = 0; k < corners; ++k) {
      const double angle = 2 * std::numbers::pi * k / corners;
      const Vector3 corner = p + std::cos(angle) * u + std::sin(angle) * v;
      painted.positions.insert(painted.positions.end(), {corner.x, corner.y, corner.z});
      if (k >= 2) painted.faces.insert(painted.faces.end(), {first, first + k - 1, first + k});
    }
  }
}

// The mesh of a row, or the reason why there is none.
std::string read_mesh_of_row(const Row& row, const std::optional<PlanItem>& file, PolygonMesh& mesh) {
  if (!file) return "no mesh in the INPUT";
  try {
    const ModelBytes bytes(*file);
    if (bytes.content_sha256() != row.report.content_sha256) return "the mesh has changed";
    mesh = bytes.mesh();
  } catch (const ItemError& error) {
    return error.what();
  }
  return {};
}

}  // namespace

SampleParameters painted_samples(std::uint32_t count, std::uint64_t seed) {
  SampleParameters parameters = parameters_for("anisotropic");
  parameters.samples = count;
  // Directions vary less than those of the surface, so that neighboring strokes agree.
  parameters.tensor.smoothing = 16;
  parameters.seed = seed;
  return parameters;
}

PaintedModel painted_model(const PreparedMesh& surface, const Row& row) {
  PaintedModel painted;
  keep_samples(painted, row.samples, row.samples.count());
  keep_surface(painted, surface);
  painted.points = working_points(row.report, row.samples.points, surface);
  return painted;
}

PaintedModel sampled_file(const PlanItem& file, const SampleParameters& parameters,
                          const EmbreeDevice& device) {
  if (!file.known_format)
    throw ItemError(Status::unsupported_format, "the extension is not that of a known mesh format");
  Model model;
  {
    const ModelBytes bytes(file);
    model.key = make_random_key(parameters.seed, bytes.content_sha256());
    model.file = bytes.mesh();
  }
  run_stages(stages_of(parameters, &device), model);
  release_charts(model);
  return painted_model(model.surface, model.row);
}

PaintedModel stored_model(const Row& row, const std::optional<PlanItem>& file, std::uint32_t count,
                          std::string& lacking) {
  if (row.report.status != Status::ok) throw ItemError(row.report.status, row.report.reason);
  const std::size_t drawn =
      count == 0 ? row.samples.count() : std::min<std::size_t>(count, row.samples.count());
  PaintedModel painted;
  keep_samples(painted, row.samples, drawn);
  const std::span<const float> points = std::span(row.samples.points).first(3 * drawn);
  PolygonMesh mesh;
  lacking = read_mesh_of_row(row, file, mesh);
  if (lacking.empty()) {
    const PreparedMesh surface = prepare_mesh(mesh);
    keep_surface(painted, surface);
    painted.points = working_points(row.report, points, surface);
  } else {
    keep_discs(painted, row);
    painted.points.assign(points.begin(), points.end());
  }
  return painted;
}

}  // namespace meander
