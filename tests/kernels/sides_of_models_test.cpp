// Signs of damaged models beside those of the whole ones, and of closed models beside exact winding numbers.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <string>
#include <tuple>
#include <vector>

#include "kernels/query/winding_number.h"
#include "support/catch.h"
#include "support/query_meshes.h"
#include "support/sided_mesh.h"
#include "support/test_meshes.h"
#include "support/threads.h"

using namespace meander;
using namespace meander::test;

namespace {

constexpr std::size_t damage_points = 20000;

void check_damage(const char* damage, const SidedMesh& whole, const PolygonMesh& damaged) {
  const SidedMesh sided(damaged);
  const Disagreement found = compare(sided, whole, damage_points);
  INFO(damage << ": wrong " << found.certain_wrong << ", uncertain " << found.uncertain << ", rule "
              << name_of(sided.rule));
  CHECK(found.certain_wrong <= 1e-4);
  CHECK(found.uncertain <= 0.1);
}

// The model and a copy, turned and moved, which pass through each other.
PolygonMesh with_copy(const PolygonMesh& file, double shift) {
  return merged(file, moved(file, 1, shift, 0.3 * shift, 0.7 * shift));
}

// Every so many models below a folder of the shared data, in order of their names.
std::vector<std::string> models_below(const std::string& folder, std::size_t every) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(shared_data(folder))) {
    MeshFormat format{};
    if (entry.is_regular_file() && mesh_format_of(entry.path(), format))
      names.push_back(folder + "/" + std::filesystem::relative(entry.path(), shared_data(folder)).string());
  }
  std::sort(names.begin(), names.end());
  std::vector<std::string> kept;
  for (std::size_t i = 0; i < names.size(); i += every) kept.push_back(names[i]);
  return kept;
}

struct Counts {
  std::size_t points = 0, uncertain = 0, wrong = 0, compared = 0, wrong_uncertain = 0;
};

// Sides by the rule closed; some of them beside the sums of all solid angles.
void count_closed(const std::string& name, std::size_t points_per_model, std::size_t compared,
                  Counts& counts) {
  const SidedMesh sided(model_of(name));
  if (sided.rule != SignRule::closed) return;
  std::vector<std::uint32_t> turned = sided.mesh.triangles;
  for (std::size_t t = 0; t < sided.oriented.flipped.size(); ++t)
    if (sided.oriented.flipped[t] != 0) std::swap(turned[3 * t + 1], turned[3 * t + 2]);
  const std::vector<double> points = side_points(sided.mesh, points_per_model, 17);
  const PointSides found = sided.sides(points);
  counts.points += points_per_model;
  counts.uncertain += found.uncertain;
  for (std::size_t k = 0; k < compared; ++k) {
    const std::size_t i = k * points_per_model / compared;
    const double exact = exact_winding_number(sided.mesh.x, sided.mesh.y, sided.mesh.z, turned,
                                              {points[3 * i], points[3 * i + 1], points[3 * i + 2]});
    const bool wrong = (std::abs(exact) >= 0.5) != (found.inside[i] != 0);
    ++counts.compared;
    counts.wrong += wrong;
    counts.wrong_uncertain += wrong && found.certain[i] == 0;
  }
}

void check_closed(const Counts& counts) {
  INFO(counts.wrong << " of " << counts.compared << " wrong, " << counts.uncertain << " of " << counts.points
                    << " uncertain");
  CHECK(static_cast<double>(counts.wrong) <= 1e-5 * static_cast<double>(counts.compared));
  CHECK(counts.wrong == counts.wrong_uncertain);
  CHECK(static_cast<double>(counts.uncertain) <= 0.01 * static_cast<double>(counts.points));
}

// Of the shared collection: the share of uncertain points of each model.
std::vector<double> uncertain_of_collection(std::size_t every, std::size_t points_per_model) {
  std::vector<double> uncertain;
  for (const std::string& name : models_below("../collection", every)) {
    const SidedMesh sided(model_of(name));
    const PointSides found = sided.sides(side_points(sided.mesh, points_per_model, 23));
    REQUIRE(found.rule != SignRule::none);
    uncertain.push_back(static_cast<double>(found.uncertain) / static_cast<double>(points_per_model));
  }
  std::sort(uncertain.begin(), uncertain.end());
  return uncertain;
}

