#include "kernels/tensor/chart_alignment.h"

#include <algorithm>
#include <cmath>

#include "kernels/core/parallel.h"
#include "kernels/core/portable_functions.h"
#include "kernels/flatten/chart_report.h"
#include "kernels/flatten/fit_square.h"
#include "kernels/tensor/comb_directions.h"
#include "kernels/tensor/tensor_blocks.h"

namespace meander {

namespace {

constexpr double largest_ratio = 1e12;  // reported for collapsed triangles

// d(u, v) / d(x, y).
struct Jacobian {
  double ux = 0, uy = 0, vx = 0, vy = 0;
};

double singular_ratio(const Jacobian& j) {
  const double conformal = portable::hypot(j.ux + j.vy, j.vx - j.uy);
  const double anti = portable::hypot(j.ux - j.vy, j.vx + j.uy);
  const double large = conformal + anti, small = std::abs(conformal - anti);
  return large < largest_ratio * small ? large / small : largest_ratio;
}

Jacobian operator*(const Jacobian& j, TangentTensor s) {
  return {j.ux * s.xx + j.uy * s.xy, j.ux * s.xy + j.uy * s.yy, j.vx * s.xx + j.vy * s.xy,
          j.vx * s.xy + j.vy * s.yy};
}

// The angle between the line on which v is constant and e1.
double angle_to(const Jacobian& j, double e1x, double e1y) {
  const double x = j.vy, y = -j.vx;  // J^-1 (1, 0) up to a factor
  if (!(portable::hypot(x, y) > 0)) return 0.5 * std::numbers::pi;
  return portable::atan2(std::abs(x * e1y - y * e1x), std::abs(x * e1x + y * e1y));
}

struct Shares {
  double mean, quantile_95;
};
struct Weighed {
  double value, weight;
};

// The value above which the weight is at most `share`. Halves of the values are partitioned and the half with
// the answer is divided further: O(T), because sorting would take a tenth of all charting.
double upper_quantile(std::vector<Weighed>& values, double share) {
  constexpr std::ptrdiff_t few = 32;
  const auto larger = [](const Weighed& a, const Weighed& b) { return a.value > b.value; };
  auto begin = values.begin(), end = values.end();
  double above = 0;
  while (end - begin > few) {
    const auto middle = begin + (end - begin) / 2;
    std::nth_element(begin, middle, end, larger);
    double half = 0;
    for (auto at = begin; at != middle; ++at) half += at->weight;
    if (above + half <= share) {
      above += half;
      begin = middle;
    } else {
      end = middle;
    }
  }
  std::sort(begin, end, larger);
  while (begin + 1 != end && above + begin->weight <= share) above += (begin++)->weight;
  return begin->value;
}

// Mean and quantile of values weighted by `weight`; `order` is scratch.
Shares shares_of(std::span<const double> value, std::span<const double> weight, std::vector<Weighed>& order) {
  order.clear();
  std::vector<double> terms(value.size());
  for (std::uint32_t t = 0; t < value.size(); ++t) {
    terms[t] = weight[t] * value[t];
    if (weight[t] > 0) order.push_back({value[t], weight[t]});
  }
  const double total = blocked_sum(weight);
  if (order.empty() || !(total > 0)) return {0, 0};
  return {blocked_sum(terms) / total, upper_quantile(order, 0.05 * total)};
}

}  // namespace

TriangleAlignment triangle_alignment(const PreparedMesh& mesh, const CutChart& chart,
                                     const TensorField& field, std::span<const double> u,
                                     std::span<const double> v) {
  const ChartGeometry geometry = chart_geometry(mesh, chart);
  const UnfoldedTriangles unfolded = unfold_triangles(geometry);
  const std::size_t count = chart.triangle_count();
  TriangleAlignment result;
  result.angle.assign(count, 0);
  result.stretch.assign(count, 0);
  result.ratio.assign(count, 1);
  result.weight.assign(count, 0);
  result.anisotropic.assign(count, 0);
  parallel_blocks(count, tensor_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      if (!geometry.counts[t]) continue;
      result.weight[t] = geometry.area[t];
      const std::uint32_t* c = &chart.triangles[3 * t];
      const double* ex = &unfolded.x[3 * t];
      const double* ey = &unfolded.y[3 * t];
      const double u1 = u[c[1]] - u[c[0]], u2 = u[c[2]] - u[c[0]];
      const double v1 = v[c[1]] - v[c[0]], v2 = v[c[2]] - v[c[0]];
      Jacobian j;
      j.ux = u1 / ex[0];
      j.vx = v1 / ex[0];
      j.uy = (u2 + j.ux * ex[2]) / -ey[2];
      j.vy = (v2 + j.vx * ex[2]) / -ey[2];
      const TensorAxes spacing = spacings_of(field.mean(chart.triangle_begin + t));
      const double wanted = spacing.first / spacing.second;
      result.anisotropic[t] = wanted >= isotropic_ratio;
      if (result.anisotropic[t]) result.angle[t] = angle_to(j, spacing.x, spacing.y);
      result.stretch[t] = std::abs(portable::log(singular_ratio(j) / wanted));
      result.ratio[t] = singular_ratio(j * tensor_of(spacing));
    }
  });
  return result;
}

