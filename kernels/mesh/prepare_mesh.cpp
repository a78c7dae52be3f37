#include "kernels/mesh/prepare_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <string>
#include <utility>

#include "kernels/core/large_vector.h"
#include "kernels/core/parallel.h"
#include "kernels/mesh/components.h"
#include "kernels/mesh/count_limit.h"
#include "kernels/mesh/half_edges.h"
#include "kernels/mesh/triangle_soup.h"

namespace meander {

namespace {

// Share of diagonal^2 below which rounding hides the difference between a surface and a curve.
constexpr double zero_area_ratio = 1e-14;

void check_counts(const PolygonMesh& mesh) {
  check_count(mesh.vertex_count(), "vertices");
  check_count(mesh.polygon_count(), "polygons");
  check_count(mesh.corners.size(), "corners");
}

void measure_area(std::span<const double> area, PreparedMesh& out) {
  out.total_area = blocked_sum(area);
  const double relative_diagonal = out.diagonal / out.unit;
  if (!(out.total_area > zero_area_ratio * relative_diagonal * relative_diagonal))
    throw ItemError(Status::zero_area, "the " + std::to_string(area.size()) +
                                           " triangles have no area (at most 1e-14 of the diagonal squared)");
  if (!std::isfinite(file_area(out, out.total_area)))
    throw ItemError(Status::non_finite,
                    "too large: the area is more than double precision holds; scale the file down");
  out.repairs[Repair::zero_area_faces] +=
      static_cast<std::uint32_t>(std::count(area.begin(), area.end(), 0.0));
}

// Exchanges corners 1 and 2 of triangle t; half-edge k becomes half-edge 2 - k.
void turn_round(TriangleSoup& soup, std::vector<std::uint32_t>& opposite, std::uint32_t t) {
  std::swap(soup.triangles[3 * t + 1], soup.triangles[3 * t + 2]);
  std::swap(soup.corner_slot[3 * t + 1], soup.corner_slot[3 * t + 2]);
  std::swap(opposite[3 * t], opposite[3 * t + 2]);
  for (std::uint32_t k = 0; k < 3; k += 2)
    if (opposite[3 * t + k] != no_index) opposite[opposite[3 * t + k]] = 3 * t + k;
}

// Makes the winding consistent, breadth-first over the edges as in find_components, and cuts conflicting
// edges, whose ends are perhaps no longer one fan. Sets the component of every triangle and returns their
// number.
std::uint32_t orient(TriangleSoup& soup, std::vector<std::uint32_t>& opposite, std::span<const double> area,
                     FanSurvey& survey, std::vector<std::uint32_t>& component, RepairCounts& repairs,
                     const CancelToken& cancel) {
  const auto count = static_cast<std::uint32_t>(soup.polygon.size());
  component.assign(count, no_index);
  std::vector<std::uint8_t> turned(count, 0);
  std::vector<std::uint32_t> queue(count + 1);  // as in find_components
  std::size_t queued = 0;
  std::uint32_t components = 0;
  for (std::uint32_t seed = 0; queued < count; ++seed) {
    if (component[seed] != no_index) continue;
    const std::size_t first = queued;
    queue[queued++] = seed;
    component[seed] = components;
    std::array<double, 2> areas = {0, 0};  // kept, turned
    for (std::size_t at = first; at < queued; ++at) {
      if (at % 65536 == 0) cancel.check();
      const std::uint32_t t = queue[at];
      areas[turned[t]] += area[t];
      for (std::uint32_t h = 3 * t; h < 3 * t + 3; ++h) {
        const std::uint32_t other = opposite[h] == no_index ? h : opposite[h], neighbor = other / 3;
        const bool same_way = other != h && soup.triangles[h] == soup.triangles[other];
        const auto wanted = static_cast<std::uint8_t>(turned[t] ^ static_cast<std::uint8_t>(same_way));
        const bool is_new = component[neighbor] == no_index;
        queue[queued] = neighbor;
        queued += is_new;
        component[neighbor] = components;
        turned[neighbor] = is_new ? wanted : turned[neighbor];
        if (turned[neighbor] != wanted) [[unlikely]] {
          opposite[h] = opposite[other] = no_index;
          survey.one_fan[soup.triangles[h]] = survey.one_fan[soup.triangles[next_half_edge(h)]] = 0;
          ++repairs[Repair::cut_edges];
        }
      }
    }
    // The file's winding holds for the larger part of the area.
    const auto to_turn = static_cast<std::uint8_t>(areas[1] <= areas[0]);
    for (std::size_t at = first; at < queued; ++at)
      if (turned[queue[at]] == to_turn) {
        turned[queue[at]] = 2;
        ++repairs[Repair::flipped_faces];
      }
    ++components;
  }
  for (std::uint32_t t = 0; t < count; ++t)
    if (turned[t] == 2) turn_round(soup, opposite, t);
  return components;
}

// Orders components along the 3-D Hilbert curve of their centroids; returns the new place of every old
// number.
std::vector<std::uint32_t> order_components(const PolygonMesh& mesh, const PreparedMesh& frame,
                                            const TriangleSoup& soup, std::span<const double> area,
                                            std::span<const std::uint32_t> component,
                                            std::uint32_t components) {
  if (components == 1) return {0};
  std::vector<CentroidSum> sums(components);
  const WorkingPositions position(mesh, frame);
  const std::uint32_t* const corner = soup.triangles.data();
  std::uint32_t current = 0;
  // The sum of the current component: most triangles belong to that of the triangle before.
  CentroidSum sum;
  for (std::size_t t = 0; t < component.size(); ++t) {
    if (component[t] != current) {
      sums[current] = sum;
      current = component[t];
      sum = sums[current];
    }
    sum.add(area[t], (1.0 / 3) * (position(corner[3 * t]) + position(corner[3 * t + 1]) +
                                  position(corner[3 * t + 2])));
  }
  sums[current] = sum;
  return places_along_curve(sums);
}

// Groups triangles by component (file order inside) and renumbers half-edges to match.
void sort_by_component(TriangleSoup& soup, std::vector<std::uint32_t>& opposite, std::vector<double>& area,
                       std::span<const std::uint32_t> component, std::span<const std::uint32_t> place,
                       PreparedMesh& out) {
  const std::size_t count = component.size(), components = place.size();
  out.components.assign(components, {});
  if (components == 1) {
    out.components[0].triangle_end = static_cast<std::uint32_t>(count);
    out.opposite = std::move(opposite);
    out.triangles = std::move(soup.triangles);
    out.corner_slot = std::move(soup.corner_slot);
    out.polygon = std::move(soup.polygon);
    out.area = std::move(area);
    return;
  }
  std::vector<std::uint32_t> begin(components + 1, 0);
  for (std::size_t t = 0; t < count; ++t) ++begin[place[component[t]] + 1];
  for (std::size_t c = 0; c < components; ++c) begin[c + 1] += begin[c];
  for (std::size_t c = 0; c < components; ++c) {
    out.components[c].triangle_begin = begin[c];
    out.components[c].triangle_end = begin[c + 1];
  }
  out.opposite.resize(3 * count);
  out.triangles.resize(3 * count);
  out.corner_slot.resize(3 * count);
  out.polygon.resize(count);
  out.area.resize(count);
  const auto move = [&](std::size_t t, std::size_t to, const auto& moved) {
    out.polygon[to] = soup.polygon[t];
    out.area[to] = area[t];
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t other = opposite[3 * t + k];
      out.opposite[3 * to + k] = other == no_index ? no_index : moved(other);
      out.triangles[3 * to + k] = soup.triangles[3 * t + k];
      out.corner_slot[3 * to + k] = soup.corner_slot[3 * t + k];
    }
  };
  if (std::is_sorted(component.begin(), component.end())) {
    // Every component moves as a whole.
    std::uint32_t to = 0;
    for (std::uint32_t t = 0; t < count; ++t, ++to) {
      if (t == 0 || component[t] != component[t - 1]) to = begin[place[component[t]]];
      const std::uint32_t shift = 3 * (to - t);  // modulo 2^32
      move(t, to, [&](std::uint32_t other) { return other + shift; });
    }
    return;
  }
  std::vector<std::uint32_t> moved_to(count);
  for (std::size_t t = 0; t < count; ++t) moved_to[t] = begin[place[component[t]]]++;
  for (std::size_t t = 0; t < count; ++t)
    move(t, moved_to[t], [&](std::uint32_t other) { return 3 * moved_to[other / 3] + other % 3; });
}

// Replaces welded vertices by one working vertex per fan, so that every vertex is a disk or a half-disk; fans
// are numbered in the order in which they first appear. Returns the welded vertex of every fan.
std::vector<std::uint32_t> split_vertices(std::span<const std::uint8_t> one_fan, PreparedMesh& out) {
  std::vector<std::uint32_t> number;  // of the vertex, or of its last fan
  assign_large(number, one_fan.size(), no_index);
  std::uint32_t fans = 0, distinct = 0;
  if (std::find(one_fan.begin(), one_fan.end(), 0) == one_fan.end()) {
    std::vector<std::uint32_t> source;
    resize_large(source, one_fan.size() + 1);
    // The entry is always written, and stays if the vertex is new, as in find_components.
    for (std::uint32_t& corner : out.triangles) {
      const std::uint32_t vertex = corner;
      source[fans] = vertex;
      corner = number[vertex] == no_index ? fans : number[vertex];
      fans += number[vertex] == no_index;
      number[vertex] = corner;
    }
    source.resize(fans);
    return source;
  }
  std::vector<std::uint32_t> source(out.triangles.size() + 1);
  std::vector<std::uint8_t> done(out.triangles.size(), 0);
  for (std::uint32_t h = 0; h < out.triangles.size(); ++h) {
    if (done[h]) continue;
    const std::uint32_t vertex = out.triangles[h];
    const bool is_new = number[vertex] == no_index;
    source[fans] = vertex;
    distinct += is_new;
    if (one_fan[vertex]) {
      number[vertex] = is_new ? fans : number[vertex];
      out.triangles[h] = number[vertex];
      fans += is_new;
    } else {
      number[vertex] = fans;
      for_fan(out.opposite, h, [&](std::uint32_t corner) {
        out.triangles[corner] = fans;
        return std::exchange(done[corner], 1) == 0;
      });
      ++fans;
    }
  }
  out.repairs[Repair::split_vertices] += fans - distinct;
  source.resize(fans);
  return source;
}

// Places working vertex v at coordinate(w) of each working coordinate w of the file vertex source(v).
template <class Source, class Coordinate>
void place_vertices(const PolygonMesh& mesh, std::size_t count, const Source& source,
                    const Coordinate& coordinate, PreparedMesh& out) {
  for (std::vector<double>* const c : {&out.x, &out.y, &out.z}) resize_large(*c, count);
  parallel_blocks(count, sum_block, [&](std::size_t begin, std::size_t end) {
    const WorkingPositions position(mesh, out);
    for (std::size_t v = begin; v < end; ++v) {
      const Vector3 p = position(source(v));
      out.x[v] = coordinate(p.x);
      out.y[v] = coordinate(p.y);
      out.z[v] = coordinate(p.z);
    }
  });
}

// Drops triangles that name a position twice by different vertices, as welding would.
void drop_repeated_positions(const PolygonMesh& mesh, TriangleSoup& soup, std::vector<double>& area,
                             PreparedMesh& out) {
  const auto same = [&](std::uint32_t a, std::uint32_t b) {
    return mesh.x[a] == mesh.x[b] && mesh.y[a] == mesh.y[b] && mesh.z[a] == mesh.z[b];
  };
  std::size_t kept = 0;
  std::uint32_t last_counted = no_index;
  for (std::size_t t = 0; t < area.size(); ++t) {
    const std::uint32_t* const corner = &soup.triangles[3 * t];
    if (area[t] == 0 &&
        (same(corner[0], corner[1]) || same(corner[1], corner[2]) || same(corner[2], corner[0]))) {
      out.repairs[Repair::repeated_corners] += soup.polygon[t] != last_counted;
      last_counted = soup.polygon[t];
      continue;
    }
    if (kept < t) {
      soup.move(t, kept, 1);
      area[kept] = area[t];
    }
    ++kept;
  }
  if (kept == area.size()) return;
  soup.resize(kept);
  area.resize(kept);
  if (kept == 0) fail_without_faces(mesh, out.repairs);
}

}  // namespace

