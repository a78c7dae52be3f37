#include "kernels/query/oriented_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <utility>

#include "kernels/core/large_vector.h"
#include "kernels/mesh/bounds_tree.h"
#include "kernels/mesh/weld_vertices.h"
#include "kernels/query/winding_number.h"

namespace meander {

namespace {

// What finding the components that lie in others may cost, about a second: a pair of boxes is one unit.
constexpr std::uint64_t max_work = std::uint64_t{1} << 27, triangle_work = 8, tree_work = 4096;
constexpr std::size_t probe_vertices = 8, large_component = 2048;
// Of area^1.5: the sphere has 0.094.
constexpr double min_cone_volume = 0.01;

// For every vertex the first at its position.
std::vector<std::uint32_t> first_at_position(const PreparedMesh& mesh) {
  PolygonMesh places;
  places.x = mesh.x;
  places.y = mesh.y;
  places.z = mesh.z;
  RepairCounts repairs;
  return weld_vertices(places, std::vector<std::uint8_t>(mesh.vertex_count(), 1), repairs);
}

// A side of a triangle, as the edge between two positions, the lower one first.
struct Side {
  std::uint32_t low, high, half_edge;
  std::int32_t direction;  // 1: from low to high
};

// The sides of the triangles, edge by edge.
std::vector<Side> sorted_sides(const PreparedMesh& mesh, std::span<const std::uint32_t> first) {
  std::vector<Side> sides;
  reserve_large(sides, mesh.triangles.size());
  for (std::uint32_t h = 0; h < mesh.triangles.size(); ++h) {
    const std::uint32_t a = first[mesh.triangles[h]], b = first[mesh.triangles[next_half_edge(h)]];
    if (a != b) sides.push_back({std::min(a, b), std::max(a, b), h, a < b ? 1 : -1});
  }
  std::sort(sides.begin(), sides.end(), [](const Side& s, const Side& t) {
    if (s.low != t.low) return s.low < t.low;
    return s.high != t.high ? s.high < t.high : s.half_edge < t.half_edge;
  });
  return sides;
}

std::vector<std::uint32_t> component_of_triangles(const PreparedMesh& mesh) {
  std::vector<std::uint32_t> component(mesh.triangle_count());
  for (std::uint32_t c = 0; c < mesh.components.size(); ++c)
    for (std::size_t t = mesh.components[c].triangle_begin; t < mesh.components[c].triangle_end; ++t)
      component[t] = c;
  return component;
}

// Calls visit(begin, end) for the runs of sides with the same edge, and the same component where
// `by_component`.
template <class Visit>
void for_each_edge(std::span<const Side> sides, std::span<const std::uint32_t> component, bool by_component,
                   const Visit& visit) {
  for (std::size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
    for (; end < sides.size() && sides[end].low == sides[begin].low && sides[end].high == sides[begin].high &&
           (!by_component || component[sides[end].half_edge / 3] == component[sides[begin].half_edge / 3]);
         ++end) {
    }
    visit(begin, end);
  }
}

std::array<Vector3, 3> corners_at(const PreparedMesh& mesh, std::size_t t) {
  const std::uint32_t* const corner = mesh.triangles.data() + 3 * t;
  return {mesh.position(corner[0]), mesh.position(corner[1]), mesh.position(corner[2])};
}

// Volume of the cones from a point to the triangles of a component.
double cone_volume(const PreparedMesh& mesh, const Component& component, Vector3 apex) {
  double volume = 0;
  for (std::size_t t = component.triangle_begin; t < component.triangle_end; ++t) {
    const auto [a, b, c] = corners_at(mesh, t);
    volume += dot(a - apex, cross(b - apex, c - apex));
  }
  return volume / 6;
}

// The middle of the sides that are open by themselves, weighted by length; of all triangles where none is.
Vector3 middle_of_boundary(const PreparedMesh& mesh, const Component& component) {
  Vector3 moment;
  double length = 0;
  for (std::uint32_t h = 3 * component.triangle_begin; h < 3 * component.triangle_end; ++h) {
    if (mesh.opposite[h] != no_index) continue;
    const Vector3 a = mesh.position(mesh.triangles[h]), b = mesh.position(mesh.triangles[next_half_edge(h)]);
    moment = moment + (0.5 * distance(a, b)) * (a + b);
    length += distance(a, b);
  }
  return length > 0 ? (1 / length) * moment : mesh.centroid(component.triangle_begin);
}

Vector3 middle_of_area(const PreparedMesh& mesh) {
  Vector3 moment;
  double area = 0;
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
    moment = moment + mesh.area[t] * mesh.centroid(t);
    area += mesh.area[t];
  }
  return area > 0 ? (1 / area) * moment : Vector3{};
}

// Whether an open component is to be turned over.
bool is_open_inward(const PreparedMesh& mesh, const Component& component, Vector3 middle) {
  const double own = cone_volume(mesh, component, middle_of_boundary(mesh, component));
  if (std::abs(own) > min_cone_volume * component.area * std::sqrt(component.area)) return own < 0;
  return cone_volume(mesh, component, middle) < 0;
}

struct Extent {
  Vector3 low, high;

