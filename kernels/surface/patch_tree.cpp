#include "kernels/surface/patch_tree.h"

#include <algorithm>
#include <cmath>

#include "kernels/core/ordered_blocks.h"
#include "kernels/core/radix_sort.h"
#include "kernels/core/status.h"

namespace meander {

namespace {

constexpr std::size_t node_block = 64;
// The points of a 3 x 3 and a 2 x 2 Gauss-Legendre rule and the four corners.
constexpr std::size_t points_per_node = 17;
constexpr double third_offset = 0.38729833462074168852;   // sqrt(0.15)
constexpr double second_offset = 0.28867513459481288225;  // 1 / sqrt(12)
constexpr std::array<double, 3> third_nodes = {0.5 - third_offset, 0.5, 0.5 + third_offset};
constexpr std::array<double, 3> third_weights = {5.0 / 18, 8.0 / 18, 5.0 / 18};
constexpr std::array<double, 2> second_nodes = {0.5 - second_offset, 0.5 + second_offset};
// Corners are evaluated slightly inside: at a border the measure may jump (knots, grid lines, the warp).
constexpr double corner_inset = 0x1p-16;
// Rounding must not decide about a leaf of exactly the maximum weight.
constexpr double leaf_slack = 1 + 1e-9;
// The number of patches of one level that a density without any smoothness may take, beside 8 N.
constexpr std::size_t patch_budget = std::size_t{1} << 16;

constexpr std::array<double, 2 * points_per_node> make_node_points() {
  std::array<double, 2 * points_per_node> points{};
  std::size_t k = 0;
  for (const double s : third_nodes)
    for (const double t : third_nodes) {
      points[k++] = s;
      points[k++] = t;
    }
  for (const double s : second_nodes)
    for (const double t : second_nodes) {
      points[k++] = s;
      points[k++] = t;
    }
  for (const double s : {corner_inset, 1 - corner_inset})
    for (const double t : {corner_inset, 1 - corner_inset}) {
      points[k++] = s;
      points[k++] = t;
    }
  return points;
}
constexpr std::array<double, 2 * points_per_node> node_points = make_node_points();

// Coefficients of the parabola through the values at third_nodes.
std::array<double, 3> parabola(double f0, double f1, double f2) {
  const double b = (f2 - f0) / (2 * third_offset), c = (f2 - 2 * f1 + f0) / (2 * third_offset * third_offset);
  return {f1 - 0.5 * b + 0.25 * c, b - c, c};
}

// The polynomial through values[3 i + j] at (third_nodes[i], third_nodes[j]).
PatchPolynomial fit(const double* values) {
  PatchPolynomial along_t{}, result{};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto c = parabola(values[3 * i], values[3 * i + 1], values[3 * i + 2]);
    for (std::size_t j = 0; j < 3; ++j) along_t[3 * i + j] = c[j];
  }
  for (std::size_t j = 0; j < 3; ++j) {
    const auto c = parabola(along_t[j], along_t[3 + j], along_t[6 + j]);
    for (std::size_t i = 0; i < 3; ++i) result[3 * i + j] = c[i];
  }
  return result;
}

// Coefficients in t of the polynomial at a given s.
std::array<double, 3> at_s(const PatchPolynomial& c, double s) {
  return {c[0] + s * (c[3] + s * c[6]), c[1] + s * (c[4] + s * c[7]), c[2] + s * (c[5] + s * c[8])};
}
double at_t(const std::array<double, 3>& c, double t) { return c[0] + t * (c[1] + t * c[2]); }

// Integrals of 1, x and x^2 over [x, x + side].
std::array<double, 3> moments(double x, double side) {
  return {side, side * (x + 0.5 * side), side * (x * (x + side) + side * side * (1.0 / 3))};
}

}  // namespace

// The errors of each node: the difference of the two rules, and the distance of the polynomial from the
// values that it was not fitted to (x area).
struct PatchTree::LevelErrors {
  std::vector<double> rules, fit;
};