PreparedMesh prepare_mesh(const PolygonMesh& mesh, const CancelToken& cancel) {
  check_counts(mesh);
  PreparedMesh out;
  out.repairs = mesh.repairs;
  TriangleSoup soup = read_soup(mesh, true, out, cancel);
  std::vector<std::uint32_t> opposite, component;
  FanSurvey survey;
  out.repairs[Repair::split_edges] += pair_half_edges(soup.triangles, mesh.vertex_count(), opposite, &survey);
  std::vector<double> area;
  std::uint32_t components = 0;
  // Areas do not depend on components, and components not on areas where no face has to be turned.
  parallel_both(
      soup.polygon.size(),
      [&] {
        if (survey.consistent) components = find_components(opposite, component, cancel);
      },
      [&] { area = soup_areas(mesh, out, soup); });
  measure_area(area, out);
  cancel.check();
  if (!survey.consistent) components = orient(soup, opposite, area, survey, component, out.repairs, cancel);
  const std::vector<std::uint32_t> place = order_components(mesh, out, soup, area, component, components);
  sort_by_component(soup, opposite, area, component, place, out);
  soup = {};
  opposite = {};
  component = {};
  area = {};
  cancel.check();
  const std::vector<std::uint32_t> source = split_vertices(survey.one_fan, out);
  // Components are described by numbers alone.
  parallel_both(
      out.triangle_count(), [&] { describe_components(out); },
      [&] {
        place_vertices(
            mesh, source.size(), [&](std::size_t v) { return source[v]; }, [](double w) { return w; }, out);
      });
  return out;
}

PreparedMesh prepare_soup(const PolygonMesh& mesh, const CancelToken& cancel) {
  check_counts(mesh);
  PreparedMesh out;
  out.repairs = mesh.repairs;
  TriangleSoup soup = read_soup(mesh, false, out, cancel);
  std::vector<double> area = soup_areas(mesh, out, soup);
  drop_repeated_positions(mesh, soup, area, out);
  measure_area(area, out);
  cancel.check();
  out.triangles = std::move(soup.triangles);
  out.corner_slot = std::move(soup.corner_slot);
  out.polygon = std::move(soup.polygon);
  out.area = std::move(area);
  // Vertices without a face may lie outside of the frame or not be finite.
  place_vertices(
      mesh, mesh.vertex_count(), [](std::size_t v) { return static_cast<std::uint32_t>(v); },
      [](double w) { return std::abs(w) <= 1 ? w : 0.0; }, out);
  Component all;
  all.triangle_end = static_cast<std::uint32_t>(out.triangle_count());
  all.vertex_end = static_cast<std::uint32_t>(out.vertex_count());
  all.area = out.total_area;
  out.components = {all};
  return out;
}

}  // namespace meander
