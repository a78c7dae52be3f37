#include "kernels/segment/segment_mesh.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "io/mesh/mesh_reader.h"
#include "kernels/core/parallel.h"
#include "kernels/core/random.h"
#include "kernels/curve/curve_key.h"
#include "kernels/cut/cut_to_disk.h"
#include "kernels/mesh/components.h"
#include "kernels/mesh/half_edges.h"
#include "kernels/mesh/prepare_mesh.h"
#include "support/catch.h"
#include "support/direction_field.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

PreparedMesh shared_mesh(const std::filesystem::path& path) {
  MeshFormat format{};
  REQUIRE(mesh_format_of(path, format));
  const FileBytes file(path);
  return prepare_mesh(read_mesh(file.bytes(), format));
}

std::vector<double> euclidean_lengths(const PreparedMesh& mesh) {
  return metric_edge_lengths(mesh, round_field(mesh));
}

// All postconditions of split_into_segments, from their definitions.
void check_split(const PreparedMesh& mesh, std::span<const std::uint32_t> label, const SegmentedMesh& split) {
  const PreparedMesh& out = split.mesh;
  const std::size_t count = mesh.triangle_count();
  REQUIRE(out.triangle_count() == count);
  std::vector<std::uint32_t> sorted = split.source_triangle;
  std::sort(sorted.begin(), sorted.end());
  for (std::uint32_t t = 0; t < count; ++t) REQUIRE(sorted[t] == t);

  std::uint32_t triangle = 0, vertex = 0;
  double area_sum = 0;
  std::uint64_t last_key = 0;
  for (std::size_t c = 0; c < out.components.size(); ++c) {
    const Component& component = out.components[c];
    REQUIRE(component.triangle_begin == triangle);
    REQUIRE(component.vertex_begin == vertex);
    triangle = component.triangle_end;
    vertex = component.vertex_end;
    std::set<std::uint32_t> labels, vertices;
    std::int64_t boundary = 0;
    double area = 0;
    CentroidSum sum;
    for (std::uint32_t t = component.triangle_begin; t < component.triangle_end; ++t) {
      const std::uint32_t from = split.source_triangle[t];
      if (t > component.triangle_begin) REQUIRE(from > split.source_triangle[t - 1]);
      labels.insert(label[from]);
      REQUIRE(from >= mesh.components[split.source_component[c]].triangle_begin);
      REQUIRE(from < mesh.components[split.source_component[c]].triangle_end);
      REQUIRE(out.area[t] == mesh.area[from]);
      REQUIRE(out.polygon[t] == mesh.polygon[from]);
      area += out.area[t];
      Vector3 middle;
      for (std::uint32_t k = 0; k < 3; ++k) {
        const std::uint32_t h = 3 * t + k, old = 3 * from + k, v = out.triangles[h];
        vertices.insert(v);
        REQUIRE(out.corner_slot[h] == mesh.corner_slot[old]);
        REQUIRE(split.source_vertex[v] == mesh.triangles[old]);
        REQUIRE(distance(out.position(v), mesh.position(mesh.triangles[old])) == 0);
        middle = middle + out.position(v);
        boundary += out.opposite[h] == no_index;
        const std::uint32_t across = mesh.opposite[old];
        if (across == no_index || label[across / 3] != label[from]) {
          REQUIRE(out.opposite[h] == no_index);
        } else {
          const std::uint32_t other = out.opposite[h];
          REQUIRE(out.opposite[other] == h);
          REQUIRE(3 * split.source_triangle[other / 3] + other % 3 == across);
          REQUIRE(out.triangles[other] == out.triangles[next_half_edge(h)]);
        }
      }
      sum.add(out.area[t], (1.0 / 3) * middle);
    }
    REQUIRE(labels.size() == 1);
    REQUIRE(vertices.size() == component.vertex_end - component.vertex_begin);
    REQUIRE(*vertices.begin() == component.vertex_begin);
    REQUIRE(*vertices.rbegin() + 1 == component.vertex_end);
    REQUIRE(component.area == area);
    area_sum += area;
    const std::int64_t faces = component.triangle_end - component.triangle_begin;
    const std::int64_t euler =
        static_cast<std::int64_t>(vertices.size()) - (3 * faces + boundary) / 2 + faces;
    REQUIRE(euler == 2 - 2 * std::int64_t{component.genus} - component.boundary_loops);
    const std::uint64_t key = hilbert_key_3d(sum.centroid());
    REQUIRE(key >= last_key);
    last_key = key;
  }
  REQUIRE(triangle == count);
  REQUIRE(vertex == out.vertex_count());
  std::vector<std::uint32_t> fan, part;
  REQUIRE(number_fans(out.opposite, fan) == out.vertex_count());  // every vertex one fan
  REQUIRE(fan == out.triangles);
  REQUIRE(find_components(out.opposite, part) == out.components.size());  // every component connected
  REQUIRE(area_sum == Approx(mesh.total_area).epsilon(1e-12));
  REQUIRE(out.total_area == mesh.total_area);
  REQUIRE(out.unit == mesh.unit);
  REQUIRE(out.bbox == mesh.bbox);
  REQUIRE(out.diagonal == mesh.diagonal);
  REQUIRE(distance(out.center, mesh.center) == 0);
  REQUIRE(out.repairs.counts == mesh.repairs.counts);
}

