#include "kernels/analyse/mode_errors.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <tuple>

#include "kernels/core/parallel.h"
#include "kernels/describe/laplacian_spectrum.h"
#include "kernels/solve/intrinsic_delaunay.h"
#include "kernels/solve/surface_laplacian.h"

namespace meander {

namespace {

constexpr std::size_t more_than_due = 3;  // about the deviation of a component from its expectation

LaplacianModes modes_of(const PreparedMesh& mesh, const Component& component, std::size_t count,
                        const CancelToken& cancel) {
  IntrinsicSurface surface = intrinsic_component(mesh, component);
  mollify(surface.length);
  make_intrinsic_delaunay(surface);
  return laplacian_modes(surface, count, cancel);
}

// The lowest of all components, as joint_spectrum: a component is asked for the number that is due to its
// area, and for twice as many while its largest is among the lowest of all.
std::vector<SurfaceMode> joint_modes(const PreparedMesh& mesh, std::size_t count, const CancelToken& cancel) {
  const std::size_t components = mesh.components.size();
  std::vector<LaplacianModes> found(components);
  std::vector<std::size_t> asked(components);
  const auto ask = [&](std::size_t c, std::size_t wanted) {
    asked[c] = std::min(wanted, count);
    found[c] = modes_of(mesh, mesh.components[c], asked[c], cancel);
  };
  for (std::size_t c = 0; c < components; ++c) {
    const double due = static_cast<double>(count) * mesh.components[c].area / mesh.total_area;
    ask(c, components == 1 ? count : more_than_due + static_cast<std::size_t>(due));
  }
  std::vector<std::tuple<double, std::size_t, std::size_t>> lowest;  // value, component, number in it
  for (bool is_complete = false; !is_complete;) {
    lowest.clear();
    for (std::size_t c = 0; c < components; ++c)
      for (std::size_t k = 0; k < found[c].values.size(); ++k) lowest.emplace_back(found[c].values[k], c, k);
    std::sort(lowest.begin(), lowest.end());
    lowest.resize(std::min(lowest.size(), count));
    is_complete = true;
    for (std::size_t c = 0; c < components; ++c) {
      // The component has no more eigenvalues, or no more that can matter.
      if (asked[c] == count || found[c].values.size() < asked[c]) continue;
      if (lowest.size() == count && found[c].values.back() >= std::get<0>(lowest.back())) continue;
      ask(c, 2 * asked[c]);
      is_complete = false;
    }
  }
  std::vector<SurfaceMode> modes;
  for (const auto& [value, component, k] : lowest) {
    SurfaceMode& mode = modes.emplace_back();
    mode.value = value;
    mode.component = static_cast<std::uint32_t>(component);
    mode.function = std::move(found[component].functions[k]);
  }
  return modes;
}

// Exact: the integrals over a triangle of a linear function and of its square.
void integrate(const PreparedMesh& mesh, SurfaceMode& mode) {
  const Component& component = mesh.components[mode.component];
  std::vector<double> first, second;
  for (std::size_t t = component.triangle_begin; t < component.triangle_end; ++t) {
    const auto at = [&](std::size_t k) {
      return mode.function[mesh.triangles[3 * t + k] - component.vertex_begin];
    };
    const double a = at(0), b = at(1), c = at(2), sum = a + b + c;
    first.push_back(mesh.area[t] * sum / 3);
    second.push_back(mesh.area[t] * (sum * sum + a * a + b * b + c * c) / 12);
  }
  mode.mean = blocked_sum(first) / mesh.total_area;
  mode.variance = blocked_sum(second) / mesh.total_area - mode.mean * mode.mean;
}

}  // namespace

std::vector<SurfaceMode> lowest_modes(const PreparedMesh& mesh, std::size_t count,
                                      const CancelToken& cancel) {
  std::vector<SurfaceMode> modes;
  if (mesh.components.size() > 1) {
    std::vector<std::uint32_t> by_area(mesh.components.size());
    std::iota(by_area.begin(), by_area.end(), 0u);
    std::stable_sort(by_area.begin(), by_area.end(), [&](std::uint32_t a, std::uint32_t b) {
      return mesh.components[a].area > mesh.components[b].area;
    });
    by_area.resize(std::min(by_area.size(), count));
    for (const std::uint32_t c : by_area) {
      SurfaceMode& mode = modes.emplace_back();
      mode.component = c;
      mode.function.assign(mesh.components[c].vertex_end - mesh.components[c].vertex_begin, 1.0);
    }
  }
  if (modes.size() < count) {
    std::vector<SurfaceMode> others = joint_modes(mesh, count - modes.size(), cancel);
    std::move(others.begin(), others.end(), std::back_inserter(modes));
  }
  parallel_tasks(modes.size(), [&](std::size_t m) { integrate(mesh, modes[m]); });
  std::erase_if(modes, [](const SurfaceMode& mode) { return !(mode.variance > 0); });
  return modes;
}

double mode_error_ratio(const PreparedMesh& mesh, std::span<const SurfaceMode> modes,
                        const SurfaceLocations& points) {
  const std::size_t n = points.triangle.size();
  if (n == 0 || modes.empty())
    throw std::invalid_argument("mode errors need at least one point and one function");
  std::vector<double> squares(modes.size());
  parallel_tasks(modes.size(), [&](std::size_t m) {
    const SurfaceMode& mode = modes[m];
    const Component& component = mesh.components[mode.component];
    double sum = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t t = points.triangle[i];
      if (t < component.triangle_begin || t >= component.triangle_end) continue;
      const auto at = [&](std::size_t k) {
        return mode.function[mesh.triangles[3 * t + k] - component.vertex_begin];
      };
      const double b = points.barycentric[2 * i], c = points.barycentric[2 * i + 1];
      sum += (1 - b - c) * at(0) + b * at(1) + c * at(2);
    }
    const double error = sum / static_cast<double>(n) - mode.mean;
    squares[m] = error * error * static_cast<double>(n) / mode.variance;
  });
  return std::sqrt(blocked_sum(squares) / static_cast<double>(modes.size()));
}

}  // namespace meander