namespace {

// Measures everything but the overlap.
AlignmentReport measured_alignment(const PreparedMesh& mesh, const CutChart& chart, const TensorField& field,
                                   std::span<const double> u, std::span<const double> v) {
  const TriangleAlignment each = triangle_alignment(mesh, chart, field, u, v);
  AlignmentReport report;
  std::vector<Weighed> order;
  report.area = blocked_sum(each.weight);
  if (report.area > 0) {
    const Shares angle = shares_of(each.angle, each.weight, order);
    const Shares stretch = shares_of(each.stretch, each.weight, order);
    const Shares ratio = shares_of(each.ratio, each.weight, order);
    report.mean_angle = angle.mean;
    report.angle_95 = angle.quantile_95;
    report.mean_stretch = stretch.mean;
    report.stretch_95 = stretch.quantile_95;
    report.mean_ratio = ratio.mean;
    report.ratio_95 = ratio.quantile_95;
    std::vector<double> anisotropic(each.weight);
    for (std::size_t t = 0; t < anisotropic.size(); ++t)
      if (!each.anisotropic[t]) anisotropic[t] = 0;
    report.anisotropic_share = blocked_sum(anisotropic) / report.area;
  }
  std::vector<std::uint8_t> counts(each.weight.size());
  for (std::size_t t = 0; t < counts.size(); ++t) counts[t] = each.weight[t] > 0;
  const std::vector<std::uint32_t> flipped = flipped_triangles(chart.triangles, counts, u, v);
  report.flips = static_cast<std::uint32_t>(flipped.size());
  double flipped_area = 0;
  for (const std::uint32_t t : flipped) flipped_area += each.weight[t];
  if (report.area > 0) report.flipped_share = flipped_area / report.area;
  return report;
}

}  // namespace

AlignmentReport chart_alignment(const PreparedMesh& mesh, const CutChart& chart, const TensorField& field,
                                std::span<const double> u, std::span<const double> v) {
  AlignmentReport report = measured_alignment(mesh, chart, field, u, v);
  if (chart.triangle_count() > 1) {
    std::vector<double> square_u(u.begin(), u.end()), square_v(v.begin(), v.end());
    fit_square(square_u, square_v);
    report.overlap = overlap_share(chart.triangles, square_u, square_v);
  }
  return report;
}

AlignmentReport chart_alignment(const PreparedMesh& mesh, const TensorField& field, const FlatChart& flat) {
  AlignmentReport report = measured_alignment(mesh, flat.cut, field, flat.u, flat.v);
  report.overlap = flat.report.overlap;
  return report;
}

bool is_accepted(const AlignmentReport& report, AlignmentForm form, const AlignmentLimits& limits) {
  if (report.flipped_share > limits.flipped || report.overlap > limits.overlap) return false;
  if (form == AlignmentForm::metric) return report.ratio_95 <= limits.ratio;
  return report.angle_95 <= limits.angle && report.stretch_95 <= limits.stretch;
}

}  // namespace meander
