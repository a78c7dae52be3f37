// The kernel of spaced samples, and what it stands on: the grid of strata, the loops over distances.
#include "kernels/sample/spaced_samples.h"

#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <map>
#include <numeric>
#include <random>
#include <set>

#include "kernels/analyse/coverage.h"
#include "kernels/analyse/spacing.h"
#include "kernels/mesh/prepare_mesh.h"
#include "kernels/partition/element_cells.h"
#include "kernels/sample/far_field.h"
#include "kernels/sample/kernel_sums.h"
#include "kernels/sample/mesh_strata.h"
#include "kernels/sample/packed_rows.h"
#include "kernels/sample/place_samples.h"
#include "kernels/sample/sequence.h"
#include "kernels/sample/stratum_grid.h"
#include "kernels/sample/stratum_lists.h"
#include "support/catch.h"
#include "support/sanitized.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

const RandomKey test_key = make_random_key(11, {});
const MetricAt in_space;

// A mesh with strata of either kind.
struct StrataOfMesh {
  PreparedMesh mesh;
  Density density;
  CurveElements elements;
  ElementCells cells;

  RandomKey key;

  StrataOfMesh(const PolygonMesh& file, std::uint32_t n, bool linear_density = false,
               RandomKey random_key = test_key)
      : mesh(prepare_mesh(file)), key(random_key) {
    if (linear_density)
      for (const std::uint32_t v : mesh.triangles) density.corner.push_back(mesh.x[v] + 1.5);
    ElementParameters parameters;
    parameters.samples = n;
    const MeshMeasure measure = measure_of(mesh, density);
    elements = build_elements({mesh, measure, key}, parameters);
    parameters.elements_per_sample = 16;
    parameters.use = ElementUse::places;
    cells = build_cells({mesh, measure, key}, parameters);
  }
  CurveStrata along_curve(std::uint32_t n) const { return {elements, n, mesh, density, key, in_space}; }
  CellStrata in_cells() const { return {cells, mesh, density, key, in_space}; }
};

std::vector<double> points_of(const SpacedSamples& samples, std::size_t first) {
  std::vector<double> points;
  for (std::size_t i = 0; i < first; ++i)
    for (const float c : samples.point[samples.rank_of_index[i]].at) points.push_back(static_cast<double>(c));
  return points;
}

double rho_of(const SpacedSamples& samples, std::size_t first, double area) {
  return spacing_of(nearest_distances(points_of(samples, first)), area).rho;
}

PointRows rows_of(const std::vector<std::array<float, 3>>& points) {
  PointRows rows;
  for (const auto& p : points) rows.push_back(p[0], p[1], p[2]);
  return rows;
}

std::vector<std::array<float, 3>> random_points(std::size_t count, std::uint32_t seed) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<float> uniform(-1, 1);
  std::vector<std::array<float, 3>> points(count);
  for (auto& p : points) p = {uniform(engine), uniform(engine), uniform(engine)};
  return points;
}

bool same(const SpacedSamples& a, const SpacedSamples& b) {
  if (a.rank_of_index != b.rank_of_index) return false;
  for (std::size_t i = 0; i < a.point.size(); ++i)
    if (a.point[i].at != b.point[i].at || a.point[i].triangle != b.point[i].triangle ||
        a.point[i].path != b.point[i].path || a.point[i].first != b.point[i].first ||
        a.point[i].second != b.point[i].second)
      return false;
  return true;
}

}  // namespace

TEST_CASE(
    "kernel sums: kernels match sums in double precision, with the same bits for all instruction sets") {
  for (const std::size_t places : {1u, 8u, 33u})
    for (const std::size_t points : {3u, 200u}) {
      const auto place = random_points(places, 1), point = random_points(points, 2);
      for (const float short_weight : {0.0f, 5.0f}) {
        const KernelScale scale{1 / 0.8f, 1 / 0.3f, 2, short_weight};
        const std::size_t first = points / 3, count = points - first;
        std::vector<double> expected(places, 1);
        for (std::size_t k = 0; k < places; ++k)
          for (std::size_t i = first; i < points; ++i) {
            double squared = 0;
            for (std::size_t c = 0; c < 3; ++c)
              squared += std::pow(double(place[k][c]) - double(point[i][c]), 2);
            const double d = std::sqrt(squared);
            expected[k] += 2 * std::pow(std::max(1 - d / 0.8, 0.0), 2) +
                           double(short_weight) * std::pow(std::max(1 - d / 0.3, 0.0), 2);
          }
        std::vector<float> sums[2];
        for (const InstructionSet set : {InstructionSet::scalar, InstructionSet::avx2}) {
          std::vector<float>& sum = sums[set == InstructionSet::avx2];
          sum.assign(places, 1);
          add_kernel(rows_of(place), rows_of(point), first, count, scale, sum, set);
          for (std::size_t k = 0; k < places; ++k) CHECK(double(sum[k]) == Approx(expected[k]).epsilon(1e-5));
        }
        CHECK(sums[0] == sums[1]);
      }
    }
}

