#include "kernels/describe/oriented_pairs.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "kernels/core/random.h"
#include "kernels/core/rotation.h"
#include "kernels/describe/local_pairs.h"
#include "kernels/describe/outward_normals.h"
#include "kernels/mesh/prepare_mesh.h"
#include "support/catch.h"
#include "support/test_meshes.h"
#include "support/threads.h"

using namespace meander;

namespace {

constexpr double degree = std::numbers::pi / 180;

struct Points {
  std::vector<float> places, normals;

  void add(Vector3 place, Vector3 normal) {
    for (const double v : {place.x, place.y, place.z}) places.push_back(static_cast<float>(v));
    for (const double v : {normal.x, normal.y, normal.z}) normals.push_back(static_cast<float>(v));
  }
  std::size_t count() const { return places.size() / 3; }
  Vector3 place(std::size_t i) const { return {places[3 * i], places[3 * i + 1], places[3 * i + 2]}; }
  Vector3 normal(std::size_t i) const { return {normals[3 * i], normals[3 * i + 1], normals[3 * i + 2]}; }
};

Vector3 direction(const UnitPair& u) {
  const double z = 2 * u.first - 1, s = std::sqrt(1 - z * z), turn = 2 * std::numbers::pi * u.second;
  return {s * std::cos(turn), s * std::sin(turn), z};
}

// Points of a box of sides 1, 0.7, 0.4 with normals of any direction.
Points box_samples(std::size_t n) {
  const RandomKey key = make_random_key(1, {});
  Points points;
  for (std::size_t i = 0; i < n; ++i) {
    const UnitPair a = random_pair(key, Stream::point_set, i, 0),
                   b = random_pair(key, Stream::point_set, i, 1);
    points.add({a.first, 0.7 * a.second, 0.4 * b.first},
               direction(random_pair(key, Stream::point_set, i, 2)));
  }
  return points;
}

Points sphere_points(std::size_t n, double radius) {
  Points points;
  for (std::size_t i = 0; i < n; ++i) {
    const Vector3 d = direction(random_pair(make_random_key(5, {}), Stream::point_set, i));
    points.add(radius * d, d);
  }
  return points;
}

OrientedPairHistogram histogram_of(const Points& points, NormalSense sense = NormalSense::signed_normals,
                                   InstructionSet set = InstructionSet::automatic) {
  return oriented_pair_histogram(points.places, points.normals, {.sense = sense, .instructions = set});
}

const PairAngleEdges& edges_of(NormalSense sense) {
  return sense == NormalSense::signed_normals ? signed_angle_edges : either_side_angle_edges;
}

std::size_t bin_of(double degrees, const std::array<double, 3>& edges) {
  return static_cast<std::size_t>(
      std::count_if(edges.begin(), edges.end(), [&](double edge) { return degrees > edge; }));
}

std::size_t slot_of(double over_mean, double a, double b, double between, NormalSense sense) {
  const auto far = static_cast<std::size_t>(
      std::min(over_mean * pair_distance_bins / pair_distance_range, pair_distance_bins - 0.5));
  const std::size_t i = bin_of(a, edges_of(sense).line), j = bin_of(b, edges_of(sense).line);
  return ((far * 4 + std::min(i, j)) * 4 + std::max(i, j)) * 4 + bin_of(between, edges_of(sense).normals);
}

double angle(Vector3 a, Vector3 b, NormalSense sense) {
  const double degrees = std::atan2(norm(cross(a, b)), dot(a, b)) / degree;
  return sense == NormalSense::either_side ? std::min(degrees, 180 - degrees) : degrees;
}

bool near_edge(double degrees, const std::array<double, 3>& edges) {
  return std::any_of(edges.begin(), edges.end(), [&](double e) { return std::abs(degrees - e) < 1e-3; });
}

// A double loop with angles in degrees. Pairs near an edge may be elsewhere.
void check_against_reference(const Points& points, NormalSense sense) {
  const std::size_t n = points.count();
  double mean = 0;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < i; ++j) mean += norm(points.place(i) - points.place(j));
  mean /= 0.5 * static_cast<double>(n) * static_cast<double>(n - 1);
  std::vector<std::uint64_t> counts(oriented_pair_bins);
  std::uint64_t doubtful = 0;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const Vector3 line = points.place(j) - points.place(i);
      const double a = angle(points.normal(i), line, sense), b = angle(points.normal(j), -1.0 * line, sense),
                   c = angle(points.normal(i), points.normal(j), sense), d = norm(line) / mean;
      ++counts[slot_of(d, a, b, c, sense)];
      const double at = d * pair_distance_bins / pair_distance_range;
      const bool doubt = near_edge(a, edges_of(sense).line) || near_edge(b, edges_of(sense).line) ||
                         near_edge(c, edges_of(sense).normals) || std::abs(at - std::round(at)) < 1e-5;
      doubtful += doubt ? 1 : 0;
    }
  const OrientedPairHistogram histogram = histogram_of(points, sense);
  CHECK(histogram.mean_distance == Approx(mean).epsilon(1e-6));
  REQUIRE(histogram.counts.size() == oriented_pair_bins);
  std::uint64_t moved = 0, all = 0;
  double squares = 0;
  for (std::size_t b = 0; b < oriented_pair_bins; ++b) {
    moved += std::max(counts[b], histogram.counts[b]) - std::min(counts[b], histogram.counts[b]);
    all += histogram.counts[b];
    squares += double{histogram.roots[b]} * double{histogram.roots[b]};
    CHECK(histogram.roots[b] == Approx(std::sqrt(static_cast<double>(histogram.counts[b]) /
                                                 (0.5 * static_cast<double>(n * (n - 1))))));
  }
  CHECK(moved <= 2 * doubtful);
  CHECK(all == n * (n - 1) / 2);
  CHECK(histogram.pairs == all);
  CHECK(squares == Approx(1).epsilon(1e-5));
}