  bool holds(const Extent& other) const {
    return low.x <= other.low.x && low.y <= other.low.y && low.z <= other.low.z && high.x >= other.high.x &&
           high.y >= other.high.y && high.z >= other.high.z;
  }
};

Extent extent_of(const PreparedMesh& mesh, const Component& component) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  Extent box{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};
  for (std::uint32_t v = component.vertex_begin; v < component.vertex_end; ++v) {
    const Vector3 p = mesh.position(v);
    box.low = {std::min(box.low.x, p.x), std::min(box.low.y, p.y), std::min(box.low.z, p.z)};
    box.high = {std::max(box.high.x, p.x), std::max(box.high.y, p.y), std::max(box.high.z, p.z)};
  }
  return box;
}

// Of one component alone.
struct OwnTree {
  TriangleTree tree;
  WindingTree winding;

  OwnTree(const PreparedMesh& mesh, std::span<const std::uint32_t> triangles)
      : tree(build_triangle_tree(mesh.x, mesh.y, mesh.z, triangles)),
        winding(build_winding_tree(tree, {}, 0.25)) {}
};

// Turns the closed components.
class Nesting {
 public:
  Nesting(const PreparedMesh& mesh, OrientedSurface& out) : mesh_(mesh), out_(out) {
    const std::size_t count = mesh.components.size();
    trees_.resize(count);
    volume_.assign(count, 0);
    extents_.resize(count);
    for (std::uint32_t c = 0; c < count; ++c) {
      if (out.closed[c] == 0) continue;
      extents_[c] = extent_of(mesh, mesh.components[c]);
      volume_[c] = cone_volume(mesh, mesh.components[c], 0.5 * (extents_[c].low + extents_[c].high));
      if (volume_[c] != 0) solids_.push_back(c);
    }
    // Those that hold others come before them.
    std::sort(solids_.begin(), solids_.end(), [&](std::uint32_t a, std::uint32_t b) {
      const double of_a = std::abs(volume_[a]), of_b = std::abs(volume_[b]);
      return of_a != of_b ? of_a > of_b : a < b;
    });
  }

  void turn() {
    if (solids_.empty()) return;
    std::vector<double> low, high;
    std::vector<std::uint32_t> rank(mesh_.components.size(), 0);
    for (std::uint32_t i = 0; i < solids_.size(); ++i) {
      const Extent& box = extents_[solids_[i]];
      low.insert(low.end(), {box.low.x, box.low.y, box.low.z});
      high.insert(high.end(), {box.high.x, box.high.y, box.high.z});
    }
    const BoundsTree tree = build_bounds_tree(low, high);
    std::vector<int> sense(solids_.size(), 1);  // of the volume, once turned
    std::vector<std::uint32_t> holders;
    for (std::uint32_t i = 0; i < solids_.size(); ++i) {
      const std::uint32_t c = solids_[i];
      holders.clear();
      visit_near(tree, low.data() + 3 * std::size_t{i}, low.data() + 3 * std::size_t{i},
                 [&](std::uint32_t j) {
                   if (!spend(1)) return false;
                   if (j < i && extents_[solids_[j]].holds(extents_[c])) holders.push_back(j);
                   return true;
                 });
      // The smallest first.
      std::sort(holders.begin(), holders.end(), std::greater<>());
      for (const std::uint32_t j : holders) {
        if (!lies_in(c, solids_[j])) continue;
        if ((volume_[c] > 0) != (volume_[solids_[j]] > 0)) sense[i] = -sense[j];
        break;
      }
      if ((volume_[c] > 0) != (sense[i] > 0)) flip(c);
    }
  }

