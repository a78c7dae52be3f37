#include "kernels/query/winding_number.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "kernels/core/parallel.h"
#include "kernels/core/portable_functions.h"
#include "kernels/query/curve_order.h"
#include "kernels/query/lanes.h"
#include "kernels/query/nearest_triangle.h"

namespace meander {

namespace {

constexpr std::size_t winding_block = 512;

// ---- moments

// The integrals over a set of triangles of the normal n, of n_i s_j and of n_i s_j s_k, s being the place
// from the center; the latter symmetrized: xx, yy, zz, xy, xz, yz, and xxx, xxy, xxz, xyy, xyz, xzz, yyy,
// yyz, yzz, zzz.
struct Moments {
  Vector3 center;
  double radius = 0, area = 0;
  std::array<double, 3> first{};
  std::array<double, 6> second{};
  std::array<double, 10> third{};
};

constexpr std::array<std::array<std::size_t, 2>, 6> axis_pairs = {
    {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}}};
constexpr std::array<std::array<std::size_t, 3>, 10> axis_triples = {{{0, 0, 0},
                                                                      {0, 0, 1},
                                                                      {0, 0, 2},
                                                                      {0, 1, 1},
                                                                      {0, 1, 2},
                                                                      {0, 2, 2},
                                                                      {1, 1, 1},
                                                                      {1, 1, 2},
                                                                      {1, 2, 2},
                                                                      {2, 2, 2}}};

std::array<double, 3> array_of(Vector3 v) { return {v.x, v.y, v.z}; }

// The mean of s_j s_k over a triangle.
double mean_product(const std::array<std::array<double, 3>, 3>& corner, std::size_t j, std::size_t k) {
  double sum = 0, sum_j = 0, sum_k = 0;
  for (const std::array<double, 3>& c : corner) {
    sum += c[j] * c[k];
    sum_j += c[j];
    sum_k += c[k];
  }
  return (sum + sum_j * sum_k) / 12;
}

void add_triangle(Moments& moments, const std::array<Vector3, 3>& triangle, double sense) {
  std::array<std::array<double, 3>, 3> s;
  for (std::size_t k = 0; k < 3; ++k) s[k] = array_of(triangle[k] - moments.center);
  const std::array<double, 3> n =
      array_of((0.5 * sense) * cross(triangle[1] - triangle[0], triangle[2] - triangle[0]));
  std::array<double, 3> mean;
  for (std::size_t k = 0; k < 3; ++k) mean[k] = (s[0][k] + s[1][k] + s[2][k]) / 3;
  for (std::size_t k = 0; k < 3; ++k) moments.first[k] += n[k];
  for (std::size_t p = 0; p < axis_pairs.size(); ++p) {
    const auto [i, j] = axis_pairs[p];
    moments.second[p] += 0.5 * (n[i] * mean[j] + n[j] * mean[i]);
  }
  for (std::size_t p = 0; p < axis_triples.size(); ++p) {
    const auto [i, j, k] = axis_triples[p];
    moments.third[p] +=
        (n[i] * mean_product(s, j, k) + n[j] * mean_product(s, i, k) + n[k] * mean_product(s, i, j)) / 3;
  }
}

// The place of an entry in `axis_pairs` or `axis_triples` by its axes.
std::size_t pair_number(std::size_t i, std::size_t j) {
  if (i == j) return i;
  return i + j + 2;  // 0 1, 0 2, 1 2
}
std::size_t triple_number(std::size_t i, std::size_t j, std::size_t k) {
  std::array<std::size_t, 3> axes{i, j, k};
  std::sort(axes.begin(), axes.end());
  return static_cast<std::size_t>(std::find(axis_triples.begin(), axis_triples.end(), axes) -
                                  axis_triples.begin());
}

// Adds the moments of `part` around another center.
void add_moments(Moments& moments, const Moments& part) {
  const std::array<double, 3> h = array_of(part.center - moments.center);
  for (std::size_t k = 0; k < 3; ++k) moments.first[k] += part.first[k];
  for (std::size_t p = 0; p < axis_pairs.size(); ++p) {
    const auto [i, j] = axis_pairs[p];
    moments.second[p] += part.second[p] + 0.5 * (part.first[i] * h[j] + part.first[j] * h[i]);
  }
  // n_i (s_j + h_j)(s_k + h_k), symmetrized; that of n_i s_j h_k is of the symmetrized n_i s_j as well.
  for (std::size_t p = 0; p < axis_triples.size(); ++p) {
    const auto [i, j, k] = axis_triples[p];
    const auto both = [&](std::size_t a, std::size_t b) { return part.second[pair_number(a, b)]; };
    moments.third[p] +=
        part.third[p] + 2.0 / 3 * (both(i, j) * h[k] + both(i, k) * h[j] + both(j, k) * h[i]) +
        (part.first[i] * h[j] * h[k] + part.first[j] * h[i] * h[k] + part.first[k] * h[i] * h[j]) / 3;
  }
}

// The coefficients of (d_x, d_y, d_z), of d_i d_j and of d_i d_j d_k in the expansion: (m.d - 3 Q[d d] / R^2
// + 7.5 O[d d d] / R^4) / (4 pi R^3), Q and O being free of traces.
std::array<double, WindingTree::terms> expansion(const Moments& moments) {
  constexpr double per_sphere = 0.25 * std::numbers::inv_pi;
  std::array<double, WindingTree::terms> term{};
  for (std::size_t k = 0; k < 3; ++k) term[k] = per_sphere * moments.first[k];
  const double trace = moments.second[0] + moments.second[1] + moments.second[2];
  for (std::size_t p = 0; p < axis_pairs.size(); ++p) {
    const auto [i, j] = axis_pairs[p];
    const double times = i == j ? 1 : 2;
    term[3 + p] = -3 * per_sphere * times * (moments.second[p] - (i == j ? trace / 3 : 0));
  }
  std::array<double, 3> traces{};
  for (std::size_t k = 0; k < 3; ++k)
    for (std::size_t i = 0; i < 3; ++i) traces[k] += moments.third[triple_number(i, i, k)];
  for (std::size_t p = 0; p < axis_triples.size(); ++p) {
    const auto [i, j, k] = axis_triples[p];
    const double times = i == k ? 1 : i == j || j == k ? 3 : 6;
    const double rest = (i == j ? traces[k] : 0) + (j == k ? traces[i] : 0) + (i == k ? traces[j] : 0);
    term[9 + p] = 7.5 * per_sphere * times * (moments.third[p] - rest / 5);
  }
  return term;
}

// The distance from which the expansion of a node of that radius errs by at most `share` of the area below it
// (WindingTree): R with sum_{k >= 3} (k + 1) t^k / R^2 = share, t = r / R; t at most 0.6, where the bound
// lets all pass, as that of a surface of little area does.
double least_distance(double radius, double share) {
  double low = 0, high = 0.6;  // of t
  for (int step = 0; step < 40; ++step) {
    const double t = 0.5 * (low + high), rest = 1 - t;
    (t * t * t * (4 - 3 * t) * t * t <= share * radius * radius * rest * rest ? low : high) = t;
  }
  return low > 0 ? radius / low : std::numeric_limits<double>::infinity();
}

float squared_from(double radius, double share) {
  const double from = 1.000001 * least_distance(radius, share);  // rounding of distances included
  return static_cast<float>(from * from);
}

class WindingBuilder {
 public:
  WindingBuilder(WindingTree& out, std::span<const std::uint8_t> flipped) : out_(out), tree_(*out.tree) {
    moments_.resize(tree_.nodes.size());
    flipped_ = flipped;
  }

