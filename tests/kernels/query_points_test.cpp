#include "kernels/sample/query_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <set>

#include "kernels/core/half.h"
#include "kernels/core/random.h"
#include "kernels/core/share_search.h"
#include "kernels/mesh/prepare_mesh.h"
#include "kernels/sample/scrambled_net.h"
#include "support/catch.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;
using Catch::Matchers::ContainsSubstring;

namespace {

// The points of a model in a frame of its own, or in units of its box.
Row with_queries(const PolygonMesh& file, const QueryParameters& parameters, bool in_box = true,
                 std::uint64_t seed = 1) {
  Row row;
  row.report.loc = {0.25, 0, -0.5};
  row.report.scale = 2;
  const PreparedMesh mesh = prepare_mesh(file);
  Notes notes;
  add_query_points(file, mesh, parameters, sharp_edges_of(file, mesh, {}, notes), in_box,
                   make_random_key(seed, {}), {}, row);
  return row;
}

QueryParameters queries_of(const std::string& text) {
  QueryParameters parameters;
  REQUIRE(take_queries(text, parameters.terms).empty());
  return parameters;
}

// In coordinates of the file.
std::array<double, 3> place_of(const Row& row, std::size_t i) {
  std::array<double, 3> at{};
  for (std::size_t k = 0; k < 3; ++k)
    at[k] = row.report.loc[k] + row.report.scale * double{row.samples.query_points[3 * i + k]};
  return at;
}

// From the cube [-1, 1]^3.
double cube_distance(const std::array<double, 3>& p) {
  double outside = 0, inside = -std::numeric_limits<double>::infinity();
  for (const double x : p) {
    const double over = std::abs(x) - 1;
    outside += over > 0 ? over * over : 0;
    inside = std::max(inside, over);
  }
  return outside > 0 ? std::sqrt(outside) : inside;
}

}  // namespace

TEST_CASE("half_of: every half comes back, ties go to even, what is too large is infinite") {
  for (std::uint32_t h = 0; h < 65536; ++h) {
    const auto half = static_cast<std::uint16_t>(h);
    const float value = value_of_half(half);
    if (std::isnan(value))
      CHECK(std::isnan(value_of_half(half_of(value))));
    else
      CHECK(half_of(value) == half);
  }
  CHECK(value_of_half(0x3C00) == 1);
  CHECK(value_of_half(0x0001) == 0x1p-24f);
  CHECK(rounded_to_half(1 + 0x1p-11f) == 1);
  CHECK(rounded_to_half(1 + 0x3p-11f) == 1 + 0x4p-11f);
  CHECK(rounded_to_half(1 + 0x1.002p-11f) == 1 + 0x1p-10f);
  CHECK(rounded_to_half(0x1p-25f) == 0);
  CHECK(rounded_to_half(0x1.8p-24f) == 0x1p-23f);
  CHECK(rounded_to_half(65519) == largest_half);
  CHECK(std::isinf(rounded_to_half(-65520)));
}

TEST_CASE("normal_quantile: known values, and antisymmetric") {
  CHECK(normal_quantile(0.5) == 0);
  CHECK(normal_quantile(0.975) == Approx(1.959963984540054).epsilon(1e-14));
  CHECK(normal_quantile(0.2) == Approx(-0.8416212335729142).epsilon(1e-14));
  CHECK(normal_quantile(1e-6) == Approx(-4.753424308822899).epsilon(1e-14));
  CHECK(normal_quantile(1e-10) == Approx(-6.361340902404056).epsilon(1e-14));
  for (const double p : {0.01, 0.1, 0.3, 0.45}) CHECK(normal_quantile(p) == Approx(-normal_quantile(1 - p)));
}