double l1(const OrientedPairHistogram& a, const OrientedPairHistogram& b) {
  double sum = 0;
  for (std::size_t k = 0; k < oriented_pair_bins; ++k)
    sum += std::abs(static_cast<double>(a.counts[k]) - static_cast<double>(b.counts[k]));
  return sum / static_cast<double>(a.pairs);
}

}  // namespace

TEST_CASE("oriented pairs: two points with given normals fall into the bin of their angles") {
  for (const double a : {20.0, 90.0, 110.0, 160.0})
    for (const double b : {40.0, 88.0, 100.0, 140.0})
      for (const NormalSense sense : {NormalSense::signed_normals, NormalSense::either_side}) {
        Points points;
        points.add({1, 2, 3}, {std::cos(a * degree), std::sin(a * degree), 0});
        points.add({6, 2, 3}, {-std::cos(b * degree), std::sin(b * degree), 0});
        const auto folded = [&](double t) {
          return sense == NormalSense::either_side ? std::min(t, 180 - t) : t;
        };
        const std::size_t slot = slot_of(1, folded(a), folded(b), folded(std::abs(180 - a - b)), sense);
        INFO(a << ", " << b << ": " << slot);
        const OrientedPairHistogram histogram = histogram_of(points, sense);
        CHECK(histogram.counts[slot] == 1);
        CHECK(histogram.roots[slot] == 1);
        CHECK(histogram.mean_distance == 5);
      }
}