  // Children come after their parents.
  void build() {
    const double area = fill_leaves();
    const double share = area > 0 ? 4 * std::numbers::pi / area : 1;
    for (std::size_t n = tree_.nodes.size(); n > 0; --n)
      add_node(n - 1, out_.bound * share, out_.strict_bound * share);
  }

 private:
  double fill_leaves() {
    leaf_moments_.resize(tree_.leaves.size());
    parallel_blocks(tree_.leaves.size(), sum_block, [&](std::size_t begin, std::size_t end) {
      for (std::size_t leaf = begin; leaf < end; ++leaf) fill_leaf(leaf);
    });
    double area = 0;
    for (const Moments& moments : leaf_moments_) area += moments.area;
    return area;
  }

  std::array<Vector3, 3> triangle(std::size_t position) const {
    return {tree_.corner(position, 0), tree_.corner(position, 1), tree_.corner(position, 2)};
  }

  void fill_leaf(std::size_t leaf) {
    WindingTree::Leaf& corners = out_.leaves[leaf];
    corners = {};
    const std::size_t begin = tree_.leaf_begin[leaf], end = tree_.leaf_begin[leaf + 1];
    Vector3 moment, middle;
    Moments& moments = leaf_moments_[leaf];
    for (std::size_t p = begin; p < end; ++p) {
      const auto [a, b, c] = triangle(p);
      const double area = triangle_area(a, b, c);
      const Vector3 sum = a + b + c;
      moments.area += area;
      moment = moment + area * sum;
      middle = middle + sum;
    }
    moments.center = moments.area > 0 ? (1 / (3 * moments.area)) * moment
                                      : (1 / (3 * static_cast<double>(end - begin))) * middle;
    moments.center = as_float(moments.center);
    for (std::size_t p = begin; p < end; ++p) {
      const bool turned = !flipped_.empty() && flipped_[tree_.order[p]] != 0;
      const std::array<Vector3, 3> corner = triangle(p);
      add_triangle(moments, corner, turned ? -1 : 1);
      for (std::size_t k = 0; k < 3; ++k) {
        moments.radius = std::max(moments.radius, distance(corner[k], moments.center));
        const std::array<double, 3> at = array_of(corner[turned ? (3 - k) % 3 : k]);
        for (std::size_t axis = 0; axis < 3; ++axis) corners.corner[3 * k + axis][p - begin] = at[axis];
      }
    }
  }

