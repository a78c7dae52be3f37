#include "kernels/segment/random_walk.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

#include "kernels/core/parallel.h"
#include "kernels/core/portable_functions.h"
#include "kernels/solve/elimination_order.h"
#include "kernels/solve/sparse_cholesky.h"

namespace meander {

namespace {

constexpr std::size_t triangle_block = 1 << 12;
constexpr std::size_t batch_size = 16;       // right-hand sides per pass over the factor
constexpr std::size_t round_size = 8;        // batches in memory at once
constexpr double min_weight = 1e-8;          // of the largest weight of a component
constexpr double accurate = 1e-9;            // probabilities with larger errors are refined
constexpr double equal_probability = 1e-12;  // closer values are ties, so that rounding does not decide

// One side of an edge, in the frame whose x axis is that side's half-edge and whose y axis points into the
// triangle: the step from the centroid to the middle of the edge, and the mean log S of the triangle. The
// other side's frame is this one rotated by 180 degrees, so steps of both sides add up and tensors agree.
struct HalfStep {
  double x = 0, y = 0;
  TangentTensor log_spacing;
  bool has_tensor = false;
};

std::array<HalfStep, 3> half_steps(const PreparedMesh& mesh, const TensorField& field, std::uint32_t t) {
  const Vector3 origin = mesh.position(mesh.triangles[3 * t]);
  const Vector3 e1 = mesh.position(mesh.triangles[3 * t + 1]) - origin;
  const Vector3 e2 = mesh.position(mesh.triangles[3 * t + 2]) - origin;
  const bool has_area = mesh.area[t] > 0;
  std::array<std::array<double, 2>, 3> corner{};
  if (has_area) {
    const TangentFrame frame = triangle_frame(mesh, t);
    corner[1] = {dot(e1, frame.x), dot(e1, frame.y)};
    corner[2] = {dot(e2, frame.x), dot(e2, frame.y)};
  } else {
    // The corners lie on a line.
    const double length = norm(e1);
    corner[1] = {length, 0};
    corner[2] = {length > 0 ? dot(e2, e1) / length : norm(e2), 0};
  }
  const TangentTensor mean =
      (1.0 / 3) * (field.corner[3 * t] + field.corner[3 * t + 1] + field.corner[3 * t + 2]);
  const double center_x = (corner[1][0] + corner[2][0]) / 3, center_y = (corner[1][1] + corner[2][1]) / 3;
  std::array<HalfStep, 3> steps;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto& a = corner[k];
    const auto& b = corner[(k + 1) % 3];
    double dx = b[0] - a[0], dy = b[1] - a[1];
    const double length = portable::hypot(dx, dy);
    dx = length > 0 ? dx / length : 1;
    dy = length > 0 ? dy / length : 0;
    const double mx = 0.5 * (a[0] + b[0]) - center_x, my = 0.5 * (a[1] + b[1]) - center_y;
    steps[k] = {mx * dx + my * dy, dx * my - dy * mx, {}, has_area};
    if (has_area) steps[k].log_spacing = in_turned_frame(mean, dx, dy);
  }
  return steps;
}

TangentTensor mean_tensor(const HalfStep& a, const HalfStep& b) {
  if (a.has_tensor != b.has_tensor) return a.has_tensor ? a.log_spacing : b.log_spacing;
  return 0.5 * (a.log_spacing + b.log_spacing);
}

double bend(const HalfStep& a, const HalfStep& b) {
  if (!a.has_tensor || !b.has_tensor) return 0;
  const TensorAxes p = tensor_axes(a.log_spacing), q = tensor_axes(b.log_spacing);
  const double cosine = p.x * q.x + p.y * q.y;
  const double directed =
      std::min(1 - portable::exp(p.second - p.first), 1 - portable::exp(q.second - q.first));
  return std::max(0.0, 1 - cosine * cosine) * directed;
}

// The walk on one component; its unseeded triangles are the unknowns.
class WalkSystem {
 public:
  WalkSystem(const PreparedMesh& mesh, const Component& component, std::span<const double> weight,
             std::span<const std::uint32_t> seeds, const CancelToken& cancel)
      : mesh_(mesh), component_(component), weight_(weight), seeds_(seeds) {
    const std::uint32_t triangles = component.triangle_end - component.triangle_begin;
    if (seeds.empty()) throw std::invalid_argument("random walk: a component without a seed");
    seed_.assign(triangles, no_index);
    for (std::uint32_t l = 0; l < seeds.size(); ++l) {
      if (seeds[l] < component.triangle_begin || seeds[l] >= component.triangle_end)
        throw std::invalid_argument("random walk: a seed outside its component");
      std::uint32_t& entry = seed_[seeds[l] - component.triangle_begin];
      if (entry != no_index) throw std::invalid_argument("random walk: two seeds in one triangle");
      entry = l;
    }
    unknown_.assign(triangles, no_index);
    for (std::uint32_t i = 0; i < triangles; ++i) {
      if (seed_[i] != no_index) continue;
      unknown_[i] = static_cast<std::uint32_t>(triangle_.size());
      triangle_.push_back(i);
    }
    if (seeds.size() > 1 && !triangle_.empty()) factorize(cancel);
  }

