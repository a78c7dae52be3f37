#include "kernels/describe/shape_dna.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "kernels/core/vector3.h"
#include "kernels/describe/laplacian_spectrum.h"
#include "kernels/mesh/components.h"
#include "kernels/mesh/half_edges.h"
#include "kernels/remesh/remesh_surface.h"
#include "kernels/solve/intrinsic_delaunay.h"

namespace meander {

namespace {

// Storage for RemeshSamples.
struct ChosenSamples {
  std::vector<std::uint32_t> triangle, rank;
  std::vector<float> weights;
  std::vector<double> position;
};

ChosenSamples choose(const PreparedMesh& mesh, const SurfaceSamplePlaces& samples) {
  const std::size_t given = samples.triangle.size();
  std::vector<std::uint32_t> by_rank(given);
  for (std::size_t i = 0; i < given; ++i) by_rank[samples.rank[i]] = static_cast<std::uint32_t>(i);
  const std::size_t count = std::min<std::size_t>(given, shape_dna_samples);
  ChosenSamples chosen;
  for (std::size_t k = 0; k < count; ++k) {
    const std::uint32_t i = by_rank[k * given / count];
    const std::uint32_t triangle = samples.triangle[i];
    const float b = samples.weights[2 * std::size_t{i}], c = samples.weights[2 * std::size_t{i} + 1];
    const std::uint32_t* const corner = mesh.triangles.data() + 3 * std::size_t{triangle};
    const Vector3 at = (1.0 - b - c) * mesh.position(corner[0]) + double{b} * mesh.position(corner[1]) +
                       double{c} * mesh.position(corner[2]);
    chosen.triangle.push_back(triangle);
    chosen.rank.push_back(static_cast<std::uint32_t>(k));
    chosen.weights.insert(chosen.weights.end(), {b, c});
    chosen.position.insert(chosen.position.end(), {at.x, at.y, at.z});
  }
  return chosen;
}

// The components by their edge lengths.
std::vector<IntrinsicSurface> intrinsic_components(const RemeshedSurface& mesh) {
  std::vector<std::uint32_t> opposite, component;
  pair_half_edges(mesh.triangles, mesh.x.size(), opposite);
  std::vector<IntrinsicSurface> surfaces(find_components(opposite, component));
  std::vector<std::uint32_t> number(mesh.x.size(), no_index), place(component.size());
  const auto position = [&](std::uint32_t v) { return Vector3{mesh.x[v], mesh.y[v], mesh.z[v]}; };
  for (std::size_t t = 0; t < component.size(); ++t) {
    IntrinsicSurface& surface = surfaces[component[t]];
    place[t] = static_cast<std::uint32_t>(surface.triangle_count());
    for (std::size_t h = 3 * t; h < 3 * t + 3; ++h) {
      const std::uint32_t from = mesh.triangles[h], to = mesh.triangles[next_half_edge(h)];
      if (number[from] == no_index) number[from] = surface.vertex_count++;
      surface.triangles.push_back(number[from]);
      surface.opposite.push_back(opposite[h]);
      surface.length.push_back(distance(position(std::min(from, to)), position(std::max(from, to))));
    }
  }
  for (IntrinsicSurface& surface : surfaces)
    for (std::uint32_t& other : surface.opposite)
      if (other != no_index) other = 3 * place[other / 3] + other % 3;
  return surfaces;
}

// Cuts every triangle in four at the middles of its edges; the geometry stays. Triangles 4 t + k have corner
// k of t, and 4 t + 3 is the middle one.
IntrinsicSurface refined(const IntrinsicSurface& coarse) {
  IntrinsicSurface fine;
  fine.vertex_count = coarse.vertex_count;
  const auto half_edges = static_cast<std::uint32_t>(coarse.triangles.size());
  std::vector<std::uint32_t> middle(half_edges);
  for (std::uint32_t h = 0; h < half_edges; ++h) {
    const std::uint32_t other = coarse.opposite[h];
    middle[h] = other < h ? middle[other] : fine.vertex_count++;  // no_index is not below h
  }
  // The halves of an edge: from its start to the middle, and from there to its end.
  const auto first_half = [](std::uint32_t h) { return 12 * (h / 3) + 3 * (h % 3); };
  const auto second_half = [](std::uint32_t h) { return 12 * (h / 3) + 3 * ((h + 1) % 3) + 2; };
  fine.triangles.resize(4 * std::size_t{half_edges});
  fine.opposite.assign(4 * std::size_t{half_edges}, no_index);
  fine.length.resize(4 * std::size_t{half_edges});
  for (std::uint32_t t = 0; t < coarse.triangle_count(); ++t) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t h = 3 * t + k, before = previous_half_edge(h), after = next_half_edge(h);
      const std::uint32_t corner = 12 * t + 3 * k, inner = 12 * t + 9 + k;
      fine.triangles[corner] = coarse.triangles[h];
      fine.triangles[corner + 1] = middle[h];
      fine.triangles[corner + 2] = middle[before];
      fine.length[corner] = coarse.length[h] / 2;
      fine.length[corner + 1] = coarse.length[after] / 2;
      fine.length[corner + 2] = coarse.length[before] / 2;
      // The middle triangle has an edge from the middle of edge k to that of the next.
      fine.triangles[inner] = middle[h];
      fine.length[inner] = coarse.length[before] / 2;
      const std::uint32_t across = 12 * t + 3 * ((k + 1) % 3) + 1;
      fine.opposite[inner] = across;
      fine.opposite[across] = inner;
      const std::uint32_t other = coarse.opposite[h];
      if (other == no_index) continue;
      fine.opposite[first_half(h)] = second_half(other);
      fine.opposite[second_half(h)] = first_half(other);
    }
  }
  return fine;
}

}  // namespace

std::vector<float> shape_dna(const PreparedMesh& mesh, const SurfaceSamplePlaces& samples,
                             const CancelToken& cancel) {
  const ChosenSamples chosen = choose(mesh, samples);
  RemeshParameters parameters;
  parameters.lines.crease_angle = 180;
  parameters.part_crossings = false;  // the spectrum does not depend on the place in space
  const RemeshedSurface remeshed = remesh_surface(
      mesh, {chosen.triangle, chosen.weights, chosen.position, chosen.rank}, {}, parameters, cancel);
  const std::vector<float> missing(shape_dna_values, std::numeric_limits<float>::quiet_NaN());
  if (remeshed.x.size() > shape_dna_max_vertices) return missing;
  std::vector<IntrinsicSurface> components = intrinsic_components(remeshed);
  if (components.empty()) return missing;
  double area = 0;
  std::size_t vertices = 0;
  for (IntrinsicSurface& component : components) {
    mollify(component.length);
    make_intrinsic_delaunay(component, cancel);
    vertices += component.vertex_count;
    area += area_of(component);
  }
  while (vertices < shape_dna_min_vertices) {
    cancel.check();
    vertices = 0;
    for (IntrinsicSurface& component : components) {
      component = refined(component);
      vertices += component.vertex_count;
    }
  }
  std::vector<double> spectrum;
  try {
    spectrum = joint_spectrum(components, shape_dna_values, cancel);
  } catch (const SpectrumNotFound&) {
    return missing;
  }
  std::vector<float> values;
  for (const double value : spectrum) {
    const double expected = 4 * std::numbers::pi * static_cast<double>(values.size() + 1) / area;
    values.push_back(static_cast<float>(std::sqrt(value / expected)));
  }
  return values;
}

}  // namespace meander
