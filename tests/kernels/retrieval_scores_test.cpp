#include "kernels/retrieve/retrieval_scores.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <stdexcept>

#include "support/catch.h"

using namespace meander;

namespace {

// Scores of one ranked list without ties, straight from the definitions; precision is not interpolated but
// at every hit.
struct ListScores {
  std::vector<double> values;     // nn, first tier, second tier, e, dcg, average precision
  std::vector<double> precision;  // at every hit
};
ListScores list_scores(const std::vector<bool>& relevant) {
  const auto wanted = static_cast<std::size_t>(std::count(relevant.begin(), relevant.end(), true));
  const auto hits = [&](std::size_t length) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < std::min(length, relevant.size()); ++i) count += relevant[i] ? 1 : 0;
    return static_cast<double>(count);
  };
  const auto c = static_cast<double>(wanted);
  ListScores s;
  const auto first = static_cast<double>(std::min<std::size_t>(32, relevant.size()));
  const double p = hits(32) / first, r = hits(32) / c;
  double dcg = 0, ideal = 0, precisions = 0;
  for (std::size_t rank = 1; rank <= relevant.size(); ++rank) {
    const double gain = rank == 1 ? 1 : 1 / std::log2(static_cast<double>(rank));
    if (rank <= wanted) ideal += gain;
    if (!relevant[rank - 1]) continue;
    dcg += gain;
    s.precision.push_back(hits(rank) / static_cast<double>(rank));
    precisions += s.precision.back();
  }
  s.values = {hits(1),     hits(wanted) / c, hits(2 * wanted) / c, p + r > 0 ? 2 * p * r / (p + r) : 0,
              dcg / ideal, precisions / c};
  return s;
}

void add(ListScores& sum, const ListScores& more) {
  sum.values.resize(more.values.size());
  sum.precision.resize(more.precision.size());
  for (std::size_t i = 0; i < more.values.size(); ++i) sum.values[i] += more.values[i];
  for (std::size_t i = 0; i < more.precision.size(); ++i) sum.precision[i] += more.precision[i];
}

// Mean over orders of the rows; `orders` 0: all of them.
ListScores shuffled_scores(const std::vector<std::uint32_t>& labels, std::size_t query,
                           const std::vector<float>& distances, std::size_t orders) {
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < labels.size(); ++i)
    if (i != query) rows.push_back(i);
  ListScores sum;
  std::size_t count = 0;
  std::mt19937_64 random(17);
  while (true) {
    std::vector<std::size_t> ranked(rows);
    std::stable_sort(ranked.begin(), ranked.end(),
                     [&](std::size_t a, std::size_t b) { return distances[a] < distances[b]; });
    std::vector<bool> relevant;
    for (const std::size_t row : ranked) relevant.push_back(labels[row] == labels[query]);
    add(sum, list_scores(relevant));
    ++count;
    if (orders == 0) {
      if (!std::next_permutation(rows.begin(), rows.end())) break;
    } else {
      if (count == orders) break;
      std::shuffle(rows.begin(), rows.end(), random);
    }
  }
  for (double& v : sum.values) v /= static_cast<double>(count);
  for (double& v : sum.precision) v /= static_cast<double>(count);
  return sum;
}

void check_equal(const RetrievalScores& found, const ListScores& expected, double margin) {
  CHECK(found.nearest_neighbor == Approx(expected.values[0]).margin(margin));
  CHECK(found.first_tier == Approx(expected.values[1]).margin(margin));
  CHECK(found.second_tier == Approx(expected.values[2]).margin(margin));
  CHECK(found.e_measure == Approx(expected.values[3]).margin(margin));
  CHECK(found.dcg == Approx(expected.values[4]).margin(margin));
  CHECK(found.average_precision == Approx(expected.values[5]).margin(margin));
  const auto wanted = static_cast<double>(expected.precision.size());
  for (std::size_t i = 0; i < recall_levels; ++i) {
    double best = 0;
    for (std::size_t k = 0; k < expected.precision.size(); ++k)
      if (static_cast<double>(k + 1) / wanted >= recall_level(i) - 1e-9)
        best = std::max(best, expected.precision[k]);
    CHECK(found.precision[i] == Approx(best).margin(margin));
  }
}

}  // namespace

