#include "kernels/mesh/triangle_soup.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <string>
#include <utility>

#include "kernels/core/parallel.h"
#include "kernels/mesh/box_frame.h"
#include "kernels/mesh/triangulate_polygon.h"
#include "kernels/mesh/weld_vertices.h"

namespace meander {

namespace {

// Flags vertices with a finite position. Empty when all vertices are finite, as in most files.
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

struct UsablePolygons {
  std::vector<std::uint8_t> usable;  // 1 for usable polygons
  std::vector<std::uint8_t> used;    // 1 for every vertex of one
  // By block of polygons, where its triangles begin if all can be used; at the end their number.
  std::vector<std::size_t> first_triangle;
  std::size_t triangles() const { return first_triangle.back(); }
};

constexpr std::size_t polygon_block = 65536;

void add_counts(const RepairCounts& more, RepairCounts& repairs) {
  for (std::size_t r = 0; r < repairs.counts.size(); ++r) repairs.counts[r] += more.counts[r];
}

// Counts the unusable polygons by their first defect.
UsablePolygons usable_polygons(const PolygonMesh& mesh, RepairCounts& repairs) {
  const std::size_t polygons = mesh.polygon_count(), vertices = mesh.vertex_count();
  const std::vector<std::uint8_t> finite = finite_vertices(mesh);
  const bool all_vertices_finite = finite.empty();
  UsablePolygons result{std::vector<std::uint8_t>(polygons, 0), std::vector<std::uint8_t>(vertices, 0),
                        std::vector<std::size_t>((polygons + polygon_block - 1) / polygon_block + 1, 0)};
  // By block of polygons.
  std::vector<RepairCounts> found(result.first_triangle.size() - 1);
  parallel_blocks(polygons, polygon_block, [&](std::size_t first, std::size_t last) {
    // Bytes may alias anything: without these copies the compiler reads every pointer again and again.
    const std::uint32_t *const polygon_begin = mesh.polygon_begin.data(), *const corners =
                                                                              mesh.corners.data();
    std::uint8_t *const usable = result.usable.data(), *const used = result.used.data();
    // Other threads may set the same flag.
    const auto use = [used](std::uint32_t vertex) {
      std::atomic_ref(used[vertex]).store(1, std::memory_order_relaxed);
    };
    RepairCounts own;
    std::size_t triangles = 0;
    for (std::size_t p = first; p < last; ++p) {
      const std::uint32_t begin = polygon_begin[p], end = polygon_begin[p + 1];
      if (end - begin < 3) {
        ++own[Repair::short_faces];
        continue;
      }
      std::uint32_t largest = std::max({corners[begin], corners[begin + 1], corners[begin + 2]});
      for (std::uint32_t k = begin + 3; k < end; ++k) largest = std::max(largest, corners[k]);
      if (largest >= vertices) {
        ++own[Repair::index_out_of_range];
        continue;
      }
      bool all_finite = true;
      if (!all_vertices_finite)
        for (std::uint32_t k = begin; k < end; ++k) all_finite = all_finite && finite[corners[k]];
      if (!all_finite) {
        ++own[Repair::non_finite];
        continue;
      }
      usable[p] = 1;
      for (std::uint32_t k = begin; k < end; ++k) use(corners[k]);
      triangles += end - begin - 2;
    }
    found[first / polygon_block] = own;
    result.first_triangle[first / polygon_block + 1] = triangles;
  });
  for (std::size_t b = 0; b < found.size(); ++b) {
    add_counts(found[b], repairs);
    result.first_triangle[b + 1] += result.first_triangle[b];
  }
  return result;
}

// A box around points; empty by default.
struct Box {
  std::array<double, 3> low, high;

