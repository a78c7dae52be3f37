#include "kernels/analyse/exact_geodesics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <queue>
#include <stdexcept>
#include <vector>

#include "kernels/core/parallel.h"
#include "kernels/solve/intrinsic_disk.h"

namespace meander {

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

struct PlanePoint {
  double x = 0, y = 0;
};
PlanePoint operator-(PlanePoint a, PlanePoint b) { return {a.x - b.x, a.y - b.y}; }
double cross(PlanePoint a, PlanePoint b) { return a.x * b.y - a.y * b.x; }
double dot(PlanePoint a, PlanePoint b) { return a.x * b.x + a.y * b.y; }
double length_of(PlanePoint a) { return std::sqrt(dot(a, a)); }

// The data that all sources share.
struct Geometry {
  const PreparedMesh& mesh;
  std::vector<double> length;                // 3 T
  std::vector<double> area;                  // T, from the lengths
  std::vector<std::uint8_t> sends;           // W: shortest paths may bend here
  std::vector<std::uint32_t> begin, corner;  // half-edges that start at vertex w: corner[begin[w]] ..

  explicit Geometry(const PreparedMesh& m) : mesh(m), sends(m.vertex_count(), 0) {
    const auto& triangles = mesh.triangles;
    std::vector<double> angle(mesh.vertex_count(), 0);
    begin.assign(mesh.vertex_count() + 1, 0);
    for (std::uint32_t h = 0; h < triangles.size(); ++h) {
      const std::uint32_t from = triangles[h], to = triangles[next_half_edge(h)];
      length.push_back(distance(mesh.position(std::min(from, to)), mesh.position(std::max(from, to))));
      ++begin[from + 1];
      if (mesh.opposite[h] == no_index) sends[from] = sends[to] = 1;
    }
    for (std::size_t t = 0; t < triangles.size(); t += 3)
      area.push_back(area_from_lengths(length[t], length[t + 1], length[t + 2]));
    for (std::size_t w = 0; w + 1 < begin.size(); ++w) begin[w + 1] += begin[w];
    corner.resize(triangles.size());
    std::vector<std::uint32_t> cursor(begin.begin(), begin.end() - 1);
    for (std::uint32_t h = 0; h < triangles.size(); ++h) {
      const double a = length[h], b = length[previous_half_edge(h)], c = length[next_half_edge(h)];
      angle[triangles[h]] += std::atan2(4 * area[h / 3], a * a + b * b - c * c);
      corner[cursor[triangles[h]]++] = h;
    }
    for (std::size_t w = 0; w < angle.size(); ++w)
      if (angle[w] > 2 * std::numbers::pi + 1e-11) sends[w] = 1;
  }
};

// Straight paths from one (unfolded) origin through the part [low, high] of half-edge h, into its triangle.
// Frame: h runs from (0, 0) along x, its triangle lies above, the origin below. Or, without a half-edge
// (no_index), the vertex `vertex` as an origin.
struct Window {
  double nearest = 0;  // any distance through it is at least this
  double before = 0;   // distance from the source to the origin
  double low = 0, high = 0;
  PlanePoint origin;
  std::uint32_t h = no_index, vertex = 0;
};
struct Later {
  bool operator()(const Window& a, const Window& b) const {
    if (a.nearest != b.nearest) return a.nearest > b.nearest;
    return a.h != b.h ? a.h > b.h : a.vertex > b.vertex;
  }
};

class Search {
 public:
  Search(const Geometry& geometry, double* reached, const CancelToken& cancel)
      : geometry_(geometry), mesh_(geometry.mesh), reached_(reached), cancel_(cancel) {}