TEST_CASE("kernel sums: groups attract like their points") {
  // 500 points in a box of .3 x .2 x .1, a distance of 1 to 2 away; the reach is 4, farther than all of them.
  const auto inner = random_points(500, 3);
  PointGroup group;
  group.mass = 500;
  std::vector<std::array<float, 3>> points;
  for (const auto& p : inner) points.push_back({0.3f * p[0], 0.2f * p[1], 0.1f * p[2]});
  for (const auto& p : points)
    for (std::size_t c = 0; c < 3; ++c) group.mean[c] += p[c] / 500;
  constexpr std::array<std::array<std::size_t, 2>, 6> of = {{{0, 0}, {1, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}}};
  for (const auto& p : points)
    for (std::size_t m = 0; m < 6; ++m)
      group.central[m] += (p[of[m][0]] - group.mean[of[m][0]]) * (p[of[m][1]] - group.mean[of[m][1]]) / 500;
  group.per_extent = 1 / std::sqrt(2 * (group.central[0] + group.central[1] + group.central[2]));
  std::vector<std::array<float, 3>> places;
  for (const auto& p : random_points(40, 4)) {
    const float length = std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]) + 1e-3f;
    const float distance = 1 + std::fmod(length * 7, 1.0f);
    places.push_back({p[0] / length * distance, p[1] / length * distance, p[2] / length * distance});
  }
  std::vector<float> exact(places.size(), 0), sums[2];
  add_kernel(rows_of(places), rows_of(points), 0, points.size(), {1 / 4.0f, 0, 1, 0}, exact);
  for (const InstructionSet set : {InstructionSet::scalar, InstructionSet::avx2}) {
    std::vector<float>& sum = sums[set == InstructionSet::avx2];
    sum.assign(places.size(), 0);
    add_group_kernel(rows_of(places), std::span(&group, 1), 1 / 4.0f, sum, set);
    for (std::size_t k = 0; k < places.size(); ++k) CHECK(sum[k] == Approx(exact[k]).epsilon(5e-4));
  }
  CHECK(sums[0] == sums[1]);
  // The mean alone is not enough.
  const auto& m = group.mean;
  std::vector<float> by_mean(places.size(), 0);
  add_kernel(rows_of(places), rows_of({m}), 0, 1, {1 / 4.0f, 0, 500, 0}, by_mean);
  float worst = 0;
  for (std::size_t k = 0; k < places.size(); ++k)
    worst = std::max(worst, std::abs(by_mean[k] / exact[k] - 1));
  CHECK(worst > 3e-3f);
}

TEST_CASE("kernel sums: gaps between boxes match a slow loop, with the same bits for all instruction sets") {
  const auto corner = random_points(37, 5), extent = random_points(37, 6);
  BoxRows boxes;
  boxes.resize(corner.size());
  for (std::size_t i = 0; i < corner.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      boxes.low[k][i] = corner[i][k];
      boxes.high[k][i] = corner[i][k] + 0.3f * std::abs(extent[i][k]);
    }
    boxes.margin[i] = 0.1f * std::abs(extent[i][0]);
  }
  const std::array<float, 3> low = {-0.2f, 0.1f, 0}, high = {0.1f, 0.3f, 0.2f};
  std::vector<float> beyond[2];
  find_gaps(boxes, low, high, 0.2f, beyond[0], InstructionSet::scalar);
  find_gaps(boxes, low, high, 0.2f, beyond[1], InstructionSet::avx2);
  CHECK(beyond[0] == beyond[1]);
  int near = 0;
  for (std::size_t i = 0; i < corner.size(); ++i) {
    float squared = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const float gap = std::max({boxes.low[k][i] - high[k], low[k] - boxes.high[k][i], 0.0f});
      squared += gap * gap;
    }
    const float within = 0.2f + boxes.margin[i];
    CHECK(beyond[0][i] == squared - within * within);
    near += beyond[0][i] <= 0 ? 1 : 0;
  }
  CHECK(near > 0);
  CHECK(near < 37);
}