TEST_CASE("oriented pairs: on a sphere the line makes half the angle of the normals plus 90 degrees") {
  const Points points = sphere_points(3000, 2.5);
  const OrientedPairHistogram histogram = histogram_of(points);
  CHECK(histogram.mean_distance == Approx(4 * 2.5 / 3).epsilon(0.01));
  // Of the pairs, (cos s - cos t) / 2 are between s and t apart, seen from the center; chords are 2 R sin(t /
  // 2).
  std::vector<double> expected(oriented_pair_bins);
  constexpr int steps = 100000;
  for (int k = 0; k < steps; ++k) {
    const double t = 180 * (k + 0.5) / steps, half = 90.0 / steps;
    const double share = (std::cos((t - half) * degree) - std::cos((t + half) * degree)) / 2;
    expected[slot_of(1.5 * std::sin(t / 2 * degree), 90 + t / 2, 90 + t / 2, t,
                     NormalSense::signed_normals)] += share;
  }
  for (std::size_t b = 0; b < oriented_pair_bins; ++b) {
    INFO(b);
    CHECK(static_cast<double>(histogram.counts[b]) / static_cast<double>(histogram.pairs) ==
          Approx(expected[b]).margin(0.01));
  }
}

TEST_CASE("oriented pairs: agree with a double loop over all pairs") {
  for (const NormalSense sense : {NormalSense::signed_normals, NormalSense::either_side}) {
    for (const std::size_t n : {2, 3, 5, 33, 34, 300}) {
      INFO(n << " points");
      check_against_reference(box_samples(n), sense);
    }
    check_against_reference(sphere_points(300, 3), sense);
  }
  check_against_reference(box_samples(1037), NormalSense::signed_normals);  // tiles in both directions
}

TEST_CASE("oriented pairs: every instruction set, number of threads and order gives the same bits") {
  for (const std::size_t n : {2, 17, 64, 1023, 1500})
    for (const NormalSense sense : {NormalSense::signed_normals, NormalSense::either_side}) {
      const Points points = n == 1023 ? sphere_points(n, 3) : box_samples(n);
      const OrientedPairHistogram reference = histogram_of(points, sense, InstructionSet::scalar);
      for (const InstructionSet set : {InstructionSet::avx2, InstructionSet::avx512}) {
        if (!is_available(set)) continue;
        INFO(n << " points, " << name_of(set));
        CHECK(histogram_of(points, sense, set).counts == reference.counts);
      }
      for (const std::size_t threads : {1u, 4u}) {
        const auto again = test::on_threads(threads, [&] { return histogram_of(points, sense); });
        CHECK(again.counts == reference.counts);
        CHECK(again.roots == reference.roots);
      }
      Points turned;  // last to first
      for (std::size_t i = n; i-- > 0;) turned.add(points.place(i), points.normal(i));
      CHECK(histogram_of(turned, sense).counts == reference.counts);
    }
}

TEST_CASE(
    "oriented pairs: invariant to position, rotation and size, and unsigned ones to the sign of a normal") {
  const Points points = box_samples(701);
  const Rotation turn = random_rotation(make_random_key(9, {}), Stream::point_set);
  Points changed, half, opposite;
  for (std::size_t i = 0; i < points.count(); ++i) {
    changed.add(7 * rotated(turn, points.place(i)) + Vector3{1, -2, 3}, rotated(turn, points.normal(i)));
    half.add(points.place(i), (i % 2 == 0 ? -1.0 : 1.0) * points.normal(i));
    opposite.add(points.place(i), -1.0 * points.normal(i));
  }
  for (const NormalSense sense : {NormalSense::signed_normals, NormalSense::either_side}) {
    const OrientedPairHistogram reference = histogram_of(points, sense);
    CHECK(l1(histogram_of(changed, sense), reference) < 1e-4);  // pairs at edges, as rounding has it
    const bool without_sense = sense == NormalSense::either_side;
    CHECK((histogram_of(half, sense).counts == reference.counts) == without_sense);
    CHECK((histogram_of(opposite, sense).counts == reference.counts) == without_sense);
  }
}