// Segments of a whole mesh, checked and cut to disks. Returns the Euler number of each summed up.
SegmentedMesh check_segments(const PreparedMesh& mesh, const TensorField& field, std::uint32_t count,
                             std::uint32_t min_triangles = 20) {
  const SegmentedMesh split = segment_mesh(mesh, field, {count, min_triangles, {}});
  std::vector<std::uint32_t> label(mesh.triangle_count());
  for (std::uint32_t c = 0; c < split.mesh.components.size(); ++c)
    for (std::uint32_t t = split.mesh.components[c].triangle_begin; t < split.mesh.components[c].triangle_end;
         ++t)
      label[split.source_triangle[t]] = c;
  check_split(mesh, label, split);
  CHECK(split.mesh.components.size() <= std::max<std::size_t>(count, mesh.components.size()) + 4);
  for (std::size_t c = 0; c < split.mesh.components.size(); ++c) {
    const Component& component = split.mesh.components[c];
    const Component& source = mesh.components[split.source_component[c]];
    const std::uint32_t triangles = component.triangle_end - component.triangle_begin;
    CHECK((triangles >= min_triangles || triangles == source.triangle_end - source.triangle_begin));
    const CutChart chart = cut_to_disk(split.mesh, component, {});  // checks that it is a disk
    CHECK(chart.triangle_count() == triangles);
  }
  const TensorField carried = carry_field(split, field);
  for (std::uint32_t h = 0; h < carried.corner.size(); h += 7)
    CHECK(carried.corner[h].xx == field.corner[3 * split.source_triangle[h / 3] + h % 3].xx);
  return split;
}

}  // namespace

TEST_CASE("split_into_segments: one label gives the same mesh") {
  const PreparedMesh mesh = prepare_mesh(
      merged(merged(torus(12, 8), moved(icosphere(1), 1, 4, 1, 0)), moved(grid_plane(3, 4), 1, -3, 0, 2)));
  REQUIRE(mesh.components.size() == 3);
  const std::vector<std::uint32_t> label(mesh.triangle_count(), 7);
  const SegmentedMesh split = split_into_segments(mesh, label);
  check_split(mesh, label, split);
  CHECK(split.mesh.triangles == mesh.triangles);
  CHECK(split.mesh.opposite == mesh.opposite);
  CHECK(split.mesh.x == mesh.x);
  CHECK(split.mesh.area == mesh.area);
  CHECK(split.source_component == std::vector<std::uint32_t>{0, 1, 2});
  for (std::size_t c = 0; c < 3; ++c) {
    const Component &a = split.mesh.components[c], &b = mesh.components[c];
    CHECK(a.area == b.area);
    CHECK(a.genus == b.genus);
    CHECK(a.boundary_loops == b.boundary_loops);
    CHECK(a.vertex_begin == b.vertex_begin);
    CHECK(a.triangle_begin == b.triangle_begin);
  }
}

TEST_CASE("split_into_segments: any labels give valid segments") {
  for (const PolygonMesh& polygons :
       {torus(20, 12), icosphere(2), grid_plane(12, 9), slab_with_tunnels(2), moebius_strip(15)}) {
    const PreparedMesh mesh = prepare_mesh(polygons);
    for (const std::uint32_t labels : {2u, 5u, 1000u}) {
      std::vector<std::uint32_t> label(mesh.triangle_count());
      for (std::uint32_t t = 0; t < label.size(); ++t)
        label[t] = philox4x32({t, labels, 0, 0}, {3, 0})[0] % labels;
      check_split(mesh, label, split_into_segments(mesh, label));
    }
  }
}

