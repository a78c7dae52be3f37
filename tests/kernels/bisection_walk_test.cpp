#include "kernels/partition/bisection_walk.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "kernels/mesh/prepare_mesh.h"
#include "kernels/model/model.h"
#include "kernels/partition/surface_regions.h"
#include "support/catch.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

constexpr int bisections = 10;
constexpr std::size_t parts = std::size_t{1} << bisections;

Vector3 centroid_at(const PreparedMesh& mesh, std::uint32_t triangle, std::uint32_t path) {
  return centroid(followed(plain_triangle(bisection_corners(mesh, triangle)), path).corner);
}

// The triangles of a mesh as wide pieces that follow each other.
CurveElements whole_faces(const PreparedMesh& mesh, int times) {
  CurveElements elements;
  elements.cumulative.push_back(0);
  for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
    elements.triangle.push_back(t);
    elements.path.push_back(1);
    elements.cumulative.push_back(elements.cumulative.back() + mesh.area[t]);
    const Vector3 at = centroid_at(mesh, t, 1);
    for (const double c : {at.x, at.y, at.z}) elements.place.push_back(static_cast<float>(c));
  }
  elements.limit = 1.5 * mesh.area[0] * share_after(times);
  return elements;
}

double share_of(std::size_t part) { return (static_cast<double>(part) + 0.5) / parts; }

}  // namespace

TEST_CASE("bisection walk: every part is reached once, by shares in any order") {
  const PreparedMesh mesh = prepare_mesh(icosphere(0));
  const CurveElements elements = whole_faces(mesh, bisections);
  BisectionWalk walk(mesh, elements), leaping(mesh, elements);
  for (std::size_t i = 0; i < elements.count(); ++i) {
    std::vector<std::uint32_t> path(parts);
    for (std::size_t k = 0; k < parts; ++k) path[k] = walk.part_at(i, share_of(k)).path;
    const std::set<std::uint32_t> different(path.begin(), path.end());
    REQUIRE(different.size() == parts);
    REQUIRE(*different.begin() == parts);
    REQUIRE(*different.rbegin() == 2 * parts - 1);
    for (std::size_t k = 0; k < parts; ++k) {
      const std::size_t far = k * 389 % parts;
      const BisectionWalk::Part part = leaping.part_at(i, share_of(far));
      REQUIRE(part.path == path[far]);
      const Piece expected = piece_of(bisection_corners(mesh, elements.triangle[i]), part.path);
      REQUIRE(std::equal(part.weights.b1, part.weights.b1 + 3, expected.b1));
      REQUIRE(std::equal(part.weights.b2, part.weights.b2 + 3, expected.b2));
    }
    CHECK(walk.part_at(i, 0).path == path.front());
    CHECK(walk.part_at(i, 1).path == path.back());
    // The border between two parts belongs to the later one.
    CHECK(walk.part_at(i, 0.5).path == path[parts / 2]);
  }
}

TEST_CASE("bisection walk: consecutive parts are near each other") {
  // Along the faces of an icosahedron, which follow each other in the order of the file.
  const PreparedMesh mesh = prepare_mesh(icosphere(0));
  const CurveElements elements = whole_faces(mesh, bisections);
  BisectionWalk walk(mesh, elements);
  for (std::size_t i = 1; i + 1 < elements.count(); ++i) {
    const double side = std::sqrt(mesh.area[elements.triangle[i]] / parts);
    const auto at = [&](std::size_t k) {
      return centroid_at(mesh, elements.triangle[i], walk.part_at(i, share_of(k)).path);
    };
    double sum = 0, most = 0;
    for (std::size_t k = 1; k < parts; ++k) {
      const double step = norm(at(k) - at(k - 1));
      sum += step;
      most = std::max(most, step);
    }
    INFO("face " << i << ": mean step " << sum / (parts - 1) / side << ", longest " << most / side);
    // In random order the mean would be some 20 sides; with one rule of the path broken it is 1.5 to 2.1. The
    // nearest of congruent halves of squares are 0.67 sides apart.
    CHECK(sum / (parts - 1) < 1.5 * side);
    const Vector3 way =
        centroid_at(mesh, elements.triangle[i + 1], 1) - centroid_at(mesh, elements.triangle[i - 1], 1);
    const Vector3 first_half = (1.0 / (parts / 2)) * [&] {
      Vector3 total{};
      for (std::size_t k = 0; k < parts / 2; ++k) total = total + at(k);
      return total;
    }();
    CHECK(dot(centroid_at(mesh, elements.triangle[i], 1) - first_half, way) >= -1e-9);
  }
}

TEST_CASE("bisection walk: an element that is light enough is its own part") {
  const PreparedMesh mesh = prepare_mesh(icosphere(0));
  CurveElements elements = whole_faces(mesh, bisections);
  elements.limit = 2 * mesh.area[0];
  BisectionWalk walk(mesh, elements);
  for (std::size_t i = 0; i < elements.count(); ++i)
    for (const double share : {0.0, 0.3, 1.0}) CHECK(walk.part_at(i, share).path == 1);
}

TEST_CASE("place_samples: parts of wide pieces of large sets get their share of the samples, for every key",
          "[statistics]") {
  // The faces of a tetrahedron are cut into pieces by 12 bisections, which have 64 parts, by 6 more. Every
  // sixteenth of each face has the number of samples that its area asks for, but for those strata that it has
  // a part of only, along its border and at the borders of regions. Over all pieces every part has as many.
  constexpr std::uint32_t n = 140000;
  constexpr int of_face = 4, of_pieces = 12, of_parts = 6;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    SampleParameters parameters;
    parameters.method = MethodChoice::direct;
    parameters.samples = n;
    Model model;
    model.file = tetrahedron();
    model.key = make_random_key(seed, {});
    run_stages(charting_stages(parameters), model);
    run_stages(placing_stages(parameters, nullptr), model);
    {
      const ElementParameters elements = element_parameters(parameters);
      const SurfaceRegions regions = build_regions({model.surface, model.measure, model.key}, elements);
      const ElementSource source({model.surface, model.measure, model.key}, elements.order, regions.group);
      const CurveElements of_region = region_elements(regions, source, 0);
      REQUIRE_FALSE(of_region.place.empty());
      REQUIRE(of_region.path.front() >> of_pieces == 1);
      REQUIRE(bisections_of(model.surface, of_region, 0) == of_parts);
    }
    const Samples& samples = model.row.samples;
    REQUIRE(samples.count() == n);
    std::vector<double> in_sixteenth(4 << of_face, 0.0), in_part(1 << of_parts, 0.0);
    for (std::size_t i = 0; i < n; ++i) {
      TriangleSource source{};
      source.corner = bisection_corners(model.surface, samples.triangle[i]);
      source.piece_bisections = of_pieces + of_parts;
      const std::uint32_t path = source.piece_at(static_cast<double>(samples.barycentric[2 * i]),
                                                 static_cast<double>(samples.barycentric[2 * i + 1]));
      const std::uint32_t leading = path >> (of_pieces + of_parts - of_face);
      ++in_sixteenth[(std::size_t{samples.triangle[i]} << of_face) + leading - (1u << of_face)];
      ++in_part[path & ((1u << of_parts) - 1)];
    }
    const double expected = n / static_cast<double>(in_sixteenth.size());
    for (const double held : in_sixteenth) CHECK(std::abs(held - expected) < 0.02 * expected);
    // The deviation of independent draws is 2.1 %.
    const double of_each = n / static_cast<double>(in_part.size());
    for (const double held : in_part) CHECK(std::abs(held - of_each) < 0.1 * of_each);
  }
}