void PatchTree::evaluate_level(const SurfaceMeasure& measure, const CurveTree& nodes,
                               std::vector<Record>& records, LevelErrors& errors,
                               const CancelToken& cancel) const {
  const std::size_t count = nodes.leaf_count();
  records.assign(count, {});
  errors.rules.resize(count);
  errors.fit.resize(count);
  ordered_blocks(count, node_block, [&](std::size_t begin, std::size_t end) {
    cancel.check();
    std::vector<double> s, t;
    s.reserve(points_per_node * node_block);
    t.reserve(points_per_node * node_block);
    for (std::size_t i = begin; i < end; ++i)
      for (std::size_t k = 0; k < points_per_node; ++k) {
        s.push_back(std::min(1.0, nodes.u[i] + node_points[2 * k] * nodes.side[i]));
        t.push_back(std::min(1.0, nodes.v[i] + node_points[2 * k + 1] * nodes.side[i]));
      }
    MeasureBatch batch;
    measure.evaluate(s, t, batch);
    for (std::size_t i = begin; i < end; ++i) {
      const double* value = &batch.value[(i - begin) * points_per_node];
      const double* element = &batch.area[(i - begin) * points_per_node];
      const double cell = nodes.side[i] * nodes.side[i];
      Record& record = records[i];
      double coarse = 0;
      for (std::size_t k = 0; k < 9; ++k) {
        const double weight = third_weights[k / 3] * third_weights[k % 3] * cell;
        record.mass += weight * value[k];
        record.area += weight * element[k];
      }
      for (std::size_t k = 9; k < 13; ++k) coarse += 0.25 * cell * value[k];
      errors.rules[i] = std::abs(record.mass - coarse);
      record.polynomial = fit(value);
      double worst = 0;
      for (std::size_t k = 0; k < points_per_node; ++k) {
        record.peak = std::max(record.peak, value[k]);
        if (k < 9) continue;
        const double fitted = at_t(at_s(record.polynomial, node_points[2 * k]), node_points[2 * k + 1]);
        worst = std::max(worst, std::abs(fitted - value[k]));
      }
      errors.fit[i] = worst * cell;
      for (double& c : record.polynomial) c *= cell;
    }
  });
}

PatchTree::PatchTree(const SurfaceMeasure& measure, const SurfaceSampleParameters& parameters,
                     const CancelToken& cancel)
    : table_(frame_table(parameters.curve)) {
  const double kappa = parameters.leaves_per_sample > 0        ? parameters.leaves_per_sample
                       : parameters.place == PlaceKind::vertex ? 64.0
                                                               : 4.0;
  const double leaves = kappa * parameters.samples;
  const int shallowest = curve_depth(parameters.curve, std::max(parameters.min_depth, measure.warp_depth()));
  deepest_ = std::max(shallowest, curve_depth(parameters.curve, parameters.max_depth));
  const std::size_t budget = patch_budget + 8 * std::size_t{parameters.samples};
  const auto branches = static_cast<std::size_t>(table_.branching * table_.branching);

  std::vector<CurveLevel> levels;
  levels.push_back({curve_root(parameters.curve), {1}});
  for (int depth = 1; depth < shallowest; ++depth) {
    CurveTree nodes = children_of(levels.back().nodes, levels.back().split);
    const std::size_t count = nodes.leaf_count();
    levels.push_back({std::move(nodes), std::vector<std::uint8_t>(count, 1)});
  }
  std::vector<Record> done, records;
  std::vector<KeyIndex> keys;
  LevelErrors errors;
  double done_mass = 0;
  for (int depth = shallowest;; ++depth) {
    cancel.check();
    CurveTree nodes = children_of(levels.back().nodes, levels.back().split);
    const std::size_t count = nodes.leaf_count();
    if (count == 0) break;
    evaluate_level(measure, nodes, records, errors, cancel);
    double level_mass = 0;
    for (const Record& record : records) level_mass += record.mass;
    leaf_mass_ = (done_mass + level_mass) / leaves * leaf_slack;
    // Below the weight of a leaf only the measure itself matters, with the precision of a leaf's.
    std::vector<std::uint8_t> split(count, 0), resolved(count);
    std::vector<double> error(count), wanted;
    for (std::size_t i = 0; i < count; ++i) {
      const double both = std::max(errors.rules[i], errors.fit[i]);
      error[i] = records[i].mass > leaf_mass_ ? both : errors.rules[i];
      resolved[i] = error[i] <= parameters.tolerance * std::max(records[i].mass, leaf_mass_);
      records[i].divisible = both <= parameters.tolerance * records[i].mass;
      if (resolved[i] == 0) wanted.push_back(error[i]);
    }
    double min_error = 0;  // only nodes of a larger error are split
    const std::size_t affordable = depth >= deepest_ ? 0 : budget / branches;
    if (wanted.size() > affordable) {
      const auto last = wanted.begin() + static_cast<std::ptrdiff_t>(wanted.size() - affordable) - 1;
      std::nth_element(wanted.begin(), last, wanted.end());
      min_error = *last;
    }
    for (std::size_t i = 0; i < count; ++i) {
      split[i] = resolved[i] == 0 && error[i] > min_error && affordable > 0;
      if (split[i] != 0) continue;
      unresolved_ += resolved[i] == 0;
      keys.push_back({nodes.key[i], static_cast<std::uint32_t>(done.size())});
      done.push_back(records[i]);
      done_mass += records[i].mass;
    }
    levels.push_back({std::move(nodes), std::move(split)});
  }
  patches_ = join_levels(levels);
  std::vector<KeyIndex> scratch;
  radix_sort(keys, scratch);
  records_.resize(done.size());
  cumulative_.assign(done.size() + 1, 0.0);
  for (std::size_t i = 0; i < done.size(); ++i) {
    records_[i] = done[keys[i].index];
    cumulative_[i + 1] = cumulative_[i] + records_[i].mass;
    area_ += records_[i].area;
  }
  leaf_mass_ = total() / leaves * leaf_slack;
  const double diagonal = measure.diagonal();
  if (!std::isfinite(area_) || !std::isfinite(diagonal))
    throw ItemError(Status::non_finite, "too large: the area is more than double precision holds");
  if (!(area_ > 1e-14 * diagonal * diagonal)) throw ItemError(Status::zero_area, "the surface has no area");
  if (!(total() > 0)) throw ItemError(Status::zero_density, "the density is zero on the whole surface");
  if (!std::isfinite(total()))
    throw ItemError(Status::unreadable, "the integral of the density is not finite");
}