TEST_CASE("oriented pairs: planes and right angles are inside bins in any direction") {
  // Samples of a cube: coplanar pairs and faces at right angles, where an edge at 90 degrees would be noise.
  const RandomKey key = make_random_key(3, {});
  Points points;
  for (std::size_t i = 0; i < 600; ++i) {
    const UnitPair u = random_pair(key, Stream::point_set, i);
    double place[3] = {0, 0, 0}, normal[3] = {0, 0, 0};
    const std::size_t axis = i % 3;
    place[axis] = normal[axis] = i % 2 == 0 ? 1 : -1;
    place[(axis + 1) % 3] = 2 * u.first - 1;
    place[(axis + 2) % 3] = 2 * u.second - 1;
    points.add({place[0], place[1], place[2]}, {normal[0], normal[1], normal[2]});
  }
  Points changed;
  const Rotation turn = random_rotation(make_random_key(10, {}), Stream::point_set);
  for (std::size_t i = 0; i < points.count(); ++i)
    changed.add(rotated(turn, points.place(i)), rotated(turn, points.normal(i)));
  for (const NormalSense sense : {NormalSense::signed_normals, NormalSense::either_side})
    CHECK(l1(histogram_of(changed, sense), histogram_of(points, sense)) < 1e-4);
}

TEST_CASE("oriented pairs: coincident points are counted, invalid arguments refused") {
  Points spot;
  for (int i = 0; i < 10; ++i) spot.add({4, 4, 4}, {0, 0, 1});
  const OrientedPairHistogram histogram = histogram_of(spot);
  CHECK(histogram.mean_distance == 0);
  CHECK(histogram.counts[0] == 45);
  const Points points = box_samples(10);
  CHECK_THROWS_AS(oriented_pair_histogram(std::vector<float>(3), std::vector<float>(3)),
                  std::invalid_argument);
  CHECK_THROWS_AS(oriented_pair_histogram(points.places, std::vector<float>(27)), std::invalid_argument);
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    std::vector<float> broken = points.places;
    broken[7] = bad;
    CHECK_THROWS_AS(oriented_pair_histogram(broken, points.normals), std::invalid_argument);
    CHECK_THROWS_AS(oriented_pair_histogram(points.places, broken), std::invalid_argument);
  }
}

namespace {

// The least of (center of triangle - center) . normal over the triangles whose center is nearer to `center`
// than 1.5.
double least_outward(const PreparedMesh& mesh, const OutwardNormals& outward, Vector3 center) {
  double least = 1;
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
    Vector3 place;
    for (std::size_t k = 0; k < 3; ++k) place = place + mesh.position(mesh.triangles[3 * t + k]);
    place = mesh.unit * ((1.0 / 3) * place) + mesh.center - center;
    const Vector3 normal = {outward.normals[3 * t], outward.normals[3 * t + 1], outward.normals[3 * t + 2]};
    if (norm(place) < 1.5) least = std::min(least, dot(place, normal));
  }
  return least;
}

std::vector<std::uint32_t> all_triangles(const PreparedMesh& mesh) {
  std::vector<std::uint32_t> triangles(mesh.triangle_count());
  for (std::uint32_t t = 0; t < triangles.size(); ++t) triangles[t] = t;
  return triangles;
}

}  // namespace

