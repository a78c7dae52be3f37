#include "kernels/query/sharp_edges.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <stdexcept>

#include "kernels/core/disjoint_sets.h"
#include "kernels/core/portable_angles.h"
#include "kernels/core/radix_sort.h"
#include "kernels/core/share_search.h"
#include "kernels/curve/curve_key.h"
#include "kernels/mesh/bounds_tree.h"

namespace meander {

namespace {

// Sines of angles below which two triangles lie in the same direction from an edge, and of triangles without
// area.
constexpr double same_direction = 1e-3, without_area = 1e-7;
// Bounds on what one vertex, one edge and one corner may cost.
constexpr std::size_t max_close = 64, max_directions = 32, max_choices = 32;

// A triangle at an edge of welded corners, the lower one first.
struct EdgeSide {
  std::uint32_t low, high, triangle, opposite;
};

// An edge that is sharp.
struct FoundEdge {
  std::uint32_t low, high;
  std::array<std::uint32_t, 2> triangle;
};

// The first of the vertices that are one.
std::vector<std::uint32_t> welded_corners(const PreparedMesh& mesh, double tolerance) {
  const std::size_t count = mesh.vertex_count();
  std::vector<double> places;
  places.reserve(3 * count);
  for (std::size_t v = 0; v < count; ++v) places.insert(places.end(), {mesh.x[v], mesh.y[v], mesh.z[v]});
  const BoundsTree tree = build_bounds_tree(places, places);
  DisjointSets sets(count);
  for (std::uint32_t v = 0; v < count; ++v) {
    std::array<double, 3> low, high;
    for (std::size_t k = 0; k < 3; ++k) {
      low[k] = places[3 * std::size_t{v} + k] - tolerance;
      high[k] = places[3 * std::size_t{v} + k] + tolerance;
    }
    std::size_t close = 0;
    visit_near(tree, low.data(), high.data(), [&](std::uint32_t other) {
      if (other >= v || distance(mesh.position(other), mesh.position(v)) > tolerance) return true;
      sets.join(other, v);
      return ++close < max_close;
    });
  }
  std::vector<std::uint32_t> first(count);
  for (std::uint32_t v = 0; v < count; ++v) first[v] = sets.find(v);
  return first;
}

std::vector<EdgeSide> edge_sides(const PreparedMesh& mesh, std::span<const std::uint32_t> first) {
  std::vector<EdgeSide> sides;
  for (std::uint32_t h = 0; h < mesh.triangles.size(); ++h) {
    const std::uint32_t a = first[mesh.triangles[h]], b = first[mesh.triangles[next_half_edge(h)]],
                        c = first[mesh.triangles[previous_half_edge(h)]];
    if (a != b && b != c && c != a) sides.push_back({std::min(a, b), std::max(a, b), h / 3, c});
  }
  std::sort(sides.begin(), sides.end(), [](const EdgeSide& s, const EdgeSide& t) {
    if (s.low != t.low) return s.low < t.low;
    return s.high != t.high ? s.high < t.high : s.triangle < t.triangle;
  });
  return sides;
}

// The directions, at right angles to an edge, in which triangles lie from it.
struct Directions {
  std::array<Vector3, max_directions> direction;
  std::array<std::uint32_t, max_directions> triangle;
  std::size_t count = 0;

  void add(Vector3 d, std::uint32_t of) {
    for (std::size_t i = 0; i < count; ++i)
      if (distance(direction[i], d) < same_direction) return;
    if (count == max_directions) return;
    direction[count] = d;
    triangle[count++] = of;
  }
};

Directions directions_at(const PreparedMesh& mesh, std::span<const EdgeSide> sides) {
  Directions found;
  const Vector3 start = mesh.position(sides[0].low), edge = mesh.position(sides[0].high) - start;
  const double length = norm(edge);
  if (!(length > 0)) return found;
  const Vector3 along = (1 / length) * edge;
  for (const EdgeSide& side : sides) {
    const Vector3 to = mesh.position(side.opposite) - start, aside = to - dot(to, along) * along;
    const double height = norm(aside);
    if (height > without_area * std::max(length, norm(to))) found.add((1 / height) * aside, side.triangle);
  }
  return found;
}

// Of the polygons of triangles.
class Classes {
 public:
  Classes(const PreparedMesh& mesh, std::span<const double> of_polygon)
      : mesh_(mesh), of_polygon_(of_polygon) {}

  bool differ(std::uint32_t triangle, std::uint32_t other) const {
    if (of_polygon_.empty()) return false;
    const double a = of_polygon_[mesh_.polygon[triangle]], b = of_polygon_[mesh_.polygon[other]];
    return !(a == b || (std::isnan(a) && std::isnan(b)));
  }

