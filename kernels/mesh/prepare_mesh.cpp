#include "kernels/mesh/prepare_mesh.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <string>

#include "kernels/core/exact_division.h"
#include "kernels/core/parallel.h"
#include "kernels/mesh/box_frame.h"
#include "kernels/mesh/components.h"
#include "kernels/mesh/count_limit.h"
#include "kernels/mesh/half_edges.h"
#include "kernels/mesh/triangulate_polygon.h"

namespace meander {

namespace {

constexpr double zero_area_ratio =
    1e-14;  // of diagonal^2: below it, rounding hides the difference between a surface and a curve

// The triangle soup of one file on its way to a PreparedMesh.
struct Soup {
  std::vector<std::uint32_t> triangles;    // 3 T welded vertices
  std::vector<std::uint32_t> corner_slot;  // 3 T
  std::vector<std::uint32_t> polygon;      // T
};

// Vertices with a finite position. Empty when all vertices are finite, as in most files.
std::vector<std::uint8_t> finite_vertices(const PolygonMesh& mesh) {
  const std::size_t vertices = mesh.vertex_count();
  const auto finite = [&](std::size_t v) {
    return std::isfinite(mesh.x[v]) && std::isfinite(mesh.y[v]) && std::isfinite(mesh.z[v]);
  };
  std::size_t first_bad = 0;
  while (first_bad < vertices && finite(first_bad)) ++first_bad;
  std::vector<std::uint8_t> result;
  if (first_bad == vertices) return result;
  result.resize(vertices);
  for (std::size_t v = 0; v < vertices; ++v) result[v] = finite(v);
  return result;
}

// Which polygons can be used at all; the others are counted by what is wrong with them, the first cause that
// holds. used: 1 for every vertex of a usable polygon.
std::vector<std::uint8_t> usable_polygons(const PolygonMesh& mesh, std::vector<std::uint8_t>& used,
                                          RepairCounts& repairs) {
  const std::size_t polygons = mesh.polygon_count(), vertices = mesh.vertex_count();
  const std::vector<std::uint8_t> finite = finite_vertices(mesh);
  std::vector<std::uint8_t> usable(polygons, 0);
  used.assign(vertices, 0);
  for (std::size_t p = 0; p < polygons; ++p) {
    const std::uint32_t begin = mesh.polygon_begin[p], end = mesh.polygon_begin[p + 1];
    if (end - begin < 3) {
      ++repairs[Repair::short_faces];
      continue;
    }
    std::uint32_t largest = 0;
    for (std::uint32_t k = begin; k < end; ++k) largest = std::max(largest, mesh.corners[k]);
    if (largest >= vertices) {
      ++repairs[Repair::index_out_of_range];
      continue;
    }
    bool all_finite = true;
    if (!finite.empty())
      for (std::uint32_t k = begin; k < end; ++k) all_finite = all_finite && finite[mesh.corners[k]];
    if (!all_finite) {
      ++repairs[Repair::non_finite];
      continue;
    }
    usable[p] = 1;
    for (std::uint32_t k = begin; k < end; ++k) used[mesh.corners[k]] = 1;
  }
  return usable;
}

[[noreturn]] void fail_without_faces(const PolygonMesh& mesh, const RepairCounts& repairs) {
  const std::string of = " of " + std::to_string(mesh.polygon_count()) + " faces";
  if (mesh.polygon_count() == 0)
    throw ItemError(Status::empty,
                    "no face in the file (" + std::to_string(mesh.vertex_count()) + " vertices)");
  const std::uint32_t range = repairs[Repair::index_out_of_range], bad = repairs[Repair::non_finite];
  if (range >= bad && range > 0)
    throw ItemError(Status::index_out_of_range,
                    "no usable face: " + std::to_string(range) + of + " name a vertex that is not there");
  if (bad > 0)
    throw ItemError(Status::non_finite,
                    "no usable face: " + std::to_string(bad) + of + " have a NaN or infinite corner");
  if (repairs[Repair::repeated_corners] > 0)
    throw ItemError(Status::zero_area,
                    "no usable face: " + std::to_string(repairs[Repair::repeated_corners]) + of +
                        " have fewer than three different positions");
  throw ItemError(Status::empty, "no usable face: all " + std::to_string(mesh.polygon_count()) +
                                     " have fewer than three corners");
}

void measure_box(const PolygonMesh& mesh, std::span<const std::uint8_t> used, PreparedMesh& out) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  out.bbox = {infinity, infinity, infinity, -infinity, -infinity, -infinity};
  for (std::size_t v = 0; v < used.size(); ++v) {
    if (!used[v]) continue;
    const double at[3] = {mesh.x[v], mesh.y[v], mesh.z[v]};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      out.bbox[axis] = std::min(out.bbox[axis], at[axis]);
      out.bbox[axis + 3] = std::max(out.bbox[axis + 3], at[axis]);
    }
  }
  out.unreferenced_vertices = static_cast<std::uint32_t>(std::count(used.begin(), used.end(), 0));
  const BoxFrame frame = box_frame(out.bbox);
  out.centre = frame.centre;
  out.unit = frame.unit;
  out.diagonal = frame.diagonal;
}