TEST_CASE("normal_share: the probabilities of one, two and three deviations") {
  CHECK(normal_share(1) == Approx(0.6826894921370859).epsilon(1e-13));
  CHECK(normal_share(2) == Approx(0.9544997361036416).epsilon(1e-13));
  CHECK(normal_share(3) == Approx(0.9973002039367398).epsilon(1e-13));
  CHECK(normal_share(1e-6) == Approx(7.978845608027e-7).epsilon(1e-8));
  CHECK(normal_share(0) <= 1e-15);
  CHECK(normal_share(1000) == Approx(1).epsilon(1e-15));
}

TEST_CASE(
    "ScrambledNet: 2^k points have one in each of 2^k intervals, and in boxes of the first dimensions") {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    const ScrambledNet net(make_random_key(seed, {}), Stream::test_shapes, 7);
    for (const std::uint32_t count : {16u, 256u, 4096u}) {
      std::set<std::uint32_t> boxes;
      std::array<std::set<std::uint32_t>, ScrambledNet::dimensions> intervals;
      const auto side = static_cast<std::uint32_t>(std::lround(std::sqrt(count)));
      for (std::uint32_t i = 0; i < count; ++i) {
        const auto u = net(i);
        for (std::size_t d = 0; d < u.size(); ++d) {
          CHECK((u[d] > 0 && u[d] < 1));
          if (d < 4) CHECK(net.first_four(i)[d] == u[d]);
          intervals[d].insert(static_cast<std::uint32_t>(u[d] * count));
        }
        boxes.insert(static_cast<std::uint32_t>(u[0] * side) * side +
                     static_cast<std::uint32_t>(u[1] * side));
      }
      for (const auto& of_dimension : intervals) CHECK(of_dimension.size() == count);
      CHECK(boxes.size() == count);
    }
  }
  const ScrambledNet one(make_random_key(1, {}), Stream::test_shapes, 0),
      other(make_random_key(1, {}), Stream::test_shapes, 1);
  CHECK(one(5) != other(5));
}

TEST_CASE("ShareSearch: the first part that ends after a share, parts of no length never") {
  const RandomKey key = make_random_key(4, {});
  for (const std::size_t count : {1u, 2u, 7u, 300u}) {
    std::vector<double> end;
    for (std::uint32_t i = 0; i < count; ++i) {
      const double u = (random_words(key, Stream::test_shapes, i)[0] + 0.5) * 0x1p-32;
      // A third have no length, some are far longer than others.
      end.push_back((end.empty() ? 0 : end.back()) + (u < 1.0 / 3 && i > 0 ? 0 : std::pow(u, 9)));
    }
    const ShareSearch search(end);
    for (std::uint32_t i = 0; i <= 1000; ++i) {
      const double share = i / 1000.0;
      const auto after = std::upper_bound(end.begin(), end.end(), share * end.back());
      const auto expected = static_cast<std::size_t>(after - end.begin());
      CHECK(search(share) == std::min(expected, count - 1));
    }
    for (const double at : end) {
      const auto after = std::upper_bound(end.begin(), end.end(), at / end.back() * end.back());
      CHECK(search(at / end.back()) == std::min(static_cast<std::size_t>(after - end.begin()), count - 1));
    }
  }
}

TEST_CASE("take_queries: terms and back, and what is wrong with others") {
  std::vector<QueryTerm> terms;
  CHECK(take_queries("near=249856@.005,.05  near-sharp=10@0.1 volume=7", terms).empty());
  REQUIRE(terms.size() == 3);
  CHECK(terms[0] == QueryTerm{QueryKind::near, 249856, {0.005, 0.05}});
  CHECK(terms[2] == QueryTerm{QueryKind::volume, 7, {1}});
  const std::string text = queries_text(terms);
  CHECK(text == "near=249856@0.005,0.05 near-sharp=10@0.1 volume=7@1");
  std::vector<QueryTerm> again;
  CHECK(take_queries(text, again).empty());
  CHECK(again == terms);
  CHECK(take_queries("", terms).empty());
  CHECK(terms.empty());
  for (const auto& [wrong, why] :
       std::vector<std::pair<std::string, std::string>>{{"near", "KIND=COUNT"},
                                                        {"nea=5@1", "near"},
                                                        {"near=5", "size"},
                                                        {"near=0@1", "0"},
                                                        {"near=5@0", "size"},
                                                        {"near=5@1,", "size"},
                                                        {"near=5@1e9", "size"},
                                                        {"near=1@.1,.2", "fewer points"},
                                                        {"near=x@1", "number of points"},
                                                        {"volume=16777216@1 near=1@1", "16777217"}})
    CHECK_THAT(take_queries(wrong, terms), ContainsSubstring(why));
  const std::vector<QueryGroup> groups = query_groups({{QueryKind::near, 7, {0.5, 1, 2}}});
  REQUIRE(groups.size() == 3);
  CHECK(groups[0].count == 3);
  CHECK(groups[2].count == 2);
  CHECK(groups[1].name == "near@1");
}