 private:
  const PreparedMesh& mesh_;
  std::span<const double> of_polygon_;
};

std::vector<FoundEdge> sharp_edges_of(const PreparedMesh& mesh, std::span<const std::uint32_t> first,
                                      const SharpEdgeParameters& parameters) {
  // Between the directions of two triangles in a plane the angle is 180 degrees.
  const double limit = -direction_of(parameters.angle * std::numbers::pi / 180).cosine;
  const std::vector<EdgeSide> sides = edge_sides(mesh, first);
  const Classes classes(mesh, parameters.classes);
  std::vector<FoundEdge> found;
  for (std::size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
    while (end < sides.size() && sides[end].low == sides[begin].low && sides[end].high == sides[begin].high)
      ++end;
    const Directions directions = directions_at(mesh, std::span(sides).subspan(begin, end - begin));
    if (directions.count == 1 && parameters.borders)
      found.push_back({sides[begin].low, sides[begin].high, {directions.triangle[0], no_index}});
    double sharpest = -2;
    FoundEdge edge{sides[begin].low, sides[begin].high, {no_index, no_index}};
    for (std::size_t i = 0; i < directions.count; ++i)
      for (std::size_t j = i + 1; j < directions.count; ++j)
        if (const double cosine = dot(directions.direction[i], directions.direction[j]); cosine > sharpest) {
          sharpest = cosine;
          edge.triangle = {directions.triangle[i], directions.triangle[j]};
        }
    if (directions.count > 2 ||
        (directions.count == 2 &&
         (sharpest >= limit || classes.differ(directions.triangle[0], directions.triangle[1]))))
      found.push_back(edge);
  }
  return found;
}

// Walks along the edges, each once.
class Walk {
 public:
  Walk(const PreparedMesh& mesh, const std::vector<FoundEdge>& edges, SharpEdges& out)
      : mesh_(mesh), edges_(edges), out_(out), taken_(edges.size(), 0) {
    // The edges at each vertex, as runs of one array.
    begin_.assign(mesh.vertex_count() + 1, 0);
    for (const FoundEdge& edge : edges) {
      ++begin_[edge.low + 1];
      ++begin_[edge.high + 1];
    }
    degree_.assign(begin_.begin() + 1, begin_.end());
    std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
    left_.assign(begin_.begin(), begin_.end() - 1);
    at_.resize(2 * edges.size());
    for (std::uint32_t e = 0; e < edges.size(); ++e) {
      at_[left_[edges[e].low]++] = e;
      at_[left_[edges[e].high]++] = e;
    }
  }

  void walk_all() {
    const std::vector<std::uint32_t> order = ends_along_curve();
    // One curve from each vertex where the number of edges left is odd, so that others may pass it.
    for (const std::uint32_t v : order)
      if (degree_[v] % 2 == 1) walk_from(v);
    for (const std::uint32_t v : order)
      while (degree_[v] > 0) walk_from(v);
    out_.curve_begin.push_back(static_cast<std::uint32_t>(out_.start.size()));
    out_.before.assign(1, 0);
    for (std::size_t e = 0; e < out_.count(); ++e)
      out_.before.push_back(out_.before.back() +
                            distance(mesh_.position(out_.start[e]), mesh_.position(out_.end[e])));
  }

 private:
  // The vertices with edges along the 3-D Hilbert curve.
  std::vector<std::uint32_t> ends_along_curve() const {
    std::vector<KeyIndex> keys, scratch;
    for (std::uint32_t v = 0; v < mesh_.vertex_count(); ++v)
      if (begin_[v + 1] > begin_[v]) keys.push_back({hilbert_key_3d(mesh_.position(v)), v});
    radix_sort(keys, scratch);
    std::vector<std::uint32_t> order;
    for (const KeyIndex& key : keys) order.push_back(key.index);
    return order;
  }

  void walk_from(std::uint32_t v) {
    out_.curve_begin.push_back(static_cast<std::uint32_t>(out_.start.size()));
    std::uint32_t at = v;
    for (std::uint32_t e = next_edge(v, {}); e != no_index;) {
      const std::uint32_t to = edges_[e].low == at ? edges_[e].high : edges_[e].low;
      taken_[e] = 1;
      --degree_[at];
      --degree_[to];
      out_.start.push_back(at);
      out_.end.push_back(to);
      out_.triangle.insert(out_.triangle.end(), edges_[e].triangle.begin(), edges_[e].triangle.end());
      const Vector3 along = mesh_.position(to) - mesh_.position(at);
      at = to;
      e = next_edge(at, along);
    }
  }