TEST_CASE("split_into_segments: a vertex with two fans of one segment is split") {
  // Two opposite pairs of the six triangles round the middle of a grid: one label, two fans, joined outside
  // by the rest of the sheet.
  const PreparedMesh mesh = prepare_mesh(grid_plane(6, 6));
  std::vector<std::uint32_t> label(mesh.triangle_count(), 0);
  const std::uint32_t middle = [&] {
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
      if (norm(mesh.position(v)) < 1e-12) return v;
    return no_index;
  }();
  REQUIRE(middle != no_index);
  std::uint32_t spoke = no_index;
  for (std::uint32_t h = 0; h < mesh.triangles.size() && spoke == no_index; ++h)
    if (mesh.triangles[h] == middle) spoke = h;
  std::uint32_t at = spoke;
  for (std::uint32_t k = 0; k < 6; ++k, at = mesh.opposite[previous_half_edge(at)])
    if (k == 0 || k == 3) label[at / 3] = 1;
  REQUIRE(at == spoke);
  const SegmentedMesh split = split_into_segments(mesh, label);
  check_split(mesh, label, split);
  CHECK(split.mesh.components.size() == 3);  // label 1 touches itself at the vertex only
  CHECK(std::count(split.source_vertex.begin(), split.source_vertex.end(), middle) == 4);
  for (const Component& c : split.mesh.components) cut_to_disk(split.mesh, c, {});
}

TEST_CASE("split_into_segments: bands around a torus are annuli, the torus minus a disk has genus 1") {
  const PreparedMesh mesh = prepare_mesh(torus(24, 10));
  std::vector<std::uint32_t> band(mesh.triangle_count()), disk(mesh.triangle_count(), 0);
  for (std::uint32_t t = 0; t < band.size(); ++t) band[t] = t / 20 / 6;  // six rows of 20 each
  const SegmentedMesh bands = split_into_segments(mesh, band);
  check_split(mesh, band, bands);
  REQUIRE(bands.mesh.components.size() == 4);
  for (const Component& c : bands.mesh.components) {
    CHECK(c.genus == 0);
    CHECK(c.boundary_loops == 2);
    CHECK(cut_to_disk(bands.mesh, c, {}).triangle_count() == 120);
  }
  disk[33] = 1;
  const SegmentedMesh punched = split_into_segments(mesh, disk);
  REQUIRE(punched.mesh.components.size() == 2);
  const std::size_t larger = punched.mesh.components[0].triangle_end > 1 ? 0 : 1;
  CHECK(punched.mesh.components[larger].genus == 1);
  CHECK(punched.mesh.components[larger].boundary_loops == 1);
  CHECK(punched.mesh.components[1 - larger].genus == 0);
}