TEST_CASE("add_query_points: distances from a cube are those of its closed form, sides are certain") {
  QueryParameters parameters = queries_of("near=3000@.01,.2 near-sharp=1000@.05 volume=2000@1.5");
  for (const bool halves : {false, true}) {
    parameters.halves = halves;
    for (const PolygonMesh& mesh :
         {cube(), inside_out(cube()), merged(cube(), cube()), merged(cube(), inside_out(cube()))}) {
      const Row row = with_queries(mesh, parameters);
      const Samples& s = row.samples;
      REQUIRE(s.query_points.size() == 18000);
      CHECK(row.report.sign_rule == SignRule::closed);
      std::uint32_t on_surface = 0;  // coordinates that are rounded may be those of a face
      for (std::size_t i = 0; i < 6000; ++i) {
        const double exact = cube_distance(place_of(row, i)), distance = 2 * double{s.query_distance[i]};
        CHECK(distance == Approx(exact).margin(halves ? 2e-3 * (1e-2 + std::abs(exact)) : 1e-6));
        if (halves && exact == 0) {
          ++on_surface;
          continue;
        }
        CHECK((s.query_inside[i] != 0) == (exact < 0));
        CHECK(std::abs(s.query_winding[i]) == Approx(exact < 0 ? 1 : 0));
        CHECK(s.query_certain[i] == 1);
        if (!halves) continue;
        CHECK(rounded_to_half(s.query_points[3 * i]) == s.query_points[3 * i]);
        CHECK(rounded_to_half(s.query_distance[i]) == s.query_distance[i]);
      }
      CHECK(row.report.uncertain == on_surface);
    }
  }
}

TEST_CASE("add_query_points: every prefix has its share of each group, and moves are Gaussian") {
  const QueryParameters parameters = queries_of("near=4000@.02,.05 near-sharp=1000@.01 volume=3000@1.5");
  const Row row = with_queries(cube(), parameters);
  const Samples& s = row.samples;
  const std::array<double, 4> shares = {0.25, 0.25, 0.125, 0.375};
  std::array<double, 4> seen{}, squares{}, moves{};
  for (std::size_t i = 0; i < 8000; ++i) {
    const std::size_t group = s.query_kind[i];
    REQUIRE(group < 4);
    ++seen[group];
    for (std::size_t g = 0; g < 4; ++g) CHECK(std::abs(seen[g] - shares[g] * static_cast<double>(i + 1)) < 2);
    // In the middle of a face a point of the surface is moved off it along one axis.
    const auto at = place_of(row, i);
    int middle = 0;
    for (const double x : at) middle += std::abs(x) < 0.6;
    if (middle != 2) continue;
    const double distance = 2 * double{s.query_distance[i]};
    ++moves[group];
    squares[group] += distance * distance;
  }
  for (const auto& [group, sigma] : {std::pair<std::size_t, double>{0, 0.02}, {1, 0.05}}) {
    REQUIRE(moves[group] > 300);
    CHECK(std::sqrt(squares[group] / moves[group]) == Approx(sigma).epsilon(0.08));
  }
  // Points on edges and in the box.
  for (std::size_t i = 0; i < 8000; ++i) {
    const auto at = place_of(row, i);
    if (s.query_kind[i] == 3)
      for (const double x : at) CHECK(std::abs(x) <= 1.5 + 1e-6);
    if (s.query_kind[i] != 2) continue;
    int at_side = 0;
    for (const double x : at) at_side += std::abs(std::abs(x) - 1) < 0.06;
    CHECK(at_side >= 2);
  }
  CHECK(with_queries(cube(), parameters, true, 2).samples.query_points != s.query_points);
  // In a frame of its own a box of the size 1 is [-scale, scale] around loc.
  const Row framed = with_queries(cube(), queries_of("volume=500@1"), false);
  for (const float x : framed.samples.query_points) CHECK(std::abs(x) <= 1);
  CHECK(*std::max_element(framed.samples.query_points.begin(), framed.samples.query_points.end()) > 0.98f);
}

