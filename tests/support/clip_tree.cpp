#include "support/clip_tree.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace meander::test {

namespace {

struct Point {
  double u, v;
};
using Polygon = std::vector<Point>;

struct Fragment {
  std::uint32_t triangle;
  Polygon polygon;
};

double area_of(const Polygon& polygon) {
  double twice = 0;
  for (std::size_t i = 2; i < polygon.size(); ++i)
    twice += (polygon[i - 1].u - polygon[0].u) * (polygon[i].v - polygon[0].v) -
             (polygon[i].u - polygon[0].u) * (polygon[i - 1].v - polygon[0].v);
  return std::abs(twice) / 2;
}

// The part of a polygon on one side of an axis-parallel line.
Polygon clip(const Polygon& polygon, bool along_u, double at, bool keep_above) {
  const auto inside = [&](Point p) {
    return keep_above ? (along_u ? p.u : p.v) >= at : (along_u ? p.u : p.v) <= at;
  };
  Polygon result;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Point a = polygon[i], b = polygon[(i + 1) % polygon.size()];
    if (inside(a)) result.push_back(a);
    if (inside(a) == inside(b)) continue;
    const double from = along_u ? a.u : a.v, to = along_u ? b.u : b.v;
    const double s = (at - from) / (to - from);
    Point cut = {a.u + s * (b.u - a.u), a.v + s * (b.v - a.v)};
    (along_u ? cut.u : cut.v) = at;
    result.push_back(cut);
  }
  return result;
}

struct Builder {
  const CurveTree& tree;
  std::vector<std::vector<Fragment>> leaves;

  std::size_t leaf_at(double u, double v) const {
    const std::uint64_t key = curve_key(tree.kind, u, v);
    return static_cast<std::size_t>(std::upper_bound(tree.key.begin(), tree.key.end(), key) -
                                    tree.key.begin()) -
           1;
  }

  void descend(double u, double v, double side, int depth, std::vector<Fragment> fragments) {
    if (fragments.empty()) return;
    const std::size_t leaf = leaf_at(u + side / 2, v + side / 2);
    if (tree.depth[leaf] <= depth) {
      leaves[leaf] = std::move(fragments);
      return;
    }
    const double half = side / 2;
    for (const bool right : {false, true})
      for (const bool upper : {false, true}) {
        std::vector<Fragment> part;
        for (const Fragment& f : fragments) {
          Polygon p = clip(clip(f.polygon, true, u + half, right), false, v + half, upper);
          if (p.size() >= 3 && area_of(p) > 0) part.push_back({f.triangle, std::move(p)});
        }
        descend(u + (right ? half : 0), v + (upper ? half : 0), half, depth + 1, std::move(part));
      }
  }
};

}  // namespace

double ClipTree::mass_in_leaf(std::size_t leaf, std::uint32_t t) const {
  const auto first = triangle.begin() + static_cast<std::ptrdiff_t>(begin[leaf]);
  const auto last = triangle.begin() + static_cast<std::ptrdiff_t>(begin[leaf + 1]);
  const auto found = std::lower_bound(first, last, t);
  return found != last && *found == t ? mass[static_cast<std::size_t>(found - triangle.begin())] : 0.0;
}

ClipTree clip_tree(const CurveTree& tree, const FlatChart& chart, std::span<const double> mass) {
  Builder builder{tree, std::vector<std::vector<Fragment>>(tree.leaf_count())};
  std::vector<double> area(mass.size());
  std::vector<Fragment> all;
  for (std::uint32_t t = 0; t < mass.size(); ++t) {
    Polygon polygon;
    Point centroid = {0, 0};
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t vertex = chart.cut.triangles[3 * t + k];
      polygon.push_back({chart.u[vertex], chart.v[vertex]});
      centroid = {centroid.u + chart.u[vertex] / 3, centroid.v + chart.v[vertex] / 3};
    }
    area[t] = area_of(polygon);
    if (area[t] > 0)
      all.push_back({t, std::move(polygon)});
    else
      builder.leaves[builder.leaf_at(centroid.u, centroid.v)].push_back({t, {}});
  }
  std::vector<std::vector<Fragment>> flat(tree.leaf_count());
  flat.swap(builder.leaves);
  builder.leaves.resize(tree.leaf_count());
  builder.descend(0, 0, 1, 0, std::move(all));

  ClipTree result;
  result.begin.push_back(0);
  for (std::size_t leaf = 0; leaf < tree.leaf_count(); ++leaf) {
    std::vector<Fragment> fragments = std::move(builder.leaves[leaf]);
    for (Fragment& f : flat[leaf]) fragments.push_back(std::move(f));
    std::sort(fragments.begin(), fragments.end(),
              [](const Fragment& a, const Fragment& b) { return a.triangle < b.triangle; });
    double sum = 0;
    for (const Fragment& f : fragments) {
      const double share = f.polygon.empty() ? 1.0 : area_of(f.polygon) / area[f.triangle];
      result.triangle.push_back(f.triangle);
      result.mass.push_back(mass[f.triangle] * share);
      sum += result.mass.back();
    }
    result.leaf_mass.push_back(sum);
    result.begin.push_back(result.triangle.size());
  }
  return result;
}

}  // namespace meander::test
