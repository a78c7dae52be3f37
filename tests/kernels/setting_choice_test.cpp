#include "kernels/retrieve/setting_choice.h"

#include <catch2/catch.hpp>
#include <stdexcept>

#include "kernels/core/random.h"
#include "support/threads.h"

using namespace meander;

namespace {

void check_same(const RetrievalScores& a, const RetrievalScores& b) {
  CHECK(a.nearest_neighbour == b.nearest_neighbour);
  CHECK(a.first_tier == b.first_tier);
  CHECK(a.second_tier == b.second_tier);
  CHECK(a.e_measure == b.e_measure);
  CHECK(a.dcg == b.dcg);
  CHECK(a.average_precision == b.average_precision);
  CHECK(a.precision == b.precision);
}

std::vector<float> random_values(std::size_t count, std::uint64_t seed) {
  const RandomKey key = make_random_key(seed, {});
  std::vector<float> values;
  for (std::size_t i = 0; i < count; ++i)
    values.push_back(static_cast<float>(random_pair(key, Stream::sequence, i).first));
  return values;
}

}  // namespace

TEST_CASE("score_combinations: each is what a base of its blocks alone gives, to the bit") {
  const std::size_t n = 300;  // more than are summed at once, and more pairs than are drawn for scales
  const std::vector<float> a = random_values(n * 5, 1), b = random_values(n * 20, 2), c = random_values(n, 3);
  const std::vector<DescriptorBlock> blocks{{a, 5}, {b, 20}, {c, 1}};
  std::vector<std::uint32_t> labels;
  for (std::size_t i = 0; i < n; ++i)
    labels.push_back(i == 7 ? 4 : static_cast<std::uint32_t>(i * i % 7 % 4));
  const std::vector<BlockCombination> combinations{{0}, {1}, {2}, {0, 1}, {2, 0}, {0, 1, 2}};
  for (const bool psb : {false, true}) {
    const RetrievalTask task = make_retrieval_task(labels, 6, psb);
    for (const DistanceKind kind :
         {DistanceKind::l1, DistanceKind::l2, DistanceKind::emd, DistanceKind::chi2, DistanceKind::cosine}) {
      const DescriptorBase base = make_descriptor_base(blocks, kind);
      const std::vector<RetrievalSummary> found = score_combinations(base, task, combinations);
      REQUIRE(found.size() == combinations.size());
      for (std::size_t s = 0; s < combinations.size(); ++s) {
        std::vector<DescriptorBlock> own;
        for (const std::uint32_t block : combinations[s]) own.push_back(blocks[block]);
        std::vector<QueryScores> queries(n);
        visit_distances(make_descriptor_base(own, kind),
                        [&](std::size_t first, std::span<const float> distances) {
                          for (std::size_t q = 0; q < distances.size() / n; ++q)
                            if (task.scores(first + q))
                              queries[first + q] = score_query(task, first + q, distances.subspan(q * n, n));
                        });
        const RetrievalSummary expected = summarise(task, queries);
        CHECK(found[s].queries == expected.queries);
        CHECK(found[s].classes == expected.classes);
        check_same(found[s].micro, expected.micro);
        check_same(found[s].macro, expected.macro);
        for (std::size_t k = 0; k < 6; ++k) check_same(found[s].by_class[k], expected.by_class[k]);
      }
    }
  }
  const RetrievalTask task = make_retrieval_task(labels, 6);
  const DescriptorBase base = make_descriptor_base(blocks, DistanceKind::l1);
  const auto score = [&] { return score_combinations(base, task, combinations); };
  const std::vector<RetrievalSummary> alone = test::on_threads(1, score),
                                      together = test::on_threads(4, score);
  for (std::size_t s = 0; s < combinations.size(); ++s) check_same(alone[s].micro, together[s].micro);
}