  Box() {
    low.fill(std::numeric_limits<double>::infinity());
    high.fill(-std::numeric_limits<double>::infinity());
  }
  void add(const std::array<double, 3>& at) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], at[axis]);
      high[axis] = std::max(high[axis], at[axis]);
    }
  }
  void add(const Box& other) {
    if (other.is_empty()) return;
    add(other.low);
    add(other.high);
  }
  bool is_empty() const { return low[0] > high[0]; }
  bool holds(const std::array<double, 3>& at) const {
    bool inside = true;
    for (std::size_t axis = 0; axis < 3; ++axis)
      inside = inside && low[axis] <= at[axis] && at[axis] <= high[axis];
    return inside;
  }
  friend bool operator==(const Box&, const Box&) = default;
};

std::array<double, 3> place_of(const PolygonMesh& mesh, std::uint32_t vertex) {
  return {mesh.x[vertex], mesh.y[vertex], mesh.z[vertex]};
}

constexpr std::size_t vertex_block = 4096;

// Boxes of the vertices that polygons use.
struct UsedBoxes {
  std::vector<Box> of_block;
  Box all;
};

UsedBoxes boxes_of_used(const PolygonMesh& mesh, std::span<const std::uint8_t> used, std::uint32_t& unused) {
  UsedBoxes boxes;
  boxes.of_block.resize((used.size() + vertex_block - 1) / vertex_block);
  std::vector<std::uint32_t> unused_of(boxes.of_block.size());
  parallel_blocks(used.size(), vertex_block, [&](std::size_t begin, std::size_t end) {
    Box box;
    std::uint32_t count = 0;
    for (std::size_t v = begin; v < end; ++v) {
      if (used[v])
        box.add(place_of(mesh, static_cast<std::uint32_t>(v)));
      else
        ++count;
    }
    boxes.of_block[begin / vertex_block] = box;
    unused_of[begin / vertex_block] = count;
  });
  for (const Box& box : boxes.of_block) boxes.all.add(box);
  unused = std::accumulate(unused_of.begin(), unused_of.end(), 0u);
  return boxes;
}

// Whether three vertices span an area that rounding of their coordinates could not make. A coordinate that is
// off by a unit in its last place moves the area by as much times the opposite side.
bool spans_area(const PolygonMesh& mesh, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  constexpr double last_places = 16 * std::numeric_limits<double>::epsilon();
  const std::array<std::array<double, 3>, 3> at = {place_of(mesh, a), place_of(mesh, b), place_of(mesh, c)};
  const auto side = [&](std::size_t from, std::size_t to) {
    return Vector3{at[to][0] - at[from][0], at[to][1] - at[from][1], at[to][2] - at[from][2]};
  };
  const auto largest_of = [](const auto& v) {
    return std::max({std::abs(v[0]), std::abs(v[1]), std::abs(v[2])});
  };
  std::array<Vector3, 3> opposite = {side(1, 2), side(2, 0), side(0, 1)};
  double largest = 0;
  for (const Vector3& s : opposite) largest = std::max(largest, largest_of(std::array{s.x, s.y, s.z}));
  if (!(largest > 0) || !std::isfinite(largest)) return false;
  double rounding = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    opposite[k] = {opposite[k].x / largest, opposite[k].y / largest, opposite[k].z / largest};
    rounding += largest_of(at[k]) / largest * norm(opposite[k]);
  }
  return norm(cross(opposite[1], opposite[2])) > last_places * rounding;
}

// Calls visit(a, b, c) for the triangles of the fan of a polygon until it returns true; returns whether it
// did.
template <class Visit>
bool any_of_fan(const PolygonMesh& mesh, std::uint32_t begin, std::uint32_t end, const Visit& visit) {
  for (std::uint32_t k = begin + 2; k < end; ++k)
    if (visit(mesh.corners[begin], mesh.corners[k - 1], mesh.corners[k])) return true;
  return false;
}