PatchNode PatchTree::root(std::size_t patch) const {
  return {0, 0, 1, records_[patch].mass, patches_.depth[patch], patches_.frame[patch]};
}

bool PatchTree::is_leaf(std::size_t patch, const PatchNode& node) const {
  return !(node.mass > leaf_mass_) || node.depth >= deepest_ || !records_[patch].divisible;
}

std::size_t PatchTree::children(std::size_t patch, const PatchNode& node,
                                std::array<PatchNode, 9>& result) const {
  const PatchPolynomial& c = records_[patch].polynomial;
  const auto branching = static_cast<std::size_t>(table_.branching);
  const double side = node.side / static_cast<double>(branching);
  std::array<std::array<double, 3>, 3> along_t{};  // integral over a row's t of each power
  std::array<std::array<double, 3>, 3> over_s{};   // by column: coefficients in t, integrated over s
  for (std::size_t k = 0; k < branching; ++k) {
    const double offset = static_cast<double>(k) * side;
    along_t[k] = moments(node.t + offset, side);
    const auto m = moments(node.s + offset, side);
    for (std::size_t j = 0; j < 3; ++j) over_s[k][j] = c[j] * m[0] + c[3 + j] * m[1] + c[6 + j] * m[2];
  }
  const std::size_t count = branching * branching;
  double sum = 0;
  for (std::size_t digit = 0; digit < count; ++digit) {
    const std::size_t cell = table_.cell_of_digit[node.frame][digit];
    const std::size_t column = cell % branching, row = cell / branching;
    const auto& a = over_s[column];
    const auto& b = along_t[row];
    PatchNode& child = result[digit];
    child.s = node.s + static_cast<double>(column) * side;
    child.t = node.t + static_cast<double>(row) * side;
    child.side = side;
    child.mass = std::max(0.0, a[0] * b[0] + a[1] * b[1] + a[2] * b[2]);
    child.depth = static_cast<std::uint8_t>(node.depth + 1);
    child.frame = table_.child_frame[node.frame][digit];
    sum += child.mass;
  }
  // Where the polynomial was cut off at zero, the parent's mass still counts.
  const double scale = sum > 0 ? node.mass / sum : 0.0;
  for (std::size_t digit = 0; digit < count; ++digit) result[digit].mass *= scale;
  return count;
}

PatchNode PatchTree::find_leaf(std::size_t patch, double rest) const {
  PatchNode node = root(patch);
  std::array<PatchNode, 9> below;
  while (!is_leaf(patch, node)) {
    const std::size_t count = children(patch, node, below);
    // Positions that rounding pushes past the end belong to the last child of positive mass.
    std::size_t chosen = count;
    for (std::size_t k = 0; k < count; ++k) {
      if (!(below[k].mass > 0)) continue;
      chosen = k;
      if (rest < below[k].mass) break;
      rest -= below[k].mass;
    }
    if (chosen == count) break;
    node = below[chosen];
    rest = std::min(rest, node.mass);
  }
  return node;
}

// The hull of the polynomial's Bernstein coefficients on the node bounds it.
double PatchTree::bound(std::size_t patch, const PatchNode& node) const {
  const Record& record = records_[patch];
  std::array<std::array<double, 3>, 3> value{};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto c = at_s(record.polynomial, node.s + 0.5 * static_cast<double>(i) * node.side);
    for (std::size_t j = 0; j < 3; ++j)
      value[i][j] = at_t(c, node.t + 0.5 * static_cast<double>(j) * node.side);
    value[i][1] = 2 * value[i][1] - 0.5 * (value[i][0] + value[i][2]);
  }
  double largest = 0;
  for (std::size_t j = 0; j < 3; ++j)
    largest =
        std::max({largest, value[0][j], value[2][j], 2 * value[1][j] - 0.5 * (value[0][j] + value[2][j])});
  largest /= patches_.side[patch] * patches_.side[patch];
  return node.side == 1 ? std::max(largest, record.peak) : largest;
}

std::vector<std::uint64_t> PatchTree::count_leaves() const {
  std::vector<std::uint64_t> counts(patches_.leaf_count(), 0);
  ordered_blocks(counts.size(), node_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) visit_leaves(p, [&](const PatchNode&) { ++counts[p]; });
  });
  return counts;
}

}  // namespace meander