TEST_CASE("kernel sums: nearest points match a slow loop, with the same bits for all instruction sets") {
  for (const std::size_t places : {1u, 8u, 33u}) {
    const auto place = random_points(places, 7), point = random_points(50, 8);
    std::vector<float> found[2];
    for (const InstructionSet set : {InstructionSet::scalar, InstructionSet::avx2}) {
      std::vector<float>& least = found[set == InstructionSet::avx2];
      least.assign(places, 0.2f);
      find_nearest(rows_of(place), rows_of(point), 40, least, set);
    }
    CHECK(found[0] == found[1]);
    for (std::size_t k = 0; k < places; ++k) {
      double expected = 0.2;
      for (std::size_t i = 0; i < 40; ++i) {
        double squared = 0;
        for (std::size_t c = 0; c < 3; ++c) squared += std::pow(double(place[k][c]) - double(point[i][c]), 2);
        expected = std::min(expected, squared);
      }
      CHECK(double(found[0][k]) == Approx(expected).epsilon(1e-5));
    }
  }
}

TEST_CASE("packed rows: numbers are recovered to 1/65535 of the range of their row") {
  PackedRows rows(3, 8);
  std::mt19937 engine(3);
  std::uniform_real_distribution<float> uniform(-2, 5);
  std::vector<float> values(8), read(8);
  for (auto& v : values) v = uniform(engine);
  const std::vector<float> equal(8, 0.3f);
  rows.write(2, values);
  rows.write(0, equal);
  rows.read(2, read);
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  for (std::size_t k = 0; k < 8; ++k)
    CHECK(std::abs(read[k] - values[k]) <= (*high - *low) / 65535 * 0.5f + 1e-6f);
  CHECK(read[static_cast<std::size_t>(low - values.begin())] == *low);
  rows.read(0, read);
  CHECK(read == equal);
}

TEST_CASE("stratum lists: what is written is read") {
  StratumLists lists(6, 2);
  std::vector<std::uint32_t> run(40);  // longer than one entry of a list, on both sides of the stratum
  std::iota(run.begin(), run.end(), 2u);
  const std::vector<std::vector<std::uint32_t>> wanted = {
      {}, {0}, {0, 1, 3, 4, 200, 20000, 4000000000u}, {4294967295u}, {3}, run};
  for (std::size_t s = 0; s < wanted.size(); ++s) {
    std::vector<std::uint32_t> others(wanted[s].rbegin(), wanted[s].rend());
    lists.write(s, others);
    if (s % 2 == 1) lists.close(s / 2);
  }
  std::vector<std::uint32_t> read = {1, 2, 3};
  for (std::size_t s = 0; s < wanted.size(); ++s) {
    lists.read(s, read);
    CHECK(read == wanted[s]);
    CHECK(lists.size(s) == wanted[s].size());
  }
  std::vector<float> from(42 + StratumLists::max_run), to(run.size() + StratumLists::max_run);
  std::iota(from.begin(), from.end(), 0.0f);
  lists.gather(5, {{from.data(), to.data()}});
  CHECK(std::equal(run.begin(), run.end(), to.begin()));
}

TEST_CASE("sum_dipoles: the slope of the far kernel, the same for every instruction set") {
  const FarScale scale{0.8f, 3, 7, 0.5f};
  const std::array<float, 3> at = {0.3f, -0.2f, 0.1f};
  // In spacings from `at`: at it, within the near reach, between both reaches, and beyond them.
  const std::array<std::array<float, 3>, 5> from = {
      {{0, 0, 0}, {1.2f, 0.5f, -0.7f}, {-3, 3, 1}, {2, -4, 4}, {6, 6, 0}}};
  DipoleRows rows;
  rows.resize(from.size());
  for (std::size_t i = 0; i < from.size(); ++i) {
    const auto k = static_cast<float>(i);
    rows.set(i, {at[0] + from[i][0] / 0.8f, at[1] + from[i][1] / 0.8f, at[2] + from[i][2] / 0.8f},
             {0.2f - 0.1f * k, 0.1f * k, 0.3f});
  }
  const auto energy = [&](const std::array<double, 3>& place) {
    const auto kernel = [](double d) {
      const double far = std::max(1 - d / 7, 0.0), near = std::max(1 - d / 3, 0.0);
      return 7.0 / 3 * far * far - near * near;
    };
    constexpr double small = 1e-3;
    double sum = 0;
    for (std::size_t i = 0; i < from.size(); ++i)
      for (const double side : {-0.5, 0.5}) {
        const auto along = [&](float row, float way, std::size_t k) {
          return place[k] - 0.8 * (double(row) - double(at[k]) + side * small * double(way));
        };
        const double x = along(rows.x[i], rows.way_x[i], 0), y = along(rows.y[i], rows.way_y[i], 1),
                     z = along(rows.z[i], rows.way_z[i], 2);
        sum += (side > 0 ? 1 : -1) / small * kernel(std::sqrt(x * x + y * y + z * z));
      }
    return sum;
  };
  const std::array<float, 3> slope = sum_dipoles(rows, at, scale, InstructionSet::scalar);
  for (std::size_t k = 0; k < 3; ++k) {
    std::array<double, 3> up{}, down{};
    up[k] = 1e-3;
    down[k] = -1e-3;
    CHECK(slope[k] == Approx((energy(up) - energy(down)) / 2e-3).margin(2e-3));
  }
  if (is_available(InstructionSet::avx2)) CHECK(sum_dipoles(rows, at, scale, InstructionSet::avx2) == slope);
}