// The box of the polygons that have an area.
Box box_of_areas(const PolygonMesh& mesh, const UsablePolygons& polygons) {
  std::vector<Box> boxes(polygons.first_triangle.size() - 1);
  parallel_blocks(polygons.usable.size(), polygon_block, [&](std::size_t first, std::size_t last) {
    Box box;
    for (std::size_t p = first; p < last; ++p) {
      if (!polygons.usable[p]) continue;
      any_of_fan(mesh, mesh.polygon_begin[p], mesh.polygon_begin[p + 1],
                 [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
                   if (spans_area(mesh, a, b, c))
                     for (const std::uint32_t vertex : {a, b, c}) box.add(place_of(mesh, vertex));
                   return false;
                 });
    }
    boxes[first / polygon_block] = box;
  });
  Box all;
  for (const Box& box : boxes) all.add(box);
  return all;
}

// The first vertex at a side of the box: sides 0 to 2 are the low ones, 3 to 5 the high ones.
std::uint32_t vertex_at_side(const PolygonMesh& mesh, std::span<const std::uint8_t> used,
                             const UsedBoxes& boxes, std::size_t side) {
  const auto side_of = [side](const Box& box) { return (side < 3 ? box.low : box.high)[side % 3]; };
  const double wanted = side_of(boxes.all);
  const std::array<std::span<const double>, 3> values = {mesh.x, mesh.y, mesh.z};
  for (std::size_t b = 0; b < boxes.of_block.size(); ++b) {
    if (side_of(boxes.of_block[b]) != wanted) continue;
    const std::size_t end = std::min((b + 1) * vertex_block, used.size());
    for (std::size_t v = b * vertex_block; v < end; ++v)
      if (values[side % 3][v] == wanted && used[v]) return static_cast<std::uint32_t>(v);
  }
  return no_index;
}

// Whether a triangle with an area has this vertex. Most files name vertices nearly in their order, so the
// search goes outwards from where the vertex would be. O(C) at worst.
bool area_has_vertex(const PolygonMesh& mesh, const UsablePolygons& polygons, std::uint32_t vertex,
                     const CancelToken& cancel) {
  const auto has_area = [&](std::size_t p) {
    return polygons.usable[p] && any_of_fan(mesh, mesh.polygon_begin[p], mesh.polygon_begin[p + 1],
                                            [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
                                              return (a == vertex || b == vertex || c == vertex) &&
                                                     spans_area(mesh, a, b, c);
                                            });
  };
  constexpr std::size_t at_once = 512;
  const std::size_t blocks = (mesh.corners.size() + at_once - 1) / at_once;
  const std::size_t middle = blocks * vertex / mesh.vertex_count();
  // A polygon may name a vertex again and again: it is tested once in each direction.
  std::array<std::size_t, 2> tried = {no_index, no_index};
  for (std::size_t step = 0; step < 2 * blocks; ++step) {
    const std::size_t distance = (step + 1) / 2, forwards = step % 2;
    if (forwards ? distance >= blocks - middle : distance > middle) continue;
    const std::size_t block = forwards ? middle + distance : middle - distance;
    const std::size_t begin = block * at_once, end = std::min(begin + at_once, mesh.corners.size());
    const std::uint32_t* const corners = mesh.corners.data();
    std::uint32_t found = 0;
    for (std::size_t k = begin; k < end; ++k) found |= static_cast<std::uint32_t>(corners[k] == vertex);
    if (found == 0) continue;
    cancel.check();
    for (std::size_t k = begin; k < end; ++k) {
      if (corners[k] != vertex) continue;
      const auto after = std::upper_bound(mesh.polygon_begin.begin(), mesh.polygon_begin.end(), k);
      const auto p = static_cast<std::size_t>(after - mesh.polygon_begin.begin()) - 1;
      if (std::exchange(tried[forwards], p) != p && has_area(p)) return true;
    }
  }
  return false;
}