  void run(std::uint32_t triangle, double weight1, double weight2) {
    const double weight[3] = {1 - weight1 - weight2, weight1, weight2};
    Vector3 p;
    for (std::uint32_t k = 0; k < 3; ++k)
      p = p + weight[k] * mesh_.position(mesh_.triangles[3 * triangle + k]);
    double straight[3];
    bool at_vertex = false;
    for (std::uint32_t k = 0; k < 3; ++k) {
      straight[k] = distance(p, mesh_.position(mesh_.triangles[3 * triangle + k]));
      if (straight[k] > 1e-14 * geometry_.length[3 * triangle + k]) continue;
      send_from(mesh_.triangles[3 * triangle + k], 0);
      at_vertex = true;
      break;
    }
    if (!at_vertex)
      for (std::uint32_t k = 0; k < 3; ++k) {
        reach(mesh_.triangles[3 * triangle + k], straight[k]);
        open(3 * triangle + k, straight[k], straight[(k + 1) % 3], 0);
      }
    for (std::size_t steps = 0; !queue_.empty(); ++steps) {
      if (steps % 65536 == 0) cancel_.check();
      const Window window = queue_.top();
      queue_.pop();
      if (window.h != no_index)
        spread(window);
      else if (window.before <= reached_[window.vertex])
        send_from(window.vertex, window.before);
    }
  }

 private:
  void reach(std::uint32_t vertex, double distance) {
    if (distance >= reached_[vertex]) return;
    reached_[vertex] = distance;
    if (!geometry_.sends[vertex]) return;
    Window origin;
    origin.nearest = origin.before = distance;
    origin.vertex = vertex;
    queue_.push(origin);
  }

  // From an origin at the given distances from the ends of half-edge h, in h's triangle, across all of h.
  void open(std::uint32_t h, double to_start, double to_end, double before) {
    const std::uint32_t other = mesh_.opposite[h];
    if (other == no_index) return;
    const double base = geometry_.length[h];
    Window window;
    window.before = before;
    window.high = base;
    window.h = other;  // runs the other way
    window.origin.x = 0.5 * (base + (to_end - to_start) * (to_end + to_start) / base);
    // An origin on the edge itself is put a hair behind it.
    window.origin.y = -std::max(2 * area_from_lengths(base, to_start, to_end) / base, 1e-13 * base);
    push(window);
  }

  void send_from(std::uint32_t vertex, double distance) {
    reached_[vertex] = distance;
    for (std::uint32_t i = geometry_.begin[vertex]; i < geometry_.begin[vertex + 1]; ++i) {
      const std::uint32_t h = geometry_.corner[i], across = next_half_edge(h), back = previous_half_edge(h);
      reach(mesh_.triangles[across], distance + geometry_.length[h]);
      reach(mesh_.triangles[back], distance + geometry_.length[back]);
      open(across, geometry_.length[h], geometry_.length[back], distance);
    }
  }

  // Whether the start or the end of its half-edge, by a path along the edge, beats every point of the window.
  bool beaten(const Window& window) const {
    const double by_low = window.before + length_of(window.origin - PlanePoint{window.low, 0});
    const double by_high = window.before + length_of(window.origin - PlanePoint{window.high, 0});
    const double slack = 1 + 1e-12;
    const std::uint32_t start = mesh_.triangles[window.h], end = mesh_.triangles[next_half_edge(window.h)];
    return by_high > slack * (reached_[start] + window.high) ||
           by_low > slack * (reached_[end] + (geometry_.length[window.h] - window.low));
  }

  void push(Window window) {
    const double size = geometry_.length[window.h];
    window.low = std::max(window.low, 0.0);
    window.high = std::min(window.high, size);
    if (!(window.high - window.low > 1e-13 * size) || beaten(window)) return;
    const double foot = std::clamp(window.origin.x, window.low, window.high);
    window.nearest = window.before + length_of(window.origin - PlanePoint{foot, 0});
    queue_.push(window);
  }

