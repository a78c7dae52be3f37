#include "kernels/retrieve/row_ranking.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "kernels/core/random.h"
#include "kernels/retrieve/nearest_rows.h"
#include "support/catch.h"
#include "support/threads.h"

using namespace meander;
using meander::test::on_threads;

namespace {

DescriptorBase ranked_base(std::span<const float> values, std::uint32_t width) {
  const DescriptorBlock block{values, width};
  return make_descriptor_base({&block, 1}, DistanceKind::l2);
}

std::vector<float> random_places(std::size_t rows, std::uint32_t width, std::uint64_t seed) {
  const RandomKey key = make_random_key(seed, {});
  std::vector<float> values(rows * width);
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = static_cast<float>(random_pair(key, Stream::sequence, i).first);
  return values;
}

std::vector<float> distances_from(const DescriptorBase& base, std::size_t row) {
  std::vector<float> distances(base.rows);
  descriptor_distances(base, row, 0, distances);
  return distances;
}

std::vector<float> ranked(const DescriptorBase& base, const RowRanking& ranking, std::size_t row) {
  std::vector<float> distances = distances_from(base, row);
  rank_row(ranking, row, distances);
  return distances;
}

// The definitions, in double and dense.
using Matrix = std::vector<std::vector<double>>;

Matrix slow_scaled(const DescriptorBase& base) {
  const std::size_t n = base.rows;
  std::vector<double> scale(n);
  Matrix scaled(n, std::vector<double>(n));
  for (std::size_t i = 0; i < n; ++i) {
    std::vector<float> sorted = distances_from(base, i);
    for (std::size_t j = 0; j < n; ++j) scaled[i][j] = static_cast<double>(sorted[j]);
    std::sort(sorted.begin(), sorted.end());
    scale[i] = static_cast<double>(sorted[std::min<std::size_t>(7, n - 1)]);  // the first is the row itself
  }
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j) scaled[i][j] /= std::sqrt(scale[i] * scale[j]);
  return scaled;
}

// Solves A x = b by elimination without pivots: A is symmetric and positive definite.
std::vector<double> slow_solve(Matrix a, std::vector<double> b) {
  const std::size_t n = b.size();
  for (std::size_t k = 0; k < n; ++k)
    for (std::size_t i = k + 1; i < n; ++i) {
      const double factor = a[i][k] / a[k][k];
      for (std::size_t j = k; j < n; ++j) a[i][j] -= factor * a[k][j];
      b[i] -= factor * b[k];
    }
  for (std::size_t k = n; k-- > 0;) {
    for (std::size_t j = k + 1; j < n; ++j) b[k] -= a[k][j] * b[j];
    b[k] /= a[k][k];
  }
  return b;
}

struct SlowDiffusion {
  std::vector<double> ranked;
  double mutual_share;
};

SlowDiffusion slow_diffusion(const DescriptorBase& base, std::size_t query, std::size_t neighbors,
                             double alpha) {
  const std::size_t n = base.rows;
  const Matrix scaled = slow_scaled(base);
  Matrix weight(n, std::vector<double>(n, 0)), has(n, std::vector<double>(n, 0));
  std::vector<std::size_t> nearest(n);
  for (std::size_t i = 0; i < n; ++i) {
    std::vector<std::size_t> order(n);
    std::iota(order.begin(), order.end(), std::size_t{0});
    order.erase(order.begin() + static_cast<std::ptrdiff_t>(i));
    std::sort(order.begin(), order.end(),
              [&](std::size_t a, std::size_t b) { return scaled[i][a] < scaled[i][b]; });
    nearest[i] = order[0];
    for (std::size_t k = 0; k < neighbors; ++k) {
      const std::size_t j = order[k];
      weight[i][j] = weight[j][i] = std::exp(-scaled[i][j] * scaled[i][j]);
      has[i][j] = 1;
    }
  }
  std::vector<double> degree(n, 0), unit(n, 0);
  double mutual = 0;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j) {
      degree[i] += weight[i][j];
      mutual += has[i][j] * has[j][i];
    }
  Matrix system(n, std::vector<double>(n));
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j)
      system[i][j] = (i == j ? 1 : 0) - alpha * weight[i][j] / std::sqrt(degree[i] * degree[j]);
  unit[query] = 1;
  const std::vector<double> f = slow_solve(system, unit);
  double mean = 0;
  const auto pairs = scale_pairs(n);
  for (const auto& [i, j] : pairs) mean += scaled[i][j] / static_cast<double>(pairs.size());
  SlowDiffusion result{{}, mutual / static_cast<double>(n * neighbors)};
  const double share = std::min(0.5, result.mutual_share);
  for (std::size_t j = 0; j < n; ++j) {
    const bool mutual_nearest = nearest[query] == j && nearest[j] == query;
    const double reached = mutual_nearest ? 1 : std::sqrt(std::min(1.0, f[j] / f[query]));
    result.ranked.push_back(scaled[query][j] / mean + share * (1 - reached));
  }
  return result;
}