  // The unknowns as triangles, counted from the component's first.
  std::span<const std::uint32_t> triangles() const { return triangle_; }
  std::size_t batches() const { return (seeds_.size() + batch_size - 1) / batch_size; }

  // The number of columns of a batch, and the probabilities of its seeds: those of unknown u at result[u *
  // columns(batch)].
  std::size_t columns(std::size_t batch) const {
    const std::size_t count = std::min(batch_size, seeds_.size() - batch * batch_size);
    return count > 8 ? 16 : count > 4 ? 8 : count > 2 ? 4 : count;
  }
  std::vector<double> solve(std::size_t batch) const {
    const std::size_t width = columns(batch);
    std::vector<double> values(triangle_.size() * width, 0.0);
    add_solution(values, width, [&](std::uint32_t seed, std::size_t column) {
      return seed == batch * batch_size + column ? 1.0 : 0.0;
    });
    return values;
  }

 private:
  // The triangle across h, counted from the component's first.
  std::uint32_t neighbor_of(std::uint32_t h) const {
    const std::uint32_t other = mesh_.opposite[h];
    if (other == no_index || other / 3 == h / 3) return no_index;
    return other / 3 - component_.triangle_begin;
  }

  // Adds the probabilities whose values at the seeds are seed_value(seed, column); `values` must be 0. Where
  // the factor has lost digits (long surfaces of very unequal weights), they are refined: the residual is a
  // sum of differences between neighbors and hence accurate.
  template <class SeedValue>
  void add_solution(std::vector<double>& values, std::size_t width, const SeedValue& seed_value) const {
    std::vector<double> correction(values.size());
    for (int pass = 0; pass <= refinements_; ++pass) {
      for (std::size_t u = 0; u < triangle_.size(); ++u) {
        double* residual = &correction[u * width];
        std::fill(residual, residual + width, 0.0);
        const std::uint32_t t = component_.triangle_begin + triangle_[u];
        for (std::uint32_t h = 3 * t; h < 3 * t + 3; ++h) {
          const std::uint32_t neighbor = neighbor_of(h);
          if (neighbor == no_index) continue;
          const std::uint32_t v = unknown_[neighbor];
          if (pass == 0 && v != no_index) continue;  // all values are 0
          for (std::size_t c = 0; c < width; ++c) {
            const double across = v == no_index ? seed_value(seed_[neighbor], c) : values[v * width + c];
            residual[c] += weight_[h] * (across - values[u * width + c]);
          }
        }
      }
      cholesky_.solve_many(correction, width);
      for (std::size_t i = 0; i < values.size(); ++i) values[i] += correction[i];
    }
  }