  static Vector3 as_float(Vector3 v) {
    return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
  }

  void add_node(std::size_t number, double share, double strict_share) {
    const TriangleTree::Node& node = tree_.nodes[number];
    WindingTree::Node& out = out_.nodes[number];
    out = {};
    Moments& all = moments_[number];
    Vector3 moment, middle;
    double children = 0;
    for (std::size_t c = 0; c < TriangleTree::fan; ++c) {
      out.from[c] = out.strictly_from[c] = std::numeric_limits<float>::infinity();
      if (node.child[c] == TriangleTree::no_child) continue;
      const Moments& part = moments_of(node.child[c]);
      all.area += part.area;
      moment = moment + part.area * part.center;
      middle = middle + part.center;
      ++children;
    }
    all.center = as_float(all.area > 0 ? (1 / all.area) * moment : (1 / children) * middle);
    for (std::size_t c = 0; c < TriangleTree::fan; ++c) {
      if (node.child[c] == TriangleTree::no_child) continue;
      const Moments& part = moments_of(node.child[c]);
      add_moments(all, part);
      all.radius = std::max(all.radius, reach(part, all.center, node, c));
      const std::array<double, 3> center = array_of(part.center);
      for (std::size_t axis = 0; axis < 3; ++axis) out.center[axis][c] = static_cast<float>(center[axis]);
      const std::array<double, WindingTree::terms> term = expansion(part);
      for (std::size_t k = 0; k < term.size(); ++k) out.term[k][c] = static_cast<float>(term[k]);
      out.from[c] = squared_from(part.radius, share);
      out.strictly_from[c] = squared_from(part.radius, strict_share);
    }
  }

  // How far from a place the triangles of a child are at most: within its ball, and within its box.
  static double reach(const Moments& part, Vector3 place, const TriangleTree::Node& node, std::size_t c) {
    const std::array<double, 3> at = array_of(place);
    double squared = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double far =
          std::max(std::abs(node.low[axis][c] - at[axis]), std::abs(node.high[axis][c] - at[axis]));
      squared += far * far;
    }
    return std::min(distance(part.center, place) + part.radius, std::sqrt(squared));
  }

