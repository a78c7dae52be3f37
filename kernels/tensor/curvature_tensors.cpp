#include "kernels/tensor/curvature_tensors.h"

#include <algorithm>
#include <cmath>

#include "kernels/core/check_range.h"
#include "kernels/core/parallel.h"
#include "kernels/core/portable_functions.h"
#include "kernels/core/weighted_quantile.h"
#include "kernels/density/curvature.h"
#include "kernels/mesh/half_edges.h"
#include "kernels/mesh/vertex_corners.h"
#include "kernels/tensor/tensor_blocks.h"
#include "kernels/tensor/vertex_tensors.h"

namespace meander {

namespace {

constexpr std::size_t fitting_block = 1024;
// The edges of a vertex span its plane when the smaller moment is at least this share of the larger one.
constexpr double min_span = 1e-4;

// Moments of the steps e and of the turns d of the normal along them. The least-squares fit of A e to d over
// symmetric A satisfies A E + E A = D + D^T with E = sum w e e^T, D = sum w d e^T.
struct TurnFit {
  TangentTensor steps;             // E
  double xx = 0, xy = 0, yy = 0;   // symmetric part of D
  double weight = 0, squared = 0;  // sum of w and of w |e|^2

  void add(double w, double ex, double ey, double dx, double dy) {
    steps = steps + w * TangentTensor{ex * ex, ex * ey, ey * ey};
    xx += w * dx * ex;
    xy += 0.5 * w * (dx * ey + dy * ex);
    yy += w * dy * ey;
    weight += w;
    squared += w * (ex * ex + ey * ey);
  }
  bool solve(TangentTensor& result) const {
    const TensorAxes axes = tensor_axes(steps);
    if (!(axes.first > 0) || !(axes.second > min_span * axes.first)) return false;
    TangentTensor turned = in_turned_frame({xx, xy, yy}, axes.x, axes.y);
    turned = {turned.xx / axes.first, 2 * turned.xy / (axes.first + axes.second), turned.yy / axes.second};
    result = in_turned_frame(turned, axes.x, -axes.y);
    return true;
  }
};

void add_edge(const PreparedMesh& mesh, std::span<const TangentFrame> frames, const TangentFrame& at,
              std::uint32_t h, double weight, TurnFit& fit) {
  const std::uint32_t a = mesh.triangles[h], b = mesh.triangles[next_half_edge(h)];
  const Vector3 e = mesh.position(b) - mesh.position(a), d = frames[b].normal - frames[a].normal;
  fit.add(weight, dot(e, at.x), dot(e, at.y), dot(d, at.x), dot(d, at.y));
}

// The fit at one vertex; keep(a, b) says whether an edge between vertices a and b counts.
template <class Keep>
TurnFit fit_at(const PreparedMesh& mesh, std::span<const TangentFrame> frames,
               std::span<const std::uint32_t> corners, const TangentFrame& at, const Keep& keep) {
  TurnFit fit;
  for (const std::uint32_t h : corners) {
    const std::uint32_t second = next_half_edge(h), third = previous_half_edge(h);
    const Vector3 p = mesh.position(mesh.triangles[h]), q = mesh.position(mesh.triangles[second]),
                  r = mesh.position(mesh.triangles[third]);
    const double share = mixed_area_share(p, q, r, mesh.area[h / 3]);
    const double size = dot(q - p, q - p) + dot(r - q, r - q) + dot(p - r, p - r);
    if (!(share > 0) || !(size > 0)) continue;
    for (const std::uint32_t edge : {h, second, third})
      if (keep(mesh.triangles[edge], mesh.triangles[next_half_edge(edge)]))
        add_edge(mesh, frames, at, edge, share / size, fit);
  }
  return fit;
}

// Gives vertices without a value the transported mean of the neighbors that had one before each round.
void fill_unknown(const PreparedMesh& mesh, std::span<const TangentFrame> frames, const VertexCorners& around,
                  std::vector<std::uint8_t>& known, std::vector<TangentTensor>& tensors) {
  struct Value {
    TangentTensor sum;
    double count = 0;
  };
  fill_from_neighbors<Value>(
      mesh, around, known,
      [&](Value& value, std::uint32_t v, std::uint32_t neighbor) {
        value.sum = value.sum + transport(tensors[neighbor], frames[neighbor], frames[v]);
        value.count += 1;
      },
      [&](const Value& value, std::uint32_t v) {
        if (value.count == 0) return false;
        tensors[v] = (1 / value.count) * value.sum;
        return true;
      });
}

// The cap on curvatures: their quantile over the part that is not flat.
double largest_curvature(const PreparedMesh& mesh, std::span<const double> bend, double epsilon,
                         double share) {
  std::vector<double> area(bend.size(), 0.0);
  for (std::size_t h = 0; h < mesh.triangles.size(); ++h)
    if (const std::uint32_t v = mesh.triangles[h]; bend[v] > epsilon) area[v] += mesh.area[h / 3];
  return std::max(epsilon, weighted_quantile(bend, area, share));
}

}  // namespace

std::vector<TangentTensor> curvature_tensors(const PreparedMesh& mesh, std::span<const TangentFrame> frames,
                                             const CancelToken& cancel) {
  const std::size_t vertices = mesh.vertex_count();
  const VertexCorners around(mesh);
  const std::vector<std::uint8_t> boundary = boundary_vertices(mesh.triangles, mesh.opposite, vertices);
  std::vector<TangentTensor> result(vertices);
  std::vector<std::uint8_t> known(vertices, 0);
  const double rounding = 0x1p-24 * (1 + norm(center_in_units(mesh)));
  // Coordinates off by `rounding` turn normals by rounding / length, and change curvatures by that over
  // length.
  const auto accept = [&](const TurnFit& fit, std::size_t v) {
    if (!fit.solve(result[v])) return;
    const TensorAxes axes = tensor_axes(result[v]);
    const double bend = std::max(std::abs(axes.first), std::abs(axes.second));
    if (bend <= 8 * rounding * fit.weight / fit.squared) result[v] = {};
    known[v] = 1;
  };
  const auto inside = [&](std::uint32_t a, std::uint32_t b) { return !boundary[a] && !boundary[b]; };
  cancel.check();
  parallel_blocks(vertices, fitting_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v)
      if (!boundary[v]) accept(fit_at(mesh, frames, around.of(v), frames[v], inside), v);
  });
  cancel.check();
  fill_unknown(mesh, frames, around, known, result);
  // Vertices of narrow strips have only boundary edges.
  const std::vector<std::uint8_t> filled = known;
  const auto all = [](std::uint32_t, std::uint32_t) { return true; };
  for (std::size_t v = 0; v < vertices; ++v)
    if (!filled[v]) accept(fit_at(mesh, frames, around.of(v), frames[v], all), v);
  fill_unknown(mesh, frames, around, known, result);
  return result;
}