// welded[v]: the lowest vertex with the bits of v's position, for used vertices; others keep no_index.
std::vector<std::uint32_t> weld(const PolygonMesh& mesh, std::span<const std::uint8_t> used,
                                RepairCounts& repairs) {
  std::vector<std::uint32_t> welded(mesh.vertex_count(), no_index);
  const std::size_t slots = std::bit_ceil(2 * mesh.vertex_count() + 2);
  std::vector<std::uint32_t> table(slots, no_index);
  const auto bits = [](double c) { return std::bit_cast<std::uint64_t>(c + 0.0); };  // -0 + 0 = 0
  for (std::uint32_t v = 0; v < welded.size(); ++v) {
    if (!used[v]) continue;
    std::uint64_t hash = bits(mesh.x[v]);
    hash = (hash ^ (hash >> 32)) * 0x9E3779B97F4A7C15u + bits(mesh.y[v]);
    hash = (hash ^ (hash >> 29)) * 0xBF58476D1CE4E5B9u + bits(mesh.z[v]);
    hash = (hash ^ (hash >> 32)) * 0x94D049BB133111EBu;
    std::size_t slot = (hash ^ (hash >> 31)) & (slots - 1);
    while (table[slot] != no_index) {
      const std::uint32_t other = table[slot];
      if (mesh.x[other] == mesh.x[v] && mesh.y[other] == mesh.y[v] && mesh.z[other] == mesh.z[v]) break;
      slot = (slot + 1) & (slots - 1);
    }
    if (table[slot] == no_index) {
      table[slot] = v;
    } else {
      ++repairs[Repair::welded_vertices];
    }
    welded[v] = table[slot];
  }
  return welded;
}

// Working coordinates of a file vertex.
Vector3 working_position(const PolygonMesh& mesh, const PreparedMesh& frame, std::uint32_t vertex) {
  const ExactDivision in_units(frame.unit);
  return {in_units(mesh.x[vertex] - frame.centre.x), in_units(mesh.y[vertex] - frame.centre.y),
          in_units(mesh.z[vertex] - frame.centre.z)};
}

// Triangles of all usable polygons, without those that name a position twice.
Soup triangulate(const PolygonMesh& mesh, std::span<const std::uint8_t> usable,
                 std::span<const std::uint32_t> welded, const PreparedMesh& frame, RepairCounts& repairs) {
  Soup soup;
  soup.triangles.reserve(mesh.corners.size());
  soup.corner_slot.reserve(mesh.corners.size());
  soup.polygon.reserve(mesh.polygon_count());
  std::vector<std::uint32_t> slots, local;
  std::vector<Vector3> corners;
  for (std::size_t p = 0; p < usable.size(); ++p) {
    if (!usable[p]) continue;
    const std::uint32_t begin = mesh.polygon_begin[p], end = mesh.polygon_begin[p + 1];
    if (end - begin == 3) {
      const std::uint32_t a = welded[mesh.corners[begin]], b = welded[mesh.corners[begin + 1]],
                          c = welded[mesh.corners[begin + 2]];
      if (a != b && b != c && c != a) {
        soup.triangles.insert(soup.triangles.end(), {a, b, c});
        soup.corner_slot.insert(soup.corner_slot.end(), {begin, begin + 1, begin + 2});
        soup.polygon.push_back(static_cast<std::uint32_t>(p));
      } else {
        ++repairs[Repair::repeated_corners];
      }
      continue;
    }
    slots.clear();
    for (std::uint32_t k = begin; k < end; ++k)
      if (slots.empty() || welded[mesh.corners[k]] != welded[mesh.corners[slots.back()]]) slots.push_back(k);
    while (slots.size() > 1 && welded[mesh.corners[slots.front()]] == welded[mesh.corners[slots.back()]])
      slots.pop_back();
    const bool shortened = slots.size() < end - begin;
    if (slots.size() < 3) {
      ++repairs[Repair::repeated_corners];
      continue;
    }
    local.clear();
    if (slots.size() == 3) {
      local = {0, 1, 2};
    } else {
      corners.clear();
      for (const std::uint32_t k : slots) corners.push_back(working_position(mesh, frame, mesh.corners[k]));
      if (triangulate_polygon(corners, local)) ++repairs[Repair::concave_polygons];
    }
    bool repeated = shortened;
    for (std::size_t t = 0; t < local.size(); t += 3) {
      std::uint32_t slot[3], vertex[3];
      for (std::size_t k = 0; k < 3; ++k) {
        slot[k] = slots[local[t + k]];
        vertex[k] = welded[mesh.corners[slot[k]]];
      }
      if (vertex[0] == vertex[1] || vertex[1] == vertex[2] || vertex[2] == vertex[0]) {
        repeated = true;
        continue;
      }
      soup.triangles.insert(soup.triangles.end(), vertex, vertex + 3);
      soup.corner_slot.insert(soup.corner_slot.end(), slot, slot + 3);
      soup.polygon.push_back(static_cast<std::uint32_t>(p));
    }
    if (repeated) ++repairs[Repair::repeated_corners];
  }
  return soup;
}

