#include "kernels/analyse/curve_chains.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "kernels/core/status.h"

namespace meander {

namespace {

// Triangles of a chart by the cells of a grid over the unit square.
class ChartGrid {
 public:
  explicit ChartGrid(const FlatChart& chart) : chart_(chart) {
    const std::size_t triangles = chart.cut.triangle_count();
    side_ = std::clamp<std::int64_t>(std::lround(std::sqrt(static_cast<double>(triangles))), 1, 1024);
    std::vector<std::uint32_t> count(static_cast<std::size_t>(side_ * side_) + 1, 0);
    const auto for_cells = [&](auto visit) {
      for (std::uint32_t t = 0; t < triangles; ++t) {
        const std::array<double, 3> u = corners(chart.u, t), v = corners(chart.v, t);
        const auto [u0, u1] = std::minmax({u[0], u[1], u[2]});
        const auto [v0, v1] = std::minmax({v[0], v[1], v[2]});
        for (std::int64_t y = cell(v0); y <= cell(v1); ++y)
          for (std::int64_t x = cell(u0); x <= cell(u1); ++x)
            visit(static_cast<std::size_t>(y * side_ + x), t);
      }
    };
    for_cells([&](std::size_t c, std::uint32_t) { ++count[c + 1]; });
    for (std::size_t c = 1; c < count.size(); ++c) count[c] += count[c - 1];
    begin_ = count;
    triangle_.resize(count.back());
    for_cells([&](std::size_t c, std::uint32_t t) { triangle_[count[c]++] = t; });
  }

  // The triangle below a point and the weights of its corners.
  bool locate(double u, double v, std::uint32_t& triangle, std::array<double, 3>& weight) const {
    const auto c = static_cast<std::size_t>(cell(v) * side_ + cell(u));
    for (std::uint32_t i = begin_[c]; i < begin_[c + 1]; ++i) {
      triangle = triangle_[i];
      const std::array<double, 3> x = corners(chart_.u, triangle), y = corners(chart_.v, triangle);
      const double area = (x[1] - x[0]) * (y[2] - y[0]) - (y[1] - y[0]) * (x[2] - x[0]);
      if (area == 0) continue;
      for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t a = (k + 1) % 3, b = (k + 2) % 3;
        weight[k] = ((x[b] - x[a]) * (v - y[a]) - (y[b] - y[a]) * (u - x[a])) / area;
      }
      if (weight[0] >= 0 && weight[1] >= 0 && weight[2] >= 0) return true;
    }
    return false;
  }

 private:
  std::array<double, 3> corners(const std::vector<double>& values, std::uint32_t t) const {
    const std::uint32_t* c = chart_.cut.triangles.data() + 3 * std::size_t{t};
    return {values[c[0]], values[c[1]], values[c[2]]};
  }
  std::int64_t cell(double value) const {
    return std::clamp<std::int64_t>(static_cast<std::int64_t>(value * static_cast<double>(side_)), 0,
                                    side_ - 1);
  }

  const FlatChart& chart_;
  std::int64_t side_ = 1;
  std::vector<std::uint32_t> begin_, triangle_;
};

}  // namespace

std::vector<CurveChain> curve_chains(const PreparedMesh& mesh, const FlatChart& chart, const CurveTree& tree,
                                     std::uint32_t steps) {
  std::vector<CurveChain> chains;
  if (chart.report.method == Method::none || chart.u.empty() || tree.leaf_count() == 0) return chains;
  const ChartGrid grid(chart);
  CurveChain chain;
  const auto close = [&] {
    if (chain.u.size() > 1) chains.push_back(std::move(chain));
    chain = {};
  };
  const auto visit = [&](double u, double v, double along) {
    std::uint32_t triangle = 0;
    std::array<double, 3> weight{};
    if (!grid.locate(u, v, triangle, weight)) return close();
    Vector3 at;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t corner = chart.cut.triangles[3 * std::size_t{triangle} + k];
      at = at + weight[k] * mesh.position(chart.cut.source_vertex[corner]);
    }
    chain.u.push_back(u);
    chain.v.push_back(v);
    chain.position.push_back(at);
    chain.along.push_back(along);
  };
  const auto center = [&](std::size_t i) {
    return std::array<double, 2>{tree.u[i] + 0.5 * tree.side[i], tree.v[i] + 0.5 * tree.side[i]};
  };
  for (std::size_t i = 0; i + 1 < tree.leaf_count(); ++i) {
    const std::array<double, 2> a = center(i), b = center(i + 1);
    for (std::uint32_t s = 0; s < steps; ++s) {
      const double t = static_cast<double>(s) / steps;
      visit(a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), static_cast<double>(i) + t);
    }
  }
  const std::array<double, 2> last = center(tree.leaf_count() - 1);
  visit(last[0], last[1], static_cast<double>(tree.leaf_count() - 1));
  close();
  return chains;
}

}  // namespace meander