TEST_CASE("tidy_segments: disconnected parts become segments, small ones join along the longest boundary") {
  const PreparedMesh mesh = prepare_mesh(grid_plane(12, 4, 12, 4));
  const std::vector<double> length = euclidean_lengths(mesh);
  const auto cell = [](std::uint32_t x, std::uint32_t y) { return 2 * (12 * y + x); };
  std::vector<std::uint32_t> label(mesh.triangle_count());
  for (std::uint32_t y = 0; y < 4; ++y)
    for (std::uint32_t x = 0; x < 12; ++x)
      for (std::uint32_t k = 0; k < 2; ++k) label[cell(x, y) + k] = x < 4 ? 9 : x < 8 ? 3 : 9;
  // Label 9 is in two parts.
  std::vector<std::uint32_t> tidy = label;
  CHECK(tidy_segments(mesh, length, 20, tidy) == 3);
  for (std::uint32_t x = 0; x < 12; ++x) CHECK(tidy[cell(x, 2)] == x / 4);
  // An L of three cells (6 triangles) with two cells' sides to the left, more to the right.
  label[cell(4, 0)] = label[cell(4, 0) + 1] = label[cell(4, 1)] = label[cell(4, 1) + 1] = 5;
  label[cell(5, 0)] = label[cell(5, 0) + 1] = 5;
  tidy = label;
  CHECK(tidy_segments(mesh, length, 7, tidy) == 3);
  for (std::uint32_t x = 4; x < 8; ++x) CHECK(tidy[cell(x, 0)] == 1);
  tidy = label;
  CHECK(tidy_segments(mesh, length, 6, tidy) == 4);  // 6 are not fewer than 6
  // Measured otherwise, its boundary on the left is the longest.
  std::vector<double> other = length;
  for (std::size_t h = 0; h < other.size(); ++h)
    if (mesh.opposite[h] != no_index && label[h / 3] + label[mesh.opposite[h] / 3] == 14) other[h] *= 10;
  tidy = label;
  CHECK(tidy_segments(mesh, other, 7, tidy) == 3);
  CHECK(tidy[cell(4, 0)] == 0);
  // Everything is small: one segment in the end; a component has no neighbor to join.
  std::vector<std::uint32_t> single(mesh.triangle_count());
  std::iota(single.begin(), single.end(), 0u);
  CHECK(tidy_segments(mesh, length, 1000, single) == 1);
  const PreparedMesh two = prepare_mesh(merged(tetrahedron(), moved(tetrahedron(), 1, 5, 0, 0)));
  std::vector<std::uint32_t> pieces = {4, 4, 1, 1, 0, 0, 0, 0};
  CHECK(tidy_segments(two, euclidean_lengths(two), 20, pieces) == 2);
  CHECK(pieces == std::vector<std::uint32_t>{0, 0, 0, 0, 1, 1, 1, 1});
  // The least size holds for every segment afterwards, whatever came in, and tidying again changes nothing.
  const PreparedMesh ring = prepare_mesh(torus(30, 20));
  for (std::uint32_t t = 0; t < 8; ++t) {
    std::vector<std::uint32_t> noise(ring.triangle_count());
    for (std::uint32_t i = 0; i < noise.size(); ++i)
      noise[i] = philox4x32({i, t, 0, 0}, {9, 0})[0] % (2 + 3 * t);
    const std::uint32_t segments = tidy_segments(ring, euclidean_lengths(ring), 20, noise);
    std::vector<std::uint32_t> size(segments, 0);
    for (const std::uint32_t l : noise) ++size[l];
    CHECK(*std::min_element(size.begin(), size.end()) >= 20);
    std::vector<std::uint32_t> again = noise;
    CHECK(tidy_segments(ring, euclidean_lengths(ring), 20, again) == segments);
    CHECK(again == noise);
    CHECK(split_into_segments(ring, noise).mesh.components.size() == segments);
  }
}

TEST_CASE("segment_mesh: every segment of a torus, a double torus and open sheets can be cut to a disk") {
  for (const double ratio : {1.0, 6.0}) {
    const PreparedMesh ring = prepare_mesh(torus(48, 24));
    const SegmentedMesh eight = check_segments(ring, field_along(ring, {0, 0, 1}, ratio), 8);
    CHECK(eight.mesh.components.size() == 8);
    const PreparedMesh slab = prepare_mesh(slab_with_tunnels(2));
    check_segments(slab, field_along(slab, {1, 0.1, 0}, ratio), 8, 4);
    check_segments(slab, field_along(slab, {1, 0.1, 0}, ratio), 3, 4);
    const PreparedMesh sheet = prepare_mesh(grid_plane(30, 20));
    check_segments(sheet, field_along(sheet, {1, 1, 0}, ratio), 12);
    const PreparedMesh band = prepare_mesh(moebius_strip(200));
    check_segments(band, field_along(band, {0, 0, 1}, ratio), 5);
    const PreparedMesh several = prepare_mesh(
        merged(merged(torus(20, 10), moved(icosphere(0), 0.1, 4, 1, 0)), moved(tetrahedron(), 1, -3, 0, 2)));
    check_segments(several, field_along(several, {0, 0, 1}, ratio), 6);
  }
}

TEST_CASE("segment_mesh: one segment per component gives the same mesh") {
  const PreparedMesh mesh = prepare_mesh(merged(torus(12, 8), moved(icosphere(1), 1, 4, 1, 0)));
  const SegmentedMesh split = segment_mesh(mesh, round_field(mesh), {1, 20, {}});
  CHECK(split.mesh.triangles == mesh.triangles);
  CHECK(split.mesh.opposite == mesh.opposite);
  CHECK_THROWS_AS(segment_mesh(mesh, round_field(mesh), {0, 20, {}}), std::invalid_argument);
  std::vector<std::uint32_t> short_label(3);
  CHECK_THROWS_AS(split_into_segments(mesh, short_label), std::invalid_argument);
  CHECK_THROWS_AS(tidy_segments(mesh, euclidean_lengths(mesh), 20, short_label), std::invalid_argument);
}