void check_collection(const std::vector<double>& uncertain) {
  REQUIRE_FALSE(uncertain.empty());
  INFO("median " << uncertain[uncertain.size() / 2] << ", third quartile "
                 << uncertain[3 * uncertain.size() / 4]);
  CHECK(uncertain[uncertain.size() / 2] <= 0.05);
}

bool has_collection() { return std::filesystem::is_directory(shared_data("../collection")); }

}  // namespace

TEST_CASE("point_sides: holes of 5 % of the area leave no certain side wrong") {
  const SidedMesh whole(icosphere(5));
  for (const bool inward : {false, true}) {
    PolygonMesh file = with_holes(icosphere(5), 0.05, 4);
    if (inward) file = inside_out(file);
    const SidedMesh pierced(file);
    REQUIRE(pierced.rule == SignRule::winding);
    const Disagreement found = compare(pierced, whole, 20000);
    CHECK(found.certain_wrong <= 1e-4);
    CHECK(found.uncertain <= 0.1);
    CHECK(found.uncertain > 0);
  }
}

TEST_CASE("point_sides: damage of generated models leaves no certain side wrong") {
  for (const PolygonMesh& file : {icosphere(5), torus(120, 60), slab_with_tunnels(6),
                                  merged(torus(90, 50), moved(icosphere(4), 0.9, 3, 0, 0))}) {
    const SidedMesh whole(file);
    REQUIRE(whole.rule == SignRule::closed);
    for (const double size : {0.17, 0.5}) check_damage("holes", whole, with_holes(file, 0.05, 7, size));
    check_damage("turned over", whole, inside_out(file));
    check_damage("doubled", whole, merged(file, file));
    check_damage("two-sided", whole, merged(file, inside_out(file)));
  }
}

TEST_CASE("point_sides: one component turned over, whole and with holes") {
  const PolygonMesh parts[] = {torus(90, 50), moved(icosphere(4), 0.9, 3, 0, 0)};
  const SidedMesh whole(merged(parts[0], parts[1]));
  check_damage("one turned over", whole, merged(inside_out(parts[0]), parts[1]));
  check_damage("the other one", whole, merged(parts[0], inside_out(parts[1])));
  check_damage("one turned over, with holes", whole,
               with_holes(merged(inside_out(parts[0]), parts[1]), 0.05, 7));
}

TEST_CASE("point_sides: a model that passes through itself is the union of its parts", "[statistics]") {
  for (const PolygonMesh& file : {icosphere(5), torus(120, 60)})
    for (const double shift : {0.02, 0.3}) {
      const PolygonMesh both = with_copy(file, shift);
      const SidedMesh sided(both);
      REQUIRE(sided.rule == SignRule::closed);
      const std::vector<double> points = side_points(sided.mesh, damage_points, 5);
      const PointSides found = sided.sides(points);
      CHECK(found.uncertain == 0);
      std::size_t wrong = 0, deep = 0;
      for (std::size_t i = 0; i < damage_points; i += 20) {
        const double exact =
            exact_winding_number(sided.mesh.x, sided.mesh.y, sided.mesh.z, sided.mesh.triangles,
                                 {points[3 * i], points[3 * i + 1], points[3 * i + 2]});
        wrong += (exact >= 0.5) != (found.inside[i] != 0);
        deep += exact > 1.5;
      }
      CHECK(wrong == 0);
      CHECK(deep > 0);
      check_damage("holes", sided, with_holes(both, 0.05, 3));
    }
}

