#include "kernels/mesh/prepare_mesh.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <utility>

#include "kernels/core/exact_division.h"
#include "kernels/core/large_vector.h"
#include "kernels/core/parallel.h"
#include "kernels/mesh/box_frame.h"
#include "kernels/mesh/components.h"
#include "kernels/mesh/count_limit.h"
#include "kernels/mesh/half_edges.h"
#include "kernels/mesh/triangulate_polygon.h"
#include "kernels/mesh/weld_vertices.h"

namespace meander {

namespace {

constexpr double zero_area_ratio =
    1e-14;  // of diagonal^2: below it, rounding hides the difference between a surface and a curve

// The triangle soup of one file on its way to a PreparedMesh.
struct Soup {
  std::vector<std::uint32_t> triangles;    // 3 T welded vertices
  std::vector<std::uint32_t> corner_slot;  // 3 T
  std::vector<std::uint32_t> polygon;      // T

  void resize(std::size_t count) {
    resize_large(triangles, 3 * count);
    resize_large(corner_slot, 3 * count);
    resize_large(polygon, count);
  }
  // Moves triangles to an earlier place.
  void move(std::size_t from, std::size_t to, std::size_t count) {
    if (from == to || count == 0) return;
    std::copy_n(&triangles[3 * from], 3 * count, &triangles[3 * to]);
    std::copy_n(&corner_slot[3 * from], 3 * count, &corner_slot[3 * to]);
    std::copy_n(&polygon[from], count, &polygon[to]);
  }
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

// Working coordinates of file vertices.
class WorkingPositions {
 public:
  WorkingPositions(const PolygonMesh& mesh, const PreparedMesh& frame)
      : x_(mesh.x.data()),
        y_(mesh.y.data()),
        z_(mesh.z.data()),
        centre_(frame.centre),
        in_units_(frame.unit) {}
  Vector3 operator()(std::uint32_t vertex) const {
    return {in_units_(x_[vertex] - centre_.x), in_units_(y_[vertex] - centre_.y),
            in_units_(z_[vertex] - centre_.z)};
  }

