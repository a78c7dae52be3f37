#include "kernels/analyse/spacing.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "kernels/analyse/kd_tree.h"
#include "kernels/core/parallel.h"

namespace meander {

namespace {

constexpr std::size_t spacing_block = 1024;

std::vector<double> on_torus(std::span<const double> x, std::span<const double> y, double period_x,
                             double period_y) {
  if (x.size() != y.size()) throw std::invalid_argument("spacing: as many x as y");
  if (!(period_x >= 0) || !(period_y >= 0) || !std::isfinite(period_x + period_y))
    throw std::invalid_argument("spacing: periods are finite and not negative");
  std::vector<double> points(2 * x.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    points[2 * i] = wrapped(x[i], period_x);
    points[2 * i + 1] = wrapped(y[i], period_y);
  }
  return points;
}

void check_triples(std::span<const double> points) {
  if (points.size() % 3 != 0) throw std::invalid_argument("spacing: three coordinates a point");
}

// Distances from every point of `queries`, in the order of its tree, to the nearest one of `tree`; `search`
// looks around one query.
template <std::size_t Dimension, class Search>
std::vector<double> all_distances(const KdTree<Dimension>& queries, const Search& search) {
  std::vector<double> distances(queries.count());
  parallel_blocks(queries.count(), spacing_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      typename KdTree<Dimension>::Nearest best;
      search(queries.point(p), queries.index(p), best);
      distances[queries.index(p)] = std::sqrt(best.squared);
    }
  });
  return distances;
}

}  // namespace

std::vector<double> nearest_distances(std::span<const double> x, std::span<const double> y, double period_x,
                                      double period_y) {
  const KdTree<2> tree(on_torus(x, y, period_x, period_y));
  if (tree.count() < 2) throw std::invalid_argument("nearest_distances: at least two points");
  return all_distances(tree, [&](const auto& query, std::uint32_t self, auto& best) {
    for_each_image(query, period_x, period_y, [&](const auto& image) { tree.nearest(image, self, best); });
  });
}

std::vector<double> nearest_distances(std::span<const double> points) {
  check_triples(points);
  const KdTree<3> tree(points);
  if (tree.count() < 2) throw std::invalid_argument("nearest_distances: at least two points");
  return all_distances(
      tree, [&](const auto& query, std::uint32_t self, auto& best) { tree.nearest(query, self, best); });
}

std::vector<double> distances_to_samples(std::span<const double> x, std::span<const double> y,
                                         std::span<const double> reference_x,
                                         std::span<const double> reference_y, double period_x,
                                         double period_y) {
  const KdTree<2> tree(on_torus(x, y, period_x, period_y));
  const KdTree<2> queries(on_torus(reference_x, reference_y, period_x, period_y));
  if (tree.count() == 0) throw std::invalid_argument("distances_to_samples: at least one sample");
  return all_distances(queries, [&](const auto& query, std::uint32_t, auto& best) {
    for_each_image(query, period_x, period_y,
                   [&](const auto& image) { tree.nearest(image, KdTree<2>::none, best); });
  });
}

std::vector<double> distances_to_samples(std::span<const double> points, std::span<const double> reference) {
  check_triples(points);
  check_triples(reference);
  const KdTree<3> tree(points), queries(reference);
  if (tree.count() == 0) throw std::invalid_argument("distances_to_samples: at least one sample");
  return all_distances(queries, [&](const auto& query, std::uint32_t, auto& best) {
    tree.nearest(query, KdTree<3>::none, best);
  });
}

double hexagonal_spacing(double area, std::uint64_t n) {
  if (!(area > 0) || n == 0) throw std::invalid_argument("hexagonal_spacing: area > 0 and n > 0");
  return std::sqrt(2 * area / (std::sqrt(3.0) * static_cast<double>(n)));
}

double hexagonal_hole(double area, std::uint64_t n) { return hexagonal_spacing(area, n) / std::sqrt(3.0); }

double hexagonal_mean_distance(double area, std::uint64_t n) {
  return hexagonal_hole(area, n) * (1.0 / 3 + 0.25 * std::log(3.0));
}

Spacing spacing_of(std::span<const double> distances, double area) {
  if (distances.empty()) throw std::invalid_argument("spacing_of: no distances");
  Spacing spacing;
  spacing.min = *std::min_element(distances.begin(), distances.end());
  spacing.mean = blocked_sum(distances) / static_cast<double>(distances.size());
  spacing.rho = spacing.min / hexagonal_spacing(area, distances.size());
  return spacing;
}

}  // namespace meander
