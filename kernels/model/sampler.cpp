#include "kernels/public/sampler.h"

#include <algorithm>
#include <numeric>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "kernels/data/row_or_failure.h"
#include "kernels/mesh/count_limit.h"
#include "kernels/model/model_sampler.h"
#include "kernels/model/setting_texts.h"

namespace meander {

namespace {

void require(bool holds, const std::string& problem) {
  if (!holds) throw std::invalid_argument(problem);
}

void require_count(std::size_t numbers, std::size_t wanted, const std::string& name, const char* of_what) {
  require(numbers == wanted, name + " has " + std::to_string(numbers) + " numbers where " + of_what +
                                 " have " + std::to_string(wanted));
}

// The number of faces. Throws where the faces are not those of the corners.
std::size_t face_count(const Mesh& mesh) {
  const std::span<const std::uint32_t> begin = mesh.face_begin;
  const std::size_t corners = mesh.corners.size();
  if (!begin.empty()) {
    require(begin.front() == 0 && begin.back() == corners && std::is_sorted(begin.begin(), begin.end()),
            "face_begin must ascend from 0 to the number of corners, " + std::to_string(corners));
    return begin.size() - 1;
  }
  const std::uint32_t width = mesh.corners_per_face;
  require(width >= 3 && corners % width == 0,
          std::to_string(corners) + " corners are no faces of " + std::to_string(width) + " corners each");
  return corners / width;
}

std::vector<std::uint32_t> face_offsets(const Mesh& mesh, std::size_t faces) {
  if (faces == 0) return {};
  if (!mesh.face_begin.empty()) return {mesh.face_begin.begin(), mesh.face_begin.end()};
  std::vector<std::uint32_t> begin(faces + 1);
  for (std::size_t f = 0; f <= faces; ++f) begin[f] = static_cast<std::uint32_t>(f * mesh.corners_per_face);
  return begin;
}

// Numbers of the elements of a mesh, or none.
std::vector<float> numbers_of(std::span<const float> numbers, std::size_t wanted, const char* name,
                              const char* of_what) {
  if (!numbers.empty()) require_count(numbers.size(), wanted, name, of_what);
  return {numbers.begin(), numbers.end()};
}

std::vector<ScalarAttribute> attributes_of(const std::vector<MeshAttribute>& given, std::size_t count,
                                           const char* of_what) {
  std::vector<ScalarAttribute> attributes;
  for (const MeshAttribute& attribute : given) {
    require_count(attribute.values.size(), count, "the attribute `" + attribute.name + "`", of_what);
    attributes.push_back(
        {attribute.name, {attribute.values.begin(), attribute.values.end()}, attribute.classes});
  }
  return attributes;
}

}  // namespace

PolygonMesh polygon_mesh_of(const Mesh& given) {
  require(given.positions.size() % 3 == 0, "positions must hold three numbers for every vertex");
  const std::size_t vertices = given.positions.size() / 3, faces = face_count(given);
  const std::size_t corners = given.corners.size();
  check_count(vertices, "vertices");
  check_count(corners, "corners");
  PolygonMesh mesh;
  mesh.normals = numbers_of(given.normals, 3 * vertices, "normals", "the vertices");
  mesh.colors.vertex = numbers_of(given.vertex_colors, 3 * vertices, "vertex_colors", "the vertices");
  mesh.colors.face = numbers_of(given.face_colors, 3 * faces, "face_colors", "the faces");
  mesh.coordinates.values = numbers_of(given.texcoords, 2 * corners, "texcoords", "the corners");
  mesh.vertex_attributes = attributes_of(given.vertex_attributes, vertices, "the vertices");
  mesh.face_attributes = attributes_of(given.face_attributes, faces, "the faces");
  mesh.coordinates.corner.resize(mesh.coordinates.values.size() / 2);
  std::iota(mesh.coordinates.corner.begin(), mesh.coordinates.corner.end(), 0u);
  for (std::vector<double>* const axis : {&mesh.x, &mesh.y, &mesh.z}) axis->resize(vertices);
  for (std::size_t v = 0; v < vertices; ++v) {
    mesh.x[v] = given.positions[3 * v];
    mesh.y[v] = given.positions[3 * v + 1];
    mesh.z[v] = given.positions[3 * v + 2];
  }
  mesh.polygon_begin = face_offsets(given, faces);
  mesh.corners.assign(given.corners.begin(), given.corners.end());
  return mesh;
}

struct Sampler::State {
  explicit State(const SampleParameters& parameters) : sampler(parameters) {}
  ModelSampler sampler;
};

Sampler::Sampler(const Settings& settings) : state_(std::make_unique<State>(parameters_of(settings))) {}

Sampler::~Sampler() = default;
Sampler::Sampler(Sampler&&) noexcept = default;
Sampler& Sampler::operator=(Sampler&&) noexcept = default;

SampledModel Sampler::sample(const Mesh& mesh, std::span<const std::uint8_t> content,
                             const CancelToken& cancel) const {
  Row row = row_or_failure("read_mesh",
                           [&] { return state_->sampler.sample(polygon_mesh_of(mesh), content, cancel); });
  return {std::move(static_cast<SampleReport&>(row.report)), std::move(row.samples),
          std::move(row.descriptors)};
}

}  // namespace meander