// Whether polygons with an area reach all six sides of the box of all polygons. They nearly always do, as the
// first vertex at each side shows. False does not mean the contrary.
bool areas_reach_sides(const PolygonMesh& mesh, const UsablePolygons& polygons, const UsedBoxes& boxes,
                       const CancelToken& cancel) {
  for (std::size_t side = 0; side < 6; ++side)
    if (!area_has_vertex(mesh, polygons, vertex_at_side(mesh, polygons.used, boxes, side), cancel))
      return false;
  return true;
}

// The box of the polygons that can be sampled. A polygon without an area may name a vertex far from all
// others, which bounds nothing. `trims`: whether there are vertices outside.
Box box_of_polygons(const PolygonMesh& mesh, const UsablePolygons& polygons, std::uint32_t& unused,
                    bool& trims, const CancelToken& cancel) {
  const UsedBoxes boxes = boxes_of_used(mesh, polygons.used, unused);
  trims = false;
  if (areas_reach_sides(mesh, polygons, boxes, cancel)) return boxes.all;
  const Box of_areas = box_of_areas(mesh, polygons);
  if (of_areas.is_empty() || of_areas == boxes.all) return boxes.all;
  trims = true;
  return of_areas;
}

void set_frame(const Box& box, PreparedMesh& out) {
  out.bbox = {box.low[0], box.low[1], box.low[2], box.high[0], box.high[1], box.high[2]};
  const BoxFrame frame = box_frame(out.bbox);
  out.center = frame.center;
  out.unit = frame.unit;
  out.diagonal = frame.diagonal;
}

// Makes the triangles of all usable polygons except those that name a position twice. within: null, or the
// box outside of which vertices of polygons without an area may lie; these are left out.
TriangleSoup triangulate(const PolygonMesh& mesh, const UsablePolygons& polygons,
                         std::span<const std::uint32_t> welded, const PreparedMesh& frame, const Box* within,
                         RepairCounts& repairs, const CancelToken& cancel) {
  TriangleSoup soup;
  soup.resize(polygons.triangles());
  // Blocks of polygons write where their triangles would be if all could be used.
  std::vector<std::size_t> written(polygons.first_triangle.size() - 1);
  std::vector<RepairCounts> found(written.size());
  parallel_blocks(polygons.usable.size(), polygon_block, [&](std::size_t first, std::size_t last) {
    RepairCounts own;
    const std::size_t own_begin = polygons.first_triangle[first / polygon_block];
    std::size_t count = own_begin;
    // The entry is always written, and stays if all corners differ, which is the result.
    const auto add = [&, triangles = soup.triangles.data(), corner_slot = soup.corner_slot.data(),
                      polygon = soup.polygon.data(), vertex_of = welded.data(),
                      corners = mesh.corners.data()](std::size_t p, std::uint32_t slot0, std::uint32_t slot1,
                                                     std::uint32_t slot2) {
      const std::uint32_t a = vertex_of[corners[slot0]], b = vertex_of[corners[slot1]],
                          c = vertex_of[corners[slot2]];
      const std::size_t to = count;
      triangles[3 * to] = a;
      triangles[3 * to + 1] = b;
      triangles[3 * to + 2] = c;
      corner_slot[3 * to] = slot0;
      corner_slot[3 * to + 1] = slot1;
      corner_slot[3 * to + 2] = slot2;
      polygon[to] = static_cast<std::uint32_t>(p);
      const bool differ = a != b && b != c && c != a;
      count = to + differ;
      return differ;
    };
    const WorkingPositions position(mesh, frame);
    std::vector<std::uint32_t> slots, local;
    std::vector<Vector3> corners;
    for (std::size_t p = first; p < last; ++p) {
      if (!polygons.usable[p]) continue;
      const std::uint32_t begin = mesh.polygon_begin[p], end = mesh.polygon_begin[p + 1];
      const auto is_outside = [&](std::uint32_t slot) {
        return within != nullptr && !within->holds(place_of(mesh, mesh.corners[slot]));
      };
      if (end - begin == 3) {
        const bool outside = is_outside(begin) || is_outside(begin + 1) || is_outside(begin + 2);
        const std::size_t before = count;
        if (!add(p, begin, begin + 1, begin + 2)) {
          ++own[Repair::repeated_corners];
        } else if (outside) {
          count = before;
          ++own[Repair::zero_area_faces];
        }
        continue;
      }
      slots.clear();
      for (std::uint32_t k = begin; k < end; ++k) {
        if (is_outside(k)) continue;
        if (slots.empty() || welded[mesh.corners[k]] != welded[mesh.corners[slots.back()]])
          slots.push_back(k);
      }
      while (slots.size() > 1 && welded[mesh.corners[slots.front()]] == welded[mesh.corners[slots.back()]])
        slots.pop_back();
      const bool shortened = slots.size() < end - begin;
      if (slots.size() < 3) {
        ++own[Repair::repeated_corners];
        continue;
      }
      local.clear();
      if (slots.size() == 3) {
        local = {0, 1, 2};
      } else {
        corners.clear();
        for (const std::uint32_t k : slots) corners.push_back(position(mesh.corners[k]));
        if (triangulate_polygon(corners, local, cancel)) ++own[Repair::concave_polygons];
      }
      bool repeated = shortened;
      for (std::size_t t = 0; t < local.size(); t += 3)
        repeated |= !add(p, slots[local[t]], slots[local[t + 1]], slots[local[t + 2]]);
      if (repeated) ++own[Repair::repeated_corners];
    }
    written[first / polygon_block] = count - own_begin;
    found[first / polygon_block] = own;
  });
  std::size_t count = 0;
  for (std::size_t b = 0; b < written.size(); ++b) {
    soup.move(polygons.first_triangle[b], count, written[b]);
    count += written[b];
    add_counts(found[b], repairs);
  }
  soup.resize(count);
  return soup;
}