  // The straightest of the edges left, no_index where there is none. Those that are taken go.
  std::uint32_t next_edge(std::uint32_t v, Vector3 along) {
    std::uint32_t best = no_index;
    double straightest = 0;
    std::size_t seen = 0;
    for (std::uint32_t i = begin_[v]; i < left_[v] && seen < max_choices;) {
      const std::uint32_t e = at_[i];
      if (taken_[e] != 0) {
        at_[i] = at_[--left_[v]];
        continue;
      }
      const std::uint32_t to = edges_[e].low == v ? edges_[e].high : edges_[e].low;
      const Vector3 next = mesh_.position(to) - mesh_.position(v);
      const double straight = dot(along, next) / norm(next);
      if (best == no_index || straight > straightest || (straight == straightest && e < best)) {
        best = e;
        straightest = straight;
      }
      ++i;
      ++seen;
    }
    return best;
  }

  const PreparedMesh& mesh_;
  const std::vector<FoundEdge>& edges_;
  SharpEdges& out_;
  std::vector<std::uint8_t> taken_;
  std::vector<std::uint32_t> begin_, left_, at_, degree_;
};

}  // namespace

SharpEdges find_sharp_edges(const PreparedMesh& mesh, const SharpEdgeParameters& parameters) {
  if (!(parameters.angle > 0 && parameters.angle < 180))
    throw std::invalid_argument("find_sharp_edges: the angle is above 0 and below 180 degrees");
  if (!(parameters.tolerance >= 0 && parameters.tolerance <= 0.01))
    throw std::invalid_argument("find_sharp_edges: the tolerance is 0 to 0.01");
  for (const std::uint32_t polygon : mesh.polygon)
    if (!parameters.classes.empty() && polygon >= parameters.classes.size())
      throw std::invalid_argument("find_sharp_edges: a class for each polygon, or none");
  const std::vector<std::uint32_t> first =
      welded_corners(mesh, parameters.tolerance * mesh.diagonal / mesh.unit);
  const std::vector<FoundEdge> found = sharp_edges_of(mesh, first, parameters);
  SharpEdges out;
  Walk(mesh, found, out).walk_all();
  return out;
}

std::vector<EdgeEnd> sharp_corners(const PreparedMesh& mesh, const SharpEdges& edges, double angle) {
  const double limit = -direction_of(angle * std::numbers::pi / 180).cosine;
  struct End {
    std::uint32_t vertex, edge;
    bool is_start;
  };
  std::vector<End> ends;
  ends.reserve(2 * edges.count());
  for (std::uint32_t e = 0; e < edges.count(); ++e) {
    ends.push_back({edges.start[e], e, true});
    ends.push_back({edges.end[e], e, false});
  }
  std::sort(ends.begin(), ends.end(), [](const End& a, const End& b) {
    return a.vertex != b.vertex ? a.vertex < b.vertex : a.edge < b.edge;
  });
  const auto away = [&](const End& end) {
    const Vector3 along = mesh.position(edges.end[end.edge]) - mesh.position(edges.start[end.edge]);
    return ((end.is_start ? 1 : -1) / norm(along)) * along;
  };
  std::vector<KeyIndex> keys, scratch;
  for (std::uint32_t begin = 0, end = 0; begin < ends.size(); begin = end) {
    while (end < ends.size() && ends[end].vertex == ends[begin].vertex) ++end;
    if (end - begin != 2 || dot(away(ends[begin]), away(ends[begin + 1])) >= limit)
      keys.push_back({hilbert_key_3d(mesh.position(ends[begin].vertex)), begin});
  }
  radix_sort(keys, scratch);
  std::vector<EdgeEnd> corners;
  corners.reserve(keys.size());
  for (const KeyIndex& key : keys) corners.push_back({ends[key.index].edge, ends[key.index].is_start});
  return corners;
}

EdgePoints points_on_edges(const PreparedMesh& mesh, const SharpEdges& edges,
                           std::span<const double> shares) {
  EdgePoints out;
  if (!shares.empty() && !(edges.length() > 0))
    throw std::invalid_argument("points_on_edges: there is no edge to place points on");
  if (shares.empty()) return out;
  out.point.reserve(3 * shares.size());
  out.edge.reserve(shares.size());
  out.along.reserve(shares.size());
  const ShareSearch edge_at(std::span(edges.before).subspan(1));
  for (const double share : shares) {
    if (!(share >= 0 && share < 1))
      throw std::invalid_argument("points_on_edges: shares are at least 0, below 1");
    const double along = share * edges.length();
    const std::size_t e = edge_at(share);
    const double length = edges.before[e + 1] - edges.before[e];
    const double weight = length > 0 ? std::clamp((along - edges.before[e]) / length, 0.0, 1.0) : 0;
    const Vector3 from = mesh.position(edges.start[e]), to = mesh.position(edges.end[e]);
    const Vector3 point = from + weight * (to - from);
    for (const double x : {point.x, point.y, point.z}) out.point.push_back(x);
    out.edge.push_back(static_cast<std::uint32_t>(e));
    out.along.push_back(weight);
  }
  return out;
}

}  // namespace meander