// Two rows of points side by side, 24 each, 1 apart along them; `gap` between the two.
std::vector<float> two_lines(float gap) {
  std::vector<float> values;
  for (int line = 0; line < 2; ++line)
    for (int i = 0; i < 24; ++i) {
      values.push_back(static_cast<float>(i));
      values.push_back(static_cast<float>(line) * gap);
    }
  return values;
}

}  // namespace

TEST_CASE("row ranking: scaled distances are distances over the local scales of both rows") {
  const std::vector<float> values = random_places(60, 3, 5);
  const DescriptorBase base = ranked_base(values, 3);
  const RowRanking ranking = make_row_ranking(base, {.kind = RankKind::scaled});
  const Matrix expected = slow_scaled(base);
  for (const std::size_t query : {0u, 31u, 59u}) {
    const std::vector<float> found = ranked(base, ranking, query);
    for (std::size_t j = 0; j < base.rows; ++j)
      CHECK(static_cast<double>(found[j]) * ranking.mean ==
            Approx(expected[query][j]).epsilon(1e-5).margin(1e-6));
  }
  const RowRanking plain = make_row_ranking(base, {});
  CHECK(ranked(base, plain, 4) == distances_from(base, 4));
}

TEST_CASE("row ranking: diffusion solves the system of the graph of nearest neighbors") {
  const std::vector<float> values = random_places(50, 2, 9);
  const DescriptorBase base = ranked_base(values, 2);
  for (const double alpha : {0.5, 0.85, 0.99}) {
    const RowRanking ranking =
        make_row_ranking(base, {.kind = RankKind::diffusion, .neighbors = 4, .alpha = alpha});
    for (const std::size_t query : {0u, 17u}) {
      const SlowDiffusion expected = slow_diffusion(base, query, 4, alpha);
      CHECK(ranking.mutual_share == Approx(expected.mutual_share));
      const std::vector<float> found = ranked(base, ranking, query);
      for (std::size_t j = 0; j < base.rows; ++j)
        CHECK(static_cast<double>(found[j]) == Approx(expected.ranked[j]).margin(1e-4));
    }
  }
}

TEST_CASE("row ranking: diffusion follows a line to rows that are no nearer than those of another line") {
  // By hand: every row's two nearest lie on its own line, so that no edge joins the lines.
  const std::vector<float> values = two_lines(8);
  const DescriptorBase base = ranked_base(values, 2);
  const RowRanking ranking = make_row_ranking(base, {.kind = RankKind::diffusion, .neighbors = 2});
  CHECK(ranking.begin.back() == 2u * 2 * (23 + 2));  // the ends have the second next, too
  for (std::size_t i = 0; i < 48; ++i)
    for (std::uint64_t e = ranking.begin[i]; e < ranking.begin[i + 1]; ++e)
      CHECK((ranking.rows[e] < 24) == (i < 24));
  const std::vector<float> found = ranked(base, ranking, 4),
                           scaled = ranked(base, make_row_ranking(base, {.kind = RankKind::scaled}), 4);
  // Row 28 lies opposite, 8 away; so does row 12 of the own line.
  CHECK(scaled[12] == Approx(static_cast<double>(scaled[28])).epsilon(0.2));
  CHECK(found[12] < found[28]);
  // What diffusion does not reach is at its scaled distance and the whole weight.
  CHECK(static_cast<double>(found[28]) ==
        Approx(static_cast<double>(scaled[28]) + ranking.diffusion_weight).epsilon(1e-5));
}

TEST_CASE("row ranking: of rows that are each other's nearest diffusion makes no other the nearest") {
  const std::vector<float> values = random_places(300, 3, 12);
  const DescriptorBase base = ranked_base(values, 3);
  const RowRanking scaled = make_row_ranking(base, {.kind = RankKind::scaled}),
                   diffusion = make_row_ranking(base, {.kind = RankKind::diffusion, .alpha = 0.99});
  const auto nearest = [&](const RowRanking& ranking, std::size_t row) {
    return std::size_t{nearest_of(ranked(base, ranking, row), row, 1)[0].row};
  };
  std::size_t pairs = 0, moved = 0;
  for (std::size_t i = 0; i < base.rows; ++i) {
    const std::size_t j = nearest(scaled, i);
    if (nearest(scaled, j) == i) {
      ++pairs;
      CHECK(nearest(diffusion, i) == j);
    } else {
      moved += nearest(diffusion, i) != j;
    }
  }
  CHECK(pairs > 100);
  CHECK(moved > 0);
}