TEST_CASE("segment_mesh: the smaller meshes of the papers can be segmented") {
  MEANDER_NEEDS_SHARED_DATA();
  for (const char* name : {"eight.off", "eight_hole.off", "hand_3k.off", "knot.obj", "venus_1k_open.off",
                           "chineselion_8k.stl", "fandisk.off", "squirrel_20k_nonmanifold.off"}) {
    INFO(name);
    const PreparedMesh mesh = shared_mesh(shared_data(std::string("paper/") + name));
    check_segments(mesh, field_along(mesh, {0, 0.3, 1}, 4), 8);
  }
}

TEST_CASE("segment_mesh: all meshes of the papers can be segmented", "[slow]") {
  MEANDER_NEEDS_SHARED_DATA();
  for (const auto& entry : std::filesystem::directory_iterator(shared_data("paper"))) {
    INFO(entry.path());
    const PreparedMesh mesh = shared_mesh(entry.path());
    for (const std::uint32_t count : {2u, 16u, 100u})
      check_segments(mesh, field_along(mesh, {0, 0.3, 1}, 8), count);
  }
}

TEST_CASE("bisect_component: two connected sides, none too small") {
  for (const PolygonMesh& polygons : {torus(40, 6), icosphere(3), grid_plane(50, 3), slab_with_tunnels(3)}) {
    const PreparedMesh mesh = prepare_mesh(polygons);
    for (const double ratio : {1.0, 8.0}) {
      const TriangleSteps steps = triangle_steps(mesh, field_along(mesh, {1, 0, 0.3}, ratio));
      const std::vector<std::uint32_t> label = bisect_component(mesh, mesh.components[0], steps);
      REQUIRE(label.size() == mesh.triangle_count());
      CHECK(label[0] == 0);
      const std::size_t ones = static_cast<std::size_t>(std::count(label.begin(), label.end(), 1u));
      CHECK(ones >= label.size() / 4);
      CHECK(ones <= label.size() - label.size() / 4);
      CHECK(split_into_segments(mesh, label).mesh.components.size() == 2);
    }
  }
  const PreparedMesh one = prepare_mesh(polygon_mesh({0, 0, 0, 1, 0, 0, 0, 1, 0}, {{0, 1, 2}}));
  CHECK(bisect_component(one, one.components[0], triangle_steps(one, round_field(one))) ==
        std::vector<std::uint32_t>{0});
}

TEST_CASE("bisect_component: limbs far from both seeds go to one side as a whole") {
  // A cross of strips, one arm longer: the arms across lie where the probability is constant up to rounding.
  std::vector<double> xyz;
  std::vector<std::vector<std::uint32_t>> faces;
  const PolygonMesh grid = grid_plane(120, 121, 120, 121);
  std::vector<std::uint32_t> number(grid.x.size(), no_index);
  for (std::size_t p = 0; p + 1 < grid.polygon_begin.size(); ++p) {
    std::vector<std::uint32_t> face;
    double x = 0, y = 0;
    for (std::uint32_t k = grid.polygon_begin[p]; k < grid.polygon_begin[p + 1]; ++k) {
      x += grid.x[grid.corners[k]] / 3;
      y += grid.y[grid.corners[k]] / 3;
    }
    if (!(std::abs(x - 60) < 1.01 || std::abs(y - 20) < 1.01)) continue;
    for (std::uint32_t k = grid.polygon_begin[p]; k < grid.polygon_begin[p + 1]; ++k) {
      const std::uint32_t v = grid.corners[k];
      if (number[v] == no_index) {
        number[v] = static_cast<std::uint32_t>(xyz.size() / 3);
        xyz.insert(xyz.end(), {grid.x[v], grid.y[v], 0.0});
      }
      face.push_back(number[v]);
    }
    faces.push_back(face);
  }
  const PreparedMesh mesh = prepare_mesh(polygon_mesh(xyz, faces));
  REQUIRE(mesh.components.size() == 1);
  const TriangleSteps steps = triangle_steps(mesh, round_field(mesh));
  const std::vector<std::uint32_t> label = bisect_component(mesh, mesh.components[0], steps);
  const SegmentedMesh split = split_into_segments(mesh, label);
  CHECK(split.mesh.components.size() == 2);
  check_split(mesh, label, split);
}