TEST_CASE("far field: a wave of samples pushes as its dipoles one by one do, but for the sample itself") {
  using namespace spaced;
  // Within a 16th of the largest. A plane of strata in runs of two by two, whose samples are displaced along
  // x by a wave.
  constexpr std::uint32_t side = 40;
  std::vector<PointMoments> moments(side * side);
  for (std::uint32_t s = 0; s < moments.size(); ++s) {
    const std::uint32_t run = s / 4, x = 2 * (run % (side / 2)) + s % 2,
                        y = 2 * (run / (side / 2)) + s / 2 % 2;
    moments[s].mean = {static_cast<float>(x), static_cast<float>(y), 0};
  }
  const std::vector<float> spacing(moments.size(), 1.0f);
  const auto way = [&](std::uint32_t s) { return 0.3f * std::sin(0.6f * moments[s].mean[0]); };
  const std::uint32_t torn = 3;
  FarField field(moments, spacing, [&](std::uint32_t s) { return s != torn; }, {});
  DipoleRows all;
  all.resize(moments.size());
  for (std::uint32_t s = 0; s < moments.size(); ++s) {
    const auto& [x, y, z] = moments[s].mean;
    field.move(s, {x, y, z}, {x + way(s), y, z});
    all.set(s, {x, y, z}, {way(s), 0, 0});
  }
  CHECK_FALSE(field.reaches(0));
  CHECK(field.reaches(4));
  DipoleRows scratch;
  std::vector<double> found, one_by_one;
  for (std::uint32_t s = 10 * 2 * side + 14 * 2; s < 10 * 2 * side + 26 * 2; ++s) {
    REQUIRE(field.reaches(s));
    const auto& [x, y, z] = moments[s].mean;
    PointRows places;
    places.push_back(x - 0.5f, y, z);
    places.push_back(x + 0.5f, y, z);
    std::vector<float> energy(2, 0.0f);
    field.add(s, moments[s], 1, {way(s), 0, 0}, 1, places, scratch, energy);
    const FarScale scale{1, static_cast<float>(kernel_reach), FarField::far_reach, FarField::ramp};
    all.set(s, moments[s].mean, {});
    one_by_one.push_back(sum_dipoles(all, moments[s].mean, scale)[0]);
    all.set(s, moments[s].mean, {way(s), 0, 0});
    found.push_back(energy[1] - energy[0]);
    CHECK(std::abs(energy[0] + energy[1] - 0.5f * scale.bend()) < 1e-5f);
  }
  const double largest = std::ranges::max(one_by_one);
  CHECK(largest > 1);
  for (std::size_t i = 0; i < found.size(); ++i)
    CHECK(found[i] == Approx(one_by_one[i]).epsilon(0).margin(largest / 16));
}

TEST_CASE("kernel sums: packed places are recovered at their steps") {
  const std::vector<std::uint32_t> packed = {0, 1023, 1023u << 10, 1023u << 20, 512u << 20 | 7u << 10 | 3, 1,
                                             2, 3};
  for (const InstructionSet set : {InstructionSet::scalar, InstructionSet::avx2}) {
    if (!is_available(set)) continue;
    std::vector<float> x(8), y(8), z(8);
    unpack(packed, {1, 2, 3}, 0.25f, x.data(), y.data(), z.data(), set);
    for (std::size_t i = 0; i < 8; ++i) {
      CHECK(x[i] == 1 + 0.25f * static_cast<float>(packed[i] & 1023));
      CHECK(y[i] == 2 + 0.25f * static_cast<float>(packed[i] >> 10 & 1023));
      CHECK(z[i] == 3 + 0.25f * static_cast<float>(packed[i] >> 20));
    }
  }
}