  const Moments& moments_of(std::uint32_t child) const {
    return (child & TriangleTree::leaf_bit) != 0 ? leaf_moments_[child & ~TriangleTree::leaf_bit]
                                                 : moments_[child];
  }

  WindingTree& out_;
  const TriangleTree& tree_;
  std::span<const std::uint8_t> flipped_;
  std::vector<Moments> moments_, leaf_moments_;
};

// ---- solid angles

// A product of complex numbers, whose angles are added up, with the turns that they have made beyond (-pi,
// pi]: one, or four at a time.
template <class Doubles>
struct Angles {
  Doubles re, im, turns;
};

void add_angle(Angles<double>& sum, double re, double im) {
  const double product_re = sum.re * re - sum.im * im, product_im = sum.re * im + sum.im * re;
  if (sum.im >= 0 && im >= 0 && product_im < 0) ++sum.turns;
  if (sum.im < 0 && im < 0 && product_im >= 0) --sum.turns;
  sum.re = product_re;
  sum.im = product_im;
}
double winding_of(const Angles<double>& sum) {
  return sum.turns + 0.5 * std::numbers::inv_pi * portable::atan2(sum.im, sum.re);
}
template <class Doubles>
MEANDER_INLINE void add_angles(Angles<Doubles>& sum, const Doubles& re, const Doubles& im) {
  const auto zero = lanes::all<Doubles>(0.0), one = lanes::all<Doubles>(1.0);
  const Doubles product_re = sum.re * re - sum.im * im, product_im = sum.re * im + sum.im * re;
  const auto beyond = (sum.im >= zero) & (im >= zero) & (product_im < zero),
             below = (sum.im < zero) & (im < zero) & (product_im >= zero);
  sum.turns = sum.turns + lanes::select(beyond, one, zero) - lanes::select(below, one, zero);
  sum.re = product_re;
  sum.im = product_im;
}

// Adds half of the solid angles of four triangles (Van Oosterom, Strackee 1983). One in whose plane the point
// lies adds nothing.
template <class Doubles>
MEANDER_INLINE void add_triangles(const WindingTree::Leaf& leaf, std::size_t first, const double (&point)[3],
                                  Angles<Doubles>& sum) {
  Doubles v[9];
#pragma GCC unroll 9
  for (std::size_t k = 0; k < 9; ++k)
    v[k] = lanes::load<Doubles>(leaf.corner[k].data() + first) - point[k % 3];
  const Doubles a = lanes::root(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]),
                b = lanes::root(v[3] * v[3] + v[4] * v[4] + v[5] * v[5]),
                c = lanes::root(v[6] * v[6] + v[7] * v[7] + v[8] * v[8]);
  const Doubles ab = v[0] * v[3] + v[1] * v[4] + v[2] * v[5], bc = v[3] * v[6] + v[4] * v[7] + v[5] * v[8],
                ca = v[6] * v[0] + v[7] * v[1] + v[8] * v[2];
  const Doubles volume = v[0] * (v[4] * v[8] - v[5] * v[7]) + v[1] * (v[5] * v[6] - v[3] * v[8]) +
                         v[2] * (v[3] * v[7] - v[4] * v[6]);
  const Doubles base = a * b * c + ab * c + bc * a + ca * b;
  const auto flat = volume == lanes::all<Doubles>(0.0);
  add_angles(sum, lanes::select(flat, lanes::all<Doubles>(1.0), base), volume);
}

