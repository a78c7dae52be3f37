#include "kernels/density/mesh_variables.h"

#include <algorithm>
#include <string>

#include "kernels/core/status.h"
#include "kernels/core/vector3.h"

namespace meander {

namespace {

double between(const std::array<double, 3>& corner, const std::array<double, 2>& weight) {
  return (1 - weight[0] - weight[1]) * corner[0] + weight[0] * corner[1] + weight[1] * corner[2];
}

double axis_of(const Vector3& v, std::size_t axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

}  // namespace

bool uses_curvature(const Expression& formula) { return formula.uses("mean") || formula.uses("gaussian"); }
bool uses_coordinates(const Expression& formula) { return formula.uses("u") || formula.uses("v"); }

MeshVariables::MeshVariables(const PolygonMesh& file, const PreparedMesh& mesh,
                             std::span<const Expression> formulas, bool unit_box, const CancelToken& cancel)
    : file_(file), mesh_(mesh) {
  if (unit_box) {
    const std::array<double, 6>& box = mesh.bbox;
    length_ = std::max({box[3] - box[0], box[4] - box[1], box[5] - box[2]});
    origin_ = {box[0], box[1], box[2]};
  }
  for (const Expression& formula : formulas) {
    if (uses_curvature(formula) && curvature_.mean.empty()) curvature_ = vertex_curvature(mesh, cancel);
    if (uses_coordinates(formula) && file.coordinates.corner.empty())
      throw ItemError(
          Status::missing_attribute,
          "the formula `" + formula.text() + "` uses texture coordinates, u or v, but the file has none");
  }
}

void MeshVariables::evaluate(const Expression& formula, std::size_t triangle,
                             std::span<const std::array<double, 2>> weight, std::span<double> value) const {
  std::array<std::vector<double>, mesh_variables.size()> held;
  std::array<std::span<const double>, mesh_variables.size()> inputs;
  for (std::size_t k = 0; k < held.size(); ++k) {
    if (!formula.uses(k)) continue;
    const std::array<double, 3> corner = at_corners(k, triangle);
    held[k].resize(weight.size());
    for (std::size_t i = 0; i < weight.size(); ++i) held[k][i] = between(corner, weight[i]);
    inputs[k] = held[k];
  }
  formula.evaluate(ExpressionInputs<double>(inputs), value);
}

void MeshVariables::evaluate_corners(const Expression& formula, std::size_t begin, std::size_t end,
                                     std::span<double> value) const {
  std::array<std::vector<double>, mesh_variables.size()> held;
  std::array<std::span<const double>, mesh_variables.size()> inputs;
  for (std::size_t k = 0; k < held.size(); ++k) {
    if (!formula.uses(k)) continue;
    held[k].resize(3 * (end - begin));
    for (std::size_t t = begin; t < end; ++t)
      if (mesh_.area[t] > 0) std::ranges::copy(at_corners(k, t), held[k].data() + 3 * (t - begin));
    inputs[k] = held[k];
  }
  formula.evaluate(ExpressionInputs<double>(inputs), value);
  for (std::size_t t = begin; t < end; ++t)
    if (!(mesh_.area[t] > 0)) std::fill_n(value.data() + 3 * (t - begin), 3, 0.0);
}

std::array<double, 3> MeshVariables::place(std::size_t triangle, const std::array<double, 2>& weight) const {
  return {between(at_corners(0, triangle), weight), between(at_corners(1, triangle), weight),
          between(at_corners(2, triangle), weight)};
}

std::array<double, 3> MeshVariables::at_corners(std::size_t variable, std::size_t triangle) const {
  const std::uint32_t* v = mesh_.triangles.data() + 3 * triangle;
  if (variable >= 3 && variable < 6) {
    const Vector3 p = mesh_.position(v[0]), n = cross(mesh_.position(v[1]) - p, mesh_.position(v[2]) - p);
    const double size = norm(n), value = size > 0 ? axis_of(n, variable - 3) / size : 0;
    return {value, value, value};
  }
  std::array<double, 3> corner;
  for (std::size_t c = 0; c < 3; ++c) {
    if (variable < 3)
      corner[c] =
          (axis_of(mesh_.center + mesh_.unit * mesh_.position(v[c]), variable) - origin_[variable]) / length_;
    else if (variable < 8)
      corner[c] = curvature(variable == 7, v[c]);
    else
      corner[c] = coordinate(variable - 8, 3 * triangle + c);
  }
  return corner;
}

double MeshVariables::curvature(bool gaussian, std::uint32_t vertex) const {
  const double scale = length_ / mesh_.unit;  // from 1 / (working length)
  return gaussian ? curvature_.gaussian[vertex] * scale * scale : curvature_.mean[vertex] * scale;
}

double MeshVariables::coordinate(std::size_t axis, std::size_t half_edge) const {
  const CornerCoordinates& coordinates = file_.coordinates;
  const std::size_t slot = mesh_.corner_slot[half_edge];
  const std::uint32_t number = slot < coordinates.corner.size() ? coordinates.corner[slot] : no_index;
  if (number == no_index || 2 * std::size_t{number} + 2 > coordinates.values.size())
    throw ItemError(Status::missing_attribute, "the formula uses texture coordinates, u or v, but face " +
                                                   std::to_string(mesh_.polygon[half_edge / 3]) +
                                                   " has none: leave them out, or give all faces some");
  return coordinates.values[2 * std::size_t{number} + axis];
}

}  // namespace meander