TEST_CASE("StratumGrid: finds every box around a box, and around separate places, once") {
  std::mt19937 engine(3);
  std::uniform_real_distribution<float> uniform(0, 1);
  StratumGrid grid(0.1);
  std::vector<PointBox> boxes;
  for (int i = 0; i < 2000; ++i) {
    PointBox box;
    const float half = (i % 7 == 0 ? 0.4f : 0.06f) * uniform(engine);
    for (std::size_t k = 0; k < 3; ++k) {
      const float middle = 2 * uniform(engine) - 1;
      box.low[k] = middle - half * uniform(engine);
      box.high[k] = middle + half * uniform(engine);
    }
    boxes.push_back(box);
    grid.add(box, 0.1f);
  }
  grid.build();
  StratumGrid::Scratch scratch;
  std::vector<std::uint32_t> found;
  const float distance = 0.12f;
  const auto near = [&](std::uint32_t stratum, const PointBox& box) {
    for (std::size_t k = 0; k < 3; ++k)
      if (boxes[stratum].low[k] > box.high[k] + distance || boxes[stratum].high[k] < box.low[k] - distance)
        return false;
    return true;
  };
  std::size_t neighbors = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const auto places = random_points(trial % 2 == 0 ? 1 : 3, static_cast<std::uint32_t>(trial));
    const PointRows rows = rows_of(places);
    PointBox box = {places[0], places[0]};
    for (const auto& p : places)
      for (std::size_t k = 0; k < 3; ++k) {
        box.low[k] = std::min(box.low[k], p[k]);
        box.high[k] = std::max(box.high[k], p[k]);
      }
    const bool torn = trial % 4 == 1;
    if (trial % 4 == 3) {  // a box as strata have them
      for (std::size_t k = 0; k < 3; ++k) box.high[k] = std::min(box.high[k], box.low[k] + 0.1f);
    }
    grid.find(rows.x, rows.y, rows.z, box, torn, distance, 256, near, scratch, found);
    const std::set<std::uint32_t> unique(found.begin(), found.end());
    CHECK(unique.size() == found.size());
    std::set<std::uint32_t> expected;
    for (std::uint32_t s = 0; s < boxes.size(); ++s) {
      if (torn)
        for (const auto& p : places)
          if (near(s, {p, p})) expected.insert(s);
      if (!torn && near(s, box)) expected.insert(s);
    }
    CHECK(unique == expected);
    neighbors += expected.size();
  }
  CHECK(neighbors > 1000);
}

// None leaves its stratum.
SpacingParameters staying() {
  SpacingParameters parameters;
  parameters.leave_rounds = 0;
  return parameters;
}

TEST_CASE("space_samples: one sample per stratum, identified by element and place") {
  for (const bool linear : {false, true})
    for (const std::uint32_t n : {1u, 2u, 63u, 64u, 65u, 130u, 1000u}) {
      const StrataOfMesh strata(torus(24, 12), n, linear);
      for (const bool progressive : {false, true}) {
        const SpacedSamples s = space_samples(strata.in_cells(), progressive, test_key, staying());
        REQUIRE(s.point.size() == n);
        Vector3 origin;
        std::vector<std::uint32_t> ranks = s.rank_of_index;
        std::sort(ranks.begin(), ranks.end());
        for (std::uint32_t r = 0; r < n; ++r) {
          REQUIRE(ranks[r] == r);
          const StratumPoint& p = s.point[r];
          const auto entries = strata.cells.cells.entries(strata.cells.cells.cell[r]);
          REQUIRE(std::any_of(entries.begin(), entries.end(), [&](const CellEntry& entry) {
            return strata.cells.triangle[entry.element()] == p.triangle &&
                   strata.cells.path_of(entry) == p.path;
          }));
          const PreparedMesh& mesh = strata.mesh;
          const Vector3 a = mesh.position(mesh.triangles[3 * p.triangle]),
                        b = mesh.position(mesh.triangles[3 * p.triangle + 1]),
                        c = mesh.position(mesh.triangles[3 * p.triangle + 2]);
          const Vector3 at = a + p.first * (b - a) + p.second * (c - a);
          // The origin of the points is their own.
          const Vector3 here = at - Vector3{double(p.at[0]), double(p.at[1]), double(p.at[2])};
          if (r == 0) origin = here;
          REQUIRE(distance(here, origin) < 1e-6);
          REQUIRE(std::min({p.first, p.second, 1 - p.first - p.second}) >= -1e-12);
        }
      }
    }
}