TEST_CASE("outward normals: closed components by their volume, open ones away from the centroid") {
  const PolygonMesh ball = test::icosphere(2);
  for (const bool first : {false, true})
    for (const bool second : {false, true}) {
      const PolygonMesh far = test::moved(ball, 1, 5, 0, 0);
      const PreparedMesh mesh = prepare_mesh(
          test::merged(first ? test::inside_out(ball) : ball, second ? test::inside_out(far) : far));
      const OutwardNormals outward = outward_normals(mesh, all_triangles(mesh));
      CHECK(outward.unoriented_share == 0);
      CHECK(least_outward(mesh, outward, {0, 0, 0}) > 0.9);
      CHECK(least_outward(mesh, outward, {5, 0, 0}) > 0.9);
    }
  // Two squares with a ball between them: each faces away from it, whatever its winding.
  for (const bool turned : {false, true}) {
    PolygonMesh squares = test::polygon_mesh({-1, -1, 4,  1, -1, 4,  1, 1, 4,  -1, 1, 4,  //
                                              -1, -1, -4, 1, -1, -4, 1, 1, -4, -1, 1, -4},
                                             {{0, 1, 2, 3}, {4, 5, 6, 7}});
    if (turned) squares = test::inside_out(squares);
    const PreparedMesh mesh = prepare_mesh(test::merged(ball, squares));
    const OutwardNormals outward = outward_normals(mesh, all_triangles(mesh));
    CHECK(outward.unoriented_share == Approx(4.0 / (320 + 4)));
    std::size_t of_squares = 0;
    for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
      const double z = mesh.unit * mesh.position(mesh.triangles[3 * t]).z + mesh.center.z;
      if (std::abs(z) < 2) continue;
      ++of_squares;
      CHECK(outward.normals[3 * t + 2] == (z > 0 ? 1 : -1));
    }
    CHECK(of_squares == 4);
  }
  const PreparedMesh mesh = prepare_mesh(ball);
  CHECK_THROWS_AS(outward_normals(mesh, std::vector<std::uint32_t>{320}), std::invalid_argument);
}

namespace {

// The histogram around one point by a double loop; pairs near an edge are counted in `doubtful`.
std::vector<double> local_reference(const Points& points, std::size_t center, double radius,
                                    NormalSense sense, std::size_t& doubtful) {
  const std::size_t n = points.count();
  Vector3 centroid{};
  for (std::size_t i = 0; i < n; ++i) centroid = centroid + points.place(i);
  centroid = (1 / static_cast<double>(n)) * centroid;
  double squares = 0;
  for (std::size_t i = 0; i < n; ++i) squares += dot(points.place(i) - centroid, points.place(i) - centroid);
  const double reach = radius * std::sqrt(squares / static_cast<double>(n));
  std::vector<double> counts(local_pair_bins, 0);
  for (std::size_t j = 0; j < n; ++j) {
    if (j == center) continue;
    const Vector3 line = points.place(j) - points.place(center);
    const double bins = norm(line) / reach * local_distance_bins;
    if (std::abs(bins - std::round(bins)) < 1e-5) ++doubtful;
    if (bins >= local_distance_bins) continue;
    const double a = angle(points.normal(center), line, sense),
                 b = angle(points.normal(j), -1.0 * line, sense),
                 c = angle(points.normal(center), points.normal(j), sense);
    if (near_edge(a, edges_of(sense).line) || near_edge(b, edges_of(sense).line) ||
        near_edge(c, edges_of(sense).normals))
      ++doubtful;
    ++counts[slot_of(bins * pair_distance_range / pair_distance_bins, a, b, c, sense)];
  }
  return counts;
}

}  // namespace

TEST_CASE("local pairs: each of the first points has the histogram of what lies within the radius") {
  for (const NormalSense sense : {NormalSense::signed_normals, NormalSense::either_side})
    for (const std::size_t n : {std::size_t{2}, std::size_t{300}, std::size_t{1101}}) {
      const Points points = box_samples(n);
      const LocalPairParameters parameters{.sense = sense, .centers = 20, .radius = 0.9};
      const std::vector<float> roots = local_pair_histograms(points.places, points.normals, parameters);
      REQUIRE(roots.size() == std::min<std::size_t>(20, n) * local_pair_bins);
      for (std::size_t i = 0; i < std::min<std::size_t>(20, n); ++i) {
        std::size_t doubtful = 0;
        const std::vector<double> counts = local_reference(points, i, 0.9, sense, doubtful);
        double all = 0, moved = 0;
        for (const double count : counts) all += count;
        for (std::size_t b = 0; b < local_pair_bins; ++b) {
          const auto root = static_cast<double>(roots[i * local_pair_bins + b]);
          moved += std::abs(root * root * all - counts[b]);
        }
        CHECK(moved <= 2.0 * static_cast<double>(doubtful) + 1e-3);
      }
    }
}