  void factorize(const CancelToken& cancel) {
    UnknownGraph graph;
    std::vector<double> values, diagonal(triangle_.size(), 0.0);
    graph.begin.reserve(triangle_.size() + 1);
    graph.begin.push_back(0);
    for (std::size_t u = 0; u < triangle_.size(); ++u) {
      const std::uint32_t t = component_.triangle_begin + triangle_[u];
      for (std::uint32_t h = 3 * t; h < 3 * t + 3; ++h) {
        const std::uint32_t neighbor = neighbor_of(h);
        if (neighbor == no_index) continue;
        diagonal[u] += weight_[h];
        if (unknown_[neighbor] == no_index) continue;
        graph.neighbors.push_back(unknown_[neighbor]);
        values.push_back(-weight_[h]);
      }
      graph.begin.push_back(static_cast<std::uint32_t>(graph.neighbors.size()));
    }
    const std::vector<std::uint32_t> order = elimination_order(graph);
    cancel.check();
    // Where rounding makes a pivot non-positive, walks may stop on the way.
    for (const double stop : {0.0, 1e-14, 1e-12, 1e-10}) {
      std::vector<double> raised = diagonal;
      for (double& d : raised) d *= 1 + stop;
      cholesky_.factorize(graph, values, raised, order, cancel);
      if (!cholesky_.succeeded()) continue;
      // A walk meets some seed, so the solution for all of them together is 1 and shows what the factor lost.
      std::vector<double> any(triangle_.size(), 0.0);
      add_solution(any, 1, [](std::uint32_t, std::size_t) { return 1.0; });
      double lost = 0;
      for (const double p : any) lost = std::max(lost, std::abs(p - 1));
      if (!(lost < 0.5)) continue;
      refinements_ = lost > accurate ? 2 : 0;
      return;
    }
    throw ItemError(Status::internal, "the random walk over " + std::to_string(triangle_.size()) +
                                          " triangles cannot be factorized");
  }

  const PreparedMesh& mesh_;
  const Component& component_;
  std::span<const double> weight_;
  std::span<const std::uint32_t> seeds_;
  std::vector<std::uint32_t> seed_;      // by triangle: its seed, no_index where unseeded
  std::vector<std::uint32_t> unknown_;   // by triangle: its unknown, no_index where seeded
  std::vector<std::uint32_t> triangle_;  // by unknown
  SparseCholesky cholesky_;
  int refinements_ = 0;
};

// Writes numbers[l] of the most probable seed l for every triangle of the component.
void label_component(const PreparedMesh& mesh, const Component& component, std::span<const double> weight,
                     std::span<const std::uint32_t> seeds, std::span<const std::uint32_t> numbers,
                     std::span<std::uint32_t> label, const CancelToken& cancel) {
  if (seeds.size() == 1) {
    std::fill(label.begin(), label.end(), numbers[0]);
    return;
  }
  const WalkSystem system(mesh, component, weight, seeds, cancel);
  for (std::size_t l = 0; l < seeds.size(); ++l) label[seeds[l] - component.triangle_begin] = numbers[l];
  struct Best {
    double probability = -1;
    std::uint32_t seed = 0;
  };
  const std::size_t unknowns = system.triangles().size();
  std::vector<Best> best(unknowns);
  // Rounds of a fixed size keep memory independent of the number of seeds.
  for (std::size_t round = 0; round < system.batches(); round += round_size) {
    std::array<std::vector<Best>, round_size> found;
    parallel_tasks(std::min(round_size, system.batches() - round), [&](std::size_t i) {
      cancel.check();
      const std::size_t batch = round + i, width = system.columns(batch), first = batch * batch_size;
      const std::size_t used = std::min(width, seeds.size() - first);
      const std::vector<double> values = system.solve(batch);
      found[i].resize(unknowns);
      for (std::size_t u = 0; u < unknowns; ++u)
        for (std::size_t c = 0; c < used; ++c)
          if (values[u * width + c] > found[i][u].probability + equal_probability)
            found[i][u] = {values[u * width + c], static_cast<std::uint32_t>(first + c)};
    });
    for (const std::vector<Best>& candidates : found)
      for (std::size_t u = 0; u < candidates.size(); ++u)
        if (candidates[u].probability > best[u].probability + equal_probability) best[u] = candidates[u];
  }
  for (std::size_t u = 0; u < unknowns; ++u) label[system.triangles()[u]] = numbers[best[u].seed];
}

// Normalizes weights given at the lower half-edge of every edge: equal on both sides, with a maximum of 1 in
// every component, a minimum, and 0 at boundaries.
void equalize_weights(const PreparedMesh& mesh, std::vector<double>& weight) {
  for (const Component& component : mesh.components) {
    const std::size_t begin = 3 * std::size_t{component.triangle_begin};
    const std::size_t end = 3 * std::size_t{component.triangle_end};
    double largest = 0;
    for (std::size_t h = begin; h < end; ++h) {
      const std::uint32_t other = mesh.opposite[h];
      if (other == no_index) weight[h] = 0;
      if (other != no_index && h < other) largest = std::max(largest, weight[h]);
    }
    for (std::size_t h = begin; h < end; ++h) {
      const std::uint32_t other = mesh.opposite[h];
      if (other == no_index || other < h) continue;
      const double w = largest > 0 ? weight[h] / largest : 1;
      weight[h] = weight[other] = w >= min_weight ? w : min_weight;
    }
  }
}

void require_half_edges(const PreparedMesh& mesh, std::size_t values) {
  if (values != mesh.triangles.size())
    throw std::invalid_argument("random walk: one weight for every half-edge is needed");
}

}  // namespace