TEST_CASE("bisect_component: a side that the walk leaves too small grows to a quarter") {
  // A square with a thin tail: half-way for the walk lies in the tail.
  PolygonMesh grid = grid_plane(80, 30, 80, 30);
  std::vector<std::vector<std::uint32_t>> faces;
  for (std::uint32_t p = 0; p < grid.polygon_count(); ++p)
    if (p / 2 % 80 < 30 || p / 2 / 80 == 15)
      faces.push_back({grid.corners[3 * p], grid.corners[3 * p + 1], grid.corners[3 * p + 2]});
  std::vector<double> xyz;
  for (std::size_t i = 0; i < grid.x.size(); ++i) xyz.insert(xyz.end(), {grid.x[i], grid.y[i], 0.0});
  const PreparedMesh mesh = prepare_mesh(polygon_mesh(xyz, faces));
  REQUIRE(mesh.components.size() == 1);
  const TriangleSteps steps = triangle_steps(mesh, round_field(mesh));
  const std::vector<std::uint32_t> label = bisect_component(mesh, mesh.components[0], steps);
  const auto ones = static_cast<std::size_t>(std::count(label.begin(), label.end(), 1u));
  CHECK(std::min(ones, label.size() - ones) >= label.size() / 4);
  CHECK(std::min(ones, label.size() - ones) <= label.size() / 3);
  check_split(mesh, label, split_into_segments(mesh, label));
  CHECK(split_into_segments(mesh, label).mesh.components.size() == 2);
}

TEST_CASE("bisect_components: repeated bisection ends in small connected pieces of the given components") {
  const PreparedMesh start = prepare_mesh(merged(torus(24, 12), moved(icosphere(2), 1, 4, 1, 0)));
  const TriangleSteps first = triangle_steps(start, field_along(start, {0, 0, 1}, 5));
  SegmentedMesh now = split_into_segments(start, std::vector<std::uint32_t>(start.triangle_count(), 0));
  TriangleSteps steps = first;
  const std::uint32_t kept =
      start.components[0].triangle_end - start.components[0].triangle_begin == 320 ? 0 : 1;
  std::vector<std::uint32_t> origin(start.triangle_count());
  std::iota(origin.begin(), origin.end(), 0u);
  std::vector<std::uint32_t> home = {0, 1};  // component of `start`
  int rounds = 0;
  for (; rounds < 20; ++rounds) {
    std::vector<std::uint32_t> large;
    for (std::uint32_t c = 0; c < now.mesh.components.size(); ++c)
      if (home[c] != kept && now.mesh.components[c].triangle_end - now.mesh.components[c].triangle_begin > 30)
        large.push_back(c);
    if (large.empty()) break;
    const std::size_t before = now.mesh.components.size();
    const SegmentedMesh next = bisect_components(now.mesh, large, steps);
    REQUIRE(next.mesh.components.size() == before + large.size());
    steps.length = carry_half_edge_values(next, steps.length);
    steps.weight = carry_half_edge_values(next, steps.weight);
    std::vector<std::uint32_t> new_home, new_origin;
    for (const std::uint32_t c : next.source_component) new_home.push_back(home[c]);
    for (const std::uint32_t t : next.source_triangle) new_origin.push_back(origin[t]);
    home = new_home;
    origin = new_origin;
    now = next;
  }
  CHECK(rounds <= 9);  // sides of at least a quarter: 576 (3/4)^k > 30 allows 10 rounds at most
  CHECK(std::count(home.begin(), home.end(), kept) == 1);
  CHECK(now.mesh.components.size() > 576 / 31);
  for (const Component& c : now.mesh.components) cut_to_disk(now.mesh, c, {});
  for (std::uint32_t h = 0; h < now.mesh.triangles.size(); ++h) {
    CHECK(distance(now.mesh.position(now.mesh.triangles[h]),
                   start.position(start.triangles[3 * origin[h / 3] + h % 3])) == 0);
    CHECK(steps.length[h] == first.length[3 * origin[h / 3] + h % 3]);
  }
}