TEST_CASE("add_query_points: moves have the bounds and the moments of their kinds") {
  // On a plane the height is one component of the move.
  struct Wanted {
    QueryMove move;
    double cut, largest, deviation;
  };
  constexpr double size = 0.02, infinite = std::numeric_limits<double>::infinity();
  for (const auto& [move, cut, largest, deviation] :
       {Wanted{QueryMove::gaussian, 0, infinite, size},
        // A normal variable within one deviation has the variance 0.2911.
        Wanted{QueryMove::gaussian, size, size, 0.539560 * size},
        Wanted{QueryMove::gaussian, 10 * size, infinite, size},
        Wanted{QueryMove::uniform, 0, size, size / std::sqrt(3.0)},
        Wanted{QueryMove::along_normal, 0, infinite, size},
        Wanted{QueryMove::along_normal, size, size, 0.539560 * size}}) {
    QueryParameters parameters = queries_of("near=8000@.02");
    parameters.move = move;
    parameters.cut = cut;
    const Row row = with_queries(grid_plane(6, 6, 2, 2), parameters);
    double sum = 0, squares = 0, most = 0, across = 0;
    std::vector<double> moves;
    for (std::size_t i = 0; i < 8000; ++i) {
      const auto at = place_of(row, i);
      sum += at[2];
      squares += at[2] * at[2];
      most = std::max(most, std::abs(at[2]));
      moves.push_back(at[2]);
      for (const std::size_t k : {std::size_t{0}, std::size_t{1}})
        across = std::max(across, std::abs(at[k] - 1));
    }
    // Nets err far less than random numbers would, 1 / sqrt(8000).
    CHECK(std::abs(sum / 8000) < 0.005 * size);
    CHECK(std::sqrt(squares / 8000) == Approx(deviation).epsilon(0.01));
    CHECK(most <= largest * (1 + 1e-5));
    CHECK(most > std::min(largest, 3 * size) * 0.99);
    CHECK((across <= 1 + 1e-6) == (move == QueryMove::along_normal));
    // Every prefix is as even.
    const auto below = std::count_if(moves.begin(), moves.begin() + 512, [](double z) { return z < 0; });
    CHECK(std::abs(below - 256) <= 2);
    CHECK(with_queries(grid_plane(6, 6, 2, 2), parameters).samples.query_points == row.samples.query_points);
  }
}

TEST_CASE("add_query_points: moves along the normal at an edge keep between its two faces") {
  QueryParameters parameters = queries_of("near-sharp=600@.1 volume=10@1");
  parameters.move = QueryMove::along_normal;
  const Row row = with_queries(cube(), parameters);
  for (std::size_t i = 0; i < 610; ++i) {
    if (row.samples.query_kind[i] != 0) continue;
    const auto at = place_of(row, i);
    // The two coordinates across the edge have moved by the same.
    std::array<double, 3> over{};
    for (std::size_t k = 0; k < 3; ++k) over[k] = std::abs(at[k]) - 1;
    const bool same = std::abs(over[0] - over[1]) < 1e-5 || std::abs(over[1] - over[2]) < 1e-5 ||
                      std::abs(over[2] - over[0]) < 1e-5;
    CHECK(same);
  }
}