TEST_CASE("score_query: by hand, hits at ranks 1, 3 and 4 of 5") {
  // Row 0 is the query, of class 0 with rows 1, 3, 4.
  const std::vector<std::uint32_t> labels{0, 0, 1, 0, 0, 1};
  const std::vector<float> distances{0, 1, 2, 3, 4, 5};
  const RetrievalTask task = make_retrieval_task(labels, 2);
  const RetrievalScores s = score_query(task, 0, distances).scores;
  CHECK(s.nearest_neighbor == 1);
  CHECK(s.first_tier == Approx(2.0 / 3));
  CHECK(s.second_tier == 1);                  // 6 places, only 5 rows
  CHECK(s.e_measure == Approx(2 * 3.0 / 8));  // P = 3/5, R = 1
  const double log3 = std::log2(3.0);
  CHECK(s.dcg == Approx((1 + 1 / log3 + 0.5) / (1 + 1 + 1 / log3)));
  CHECK(s.average_precision == Approx((1 + 2.0 / 3 + 3.0 / 4) / 3));
  CHECK(s.precision[5] == 1);                // recall 0.30: the first hit will do
  CHECK(s.precision[6] == Approx(3.0 / 4));  // recall 0.35: 2/3 at the second hit, but 3/4 at the third
  CHECK(s.precision[19] == Approx(3.0 / 4));
}

TEST_CASE("score_query: by hand, a tie of a hit and a miss at the front counts half") {
  const std::vector<std::uint32_t> labels{0, 0, 1, 1};
  const RetrievalTask task = make_retrieval_task(labels, 2);
  const QueryScores q = score_query(task, 0, std::vector<float>{0, 2, 2, 9});
  CHECK(q.scores.nearest_neighbor == 0.5);
  CHECK(q.scores.first_tier == 0.5);
  CHECK(q.scores.second_tier == 1);
  CHECK(q.scores.dcg == 1);                           // ranks 1 and 2 weigh the same
  CHECK(q.scores.average_precision == Approx(0.75));  // 1 or 1/2
  REQUIRE(q.nearest_classes.size() == 2);
  CHECK(q.nearest_classes[0] == std::pair<std::uint32_t, double>{0, 0.5});
  CHECK(q.nearest_classes[1] == std::pair<std::uint32_t, double>{1, 0.5});
  // The historical rule: the lower row is in front.
  const RetrievalTask psb = make_retrieval_task(std::vector<std::uint32_t>{0, 0, 0, 1}, 2, true);
  CHECK(score_query(psb, 0, std::vector<float>{0, 2, 9, 2}).scores.nearest_neighbor == 1);
  CHECK(score_query(make_retrieval_task(std::vector<std::uint32_t>{1, 0, 0, 0}, 2, true), 3,
                    std::vector<float>{2, 2, 9, 0})
            .scores.nearest_neighbor == 0);
}

TEST_CASE("score_query: agrees with the mean over all orders of the rows") {
  std::mt19937_64 random(4);
  for (int trial = 0; trial < 12; ++trial) {
    const std::size_t n = 8;
    std::vector<std::uint32_t> labels;
    std::vector<float> distances;
    const std::uint64_t values = 1 + static_cast<std::uint64_t>(trial) % 4;  // 1: everything is level
    for (std::size_t i = 0; i < n; ++i) {
      labels.push_back(i < 2 ? 0 : static_cast<std::uint32_t>(random() % 2));
      distances.push_back(static_cast<float>(random() % values));
    }
    const RetrievalTask task = make_retrieval_task(labels, 2);
    INFO("trial " << trial);
    check_equal(score_query(task, 0, distances).scores, shuffled_scores(labels, 0, distances, 0), 1e-12);
  }
}

TEST_CASE("score_query: agrees with random orders of larger lists, exactly without ties", "[statistics]") {
  std::mt19937_64 random(5);
  for (const bool ties : {false, true}) {
    const std::size_t n = 90;
    std::vector<std::uint32_t> labels;
    std::vector<float> distances;
    for (std::size_t i = 0; i < n; ++i) {
      labels.push_back(static_cast<std::uint32_t>(i % 3));
      distances.push_back(ties ? static_cast<float>(random() % 5 + i % 3)
                               : static_cast<float>(random() >> 40));
    }
    const RetrievalTask task = make_retrieval_task(labels, 3);
    for (const std::size_t query : {0u, 1u, 89u})
      check_equal(score_query(task, query, distances).scores,
                  shuffled_scores(labels, query, distances, ties ? 4000 : 1), ties ? 0.03 : 1e-12);
  }
}