TriangleSteps triangle_steps(const PreparedMesh& mesh, const TensorField& field,
                             const RandomWalkParameters& parameters) {
  if (!(parameters.sigma > 0) || !std::isfinite(parameters.sigma))
    throw std::invalid_argument("random walk: sigma must be a positive number");
  if (!(parameters.bending >= 0) || !std::isfinite(parameters.bending))
    throw std::invalid_argument("random walk: bending must not be negative");
  const std::size_t half_edges = mesh.triangles.size();
  if (field.corner.size() != half_edges)
    throw std::invalid_argument("random walk: the field is that of another mesh");
  std::vector<HalfStep> half(half_edges);
  parallel_blocks(mesh.triangle_count(), triangle_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const std::array<HalfStep, 3> steps = half_steps(mesh, field, static_cast<std::uint32_t>(t));
      std::copy(steps.begin(), steps.end(), half.begin() + static_cast<std::ptrdiff_t>(3 * t));
    }
  });
  TriangleSteps steps;
  steps.length.assign(half_edges, 0.0);
  steps.weight = metric_edge_lengths(mesh, field);
  // Visits each edge once, at its lower half-edge.
  const auto for_each_edge = [&](std::size_t begin, std::size_t end, const auto& body) {
    for (std::size_t h = begin; h < end; ++h) {
      const std::uint32_t other = mesh.opposite[h];
      if (other != no_index && h < other) body(h, other);
    }
  };
  parallel_blocks(half_edges, 3 * triangle_block, [&](std::size_t begin, std::size_t end) {
    for_each_edge(begin, end, [&](std::size_t h, std::uint32_t other) {
      const HalfStep &a = half[h], &b = half[other];
      const TangentTensor metric = metric_of(mean_tensor(a, b));
      steps.length[h] = std::sqrt(std::max(0.0, quadratic(metric, a.x + b.x, a.y + b.y)));
    });
  });
  std::vector<double> inverse_mean(mesh.components.size());
  for (std::size_t c = 0; c < inverse_mean.size(); ++c) {
    double sum = 0;
    std::size_t edges = 0;
    for_each_edge(3 * std::size_t{mesh.components[c].triangle_begin},
                  3 * std::size_t{mesh.components[c].triangle_end}, [&](std::size_t h, std::uint32_t other) {
                    steps.length[other] = steps.length[h];
                    sum += steps.length[h];
                    ++edges;
                  });
    inverse_mean[c] = sum > 0 ? static_cast<double>(edges) / sum : 0;
  }
  for (std::size_t c = 0; c < inverse_mean.size(); ++c) {
    const std::size_t first = 3 * std::size_t{mesh.components[c].triangle_begin};
    const std::size_t count = 3 * std::size_t{mesh.components[c].triangle_end} - first;
    parallel_blocks(count, 3 * triangle_block, [&](std::size_t begin, std::size_t end) {
      for_each_edge(first + begin, first + end, [&](std::size_t h, std::uint32_t other) {
        double cost = steps.length[h] * inverse_mean[c];
        if (parameters.bending > 0) cost += parameters.bending * bend(half[h], half[other]);
        steps.weight[h] *= portable::exp(-cost / parameters.sigma);
      });
    });
  }
  equalize_weights(mesh, steps.weight);
  return steps;
}

