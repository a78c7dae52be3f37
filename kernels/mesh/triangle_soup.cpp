#include "kernels/mesh/triangle_soup.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <string>

#include "kernels/core/parallel.h"
#include "kernels/mesh/box_frame.h"
#include "kernels/mesh/triangulate_polygon.h"
#include "kernels/mesh/weld_vertices.h"

namespace meander {

namespace {

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

struct UsablePolygons {
  std::vector<std::uint8_t> usable;  // 1 for those that can be used at all
  std::vector<std::uint8_t> used;    // 1 for every vertex of one
  // By block of polygons, where its triangles begin if all can be used; at last their number.
  std::vector<std::size_t> first_triangle;
  std::size_t triangles() const { return first_triangle.back(); }
};

constexpr std::size_t polygon_block = 65536;

void add_counts(const RepairCounts& more, RepairCounts& repairs) {
  for (std::size_t r = 0; r < repairs.counts.size(); ++r) repairs.counts[r] += more.counts[r];
}

// The polygons that cannot be used are counted by what is wrong with them, the first cause that holds.
UsablePolygons usable_polygons(const PolygonMesh& mesh, RepairCounts& repairs) {
  const std::size_t polygons = mesh.polygon_count(), vertices = mesh.vertex_count();
  const std::vector<std::uint8_t> finite = finite_vertices(mesh);
  const bool all_vertices_finite = finite.empty();
  UsablePolygons result{std::vector<std::uint8_t>(polygons, 0), std::vector<std::uint8_t>(vertices, 0),
                        std::vector<std::size_t>((polygons + polygon_block - 1) / polygon_block + 1, 0)};
  // By block of polygons.
  std::vector<RepairCounts> found(result.first_triangle.size() - 1);
  parallel_blocks(polygons, polygon_block, [&](std::size_t first, std::size_t last) {
    // Bytes may alias anything: without these the compiler reads every pointer again and again.
    const std::uint32_t *const polygon_begin = mesh.polygon_begin.data(), *const corners =
                                                                              mesh.corners.data();
    std::uint8_t *const usable = result.usable.data(), *const used = result.used.data();
    // Other threads may set the same one.
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

void measure_box(const PolygonMesh& mesh, std::span<const std::uint8_t> used, PreparedMesh& out) {
  struct Box {
    std::array<double, 3> low, high;
    std::uint32_t unused = 0;
    Box() {
      low.fill(std::numeric_limits<double>::infinity());
      high.fill(-std::numeric_limits<double>::infinity());
    }
  };
  std::vector<Box> boxes((used.size() + polygon_block - 1) / polygon_block);
  parallel_blocks(used.size(), polygon_block, [&](std::size_t begin, std::size_t end) {
    Box box;
    for (std::size_t v = begin; v < end; ++v) {
      if (!used[v]) {
        ++box.unused;
        continue;
      }
      const std::array<double, 3> at = {mesh.x[v], mesh.y[v], mesh.z[v]};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        box.low[axis] = std::min(box.low[axis], at[axis]);
        box.high[axis] = std::max(box.high[axis], at[axis]);
      }
    }
    boxes[begin / polygon_block] = box;
  });
  Box all;
  for (const Box& box : boxes) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      all.low[axis] = std::min(all.low[axis], box.low[axis]);
      all.high[axis] = std::max(all.high[axis], box.high[axis]);
    }
    all.unused += box.unused;
  }
  out.bbox = {all.low[0], all.low[1], all.low[2], all.high[0], all.high[1], all.high[2]};
  out.unreferenced_vertices = all.unused;
  const BoxFrame frame = box_frame(out.bbox);
  out.centre = frame.centre;
  out.unit = frame.unit;
  out.diagonal = frame.diagonal;
}

// Triangles of all usable polygons, without those that name a position twice.
TriangleSoup triangulate(const PolygonMesh& mesh, const UsablePolygons& polygons,
                         std::span<const std::uint32_t> welded, const PreparedMesh& frame,
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
    // Always written, and stays if all corners differ, which is the result.
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
      if (end - begin == 3) {
        if (!add(p, begin, begin + 1, begin + 2)) ++own[Repair::repeated_corners];
        continue;
      }
      slots.clear();
      for (std::uint32_t k = begin; k < end; ++k)
        if (slots.empty() || welded[mesh.corners[k]] != welded[mesh.corners[slots.back()]])
          slots.push_back(k);
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
  measure_box(mesh, polygons.used, out);
  cancel.check();
  TriangleSoup soup =
      triangulate(mesh, polygons,
                  weld ? weld_vertices(mesh, polygons.used, out.repairs) : every_vertex(mesh.vertex_count()),
                  out, out.repairs, cancel);
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