std::vector<std::uint32_t> every_vertex(std::size_t count) {
  std::vector<std::uint32_t> vertex(count);
  std::iota(vertex.begin(), vertex.end(), 0u);
  return vertex;
}

}  // namespace

void fail_without_faces(const PolygonMesh& mesh, const RepairCounts& repairs) {
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

TriangleSoup read_soup(const PolygonMesh& mesh, bool weld, PreparedMesh& out, const CancelToken& cancel) {
  const UsablePolygons polygons = usable_polygons(mesh, out.repairs);
  if (polygons.triangles() == 0) fail_without_faces(mesh, out.repairs);
  bool trims = false;
  const Box box = box_of_polygons(mesh, polygons, out.unreferenced_vertices, trims, cancel);
  set_frame(box, out);
  cancel.check();
  TriangleSoup soup =
      triangulate(mesh, polygons,
                  weld ? weld_vertices(mesh, polygons.used, out.repairs) : every_vertex(mesh.vertex_count()),
                  out, trims ? &box : nullptr, out.repairs, cancel);
  if (soup.polygon.empty()) fail_without_faces(mesh, out.repairs);
  if (soup.polygon.size() > no_index / 3)
    throw ItemError(Status::too_large, std::to_string(soup.polygon.size()) +
                                           " triangles are more than 32-bit half-edges can number");
  return soup;
}

std::vector<double> soup_areas(const PolygonMesh& mesh, const PreparedMesh& frame, const TriangleSoup& soup) {
  std::vector<double> area;
  resize_large(area, soup.polygon.size());
  parallel_blocks(area.size(), sum_block, [&](std::size_t begin, std::size_t end) {
    const WorkingPositions position(mesh, frame);
    const std::uint32_t* const corner = soup.triangles.data();
    for (std::size_t t = begin; t < end; ++t)
      area[t] =
          triangle_area(position(corner[3 * t]), position(corner[3 * t + 1]), position(corner[3 * t + 2]));
  });
  return area;
}

}  // namespace meander