std::vector<double> random_walk_probabilities(const PreparedMesh& mesh, const Component& component,
                                              std::span<const double> weight,
                                              std::span<const std::uint32_t> seeds,
                                              const CancelToken& cancel) {
  require_half_edges(mesh, weight.size());
  const WalkSystem system(mesh, component, weight, seeds, cancel);
  const std::size_t count = seeds.size();
  std::vector<double> probability((component.triangle_end - component.triangle_begin) * count,
                                  count == 1 ? 1.0 : 0.0);
  if (count == 1) return probability;
  for (std::size_t l = 0; l < count; ++l) probability[(seeds[l] - component.triangle_begin) * count + l] = 1;
  parallel_tasks(system.batches(), [&](std::size_t batch) {
    cancel.check();
    const std::vector<double> values = system.solve(batch);
    const std::size_t width = system.columns(batch), first = batch * batch_size;
    for (std::size_t u = 0; u < system.triangles().size(); ++u)
      for (std::size_t c = 0; c < std::min(width, count - first); ++c)
        probability[system.triangles()[u] * count + first + c] = values[u * width + c];
  });
  return probability;
}

std::vector<std::uint32_t> random_walk_labels(const PreparedMesh& mesh, std::span<const double> weight,
                                              std::span<const std::uint32_t> seeds,
                                              const CancelToken& cancel) {
  require_half_edges(mesh, weight.size());
  std::vector<std::uint32_t> component_of(mesh.triangle_count());
  for (std::uint32_t c = 0; c < mesh.components.size(); ++c)
    std::fill(component_of.begin() + mesh.components[c].triangle_begin,
              component_of.begin() + mesh.components[c].triangle_end, c);
  std::vector<std::vector<std::uint32_t>> own(mesh.components.size()), numbers(mesh.components.size());
  for (std::uint32_t l = 0; l < seeds.size(); ++l) {
    if (seeds[l] >= component_of.size()) throw std::invalid_argument("random walk: no such seed triangle");
    own[component_of[seeds[l]]].push_back(seeds[l]);
    numbers[component_of[seeds[l]]].push_back(l);
  }
  for (const auto& list : own)
    if (list.empty()) throw std::invalid_argument("random walk: a component without a seed");
  std::vector<std::uint32_t> label(mesh.triangle_count());
  parallel_tasks(own.size(), [&](std::size_t c) {
    const Component& component = mesh.components[c];
    const std::uint32_t count = component.triangle_end - component.triangle_begin;
    label_component(mesh, component, weight, own[c], numbers[c],
                    std::span(label).subspan(component.triangle_begin, count), cancel);
  });
  return label;
}

}  // namespace meander