// By sample: whether it lies in its interval of the curve.
std::vector<bool> stay_in_intervals(const StrataOfMesh& strata, const SpacedSamples& samples) {
  const CurveElements& elements = strata.elements;
  const auto n = static_cast<double>(samples.point.size());
  const double shift = random_pair(test_key, Stream::sequence_shift, 0).first;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> element_of;
  for (std::size_t e = 0; e < elements.count(); ++e) element_of[{elements.triangle[e], elements.path[e]}] = e;
  std::vector<bool> stay;
  for (const StratumPoint& point : samples.point) {
    const auto r = static_cast<double>(stay.size());
    const std::size_t e = element_of.at({point.triangle, point.path});
    const double begin = (r + shift) / n, end = (r + 1 + shift) / n;
    const double low = elements.cumulative[e] / elements.total(),
                 high = elements.cumulative[e + 1] / elements.total();
    const bool here = low < end + 1e-12 && high > begin - 1e-12;
    const bool wrapped = low < end - 1 + 1e-12 && high > begin - 1 - 1e-12;
    stay.push_back(here || wrapped);
  }
  return stay;
}

TEST_CASE("space_samples: along a curve, samples lie in the intervals of their strata") {
  const StrataOfMesh strata(icosphere(2), 500);
  for (const bool progressive : {false, true}) {
    const std::vector<bool> stay =
        stay_in_intervals(strata, space_samples(strata.along_curve(500), progressive, test_key, staying()));
    REQUIRE(std::find(stay.begin(), stay.end(), false) == stay.end());
  }
}

TEST_CASE("space_samples: few leave their intervals, and then keep their distance") {
  std::ptrdiff_t all = 0;
  SpacingParameters leaving;
  leaving.hole_rounds = 0;  // for which samples leave as well
  const auto bent = [](std::uint32_t n) { return n < 200 ? torus(24, 12) : icosphere(n < 500 ? 2 : 3); };
  // Of other sizes some leave for the distances in a prefix alone.
  for (const std::uint32_t n : {130u, 300u, 700u, 2100u}) {
    const StrataOfMesh strata(bent(n), n);
    const double wanted = hexagonal_distance * SpacingParameters{}.progressive_repair_below *
                          std::sqrt(strata.along_curve(n).measure() / n);
    const auto least = [&](const SpacedSamples& samples) {
      return std::ranges::min(nearest_distances(points_of(samples, n))) / wanted;
    };
    const SpacedSamples left = space_samples(strata.along_curve(n), true, test_key, leaving);
    const std::vector<bool> stay = stay_in_intervals(strata, left);
    const std::ptrdiff_t gone = std::count(stay.begin(), stay.end(), false);
    INFO(n << " samples, " << gone << " left their intervals");
    CHECK(gone <= n / 32);  // half of what four rounds may move
    CHECK(least(left) > 0.99);
    if (gone > 0) CHECK(least(space_samples(strata.along_curve(n), true, test_key, staying())) < 0.99);
    all += gone;
  }
  CHECK(all > 0);
}

TEST_CASE("space_samples: progressive prefixes have one sample in each block of leaves") {
  for (const std::uint32_t n : {256u, 1000u, 1200u, 2048u}) {
    const StrataOfMesh strata(torus(24, 12), n);
    const SpacedSamples s = space_samples(strata.in_cells(), true, test_key, {});
    for (std::uint32_t size = 64; size <= n; size *= 2) {
      std::vector<int> samples(size, 0);
      for (std::uint32_t i = 0; i < size; ++i)
        ++samples[((std::uint64_t{s.rank_of_index[i]} + 1) * size - 1) / n];
      INFO("the first " << size << " of " << n);
      CHECK(*std::max_element(samples.begin(), samples.end()) == 1);
    }
  }
}

TEST_CASE("space_samples: samples keep their distance") {
  for (const PolygonMesh& file : {torus(48, 24), icosphere(3), cube(), grid_plane(20, 20)}) {
    for (const std::uint32_t n : thinned<std::uint32_t>(1, {1000, 5000})) {
      const StrataOfMesh strata(file, n);
      const double area = strata.mesh.total_area;
      INFO(file.polygon_count() << " faces, " << n << " samples");
      CHECK(rho_of(space_samples(strata.in_cells(), false, test_key, {}), n, area) > 0.6);
      CHECK(rho_of(space_samples(strata.along_curve(n), false, test_key, {}), n, area) > 0.58);
      const SpacedSamples progressive = space_samples(strata.in_cells(), true, test_key, {});
      CHECK(rho_of(progressive, n, area) > 0.5);
      for (std::uint32_t size = 128; size < n; size *= 2) CHECK(rho_of(progressive, size, area) > 0.42);
      const SpacedSamples fast =
          space_samples(strata.in_cells(), false, test_key, spacing_parameters(SpacingKind::fast));
      CHECK(rho_of(fast, n, area) > 0.45);
      const SpacedSamples best =
          space_samples(strata.in_cells(), false, test_key, spacing_parameters(SpacingKind::best));
      CHECK(rho_of(best, n, area) > 0.65);
    }
  }
}