TEST_CASE("point_sides: two holes together make no inside") {
  // Two boxes without their tops, nearly the same: right above them either winding number is nearly one half.
  PolygonMesh box = two_sided_plate(8, 1);
  const double top = *std::max_element(box.z.begin(), box.z.end());
  std::vector<std::uint8_t> removed(box.polygon_count(), 0);
  for (std::uint32_t p = 0; p < box.polygon_count(); ++p)
    removed[p] = std::all_of(box.corners.begin() + box.polygon_begin[p],
                             box.corners.begin() + box.polygon_begin[p + 1],
                             [&](std::uint32_t v) { return box.z[v] == top; });
  const Vector3 middle{0.5, 0.5, 0.5}, shift{0.01, 0.005, -0.01};
  remove_polygons(box, removed);
  PolygonMesh copy = box;
  for (double& x : copy.x) x += shift.x;
  for (double& y : copy.y) y += shift.y;
  for (double& z : copy.z) z += shift.z;
  const SidedMesh both(merged(box, copy));
  REQUIRE(both.oriented.open_edges == 64);
  const std::vector<double> points = side_points(both.mesh, damage_points, 3);
  const PointSides found = label_points(both.tree, both.oriented, SignRule::winding, points).sides;
  std::size_t wrong = 0, certain_above = 0, uncertain_above = 0;
  for (std::size_t i = 0; i < damage_points; ++i) {
    const Vector3 p =
        both.mesh.center + both.mesh.unit * Vector3{points[3 * i], points[3 * i + 1], points[3 * i + 2]};
    const auto in_box = [&](Vector3 from) {
      return std::max({std::abs(from.x), std::abs(from.y), std::abs(from.z)}) < 0.5;
    };
    const bool inside = in_box(p - middle) || in_box(p - middle - shift);
    wrong += found.certain[i] != 0 && (found.inside[i] != 0) != inside;
    if (inside || p.z < top || std::abs(found.winding[i]) < 0.86) continue;
    (found.certain[i] != 0 ? certain_above : uncertain_above) += 1;
  }
  CHECK(wrong <= 2);
  CHECK(certain_above == 0);
  CHECK(uncertain_above > 10);
}

TEST_CASE("point_sides: the open end of a tube that lies in a solid makes nothing uncertain") {
  // A tube of large faces that ends in a ball.
  PolygonMesh tube;
  constexpr std::uint32_t corners = 12;
  for (std::uint32_t i = 0; i < corners; ++i)
    for (const double x : {0.5, 3.0}) {
      const double angle = 2 * std::numbers::pi * i / corners;
      tube.x.push_back(x);
      tube.y.push_back(0.2 * std::cos(angle));
      tube.z.push_back(0.2 * std::sin(angle));
    }
  for (std::uint32_t i = 0; i < corners; ++i) {
    const std::uint32_t next = (i + 1) % corners;
    for (const std::uint32_t v : {2 * i, 2 * i + 1, 2 * next + 1, 2 * next}) tube.corners.push_back(v);
    tube.polygon_begin.push_back(static_cast<std::uint32_t>(tube.corners.size()));
  }
  for (std::uint32_t i = 0; i < corners; ++i) tube.corners.push_back(2 * (corners - 1 - i) + 1);
  tube.polygon_begin.push_back(static_cast<std::uint32_t>(tube.corners.size()));
  const SidedMesh sided(merged(icosphere(4), tube));
  CHECK(sided.rule == SignRule::winding);
  const std::vector<double> points = side_points(sided.mesh, damage_points, 9);
  const PointSides found = sided.sides(points);
  CHECK(static_cast<double>(found.uncertain) <= 0.01 * static_cast<double>(damage_points));
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < damage_points; ++i) {
    const Vector3 p =
        sided.mesh.center + sided.mesh.unit * Vector3{points[3 * i], points[3 * i + 1], points[3 * i + 2]};
    // The tube as a prism.
    double in_prism = 0;
    for (std::uint32_t k = 0; k < corners; ++k) {
      const double angle = 2 * std::numbers::pi * (k + 0.5) / corners;
      in_prism = std::max(in_prism, p.y * std::cos(angle) + p.z * std::sin(angle));
    }
    const double apothem = 0.2 * std::cos(std::numbers::pi / corners);
    const bool in_tube = p.x > 0.5 && p.x < 3 && in_prism < apothem;
    // Within the faces of the ball rounding of its shape matters: those points are left out.
    if (norm(p) > 0.99 && norm(p) < 1.001) continue;
    wrong += found.certain[i] != 0 && (found.inside[i] != 0) != (in_tube || norm(p) < 1);
  }
  CHECK(wrong == 0);
}