template <class Lanes>
MEANDER_INLINE double winding_in_lanes(const WindingTree& winding, Vector3 at_point, bool strictly) {
  using Floats = typename Lanes::Floats;
  using Doubles = typename Lanes::Doubles;
  const double point[3] = {at_point.x, at_point.y, at_point.z};
  const TriangleTree& tree = *winding.tree;
  const float x = static_cast<float>(point[0]), y = static_cast<float>(point[1]),
              z = static_cast<float>(point[2]);
  const auto none = lanes::all<Doubles>(0.0);
  auto far = lanes::all<Floats>(0.0f);
  Angles<Doubles> near = {lanes::all<Doubles>(1.0), none, none};
  std::uint32_t stack[TriangleTree::max_waiting];
  std::size_t waiting = 0;
  std::uint32_t at = 0;
  for (;;) {
    if ((at & TriangleTree::leaf_bit) == 0) {
      const WindingTree::Node& node = winding.nodes[at];
      const TriangleTree::Node& shape = tree.nodes[at];
      const Floats dx = lanes::load<Floats>(node.center[0].data()) - x,
                   dy = lanes::load<Floats>(node.center[1].data()) - y,
                   dz = lanes::load<Floats>(node.center[2].data()) - z,
                   from = lanes::load<Floats>((strictly ? node.strictly_from : node.from).data());
      const Floats squared = dx * dx + dy * dy + dz * dz;
      unsigned close = lanes::bits_of(from > squared);
      if (close != 0xFF) {
        Floats t[WindingTree::terms];
#pragma GCC unroll 19
        for (std::size_t k = 0; k < WindingTree::terms; ++k) t[k] = lanes::load<Floats>(node.term[k].data());
        const Floats per_squared = 1.0f / squared, per_cube = per_squared / lanes::root(squared);
        const Floats dipole = t[0] * dx + t[1] * dy + t[2] * dz;
        const Floats quadrupole =
            dx * (t[3] * dx + t[6] * dy + t[7] * dz) + dy * (t[4] * dy + t[8] * dz) + t[5] * dz * dz;
        const Floats zz = dz * dz;
        const Floats octupole =
            dx * (dx * (t[9] * dx + t[10] * dy + t[11] * dz) + dy * (t[12] * dy + t[13] * dz) + t[14] * zz) +
            dy * (dy * (t[15] * dy + t[16] * dz) + t[17] * zz) + t[18] * dz * zz;
        const Floats value = per_cube * (dipole + per_squared * (quadrupole + per_squared * octupole));
        far = far + lanes::select(from <= squared, value, lanes::all<Floats>(0.0f));
      }
      for (; close != 0; close &= close - 1) {
        const std::uint32_t child = shape.child[static_cast<std::size_t>(std::countr_zero(close))];
        if (child != TriangleTree::no_child) stack[waiting++] = child;
      }
    } else {
      const WindingTree::Leaf& leaf = winding.leaves[at & ~TriangleTree::leaf_bit];
      add_triangles(leaf, 0, point, near);
      add_triangles(leaf, 4, point, near);
      // Products of many would leave the range of double.
      const Doubles size = lanes::larger(near.re, none - near.re) + lanes::larger(near.im, none - near.im);
      near.re = near.re / size;
      near.im = near.im / size;
    }
    if (waiting == 0) break;
    at = stack[--waiting];
  }
  std::array<float, lanes::count> far_sums;
  std::array<double, 4> re, im, turns;
  lanes::store(far, far_sums.data());
  lanes::store(near.re, re.data());
  lanes::store(near.im, im.data());
  lanes::store(near.turns, turns.data());
  double sum = 0;
  for (const float value : far_sums) sum += static_cast<double>(value);
  Angles<double> all = {re[0], im[0], turns[0]};
  for (std::size_t k = 1; k < 4; ++k) {
    all.turns += turns[k];
    add_angle(all, re[k], im[k]);
  }
  return sum + winding_of(all);
}

double winding_by_pairs(const WindingTree& winding, Vector3 point, bool strictly) {
  return winding_in_lanes<lanes::Pairs>(winding, point, strictly);
}
MEANDER_TARGET("avx2") double winding_avx2(const WindingTree& winding, Vector3 point, bool strictly) {
  return winding_in_lanes<lanes::Wide>(winding, point, strictly);
}
// Both give the same.
double winding_at(const WindingTree& winding, Vector3 point, bool strictly, InstructionSet set) {
  return takes_avx2(set) ? winding_avx2(winding, point, strictly)
                         : winding_by_pairs(winding, point, strictly);
}