TEST_CASE("row ranking: the same bits for any number of threads") {
  const std::vector<float> values = random_places(700, 4, 3);
  const DescriptorBase base = ranked_base(values, 4);
  std::vector<std::vector<float>> results;
  for (const int threads : {1, 2, 4})
    on_threads(static_cast<std::size_t>(threads), [&] {
      const RowRanking ranking = make_row_ranking(base, {.kind = RankKind::diffusion});
      std::vector<float> all;
      for (std::size_t i = 0; i < base.rows; i += 50) {
        const std::vector<float> found = ranked(base, ranking, i);
        all.insert(all.end(), found.begin(), found.end());
      }
      results.push_back(all);
    });
  CHECK(results[0] == results[1]);
  CHECK(results[0] == results[2]);
}

TEST_CASE("row ranking: a row outside of the base is ranked as rows inside are") {
  const std::vector<float> values = random_places(400, 2, 21);
  const DescriptorBase base = ranked_base(values, 2);
  const std::vector<float> rest(values.begin() + 2, values.end());
  const DescriptorBase without = ranked_base(rest, 2);
  for (const RankKind kind : {RankKind::plain, RankKind::scaled, RankKind::diffusion}) {
    const std::vector<float> inside = ranked(base, make_row_ranking(base, {.kind = kind}), 0);
    std::vector<float> outside = distances_from(base, 0);
    outside.erase(outside.begin());
    rank_outside(make_row_ranking(without, {.kind = kind}), outside);
    std::size_t same = 0;
    const auto a = nearest_of(inside, 0, 20), b = nearest_of(outside, NearestSearch::no_row, 20);
    for (const NearRow& near : a)
      same += static_cast<std::size_t>(
          std::count_if(b.begin(), b.end(), [&](const NearRow& other) { return other.row + 1 == near.row; }));
    CHECK(same >= 19);
    for (std::size_t j = 0; j < outside.size(); ++j)
      CHECK(outside[j] == Approx(static_cast<double>(inside[j + 1])).margin(0.05));
  }
}

TEST_CASE("row ranking: equal rows, few rows and many rows") {
  const std::vector<float> equal(40, 1.0f);
  const DescriptorBase same = ranked_base(equal, 1);
  const RowRanking of_same = make_row_ranking(same, {.kind = RankKind::diffusion});
  for (const float distance : ranked(same, of_same, 7)) CHECK((distance >= 0 && distance <= 0.5f));
  // Twenty equal rows among others: a local scale of 0 counts as a hundredth of the mean.
  std::vector<float> mixed = random_places(60, 1, 2);
  std::fill(mixed.begin(), mixed.begin() + 20, 0.5f);
  const DescriptorBase partly = ranked_base(mixed, 1);
  const RowRanking of_partly = make_row_ranking(partly, {.kind = RankKind::diffusion});
  for (std::size_t i = 0; i < 60; ++i)
    for (const float distance : ranked(partly, of_partly, i)) CHECK(std::isfinite(distance));

  for (const std::size_t rows : {1u, 2u, 9u, 15u}) {
    const DescriptorBase few = ranked_base(std::span(mixed).subspan(20, rows), 1);
    const RowRanking ranking = make_row_ranking(few, {.kind = RankKind::diffusion});
    CHECK(ranking.kind == RankKind::scaled);
    CHECK(ranked(few, ranking, 0)[0] == 0);
  }
  // Beyond the bound on its work, a query is ranked by what lies around it.
  const std::vector<float> line = random_places(max_diffused_rows + 2000, 1, 4);
  const DescriptorBase many = ranked_base(line, 1);
  const RowRanking ranking = make_row_ranking(many, {.kind = RankKind::diffusion, .neighbors = 8});
  const std::vector<float> found = ranked(many, ranking, 0);
  const auto nearest = nearest_of(found, 0, 8), by_distance = nearest_rows(many, 0, 8);
  std::size_t both = 0;
  for (const NearRow& near : nearest)
    both += static_cast<std::size_t>(std::count_if(
        by_distance.begin(), by_distance.end(), [&](const NearRow& other) { return other.row == near.row; }));
  CHECK(both >= 5);

  CHECK_THROWS_AS(make_row_ranking(many, {.kind = RankKind::diffusion, .neighbors = 65}),
                  std::invalid_argument);
  CHECK_THROWS_AS(make_row_ranking(many, {.kind = RankKind::diffusion, .alpha = 1}), std::invalid_argument);
  CHECK(default_neighbors(1) == 3);
  CHECK(default_neighbors(421) == 6);
  CHECK(default_neighbors(2049) == 9);
  CHECK(default_neighbors(100000) == 14);
}