TEST_CASE("add_query_points: faces, corners and weights name the nearest point") {
  QueryParameters parameters = queries_of("near=1000@.1 volume=1000@1.5");
  parameters.nearest = true;
  // The doubled faces are those of the cube, whose numbers stay.
  for (const PolygonMesh& mesh : {cube(), merged(cube(), cube()), icosphere(2)}) {
    const Row row = with_queries(mesh, parameters);
    const Samples& s = row.samples;
    for (std::size_t i = 0; i < 2000; ++i) {
      const auto at = place_of(row, i);
      const double b1 = double{s.query_barycentric[2 * i]}, b2 = double{s.query_barycentric[2 * i + 1]};
      const std::array<double, 3> weights = {1 - b1 - b2, b1, b2};
      std::array<double, 3> nearest{};
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t v = s.query_corners[3 * i + k];
        nearest[0] += weights[k] * mesh.x[v];
        nearest[1] += weights[k] * mesh.y[v];
        nearest[2] += weights[k] * mesh.z[v];
        const auto begin = mesh.corners.begin() + mesh.polygon_begin[s.query_face[i]],
                   end = mesh.corners.begin() + mesh.polygon_begin[s.query_face[i] + 1];
        CHECK(std::find(begin, end, v) != end);
      }
      CHECK(std::hypot(at[0] - nearest[0], at[1] - nearest[1], at[2] - nearest[2]) ==
            Approx(2 * std::abs(double{s.query_distance[i]})).margin(1e-6));
    }
  }
}

TEST_CASE("add_query_points: how sides are decided is said, and what has none is uncertain") {
  QueryParameters parameters = queries_of("volume=2000@1");
  const PolygonMesh sheet = grid_plane(4, 4);
  const Row open = with_queries(sheet, parameters);
  CHECK(open.report.sign_rule == SignRule::shell);
  CHECK(std::all_of(open.samples.query_winding.begin(), open.samples.query_winding.end(),
                    [](float w) { return std::isnan(w); }));
  const auto certain = std::count(open.samples.query_certain.begin(), open.samples.query_certain.end(), 1);
  CHECK(open.report.uncertain == 2000 - certain);

  parameters.sign = SignChoice::closed;
  const Row refused = with_queries(sheet, parameters);
  CHECK(refused.report.sign_rule == SignRule::none);
  CHECK(refused.report.uncertain == 2000);
  CHECK(std::count(refused.samples.query_certain.begin(), refused.samples.query_certain.end(), 1) == 0);
  CHECK(with_queries(cube(), parameters).report.sign_rule == SignRule::closed);

  parameters.sign = SignChoice::none;
  const Row unsigned_row = with_queries(cube(), parameters);
  CHECK(unsigned_row.samples.query_inside.empty());
  CHECK(unsigned_row.samples.query_winding.empty());
  CHECK(*std::min_element(unsigned_row.samples.query_distance.begin(),
                          unsigned_row.samples.query_distance.end()) >= 0);

  // A missing face: nearly closed.
  PolygonMesh box = icosphere(3);
  box.corners.resize(box.corners.size() - 3);
  box.polygon_begin.pop_back();
  parameters.sign = SignChoice::automatic;
  const Row nearly = with_queries(box, parameters);
  CHECK(nearly.report.sign_rule == SignRule::winding);
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < 2000; ++i) {
    const auto at = place_of(nearly, i);
    const double radius = std::hypot(at[0], at[1], at[2]);
    if (std::abs(radius - 1) > 0.05 && nearly.samples.query_certain[i] == 1)
      wrong += (nearly.samples.query_inside[i] != 0) != (radius < 1);
  }
  CHECK(wrong == 0);
}

TEST_CASE("add_query_points: without a sharp edge points near sharp edges are near the surface") {
  const Row row = with_queries(icosphere(3), queries_of("near-sharp=500@.001"));
  for (const float distance : row.samples.query_distance) CHECK(std::abs(distance) < 0.01f);
}