void wind_run(const WindingTree& winding, std::span<const double> points, std::span<const std::uint32_t> run,
              InstructionSet set, std::vector<double>& out) {
  for (const std::uint32_t i : run) {
    const Vector3 point{points[3 * std::size_t{i}], points[3 * std::size_t{i} + 1],
                        points[3 * std::size_t{i} + 2]};
    out[i] = winding_at(winding, point, false, set);
  }
}

// Visits half of the solid angle of each triangle as a complex number, but of those whose plane holds the
// point.
template <class Visit>
void visit_half_angles(std::span<const double> x, std::span<const double> y, std::span<const double> z,
                       std::span<const std::uint32_t> triangles, Vector3 point, const Visit& visit) {
  for (std::size_t t = 0; t + 2 < triangles.size(); t += 3) {
    std::array<Vector3, 3> v;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t c = triangles[t + k];
      v[k] = Vector3{x[c], y[c], z[c]} - point;
    }
    const double a = norm(v[0]), b = norm(v[1]), c = norm(v[2]);
    const double volume = dot(v[0], cross(v[1], v[2]));
    const double base = a * b * c + dot(v[0], v[1]) * c + dot(v[1], v[2]) * a + dot(v[2], v[0]) * b;
    if (volume != 0) visit(base, volume);
  }
}

}  // namespace

double exact_winding_number(std::span<const double> x, std::span<const double> y, std::span<const double> z,
                            std::span<const std::uint32_t> triangles, Vector3 point) {
  double sum = 0;
  visit_half_angles(x, y, z, triangles, point, [&](double re, double im) { sum += portable::atan2(im, re); });
  return 0.5 * std::numbers::inv_pi * sum;
}

double short_winding_number(std::span<const double> x, std::span<const double> y, std::span<const double> z,
                            std::span<const std::uint32_t> triangles, Vector3 point) {
  Angles<double> sum = {1, 0, 0};
  visit_half_angles(x, y, z, triangles, point, [&](double re, double im) {
    add_angle(sum, re, im);
    const double size = std::abs(sum.re) + std::abs(sum.im);
    sum.re /= size;
    sum.im /= size;
  });
  return winding_of(sum);
}

WindingTree build_winding_tree(const TriangleTree& tree, std::span<const std::uint8_t> flipped, double bound,
                               std::optional<double> strict_bound) {
  if (!flipped.empty() && flipped.size() != tree.count())
    throw std::invalid_argument("build_winding_tree: as many bytes as triangles");
  if (!(bound > 0 && strict_bound.value_or(bound) > 0))
    throw std::invalid_argument("build_winding_tree: the bound is above 0");
  WindingTree winding;
  winding.tree = &tree;
  winding.bound = bound;
  winding.strict_bound = strict_bound.value_or(bound);
  winding.nodes.resize(tree.nodes.size());
  winding.leaves.resize(tree.leaves.size());
  WindingBuilder(winding, flipped).build();
  return winding;
}

double winding_number(const WindingTree& winding, Vector3 point, bool strictly) {
  return winding_at(winding, point, strictly, InstructionSet::automatic);
}

std::vector<double> winding_numbers(const WindingTree& winding, std::span<const double> points,
                                    const CancelToken& cancel, InstructionSet set) {
  if (points.size() % 3 != 0) throw std::invalid_argument("winding_numbers: three coordinates a point");
  for (const double c : points)
    if (!(std::abs(c) <= farthest_point))
      throw std::invalid_argument("winding_numbers: points must be finite, and not too far from the mesh");
  const std::vector<std::uint32_t> order = order_along_curve(points);
  std::vector<double> out(points.size() / 3);
  parallel_blocks(out.size(), winding_block, [&](std::size_t begin, std::size_t end) {
    cancel.check();
    wind_run(winding, points, std::span(order).subspan(begin, end - begin), set, out);
  });
  return out;
}

}  // namespace meander