TEST_CASE("space_samples: holes are filled, and samples keep their distance") {
  for (const PolygonMesh& file : {torus(48, 24), icosphere(4), cube(), grid_plane(20, 20)}) {
    const bool smooth = file.polygon_count() > 1000;
    const std::uint32_t n = 4000;
    const StrataOfMesh strata(file, n);
    const PreparedMesh& mesh = strata.mesh;
    INFO(file.polygon_count() << " faces");
    for (const bool progressive : {false, true}) {
      SpacingParameters parameters;
      const SpacedSamples filled = space_samples(strata.in_cells(), progressive, test_key, parameters);
      parameters.hole_rounds = 0;
      const SpacedSamples before = space_samples(strata.in_cells(), progressive, test_key, parameters);
      const auto hole_of = [&](const SpacedSamples& samples) {
        std::vector<double> points;
        for (const StratumPoint& p : samples.point) {
          const auto corner = [&](std::size_t k) {
            return mesh.position(mesh.triangles[3 * p.triangle + k]);
          };
          const Vector3 at =
              (1 - p.first - p.second) * corner(0) + p.first * corner(1) + p.second * corner(2);
          points.insert(points.end(), {at.x, at.y, at.z});
        }
        return coverage_of({mesh.x, mesh.y, mesh.z, mesh.triangles}, points, 1).hole;
      };
      std::size_t moved = 0;
      for (std::size_t i = 0; i < n; ++i) moved += filled.point[i].at != before.point[i].at ? 1 : 0;
      CHECK(moved > 0);
      CHECK(moved < n / 50);
      // At creases, borders, and between samples that were placed before, not all are found.
      CHECK(hole_of(filled) < hole_of(before) + 0.001);
      if (smooth && !progressive) CHECK(hole_of(filled) < 1.5);
      CHECK(rho_of(filled, n, mesh.total_area) > (progressive ? 0.55 : 0.65));
    }
  }
}

TEST_CASE("space_samples: the spacing follows the density") {
  // Density from .5 to 2.5: spacings differ by a factor of 2.2, and with them the levels of the grid.
  const std::uint32_t n = 3000;
  const StrataOfMesh strata(torus(48, 24), n, true);
  const double mass = strata.elements.total();
  for (const bool progressive : {false, true})
    for (const bool cells : {false, true}) {
      const SpacedSamples s = cells ? space_samples(strata.in_cells(), progressive, test_key, {})
                                    : space_samples(strata.along_curve(n), progressive, test_key, {});
      std::vector<double> points;
      for (const StratumPoint& p : s.point)
        for (const float c : p.at) points.push_back(static_cast<double>(c));
      const std::vector<double> distances = nearest_distances(points);
      double least = 1;
      for (std::uint32_t i = 0; i < n; ++i) {
        const double wanted = hexagonal_spacing(mass / static_cast<double>(s.point[i].density), n);
        least = std::min(least, distances[i] / wanted);
      }
      INFO("progressive " << progressive << ", cells " << cells);
      CHECK(least > (progressive ? 0.42 : 0.5));
    }
}

TEST_CASE("space_samples: a metric makes neighborhoods elliptical") {
  // A square whose metric is four times as long along x: samples keep four times the distance there.
  const std::uint32_t n = 2000;
  const StrataOfMesh strata(grid_plane(40, 40), n);
  const float stretch = 2;
  const MetricAt metric = [&](std::uint32_t, double, double) {
    LocalMetric local;
    local.rows = {{{1 / stretch, 0, 0}, {0, stretch, 0}, {0, 0, 1}}};
    local.stretch = stretch;
    return local;
  };
  const CurveStrata stretched(strata.elements, n, strata.mesh, strata.density, test_key, metric);
  const SpacedSamples s = space_samples(stretched, false, test_key, {});
  std::vector<double> points;
  for (const StratumPoint& p : s.point) {
    points.push_back(double(p.at[0]) / double(stretch));
    points.push_back(double(p.at[1]) * double(stretch));
    points.push_back(double(p.at[2]));
  }
  CHECK(spacing_of(nearest_distances(points), strata.mesh.total_area).rho > 0.5);
  CHECK(rho_of(s, n, strata.mesh.total_area) < 0.4);
}