std::vector<double> soup_areas(const PolygonMesh& mesh, const PreparedMesh& frame, const Soup& soup) {
  std::vector<double> area(soup.polygon.size());
  parallel_blocks(area.size(), sum_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t)
      area[t] = triangle_area(working_position(mesh, frame, soup.triangles[3 * t]),
                              working_position(mesh, frame, soup.triangles[3 * t + 1]),
                              working_position(mesh, frame, soup.triangles[3 * t + 2]));
  });
  return area;
}

// Exchanges corners 1 and 2 of triangle t; half-edge k becomes half-edge 2 - k.
void turn_round(Soup& soup, std::vector<std::uint32_t>& opposite, std::uint32_t t) {
  std::swap(soup.triangles[3 * t + 1], soup.triangles[3 * t + 2]);
  std::swap(soup.corner_slot[3 * t + 1], soup.corner_slot[3 * t + 2]);
  std::swap(opposite[3 * t], opposite[3 * t + 2]);
  for (std::uint32_t k = 0; k < 3; k += 2)
    if (opposite[3 * t + k] != no_index) opposite[opposite[3 * t + k]] = 3 * t + k;
}

// Whether the two triangles at every edge run along it in opposite directions, as in most files.
bool consistently_wound(const Soup& soup, std::span<const std::uint32_t> opposite) {
  for (std::size_t h = 0; h < opposite.size(); ++h)
    if (opposite[h] != no_index && soup.triangles[h] == soup.triangles[opposite[h]]) return false;
  return true;
}

// Breadth-first over the edges: component number of every triangle, consistent winding, conflicting edges
// cut.
std::uint32_t orient(Soup& soup, std::vector<std::uint32_t>& opposite, std::span<const double> area,
                     std::vector<std::uint32_t>& component, RepairCounts& repairs,
                     const CancelToken& cancel) {
  if (consistently_wound(soup, opposite)) return find_components(opposite, component, cancel);
  const auto count = static_cast<std::uint32_t>(soup.polygon.size());
  component.assign(count, no_index);
  std::vector<std::uint8_t> turned(count, 0);
  std::vector<std::uint32_t> queue;
  queue.reserve(count);
  std::uint32_t components = 0;
  for (std::uint32_t seed = 0; seed < count; ++seed) {
    if (component[seed] != no_index) continue;
    const std::size_t first = queue.size();
    queue.push_back(seed);
    component[seed] = components;
    double kept_area = 0, turned_area = 0;
    for (std::size_t at = first; at < queue.size(); ++at) {
      if (at % 65536 == 0) cancel.check();
      const std::uint32_t t = queue[at];
      (turned[t] ? turned_area : kept_area) += area[t];
      for (std::uint32_t h = 3 * t; h < 3 * t + 3; ++h) {
        const std::uint32_t other = opposite[h];
        if (other == no_index) continue;
        const bool agrees = soup.triangles[h] != soup.triangles[other];  // the other side runs the other way
        const auto wanted = static_cast<std::uint8_t>(agrees ? turned[t] : !turned[t]);
        const std::uint32_t neighbour = other / 3;
        if (component[neighbour] == no_index) {
          component[neighbour] = components;
          turned[neighbour] = wanted;
          queue.push_back(neighbour);
        } else if (turned[neighbour] != wanted) {
          opposite[h] = opposite[other] = no_index;
          ++repairs[Repair::cut_edges];
        }
      }
    }
    // The file's winding holds for the larger part of the area.
    const auto to_turn = static_cast<std::uint8_t>(turned_area <= kept_area);
    for (std::size_t at = first; at < queue.size(); ++at)
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

// Components along the 3-D Hilbert curve of their centroids; new place of every old component number.
std::vector<std::uint32_t> order_components(const PolygonMesh& mesh, const PreparedMesh& frame,
                                            const Soup& soup, std::span<const double> area,
                                            std::span<const std::uint32_t> component,
                                            std::uint32_t components) {
  if (components == 1) return {0};
  std::vector<CentroidSum> sums(components);
  for (std::size_t t = 0; t < component.size(); ++t)
    sums[component[t]].add(area[t], (1.0 / 3) * (working_position(mesh, frame, soup.triangles[3 * t]) +
                                                 working_position(mesh, frame, soup.triangles[3 * t + 1]) +
                                                 working_position(mesh, frame, soup.triangles[3 * t + 2])));
  return places_along_curve(sums);
}

// Triangles grouped by component (file order inside), half-edges renumbered to match.
void sort_by_component(Soup& soup, std::vector<std::uint32_t>& opposite, std::vector<double>& area,
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
  std::vector<std::uint32_t> moved_to(count);
  for (std::size_t t = 0; t < count; ++t) moved_to[t] = begin[place[component[t]]]++;
  out.opposite.resize(3 * count);
  out.triangles.resize(3 * count);
  out.corner_slot.resize(3 * count);
  out.polygon.resize(count);
  out.area.resize(count);
  for (std::size_t t = 0; t < count; ++t) {
    const std::size_t to = moved_to[t];
    out.polygon[to] = soup.polygon[t];
    out.area[to] = area[t];
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t other = opposite[3 * t + k];
      out.opposite[3 * to + k] = other == no_index ? no_index : 3 * moved_to[other / 3] + other % 3;
      out.triangles[3 * to + k] = soup.triangles[3 * t + k];
      out.corner_slot[3 * to + k] = soup.corner_slot[3 * t + k];
    }
  }
}

// Replaces welded vertices by one working vertex per fan, so that every vertex is a disk or a half-disk.
void split_vertices(const PolygonMesh& mesh, PreparedMesh& out) {
  std::vector<std::uint32_t> fan;
  const std::uint32_t fans = number_fans(out.opposite, fan);
  out.x.resize(fans);
  out.y.resize(fans);
  out.z.resize(fans);
  std::vector<std::uint8_t> seen(mesh.vertex_count(), 0);
  std::uint32_t distinct = 0;
  std::uint32_t next = 0;
  for (std::size_t h = 0; h < fan.size(); ++h) {
    if (fan[h] != next) continue;  // fans are numbered in the order in which they first appear
    ++next;
    const std::uint32_t v = out.triangles[h];
    distinct += seen[v] == 0;
    seen[v] = 1;
    const Vector3 p = working_position(mesh, out, v);
    out.x[fan[h]] = p.x;
    out.y[fan[h]] = p.y;
    out.z[fan[h]] = p.z;
  }
  out.repairs[Repair::split_vertices] += fans - distinct;
  out.triangles = std::move(fan);
}

}  // namespace