  void spread(const Window& window) {
    if (beaten(window)) return;
    const std::uint32_t h = window.h, next = next_half_edge(h), previous = previous_half_edge(h);
    const double base = geometry_.length[h], left = geometry_.length[previous],
                 right = geometry_.length[next];
    const PlanePoint apex{0.5 * (base + (left - right) * (left + right) / base),
                          2 * geometry_.area[h / 3] / base};
    const PlanePoint origin = window.origin, start{0, 0}, end{base, 0};
    const PlanePoint low_ray = PlanePoint{window.low, 0} - origin,
                     high_ray = PlanePoint{window.high, 0} - origin;
    const PlanePoint to_apex = apex - origin;
    const double by_low = cross(low_ray, to_apex), by_high = cross(high_ray, to_apex);
    const bool right_of_low = by_low <= 0, left_of_high = by_high >= 0;
    // An apex on the common ray of two windows must not fall between them.
    const double apex_distance = length_of(to_apex);
    if (by_low <= 1e-12 * length_of(low_ray) * apex_distance &&
        by_high >= -1e-12 * length_of(high_ray) * apex_distance)
      reach(mesh_.triangles[previous], window.before + apex_distance);
    if (right_of_low)  // some paths leave by the left side, from start to apex
      pass(window, previous, start, apex, left, low_ray, left_of_high ? nullptr : &high_ray, end, true);
    if (left_of_high)  // and by the right side, seen from the apex to the end
      pass(window, next, apex, end, right, high_ray, right_of_low ? nullptr : &low_ray, start, false);
  }

  // Pushes the window that leaves through half-edge `side`, which the neighbor sees from `from` to `to`:
  // from the outer ray to the inner one, or to the apex when there is none. `behind` is the triangle's vertex
  // off that side.
  void pass(const Window& window, std::uint32_t side, PlanePoint from, PlanePoint to, double size,
            PlanePoint outer, const PlanePoint* inner, PlanePoint behind, bool is_left) {
    const std::uint32_t other = mesh_.opposite[side];
    if (other == no_index) return;
    const PlanePoint axis{(to.x - from.x) / size, (to.y - from.y) / size};
    const PlanePoint relative = window.origin - from;
    const auto hit = [&](PlanePoint ray, double otherwise) {
      const double u = cross(relative, ray) / cross(axis, ray);
      return std::isfinite(u) ? u : otherwise;
    };
    Window child;
    child.before = window.before;
    child.h = other;
    child.low = is_left ? hit(outer, 0) : (inner == nullptr ? 0 : hit(*inner, 0));
    child.high = is_left ? (inner == nullptr ? size : hit(*inner, size)) : hit(outer, size);
    child.origin = {dot(relative, axis), std::min(cross(axis, relative), -1e-13 * size)};
    // The vertex behind, off the side of the paths, against the far end: it then beats all that lies between.
    const double far = std::clamp(is_left ? child.low : child.high, 0.0, size);
    const std::uint32_t behind_vertex = mesh_.triangles[previous_half_edge(side)];
    const PlanePoint far_point{from.x + far * axis.x, from.y + far * axis.y};
    const double by_window = window.before + length_of(far_point - window.origin);
    if (by_window > (1 + 1e-12) * (reached_[behind_vertex] + length_of(far_point - behind))) return;
    push(child);
  }

  const Geometry& geometry_;
  const PreparedMesh& mesh_;
  double* reached_;
  const CancelToken& cancel_;
  std::priority_queue<Window, std::vector<Window>, Later> queue_;
};

}  // namespace

void exact_geodesics(const PreparedMesh& mesh, PointsOnMesh sources, std::span<double> distance,
                     const CancelToken& cancel) {
  check_points_on_mesh(mesh, sources);
  const std::size_t width = mesh.vertex_count();
  if (distance.size() != sources.count() * width)
    throw std::invalid_argument("exact_geodesics: one distance per source and vertex is needed");
  const Geometry geometry(mesh);
  for (const Component& component : mesh.components) {
    const auto first = geometry.area.begin() + component.triangle_begin;
    const auto last = geometry.area.begin() + component.triangle_end;
    if (std::all_of(first, last, [](double a) { return a > 0; })) continue;
    for (const std::uint32_t t : sources.triangle)
      if (t >= component.triangle_begin && t < component.triangle_end)
        throw std::invalid_argument("exact_geodesics: the component has a triangle of no area");
  }
  std::fill(distance.begin(), distance.end(), infinite);
  parallel_tasks(sources.count(), [&](std::size_t s) {
    double* reached = distance.data() + s * width;
    Search(geometry, reached, cancel)
        .run(sources.triangle[s], sources.barycentric[2 * s], sources.barycentric[2 * s + 1]);
    for (std::size_t w = 0; w < width; ++w) reached[w] *= mesh.unit;
  });
}

}  // namespace meander