 private:
  bool spend(std::uint64_t work) {
    if (work > work_left_) out_.nested = false;
    work_left_ -= std::min(work, work_left_);
    return out_.nested;
  }

  bool lies_in(std::uint32_t inner, std::uint32_t outer) {
    const Component &of = mesh_.components[inner], &around = mesh_.components[outer];
    const std::size_t vertices = of.vertex_end - of.vertex_begin, probes = std::min(vertices, probe_vertices);
    const std::size_t triangles = around.triangle_end - around.triangle_begin;
    const bool by_tree = triangles > large_component;
    if (!spend(probes * (by_tree ? tree_work : triangle_work * triangles))) return false;
    const std::span<const std::uint32_t> own =
        std::span(mesh_.triangles).subspan(3 * std::size_t{around.triangle_begin}, 3 * triangles);
    if (by_tree && !trees_[outer]) trees_[outer] = std::make_unique<OwnTree>(mesh_, own);
    for (std::size_t k = 0; k < probes; ++k) {
      const Vector3 p = mesh_.position(of.vertex_begin + static_cast<std::uint32_t>(k * vertices / probes));
      const double winding = by_tree ? winding_number(trees_[outer]->winding, p)
                                     : exact_winding_number(mesh_.x, mesh_.y, mesh_.z, own, p);
      if (std::abs(winding) < 0.5) return false;
    }
    return true;
  }
  void flip(std::uint32_t c) {
    const Component& component = mesh_.components[c];
    std::fill(out_.flipped.begin() + component.triangle_begin, out_.flipped.begin() + component.triangle_end,
              std::uint8_t{1});
  }

  const PreparedMesh& mesh_;
  OrientedSurface& out_;
  std::vector<double> volume_;
  std::vector<Extent> extents_;
  std::vector<std::uint32_t> solids_;
  std::vector<std::unique_ptr<OwnTree>> trees_;  // by component, once it is asked for
  std::uint64_t work_left_ = max_work;
};

}  // namespace

OrientedSurface orient_outward(const PreparedMesh& mesh) {
  OrientedSurface out;
  out.flipped.assign(mesh.triangle_count(), 0);
  out.open_sides.assign(mesh.triangle_count(), 0);
  out.closed.assign(mesh.components.size(), 1);
  const std::vector<std::uint32_t> component_of = component_of_triangles(mesh);
  const std::vector<std::uint32_t> first = first_at_position(mesh);
  const std::vector<Side> sides = sorted_sides(mesh, first);
  for_each_edge(sides, component_of, true, [&](std::size_t begin, std::size_t end) {
    int sum = 0;
    for (std::size_t s = begin; s < end; ++s) sum += sides[s].direction;
    if (sum != 0) out.closed[component_of[sides[begin].half_edge / 3]] = 0;
  });
  Nesting(mesh, out).turn();
  const Vector3 middle = middle_of_area(mesh);
  for (std::size_t c = 0; c < mesh.components.size(); ++c) {
    const Component& component = mesh.components[c];
    if (out.closed[c] != 0 || !is_open_inward(mesh, component, middle)) continue;
    std::fill(out.flipped.begin() + component.triangle_begin, out.flipped.begin() + component.triangle_end,
              std::uint8_t{1});
  }
  std::vector<std::uint8_t> at_boundary(mesh.vertex_count(), 0);  // by the first at a position
  const auto passes = [&](std::size_t begin, std::size_t end) {
    int sum = 0;
    for (std::size_t s = begin; s < end; ++s)
      sum += out.flipped[sides[s].half_edge / 3] != 0 ? -sides[s].direction : sides[s].direction;
    return sum;
  };
  std::size_t open = 0;
  for_each_edge(sides, component_of, false,
                [&](std::size_t begin, std::size_t end) { open += passes(begin, end) != 0; });
  out.boundary.reserve(7 * open);
  for_each_edge(sides, component_of, false, [&](std::size_t begin, std::size_t end) {
    const int sum = passes(begin, end);
    if (sum == 0) return;
    out.open_edges += static_cast<std::uint32_t>(std::abs(sum));
    for (std::size_t s = begin; s < end; ++s)
      out.open_sides[sides[s].half_edge / 3] |= std::uint8_t(1u << sides[s].half_edge % 3);
    const Vector3 low = mesh.position(sides[begin].low), high = mesh.position(sides[begin].high);
    out.boundary.insert(out.boundary.end(),
                        {low.x, low.y, low.z, high.x, high.y, high.z, static_cast<double>(sum)});
    at_boundary[sides[begin].low] = at_boundary[sides[begin].high] = 1;
  });
  for (std::size_t h = 0; h < mesh.triangles.size() && out.open_edges > 0; ++h)
    if (at_boundary[first[mesh.triangles[h]]] != 0) out.open_sides[h / 3] |= std::uint8_t(8u << h % 3);
  return out;
}