PreparedMesh prepare_mesh(const PolygonMesh& mesh, const CancelToken& cancel) {
  check_count(mesh.vertex_count(), "vertices");
  check_count(mesh.polygon_count(), "polygons");
  check_count(mesh.corners.size(), "corners");
  PreparedMesh out;
  out.repairs = mesh.repairs;
  std::vector<std::uint8_t> used;
  const std::vector<std::uint8_t> usable = usable_polygons(mesh, used, out.repairs);
  if (std::find(usable.begin(), usable.end(), 1) == usable.end()) fail_without_faces(mesh, out.repairs);
  measure_box(mesh, used, out);
  cancel.check();

  const std::vector<std::uint32_t> welded = weld(mesh, used, out.repairs);
  Soup soup = triangulate(mesh, usable, welded, out, out.repairs);
  if (soup.polygon.empty()) fail_without_faces(mesh, out.repairs);
  if (soup.polygon.size() > no_index / 3)
    throw ItemError(Status::too_large, std::to_string(soup.polygon.size()) +
                                           " triangles are more than 32-bit half-edges can number");
  std::vector<double> area = soup_areas(mesh, out, soup);
  out.total_area = blocked_sum(area);
  const double relative_diagonal = out.diagonal / out.unit;
  if (!(out.total_area > zero_area_ratio * relative_diagonal * relative_diagonal))
    throw ItemError(Status::zero_area, "the " + std::to_string(soup.polygon.size()) +
                                           " triangles have no area (at most 1e-14 of the diagonal squared)");
  if (!std::isfinite(file_area(out, out.total_area)))
    throw ItemError(Status::non_finite,
                    "too large: the area is more than double precision holds; scale the file down");
  out.repairs[Repair::zero_area_faces] +=
      static_cast<std::uint32_t>(std::count(area.begin(), area.end(), 0.0));
  cancel.check();

  std::vector<std::uint32_t> opposite, component;
  out.repairs[Repair::split_edges] += pair_half_edges(soup.triangles, mesh.vertex_count(), opposite);
  const std::uint32_t components = orient(soup, opposite, area, component, out.repairs, cancel);
  const std::vector<std::uint32_t> place = order_components(mesh, out, soup, area, component, components);
  sort_by_component(soup, opposite, area, component, place, out);
  cancel.check();
  split_vertices(mesh, out);
  describe_components(out);
  return out;
}

}  // namespace meander