TEST_CASE("psb_compat: lists with ties are sorted by distance, then row") {
  std::mt19937_64 random(6);
  std::vector<std::uint32_t> labels;
  std::vector<float> distances;
  for (std::size_t i = 0; i < 60; ++i) {
    labels.push_back(static_cast<std::uint32_t>(random() % 3));
    distances.push_back(static_cast<float>(random() % 6));
  }
  const RetrievalTask task = make_retrieval_task(labels, 3, true);
  for (std::size_t query = 0; query < 60; ++query)
    check_equal(score_query(task, query, distances).scores, shuffled_scores(labels, query, distances, 1),
                1e-12);
}

TEST_CASE("score_query: a large base of equal rows has closed-form expected scores") {
  // n - 1 rows level, r of them hits: every place is a hit with probability r / (n - 1).
  const std::size_t n = 30001, r = 300;
  std::vector<std::uint32_t> labels(n, 1);
  for (std::size_t i = 0; i <= r; ++i) labels[i * 100] = 0;
  const RetrievalTask task = make_retrieval_task(labels, 2);
  const RetrievalScores s = score_query(task, 0, std::vector<float>(n, 1.0f)).scores;
  const double share = static_cast<double>(r) / static_cast<double>(n - 1);
  CHECK(s.nearest_neighbor == Approx(share));
  CHECK(s.first_tier == Approx(share));
  CHECK(s.second_tier == Approx(2 * share));
  // Sum over places j of P(hit) (1 + (j - 1) (r - 1) / (n - 2)) / j, over r.
  const double q = static_cast<double>(r - 1) / static_cast<double>(n - 2);
  double precisions = 0;
  for (std::size_t j = 1; j < n; ++j)
    precisions += share * (1 + static_cast<double>(j - 1) * q) / static_cast<double>(j);
  CHECK(s.average_precision == Approx(precisions / static_cast<double>(r)).epsilon(1e-10));
}

TEST_CASE("summarize: tiny classes, micro, macro, classes and confusion by hand") {
  // Class 0: rows 0 1 2 (perfect); class 1: rows 3 4 (each finds class 0 first); class 2: row 5 alone.
  const std::vector<std::uint32_t> labels{0, 0, 0, 1, 1, 2};
  const std::vector<float> at{0, 0.1f, 0.25f, -2, 2, 30};  // on a line
  for (const bool psb : {false, true}) {
    const RetrievalTask task = make_retrieval_task(labels, 3, psb);
    CHECK(task.scored == (psb ? std::vector<std::uint8_t>{1, 0, 0} : std::vector<std::uint8_t>{1, 1, 0}));
    std::vector<QueryScores> queries(6);
    for (std::size_t q = 0; q < 6; ++q) {
      if (!task.scores(q)) continue;
      std::vector<float> distances;
      for (const float x : at) distances.push_back(std::abs(x - at[q]));
      queries[q] = score_query(task, q, distances);
    }
    const RetrievalSummary s = summarize(task, queries);
    CHECK(s.queries == (psb ? 3u : 5u));
    CHECK(s.classes == (psb ? 1u : 2u));
    CHECK(s.by_class[0].first_tier == 1);
    CHECK(s.by_class[1].nearest_neighbor == 0);
    CHECK(s.by_class[2].dcg == 0);
    CHECK(s.micro.nearest_neighbor == Approx(psb ? 1 : 0.6));
    CHECK(s.macro.nearest_neighbor == Approx(psb ? 1 : 0.5));
    CHECK(s.confusion == (psb ? std::vector<double>{1, 0, 0, 0, 0, 0, 0, 0, 0}
                              : std::vector<double>{1, 0, 0, 1, 0, 0, 0, 0, 0}));
    // Without the table of confusions, which would be too large for many classes.
    const RetrievalSummary scores = summarize(task, queries, false);
    CHECK(scores.confusion.empty());
    CHECK(scores.micro.average_precision == s.micro.average_precision);
    CHECK(scores.by_class[0].dcg == s.by_class[0].dcg);
  }
  const std::vector<std::uint32_t> first{0};
  const RetrievalTask none = make_retrieval_task(labels, 3, true, first);
  const RetrievalSummary empty = summarize(none, std::vector<QueryScores>(6));
  CHECK(empty.queries == 0);
  CHECK(empty.micro.dcg == 0);
  CHECK_THROWS_AS(score_query(none, 0, at), std::invalid_argument);
  CHECK_THROWS_AS(make_retrieval_task(labels, 2), std::invalid_argument);
}
