#include "kernels/retrieve/setting_choice.h"

#include <algorithm>
#include <stdexcept>

#include "kernels/core/random.h"
#include "support/catch.h"
#include "support/threads.h"

using namespace meander;

namespace {

void check_same(const RetrievalScores& a, const RetrievalScores& b) {
  CHECK(a.nearest_neighbor == b.nearest_neighbor);
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

TEST_CASE("score_combinations: each equals a base of its blocks alone, bit for bit") {
  const std::size_t n = 300;  // more than are summed at once, and more pairs than are drawn for scales
  const std::vector<float> a = random_values(n * 5, 1), b = random_values(n * 20, 2), c = random_values(n, 3);
  const std::vector<DescriptorBlock> blocks{{a, 5}, {b, 20}, {c, 1}};
  std::vector<std::uint32_t> labels;
  for (std::size_t i = 0; i < n; ++i)
    labels.push_back(i == 7 ? 4 : static_cast<std::uint32_t>(i * i % 7 % 4));
  const std::vector<BlockCombination> combinations{
      {0}, {1}, {2}, {0, 1}, {2, 0}, {0, 1, 2}, {{0, 0.25}, {2, 3}}, {{2, 3}, {1, 0.5}, {0, 1}}};
  for (const bool psb : {false, true}) {
    const RetrievalTask task = make_retrieval_task(labels, 6, psb);
    for (const DistanceKind kind :
         {DistanceKind::l1, DistanceKind::l2, DistanceKind::emd, DistanceKind::chi2, DistanceKind::cosine}) {
      const DescriptorBase base = make_descriptor_base(blocks, kind);
      const std::vector<RetrievalSummary> found = score_combinations(base, task, combinations);
      REQUIRE(found.size() == combinations.size());
      for (std::size_t s = 0; s < combinations.size(); ++s) {
        std::vector<DescriptorBlock> own;
        for (const WeightedBlock& part : combinations[s]) {
          own.push_back(blocks[part.block]);
          own.back().weight = part.weight;
        }
        std::vector<QueryScores> queries(n);
        visit_distances(make_descriptor_base(own, kind),
                        [&](std::size_t first, std::span<const float> distances) {
                          for (std::size_t q = 0; q < distances.size() / n; ++q)
                            if (task.scores(first + q))
                              queries[first + q] = score_query(task, first + q, distances.subspan(q * n, n));
                        });
        const RetrievalSummary expected = summarize(task, queries);
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

TEST_CASE("leave_one_class_out: a case by hand") {
  // Of class A (rows 0, 1), B (2, 3), C (4, 5, 6), E of one model. Under p, A and C find themselves and B
  // finds A; under q, only B finds itself.
  const std::vector<float> p{0, 0.1f, 5, -5, 100, 100.1f, 100.2f, 1000};
  const std::vector<float> q{5, -5, 0, 0.1f, 5.2f, -5.2f, 0.3f, 1000};
  const std::vector<std::uint32_t> labels{0, 0, 1, 1, 2, 2, 2, 4};
  const RetrievalTask task = make_retrieval_task(labels, 5);
  const DescriptorBlock blocks[] = {{p, 1}, {q, 1}};
  const DescriptorBase base = make_descriptor_base(blocks, DistanceKind::l1);
  const SettingCriterion nn = SettingCriterion::nearest_neighbor;

  const std::vector<BlockCombination> p_first{{0}, {1}}, q_first{{1}, {0}};
  const std::vector<RetrievalSummary> settings = score_combinations(base, task, p_first);
  CHECK(settings[0].micro.nearest_neighbor == Approx(5.0 / 7));
  CHECK(settings[1].micro.nearest_neighbor == Approx(2.0 / 7));
  CHECK(best_setting(settings, nn) == 0);
  // Without A: p 3/5, q 2/5. Without B: p 5/5. Without C: both 2/4, the first is taken.
  const LeftOutScores left_out = leave_one_class_out(task, settings, nn);
  constexpr std::size_t none = LeftOutScores::no_setting;
  CHECK(left_out.setting == std::vector<std::size_t>{0, 0, 0, none, none});
  CHECK(left_out.scores.queries == 7);
  CHECK(left_out.scores.classes == 3);
  CHECK(left_out.scores.micro.nearest_neighbor == Approx(5.0 / 7));
  CHECK(left_out.scores.macro.nearest_neighbor == Approx(2.0 / 3));

  const std::vector<RetrievalSummary> swapped = score_combinations(base, task, q_first);
  CHECK(best_setting(swapped, nn) == 1);
  const LeftOutScores other = leave_one_class_out(task, swapped, nn);
  CHECK(other.setting == std::vector<std::size_t>{1, 1, 0, none, none});  // C gets q, which fails it
  CHECK(other.scores.micro.nearest_neighbor == Approx(2.0 / 7));
  CHECK(other.scores.by_class[0].nearest_neighbor == 1);
  CHECK(other.scores.by_class[1].nearest_neighbor == 0);
  CHECK(other.scores.by_class[2].nearest_neighbor == 0);
}

TEST_CASE("criteria: follow their definitions, and impossible choices are refused") {
  RetrievalScores scores;
  scores.nearest_neighbor = 0.5;
  scores.first_tier = 0.25;
  scores.second_tier = 0.1;
  scores.e_measure = 0.2;
  scores.dcg = 0.3;
  scores.average_precision = 0.4;
  CHECK(criterion_of(scores, SettingCriterion::nearest_and_first_tier) == 0.375);
  CHECK(criterion_of(scores, SettingCriterion::nearest_neighbor) == 0.5);
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

namespace {

// Three classes of eight models. Block 0 tells class 0 from the others, block 1 class 1, block 2 is noise
// that is larger than both.
struct Told {
  std::vector<std::uint32_t> labels;
  std::vector<float> first, second, noise;
  DescriptorBase base;
  RetrievalTask task;

  explicit Told(std::uint64_t seed) {
    const std::size_t n = 24;
    const std::vector<float> a = random_values(n, seed), b = random_values(n, seed + 1);
    noise = random_values(4 * n, seed + 2);
    for (std::size_t i = 0; i < n; ++i) {
      labels.push_back(static_cast<std::uint32_t>(i % 3));
      first.push_back(a[i] + (labels[i] == 0 ? 1.2f : 0.0f));
      second.push_back(b[i] + (labels[i] == 1 ? 1.2f : 0.0f));
    }
    const DescriptorBlock blocks[] = {{first, 1}, {second, 1}, {noise, 4}};
    base = make_descriptor_base(blocks, DistanceKind::l1);
    task = make_retrieval_task(labels, 3);
  }
};

double criterion_without(const RetrievalTask& task, const RetrievalSummary& summary, std::size_t without) {
  double sum = 0, queries = 0;
  for (std::size_t c = 0; c < task.members.size(); ++c) {
    if (c == without) continue;
    const auto members = static_cast<double>(task.members[c].size());
    sum += members * criterion_of(summary.by_class[c], {});
    queries += members;
  }
  return sum / queries;
}

void check_same_course(const LearntCourse& a, const LearntCourse& b) {
  REQUIRE(a.size() == b.size());
  for (std::size_t i = 0; i < a.size(); ++i) CHECK(a[i].combination == b[i].combination);
}

}  // namespace

TEST_CASE("learn_weights: no single weight of the grid is better, and noise gets little or none") {
  const std::vector<BlockCombination> starts{{0}, {1}, {2}, {0, 1, 2}};
  for (const std::uint64_t seed : {1u, 20u, 300u}) {
    const Told told(seed);
    WeightSearch search;
    search.rounds = 10;
    const std::vector<RetrievalSummary> scored = score_combinations(told.base, told.task, starts);
    const LearntWeights learnt = learn_weights(told.base, told.task, starts, scored, search);
    const std::vector<BlockCombination> last{learnt.all.back().combination};
    const RetrievalSummary reached_by_all = score_combinations(told.base, told.task, last)[0];
    CHECK(learnt.all.back().rated.by_class == criterion_by_class(reached_by_all, {}));
    CHECK(criterion_of(reached_by_all.micro, {}) >= criterion_of(scored[3].micro, {}));
    double largest = 0, of_noise = 0;
    for (const WeightedBlock& part : last[0]) {
      largest = std::max(largest, part.weight);
      if (part.block == 2) of_noise = part.weight;
    }
    CHECK(largest == 1);
    CHECK(of_noise <= 0.5);
    // With all classes and without each: a maximum along every axis of the grid.
    for (std::size_t course = 0; course <= 3; ++course) {
      const std::size_t without = course == 3 ? 99 : course;
      const LearntCourse& path = course == 3 ? learnt.all : learnt.without[course];
      REQUIRE_FALSE(path.empty());
      const BlockCombination& present = path.back().combination;
      const std::vector<BlockCombination> itself{present};
      const double reached =
          criterion_without(told.task, score_combinations(told.base, told.task, itself)[0], without);
      for (std::uint32_t block = 0; block < 3; ++block)
        for (const double weight : search.grid) {
          BlockCombination other;
          for (const WeightedBlock& part : present)
            if (part.block != block) other.push_back(part);
          if (weight > 0) other.emplace_back(block, weight);
          std::sort(other.begin(), other.end(),
                    [](const WeightedBlock& a, const WeightedBlock& b) { return a.block < b.block; });
          if (other.empty()) continue;
          const std::vector<BlockCombination> one{other};
          CHECK(criterion_without(told.task, score_combinations(told.base, told.task, one)[0], without) <=
                reached + 1e-9);
        }
    }
    const LearntWeights alone =
        test::on_threads(1, [&] { return learn_weights(told.base, told.task, starts, scored, search); });
    check_same_course(alone.all, learnt.all);
    for (std::size_t c = 0; c < 3; ++c) check_same_course(alone.without[c], learnt.without[c]);
  }
}

TEST_CASE("learn_weights: a class has no influence on weights learned without it") {
  // What tells class 2 from the others is the noise: were its queries counted, the noise would be wanted.
  Told told(7);
  for (std::size_t i = 0; i < told.labels.size(); ++i)
    if (told.labels[i] == 2) {
      std::fill_n(told.noise.begin() + static_cast<std::ptrdiff_t>(4 * i), 4, 3.0f);
      told.first[i] = told.second[i] = static_cast<float>(i % 5) / 5;
    }
  const DescriptorBlock blocks[] = {{told.first, 1}, {told.second, 1}, {told.noise, 4}};
  const DescriptorBase base = make_descriptor_base(blocks, DistanceKind::l1);
  const std::vector<BlockCombination> starts{{0, 1}, {0, 1, 2}};
  const auto learnt_by = [&](const RetrievalTask& task) {
    return learn_weights(base, task, starts, score_combinations(base, task, starts));
  };
  const LearntWeights learnt = learnt_by(told.task);
  // Leaving class 2 out must give what is learnt when its models have no class to be found.
  std::vector<std::uint32_t> labels = told.labels;
  std::uint32_t next = 3;
  for (std::uint32_t& label : labels)
    if (label == 2) label = next++;
  const LearntWeights others = learnt_by(make_retrieval_task(labels, next));
  check_same_course(others.all, learnt.without[2]);
  CHECK_THROWS_AS(learn_weights(base, told.task, {}, {}), std::invalid_argument);
  CHECK_THROWS_AS(learn_weights(base, told.task, starts, {}), std::invalid_argument);
}

TEST_CASE("simplest_setting: the fewest descriptors within one standard error of the best") {
  // Four classes of two: means .75, .7, .5; differences to the first (0, .1, 0, .1) and (.2, .3, .2, .3).
  const std::vector<std::uint32_t> labels{0, 0, 1, 1, 2, 2, 3, 3};
  const RetrievalTask task = make_retrieval_task(labels, 4);
  const RatedSetting best{3, {0.7, 0.8, 0.7, 0.8}}, near{2, {0.7, 0.7, 0.7, 0.7}},
      far{1, {0.5, 0.5, 0.5, 0.5}}, nearer{2, {0.7, 0.8, 0.7, 0.7}};
  const auto taken = [&](std::vector<const RatedSetting*> settings, std::size_t without = no_class) {
    return simplest_setting(task, settings, without);
  };
  // Of `near` the mean difference is .05 and its standard error sqrt(4 x .05^2) / 4 = .025.
  CHECK(taken({&best, &near, &far}) == 0);
  // Of `nearer` .025, and sqrt(3 x .025^2 + .075^2) / 4 = .0217.
  CHECK(taken({&best, &nearer, &far}) == 0);
  // Without class 1: .0333, and sqrt(2 x .0333^2 + .0667^2) / 3 = .0272.
  CHECK(taken({&best, &nearer}, 1) == 0);
  // Without class 3 nothing is left of it.
  CHECK(taken({&best, &nearer, &far}, 3) == 1);
  CHECK(taken({&near, &nearer}) == 1);
  CHECK(taken({&far, &far}) == 0);
  const RatedSetting uneven{1, {0.9, 0.2, 0.9, 0.8}};  // .05 below, with a standard error of .17
  CHECK(taken({&best, &near, &uneven}) == 2);
  CHECK_THROWS_AS(taken({}), std::invalid_argument);
}