 private:
  const double *x_, *y_, *z_;
  Vector3 centre_;
  ExactDivision in_units_;
};

// Triangles of all usable polygons, without those that name a position twice.
Soup triangulate(const PolygonMesh& mesh, const UsablePolygons& polygons,
                 std::span<const std::uint32_t> welded, const PreparedMesh& frame, RepairCounts& repairs) {
  Soup soup;
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
        if (triangulate_polygon(corners, local)) ++own[Repair::concave_polygons];
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

void check_counts(const PolygonMesh& mesh) {
  check_count(mesh.vertex_count(), "vertices");
  check_count(mesh.polygon_count(), "polygons");
  check_count(mesh.corners.size(), "corners");
}

std::vector<std::uint32_t> every_vertex(std::size_t count) {
  std::vector<std::uint32_t> vertex(count);
  std::iota(vertex.begin(), vertex.end(), 0u);
  return vertex;
}

// All triangles of the file, and the frame of its coordinates. `weld`: over vertices of different positions.
Soup read_soup(const PolygonMesh& mesh, bool weld, PreparedMesh& out, const CancelToken& cancel) {
  const UsablePolygons polygons = usable_polygons(mesh, out.repairs);
  if (polygons.triangles() == 0) fail_without_faces(mesh, out.repairs);
  measure_box(mesh, polygons.used, out);
  cancel.check();
  Soup soup =
      triangulate(mesh, polygons,
                  weld ? weld_vertices(mesh, polygons.used, out.repairs) : every_vertex(mesh.vertex_count()),
                  out, out.repairs);
  if (soup.polygon.empty()) fail_without_faces(mesh, out.repairs);
  if (soup.polygon.size() > no_index / 3)
    throw ItemError(Status::too_large, std::to_string(soup.polygon.size()) +
                                           " triangles are more than 32-bit half-edges can number");
  return soup;
}

std::vector<double> soup_areas(const PolygonMesh& mesh, const PreparedMesh& frame, const Soup& soup) {
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
void turn_round(Soup& soup, std::vector<std::uint32_t>& opposite, std::uint32_t t) {
  std::swap(soup.triangles[3 * t + 1], soup.triangles[3 * t + 2]);
  std::swap(soup.corner_slot[3 * t + 1], soup.corner_slot[3 * t + 2]);
  std::swap(opposite[3 * t], opposite[3 * t + 2]);
  for (std::uint32_t k = 0; k < 3; k += 2)
    if (opposite[3 * t + k] != no_index) opposite[opposite[3 * t + k]] = 3 * t + k;
}

// Breadth-first over the edges, as find_components: component number of every triangle, consistent winding,
// conflicting edges cut. The ends of those are perhaps no longer one fan.
std::uint32_t orient(Soup& soup, std::vector<std::uint32_t>& opposite, std::span<const double> area,
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
        const std::uint32_t other = opposite[h] == no_index ? h : opposite[h], neighbour = other / 3;
        const bool same_way = other != h && soup.triangles[h] == soup.triangles[other];
        const auto wanted = static_cast<std::uint8_t>(turned[t] ^ static_cast<std::uint8_t>(same_way));
        const bool is_new = component[neighbour] == no_index;
        queue[queued] = neighbour;
        queued += is_new;
        component[neighbour] = components;
        turned[neighbour] = is_new ? wanted : turned[neighbour];
        if (turned[neighbour] != wanted) [[unlikely]] {
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

// Components along the 3-D Hilbert curve of their centroids; new place of every old component number.
std::vector<std::uint32_t> order_components(const PolygonMesh& mesh, const PreparedMesh& frame,
                                            const Soup& soup, std::span<const double> area,
                                            std::span<const std::uint32_t> component,
                                            std::uint32_t components) {
  if (components == 1) return {0};
  std::vector<CentroidSum> sums(components);
  const WorkingPositions position(mesh, frame);
  const std::uint32_t* const corner = soup.triangles.data();
  std::uint32_t current = 0;
  CentroidSum sum;  // of the current component: most triangles belong to that of the one before
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
// are numbered in the order in which they first appear. The welded vertex of every fan is the result.
std::vector<std::uint32_t> split_vertices(std::span<const std::uint8_t> one_fan, PreparedMesh& out) {
  std::vector<std::uint32_t> number(one_fan.size(), no_index);  // of the vertex, or of its last fan
  std::uint32_t fans = 0, distinct = 0;
  if (std::find(one_fan.begin(), one_fan.end(), 0) == one_fan.end()) {
    std::vector<std::uint32_t> source(one_fan.size() + 1);
    // Always written, and stays if the vertex is new: as in find_components.
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

void place_vertices(const PolygonMesh& mesh, std::span<const std::uint32_t> source, PreparedMesh& out) {
  for (std::vector<double>* const c : {&out.x, &out.y, &out.z}) resize_large(*c, source.size());
  parallel_blocks(source.size(), sum_block, [&](std::size_t begin, std::size_t end) {
    const WorkingPositions position(mesh, out);
    for (std::size_t v = begin; v < end; ++v) {
      const Vector3 p = position(source[v]);
      out.x[v] = p.x;
      out.y[v] = p.y;
      out.z[v] = p.z;
    }
  });
}

// Those of the file, where they are finite.
void place_all_vertices(const PolygonMesh& mesh, PreparedMesh& out) {
  for (std::vector<double>* const c : {&out.x, &out.y, &out.z}) resize_large(*c, mesh.vertex_count());
  parallel_blocks(mesh.vertex_count(), sum_block, [&](std::size_t begin, std::size_t end) {
    const WorkingPositions position(mesh, out);
    const auto inside = [](double w) { return std::abs(w) <= 1 ? w : 0.0; };  // of no face, or not finite
    for (std::size_t v = begin; v < end; ++v) {
      const Vector3 p = position(static_cast<std::uint32_t>(v));
      out.x[v] = inside(p.x);
      out.y[v] = inside(p.y);
      out.z[v] = inside(p.z);
    }
  });
}

// Triangles that name a position twice by different vertices, as welding would find them.
void drop_repeated_positions(const PolygonMesh& mesh, Soup& soup, std::vector<double>& area,
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
      std::copy_n(&soup.triangles[3 * t], 3, &soup.triangles[3 * kept]);
      std::copy_n(&soup.corner_slot[3 * t], 3, &soup.corner_slot[3 * kept]);
      soup.polygon[kept] = soup.polygon[t];
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
  Soup soup = read_soup(mesh, true, out, cancel);
  std::vector<std::uint32_t> opposite, component;
  FanSurvey survey;
  out.repairs[Repair::split_edges] += pair_half_edges(soup.triangles, mesh.vertex_count(), opposite, &survey);
  std::vector<double> area;
  std::uint32_t components = 0;
  // Areas do not depend on components, nor the other way round where no face has to be turned.
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
      out.triangle_count(), [&] { describe_components(out); }, [&] { place_vertices(mesh, source, out); });
  return out;
}

PreparedMesh prepare_soup(const PolygonMesh& mesh, const CancelToken& cancel) {
  check_counts(mesh);
  PreparedMesh out;
  out.repairs = mesh.repairs;
  Soup soup = read_soup(mesh, false, out, cancel);
  std::vector<double> area = soup_areas(mesh, out, soup);
  drop_repeated_positions(mesh, soup, area, out);
  measure_area(area, out);
  cancel.check();
  out.triangles = std::move(soup.triangles);
  out.corner_slot = std::move(soup.corner_slot);
  out.polygon = std::move(soup.polygon);
  out.area = std::move(area);
  place_all_vertices(mesh, out);
  Component all;
  all.triangle_end = static_cast<std::uint32_t>(out.triangle_count());
  all.vertex_end = static_cast<std::uint32_t>(out.vertex_count());
  all.area = out.total_area;
  out.components = {all};
  return out;
}

}  // namespace meander