std::uint32_t drop_doubled_faces(PolygonMesh& mesh) {
  const std::size_t count = mesh.polygon_count();
  std::vector<std::uint8_t> used(mesh.vertex_count(), 1);
  for (std::size_t v = 0; v < used.size(); ++v)
    if (!(std::isfinite(mesh.x[v]) && std::isfinite(mesh.y[v]) && std::isfinite(mesh.z[v]))) used[v] = 0;
  RepairCounts repairs;
  const std::vector<std::uint32_t> first = weld_vertices(mesh, used, repairs);
  // The positions of the corners of each polygon, ascending, and the polygons in order of these.
  std::vector<std::uint32_t> places(mesh.corners.size());
  for (std::size_t k = 0; k < places.size(); ++k)
    places[k] = mesh.corners[k] < first.size() ? first[mesh.corners[k]] : no_index;
  const auto corners = [&](std::uint32_t p) {
    return std::span(places).subspan(mesh.polygon_begin[p],
                                     mesh.polygon_begin[p + 1] - mesh.polygon_begin[p]);
  };
  for (std::uint32_t p = 0; p < count; ++p) {
    const std::span<std::uint32_t> own = corners(p);
    std::sort(own.begin(), own.end());
  }
  std::vector<std::uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    const std::span<const std::uint32_t> of_a = corners(a), of_b = corners(b);
    const auto [at_a, at_b] = std::mismatch(of_a.begin(), of_a.end(), of_b.begin(), of_b.end());
    if (at_a != of_a.end() && at_b != of_b.end()) return *at_a < *at_b;
    return of_a.size() != of_b.size() ? of_a.size() < of_b.size() : a < b;
  });
  std::vector<std::uint8_t> doubled(count, 0);
  std::uint32_t dropped = 0;
  for (std::size_t i = 1; i < count; ++i) {
    const std::span<const std::uint32_t> own = corners(order[i]), before = corners(order[i - 1]);
    if (own.size() < 3 || !std::equal(own.begin(), own.end(), before.begin(), before.end())) continue;
    doubled[order[i]] = 1;
    ++dropped;
  }
  if (dropped == 0) return 0;
  const auto keep = [&](std::vector<std::uint32_t>& of_corners) {
    if (of_corners.empty()) return;
    std::size_t kept = 0;
    for (std::uint32_t p = 0; p < count; ++p)
      if (doubled[p] == 0)
        for (std::uint32_t k = mesh.polygon_begin[p]; k < mesh.polygon_begin[p + 1]; ++k)
          of_corners[kept++] = of_corners[k];
    of_corners.resize(kept);
  };
  keep(mesh.corner_normals);
  keep(mesh.coordinates.corner);
  keep(mesh.corners);
  std::uint32_t kept = 0, begin = 0;
  for (std::uint32_t p = 0; p < count; ++p) {
    const std::uint32_t end = mesh.polygon_begin[p + 1];
    mesh.polygon_begin[p] = kept;
    if (doubled[p] == 0) kept += end - begin;
    begin = end;
  }
  mesh.polygon_begin[count] = kept;
  return dropped;
}

}  // namespace meander