TEST_CASE("leave_one_class_out by hand") {
  // Of class A (rows 0, 1), B (2, 3), C (4, 5, 6), E of one model. Under p, A and C find themselves and B
  // finds A; under q, only B finds itself.
  const std::vector<float> p{0, 0.1f, 5, -5, 100, 100.1f, 100.2f, 1000};
  const std::vector<float> q{5, -5, 0, 0.1f, 5.2f, -5.2f, 0.3f, 1000};
  const std::vector<std::uint32_t> labels{0, 0, 1, 1, 2, 2, 2, 4};
  const RetrievalTask task = make_retrieval_task(labels, 5);
  const DescriptorBlock blocks[] = {{p, 1}, {q, 1}};
  const DescriptorBase base = make_descriptor_base(blocks, DistanceKind::l1);
  const SettingCriterion nn = SettingCriterion::nearest_neighbour;

  const std::vector<BlockCombination> p_first{{0}, {1}}, q_first{{1}, {0}};
  const std::vector<RetrievalSummary> settings = score_combinations(base, task, p_first);
  CHECK(settings[0].micro.nearest_neighbour == Approx(5.0 / 7));
  CHECK(settings[1].micro.nearest_neighbour == Approx(2.0 / 7));
  CHECK(best_setting(settings, nn) == 0);
  // Without A: p 3/5, q 2/5. Without B: p 5/5. Without C: both 2/4, the first is taken.
  const LeftOutScores left_out = leave_one_class_out(task, settings, nn);
  constexpr std::size_t none = LeftOutScores::no_setting;
  CHECK(left_out.setting == std::vector<std::size_t>{0, 0, 0, none, none});
  CHECK(left_out.scores.queries == 7);
  CHECK(left_out.scores.classes == 3);
  CHECK(left_out.scores.micro.nearest_neighbour == Approx(5.0 / 7));
  CHECK(left_out.scores.macro.nearest_neighbour == Approx(2.0 / 3));

  const std::vector<RetrievalSummary> swapped = score_combinations(base, task, q_first);
  CHECK(best_setting(swapped, nn) == 1);
  const LeftOutScores other = leave_one_class_out(task, swapped, nn);
  CHECK(other.setting == std::vector<std::size_t>{1, 1, 0, none, none});  // C gets q, which fails it
  CHECK(other.scores.micro.nearest_neighbour == Approx(2.0 / 7));
  CHECK(other.scores.by_class[0].nearest_neighbour == 1);
  CHECK(other.scores.by_class[1].nearest_neighbour == 0);
  CHECK(other.scores.by_class[2].nearest_neighbour == 0);
}

TEST_CASE("criteria and what cannot be chosen") {
  RetrievalScores scores;
  scores.nearest_neighbour = 0.5;
  scores.first_tier = 0.25;
  scores.second_tier = 0.1;
  scores.e_measure = 0.2;
  scores.dcg = 0.3;
  scores.average_precision = 0.4;
  CHECK(criterion_of(scores, SettingCriterion::nearest_and_first_tier) == 0.375);
  CHECK(criterion_of(scores, SettingCriterion::nearest_neighbour) == 0.5);
  CHECK(criterion_of(scores, SettingCriterion::first_tier) == 0.25);
  CHECK(criterion_of(scores, SettingCriterion::second_tier) == 0.1);
  CHECK(criterion_of(scores, SettingCriterion::e_measure) == 0.2);
  CHECK(criterion_of(scores, SettingCriterion::dcg) == 0.3);
  CHECK(criterion_of(scores, SettingCriterion::average_precision) == 0.4);

  const std::vector<float> values{0, 1, 2, 3};
  const DescriptorBlock block{values, 1};
  const DescriptorBase base = make_descriptor_base({&block, 1}, DistanceKind::l1);
  const std::vector<std::uint32_t> one{0, 0, 1, 2}, two{0, 0, 1, 1}, fewer{0, 0, 1};
  const std::vector<BlockCombination> good{{0}}, nothing{{}}, unknown{{0, 1}};
  const RetrievalTask lone = make_retrieval_task(one, 3), pairs = make_retrieval_task(two, 2);
  CHECK_THROWS_AS(leave_one_class_out(lone, score_combinations(base, lone, good), {}), std::invalid_argument);
  CHECK_THROWS_AS(leave_one_class_out(pairs, {}, {}), std::invalid_argument);
  CHECK_THROWS_AS(best_setting({}, {}), std::invalid_argument);
  CHECK_THROWS_AS(score_combinations(base, pairs, nothing), std::invalid_argument);
  CHECK_THROWS_AS(score_combinations(base, pairs, unknown), std::invalid_argument);
  CHECK_THROWS_AS(score_combinations(base, make_retrieval_task(fewer, 2), good), std::invalid_argument);
}