TEST_CASE(
    "local pairs: the same bits for every instruction set, place, size, sense and order of the others") {
  const Points points = box_samples(700);
  const auto made = [](const Points& of, LocalPairParameters parameters = {}) {
    return local_pair_histograms(of.places, of.normals, parameters);
  };
  const std::vector<float> expected = made(points);
  for (const InstructionSet set : {InstructionSet::scalar, InstructionSet::avx2, InstructionSet::avx512})
    if (is_available(set)) CHECK(made(points, {.instructions = set}) == expected);
  for (const std::size_t threads : {1u, 3u})
    CHECK(test::on_threads(threads, [&] { return made(points); }) == expected);
  Points turned = points, larger = points, reversed;
  for (std::size_t i = 0; i < points.count(); ++i)
    if (i % 2 == 1)
      for (std::size_t k = 0; k < 3; ++k) turned.normals[3 * i + k] *= -1;
  CHECK(made(turned) == expected);
  CHECK(made(turned, {.sense = NormalSense::signed_normals}) !=
        made(points, {.sense = NormalSense::signed_normals}));
  for (float& coordinate : larger.places) coordinate *= 1024;
  CHECK(made(larger) == expected);
  for (std::size_t i = 0; i < points.count(); ++i) {
    const std::size_t from = i < 160 ? i : points.count() + 159 - i;
    reversed.add(points.place(from), points.normal(from));
  }
  const std::vector<float> other_order = made(reversed, {.centers = 160});
  double difference = 0;  // the size is a sum over all points
  for (std::size_t b = 0; b < other_order.size(); ++b)
    difference += std::abs(static_cast<double>(other_order[b]) - static_cast<double>(expected[b]));
  CHECK(difference < 1);
}

TEST_CASE("local pairs: a radius of spacings reaches as many points of another size, fewer of more samples") {
  // A square grid: the nearest point of every one is at distance 1, so that 3.5 spacings are 3.5.
  const auto grid = [](int side, float step) {
    Points points;
    for (int i = 0; i < side * side; ++i)
      points.add({step * static_cast<float>(i % side), step * static_cast<float>(i / side), 0}, {0, 0, 1});
    return points;
  };
  const auto bins_taken = [](const Points& points, const LocalPairParameters& parameters) {
    const std::vector<float> roots = local_pair_histograms(points.places, points.normals, parameters);
    return std::vector<float>(roots.begin() + 50 * local_pair_bins, roots.begin() + 51 * local_pair_bins);
  };
  const LocalPairParameters spacings{.radius = 3.5, .unit = RadiusUnit::spacing};
  const std::vector<float> of_ten = bins_taken(grid(10, 1), spacings);
  // By hand: around (0, 5) lie 21 points within 3.5; the third of the bins, from 1 to 1.5, has 3 at 1, 2
  // at 1.41.
  double within_one = 0;
  for (std::size_t b = 2 * 64; b < 3 * 64; ++b) within_one += static_cast<double>(of_ten[b] * of_ten[b]);
  CHECK(within_one == Approx(5.0 / 21).epsilon(1e-5));
  CHECK(bins_taken(grid(10, 4), spacings) == of_ten);
  CHECK(bins_taken(grid(10, 1), {.radius = 3.5}) != of_ten);
}

TEST_CASE("local pairs: points that coincide, and invalid input") {
  Points same;
  for (int i = 0; i < 5; ++i) same.add({1, 2, 3}, {0, 0, 1});
  for (const float root : local_pair_histograms(same.places, same.normals)) CHECK((root >= 0 && root <= 1));
  const Points points = box_samples(10);
  const std::span<const float> places = points.places;
  CHECK_THROWS_AS(local_pair_histograms(places.first(3), places.first(3)), std::invalid_argument);
  CHECK_THROWS_AS(local_pair_histograms(places, places.first(27)), std::invalid_argument);
  CHECK_THROWS_AS(local_pair_histograms(places, points.normals, {.radius = 0}), std::invalid_argument);
}
