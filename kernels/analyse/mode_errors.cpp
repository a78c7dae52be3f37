#include "kernels/analyse/mode_errors.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "kernels/core/parallel.h"
#include "kernels/describe/laplacian_spectrum.h"
#include "kernels/solve/intrinsic_delaunay.h"
#include "kernels/solve/surface_laplacian.h"

namespace meander {

namespace {

LaplacianModes modes_of(const PreparedMesh& mesh, const Component& component, std::size_t count,
                        const CancelToken& cancel) {
  IntrinsicSurface surface = intrinsic_component(mesh, component);
  mollify(surface.length);
  make_intrinsic_delaunay(surface);
  return laplacian_modes(surface, count, cancel);
}

// The lowest of all components.
std::vector<SurfaceMode> joint_modes(const PreparedMesh& mesh, std::size_t count, const CancelToken& cancel) {
  std::vector<double> area;
  for (const Component& component : mesh.components) area.push_back(component.area);
  std::vector<LaplacianModes> found(area.size());
  const std::vector<JointEigenvalue> lowest =
      joint_eigenvalues(area, count, [&](std::size_t c, std::size_t n) {
        found[c] = modes_of(mesh, mesh.components[c], n, cancel);
        return found[c].values;
      });
  std::vector<SurfaceMode> modes;
  for (const JointEigenvalue& eigenvalue : lowest) {
    SurfaceMode& mode = modes.emplace_back();
    mode.value = eigenvalue.value;
    mode.component = eigenvalue.component;
    mode.function = std::move(found[eigenvalue.component].functions[eigenvalue.number]);
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