std::vector<std::string> validate(const CurvatureFieldParameters& p) {
  std::vector<std::string> problems;
  check_range(problems, "max ratio", p.max_ratio, 1, 64);
  check_range(problems, "curvature epsilon", p.epsilon, 1e-6, 1e3);
  check_range(problems, "curvature quantile", p.quantile, 0.01, 1.0);
  check_range(problems, "tensor smoothing", p.smoothing, 0, 64);
  return problems;
}

std::vector<TangentTensor> curvature_field(const PreparedMesh& mesh, std::span<const TangentFrame> frames,
                                           const CurvatureFieldParameters& parameters,
                                           const CancelToken& cancel) {
  std::vector<TangentTensor> field = curvature_tensors(mesh, frames, cancel);
  smooth_tensors(mesh, frames, field, parameters.smoothing, cancel);
  const double epsilon = parameters.epsilon / (mesh.diagonal / mesh.unit);
  std::vector<double> bend(field.size());
  for (std::size_t v = 0; v < field.size(); ++v) {
    const TensorAxes axes = tensor_axes(field[v]);
    bend[v] = std::max(std::abs(axes.first), std::abs(axes.second));
  }
  const double largest =
      parameters.adaptive ? largest_curvature(mesh, bend, epsilon, parameters.quantile) : 0.0;
  const double min_share = 1 / (parameters.max_ratio * parameters.max_ratio);
  parallel_blocks(field.size(), fitting_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      TensorAxes axes = tensor_axes(field[v]);
      // Where the first direction bends more, the second is the long one: the axes change places.
      double flat = std::abs(axes.second), bent = std::abs(axes.first);
      double x = -axes.y, y = axes.x;
      if (flat > bent) {
        std::swap(flat, bent);
        x = axes.x;
        y = axes.y;
      }
      if (parameters.adaptive && bent > largest) {
        flat *= largest / bent;
        bent = largest;
      }
      bent += epsilon;
      flat = std::max(flat + epsilon, min_share * bent);
      double first = -0.5 * portable::log(flat), second = -0.5 * portable::log(bent);
      if (!parameters.adaptive) {
        first = 0.5 * (first - second);
        second = -first;
      }
      field[v] = tensor_of({first, second, x, y});
    }
  });
  smooth_tensors(mesh, frames, field, parameters.smoothing, cancel);
  const double min_log = portable::log(isotropic_ratio);
  for (TangentTensor& tensor : field) {
    const TensorAxes axes = tensor_axes(tensor);
    if (axes.first - axes.second < min_log) tensor = 0.5 * trace(tensor) * TangentTensor{1, 0, 1};
  }
  return field;
}

}  // namespace meander
