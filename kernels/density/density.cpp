#include "kernels/density/density.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <span>
#include <utility>

#include "kernels/core/parallel.h"
#include "kernels/core/portable_functions.h"
#include "kernels/core/weighted_quantile.h"
#include "kernels/density/curvature.h"
#include "kernels/density/density_pieces.h"
#include "kernels/density/formula_density.h"
#include "kernels/density/texture_density.h"

namespace meander {

namespace {

constexpr std::size_t triangle_block = 4096;

// The curvature that gets density 1: the quantile over the surface, or over its curved part where that is
// less than 1 - share of the area. 0 when the surface is flat.
double reference_curvature(std::span<const double> curvature, std::span<const double> area, double share) {
  const double reference = weighted_quantile(curvature, area, share);
  if (reference > 0) return reference;
  std::vector<double> bent(area.begin(), area.end());
  for (std::size_t v = 0; v < bent.size(); ++v)
    if (!(curvature[v] > 0)) bent[v] = 0;
  if (std::none_of(bent.begin(), bent.end(), [](double a) { return a > 0; })) return 0;
  return weighted_quantile(curvature, bent, share);
}

std::vector<double> chosen_curvature(const VertexCurvature& of, DensityKind kind, double diagonal) {
  std::vector<double> result(of.mean.size());
  for (std::size_t v = 0; v < result.size(); ++v) {
    const double mean = of.mean[v] * diagonal, gaussian = of.gaussian[v] * diagonal * diagonal;
    if (kind == DensityKind::mean)
      result[v] = mean;
    else if (kind == DensityKind::gaussian)
      result[v] = std::abs(gaussian);
    else
      result[v] = mean + std::sqrt(std::max(0.0, mean * mean - gaussian));
  }
  return result;
}

Density curvature_density(const PolygonMesh&, const PreparedMesh& mesh, const DensityParameters& parameters,
                          const CancelToken& cancel) {
  const VertexCurvature all = vertex_curvature(mesh, cancel);
  std::vector<double> value = chosen_curvature(all, parameters.kind, mesh.diagonal / mesh.unit);
  const double reference = reference_curvature(value, all.mixed_area, parameters.quantile);
  cancel.check();
  Density density;
  if (!(reference > 0)) return density;
  for (double& c : value)
    c = parameters.floor +
        (1 - parameters.floor) * portable::pow(std::min(1.0, c / reference), parameters.exponent);
  density.corner.resize(mesh.triangles.size());
  for (std::size_t h = 0; h < mesh.triangles.size(); ++h) density.corner[h] = value[mesh.triangles[h]];
  return density;
}

const ScalarAttribute& find_attribute(std::span<const ScalarAttribute> attributes, const std::string& name,
                                      const std::string& kind) {
  for (const ScalarAttribute& attribute : attributes)
    if (attribute.name == name) return attribute;
  std::string names;
  for (const ScalarAttribute& attribute : attributes) names += (names.empty() ? "" : ", ") + attribute.name;
  throw ItemError(Status::missing_attribute,
                  "the density names the " + kind + " attribute \"" + name + "\" but the file " +
                      (names.empty() ? "has no " + kind + " attributes"
                                     : "has only the " + kind + " attributes " + names));
}

[[noreturn]] void fail_at(const ScalarAttribute& attribute, const std::string& kind, std::size_t i) {
  char value[32];
  std::snprintf(value, sizeof value, "%.6g", attribute.values[i]);
  const bool large = std::isfinite(attribute.values[i]) && attribute.values[i] > 0;
  throw ItemError(Status::unreadable,
                  "the " + kind + " attribute \"" + attribute.name + "\" is " + value + " at " + kind + " " +
                      std::to_string(i) +
                      (large ? ", which is too large: densities are stored in float32, up to 3.4e38"
                             : "; a density must be finite and not negative"));
}

// element(h): number of the file's element behind corner h.
template <class Element>
Density attribute_density(const PreparedMesh& mesh, const ScalarAttribute& attribute, const std::string& kind,
                          const Element& element) {
  Density density;
  density.corner.resize(mesh.triangles.size());
  std::size_t bad = attribute.values.size();
  for (std::size_t h = 0; h < density.corner.size(); ++h) {
    const std::size_t i = element(h);
    if (i >= attribute.values.size())
      throw ItemError(Status::internal, "the " + kind + " attribute \"" + attribute.name + "\" has " +
                                            std::to_string(attribute.values.size()) + " values but " + kind +
                                            " " + std::to_string(i) + " is used");
    const double value = attribute.values[i];
    if (!(value >= 0) || !(value <= largest_density)) bad = std::min(bad, i);
    density.corner[h] = value == 0 ? 0.0 : value;  // -0 becomes 0
  }
  if (bad < attribute.values.size()) fail_at(attribute, kind, bad);
  bool positive = false;
  for (std::size_t h = 0; h < density.corner.size() && !positive; ++h)
    positive = mesh.area[h / 3] * (density.corner[h] / 3) > 0;
  if (!positive)
    throw ItemError(Status::zero_density,
                    "the " + kind + " attribute \"" + attribute.name + "\" is zero on the whole surface");
  return density;
}

Density uniform_density(const PolygonMesh&, const PreparedMesh&, const DensityParameters&,
                        const CancelToken&) {
  return {};
}

Density vertex_density(const PolygonMesh& file, const PreparedMesh& mesh, const DensityParameters& parameters,
                       const CancelToken&) {
  return attribute_density(mesh, find_attribute(file.vertex_attributes, parameters.attribute, "vertex"),
                           "vertex",
                           [&](std::size_t h) -> std::size_t { return file.corners[mesh.corner_slot[h]]; });
}

Density face_density(const PolygonMesh& file, const PreparedMesh& mesh, const DensityParameters& parameters,
                     const CancelToken&) {
  return attribute_density(mesh, find_attribute(file.face_attributes, parameters.attribute, "face"), "face",
                           [&](std::size_t h) -> std::size_t { return mesh.polygon[h / 3]; });
}

constexpr auto attribute_name = &DensityParameters::attribute;
constexpr auto formula_source = &DensityParameters::formula;
constexpr auto forms = std::to_array<DensityForm>(
    {{{"uniform", DensityKind::uniform}, "uniform", uniform_density},
     {{"mean", DensityKind::mean}, "mean", curvature_density, nullptr, true, true},
     {{"gaussian", DensityKind::gaussian}, "gaussian", curvature_density, nullptr, true, true},
     {{"max", DensityKind::max}, "max curvature", curvature_density, nullptr, true, true},
     {{"attribute:", DensityKind::vertex_attribute},
      "attribute:NAME of vertices",
      vertex_density,
      attribute_name},
     {{"face-attribute:", DensityKind::face_attribute}, "face-attribute:NAME", face_density, attribute_name},
     {{"texture", DensityKind::texture},
      "texture: the luminance of the model's textures, more samples where they are bright (with --colors)",
      make_texture_density,
      nullptr,
      true,
      false,
      true},
     {{"texture-inverse", DensityKind::texture_inverse},
      "texture-inverse: more where they are dark",
      make_texture_density,
      nullptr,
      true,
      false,
      true},
     {{"formula:", DensityKind::formula},
      "formula:TEXT in x, y, z, nx, ny, nz, mean, gaussian, u, v, as `formula:1 + z^2`",
      make_formula_density,
      formula_source},
     {{"unit-formula:", DensityKind::unit_formula},
      "unit-formula:TEXT with lengths of the unit box",
      make_formula_density,
      formula_source}});
static_assert(is_in_order(forms));

}  // namespace

std::span<const DensityForm> density_forms() { return forms; }

Density make_density(const PolygonMesh& file, const PreparedMesh& mesh, const DensityParameters& parameters,
                     const CancelToken& cancel) {
  return form_of(parameters).make(file, mesh, parameters, cancel);
}

double density_bytes(const DensityParameters& parameters, double triangles) {
  return is_in_pieces(parameters) ? piece_density_bytes(triangles) : 0;
}

double file_measure(const PreparedMesh& mesh, double total) {
  const double measure = file_area(mesh, total);
  if (!std::isfinite(measure))
    throw ItemError(Status::non_finite,
                    "too large: the integral of the density over the surface is more than double precision "
                    "holds; scale the file or its density down");
  return measure;
}

std::vector<double> triangle_masses(const PreparedMesh& mesh, const Density& density) {
  std::vector<double> mass(mesh.area);
  if (density.uniform()) return mass;
  parallel_blocks(mass.size(), triangle_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      if (density.in_pieces()) {
        mass[t] *= density.piece_mean[density.piece_begin[t] + 1];
        continue;
      }
      const double* corner = density.corner.data() + 3 * t;
      mass[t] *= (corner[0] + corner[1] + corner[2]) / 3;
    }
  });
  return mass;
}

double MeshMeasure::total() const { return masses.empty() ? mass_sum : blocked_sum(masses); }

MeshMeasure measure_of(const PreparedMesh& mesh, Density density, bool keep_masses) {
  MeshMeasure measure;
  if (keep_masses)
    measure.masses = triangle_masses(mesh, density);
  else if (density.uniform())
    measure.mass_sum = blocked_sum(mesh.area);
  else
    measure.mass_sum = blocked_sum(triangle_masses(mesh, density));
  measure.density = std::move(density);
  return measure;
}

}  // namespace meander