TEST_CASE("point_sides: by winding the numbers of all triangles, and the same for every thread count") {
  for (const PolygonMesh& file :
       {with_holes(icosphere(4), 0.05, 2), with_holes(torus(60, 40), 0.03, 5),
        merged(with_holes(icosphere(4), 0.02, 8), moved(icosphere(3), 0.6, 0.9, 0, 0))}) {
    const SidedMesh sided(file);
    REQUIRE(sided.rule == SignRule::winding);
    std::vector<std::uint32_t> turned = sided.mesh.triangles;
    for (std::size_t t = 0; t < sided.oriented.flipped.size(); ++t)
      if (sided.oriented.flipped[t] != 0) std::swap(turned[3 * t + 1], turned[3 * t + 2]);
    const std::vector<double> points = side_points(sided.mesh, 100000, 41);
    const PointSides found = on_threads(1, [&] { return sided.sides(points); });
    CHECK(on_threads(3, [&] { return sided.sides(points); }).winding == found.winding);
    double largest = 0, largest_near = 0;
    for (std::size_t i = 0; i < points.size() / 3; i += 50) {
      const double exact = exact_winding_number(sided.mesh.x, sided.mesh.y, sided.mesh.z, turned,
                                                {points[3 * i], points[3 * i + 1], points[3 * i + 2]});
      const double error = std::abs(found.winding[i] - exact);
      largest = std::max(largest, error);
      if (std::abs(std::abs(exact) - 0.5) < 0.05) largest_near = std::max(largest_near, error);
      if (found.certain[i] != 0) CHECK((found.inside[i] != 0) == (std::abs(exact) >= 0.5));
    }
    CHECK(largest <= 0.1);
    CHECK(largest_near <= 0.03);
  }
}

TEST_CASE("point_sides: real models before and after damage", "[statistics]") {
  MEANDER_NEEDS_SHARED_DATA();
  for (const char* name : {"paper/fandisk.off", "paper/hand_3k.off", "paper/knot.obj", "paper/igea_16k.off",
                           "paper/squirrel_20k_nonmanifold.off", "paper/maxplanck_25k.off"}) {
    const PolygonMesh file = model_of(name);
    const SidedMesh whole(file);
    REQUIRE(whole.rule == SignRule::closed);
    INFO(name);
    const auto check = [&](const char* damage, const PolygonMesh& damaged) {
      check_damage(damage, whole, damaged);
    };
    for (const double size : {0.17, 0.35, 0.6}) check("holes", with_holes(file, 0.05, 7, size));
    check("turned over", inside_out(file));
    check("doubled", merged(file, file));
    check("two-sided", merged(file, inside_out(file)));
    const PolygonMesh both = with_copy(file, 0.05 * whole.mesh.diagonal);
    const SidedMesh through_itself(both);
    check_damage("through itself", through_itself, with_holes(both, 0.05, 3));
  }
  // Large holes of both that lie beside each other.
  for (const auto& [name, shift, size, seed] : {std::tuple{"paper/fandisk.off", 0.05, 0.35, 11},
                                                {"paper/knot.obj", 0.05, 0.35, 3},
                                                {"paper/maxplanck_25k.off", 0.3, 0.17, 7}}) {
    INFO(name);
    const PolygonMesh file = model_of(name), both = with_copy(file, shift * prepare_mesh(file).diagonal);
    check_damage("large holes", SidedMesh(both),
                 with_holes(both, 0.05, static_cast<std::uint64_t>(seed), size));
  }
}

TEST_CASE("point_sides: closed real models, as the sums of all solid angles say", "[release]") {
  MEANDER_NEEDS_SHARED_DATA();
  Counts counts;
  for (const char* folder : {"retrieval", "paper"})
    for (const std::string& name : models_below(folder, 12)) count_closed(name, 30000, 150, counts);
  CHECK(counts.compared > 1000);
  check_closed(counts);
}

TEST_CASE("point_sides: all closed real models, as the sums of all solid angles say", "[slow]") {
  MEANDER_NEEDS_SHARED_DATA();
  Counts counts;
  for (const char* folder : {"retrieval", "paper"})
    for (const std::string& name : models_below(folder, 1)) count_closed(name, 200000, 2000, counts);
  CHECK(counts.compared > 200000);
  check_closed(counts);
}

TEST_CASE("point_sides: no model of the shared collection is left without sides, half have 95 % certain") {
  if (!has_collection()) {
    WARN("skipped: the shared collection is not beside this clone");
    return;
  }
  check_collection(uncertain_of_collection(12, 20000));
}

TEST_CASE("point_sides: all of the shared collection, half have 95 % certain", "[slow]") {
  if (!has_collection()) {
    WARN("skipped: the shared collection is not beside this clone");
    return;
  }
  check_collection(uncertain_of_collection(1, 200000));
}