TEST_CASE("space_samples: stacked sheets, one triangle and distant components") {
  // 40 copies of one square: as many strata lie on each other as a stratum looks at.
  PolygonMesh stack = grid_plane(4, 4);
  const PolygonMesh sheet = stack;
  for (int i = 1; i < 40; ++i) stack = merged(stack, sheet);
  const PolygonMesh triangle = polygon_mesh({0, 0, 0, 1, 0, 0, 0, 1e-7, 0}, {{0, 1, 2}});
  PolygonMesh far = cube();
  for (int i = 1; i <= 20; ++i) far = merged(far, moved(cube(), 0.01, 30.0 * i, 7.0 * i, 0));
  PolygonMesh farther = icosphere(3);
  farther = merged(farther, moved(cube(), 1e-3, 1e6, 0, 0));
  for (const PolygonMesh& file : {stack, triangle, far, farther})
    for (const std::uint32_t n : {300u, 1111u}) {
      const StrataOfMesh strata(file, n);
      for (const bool progressive : {false, true}) {
        const SpacedSamples s = space_samples(strata.in_cells(), progressive, test_key, {});
        CHECK(std::set<std::uint32_t>(s.rank_of_index.begin(), s.rank_of_index.end()).size() == n);
        CHECK(space_samples(strata.along_curve(n), progressive, test_key, {}).point.size() == n);
      }
      // Farther apart than where they start, however many strata there are around each. Along a needle, which
      // has no room beside its samples, they stay as far apart: the mean of many keys, as a median varies by
      // 3 %.
      SpacingParameters none = staying();
      none.sweeps = none.repairs = 0;
      const auto median_distance = [&](const StrataOfMesh& of, const SpacingParameters& parameters) {
        const SpacedSamples s = space_samples(of.in_cells(), false, of.key, parameters);
        std::vector<double> distances = nearest_distances(points_of(s, n));
        std::nth_element(distances.begin(), distances.begin() + n / 2, distances.end());
        return distances[n / 2];
      };
      INFO(file.polygon_count() << " faces, " << n << " samples");
      const int keys = file.polygon_count() == 1 ? 12 : 1;
      double gain = 0;
      for (int k = 0; k < keys; ++k) {
        const StrataOfMesh keyed(file, n, false, keys == 1 ? test_key : make_random_key(100 + k, {}));
        gain += median_distance(keyed, {}) / median_distance(keyed, none) / keys;
      }
      CHECK(gain > 0.98);
    }
}

TEST_CASE("space_samples: the same samples for every number of threads", "[release]") {
  const std::uint32_t n = sanitized ? 9000 : 20000;  // five blocks of a sweep, with sanitizers three
  const StrataOfMesh strata(torus(60, 30), n);
  for (const bool progressive : {false, true}) {
    SpacedSamples one, many;
    oneapi::tbb::task_arena(1).execute(
        [&] { one = space_samples(strata.in_cells(), progressive, test_key, {}); });
    oneapi::tbb::task_arena(4).execute(
        [&] { many = space_samples(strata.in_cells(), progressive, test_key, {}); });
    CHECK(same(one, many));
    CHECK(rho_of(one, n, strata.mesh.total_area) > (progressive ? 0.5 : 0.6));
  }
  const SpacedSamples other = space_samples(strata.in_cells(), true, make_random_key(12, {}), {});
  CHECK_FALSE(same(other, space_samples(strata.in_cells(), true, test_key, {})));
}

TEST_CASE("space_samples: a mesh in other units has the same samples") {
  const std::uint32_t n = 700;
  PolygonMesh scaled = torus(24, 12);
  for (std::vector<double>* const row : {&scaled.x, &scaled.y, &scaled.z})
    for (double& c : *row) c *= 1024;
  const StrataOfMesh here(torus(24, 12), n), there(scaled, n);
  const SpacedSamples a = space_samples(here.in_cells(), true, test_key, {}),
                      b = space_samples(there.in_cells(), true, test_key, {});
  CHECK(same(a, b));
}

TEST_CASE("space_samples: stops when canceled, and refuses parameters out of range") {
  const StrataOfMesh strata(torus(24, 12), 5000);
  const std::atomic<bool> stopped = true;
  CancelToken cancel;
  cancel.canceled = &stopped;
  CHECK_THROWS_AS(space_samples(strata.in_cells(), true, test_key, {}, cancel), RunCanceled);
  SpacingParameters parameters;
  parameters.candidates = 12;
  CHECK(validate(parameters).size() == 1);
  CHECK_THROWS_AS(space_samples(strata.in_cells(), true, test_key, parameters), std::invalid_argument);
  for (const SpacingKind kind : {SpacingKind::fast, SpacingKind::standard, SpacingKind::best})
    CHECK(validate(spacing_parameters(kind)).empty());
  CHECK_THROWS_AS(sample_sequence(SequenceKind::spaced, 10, 0.25, test_key), std::invalid_argument);
}
