// Which descriptors under which distance find classes best, and how well that choice does on classes that
// had no say in it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "kernels/retrieve/descriptor_distance.h"
#include "kernels/retrieve/retrieval_scores.h"

namespace meander {

// Blocks of a base whose distances are added in this order, each times a positive weight.
struct WeightedBlock {
  std::uint32_t block = 0;
  double weight = 1;
  WeightedBlock(std::uint32_t number, double times = 1) : block(number), weight(times) {}
  friend bool operator==(const WeightedBlock&, const WeightedBlock&) = default;
};
using BlockCombination = std::vector<WeightedBlock>;

// Scores of every combination, from one pass over the distances of each block. The base holds all blocks; a
// combination of several adds their distances times their weights over their scales, one of a single block
// takes them as they are: the same bits as of a base that make_descriptor_base makes of these blocks alone.
// Summaries carry no confusion matrix. The same for every thread count. Throws std::invalid_argument for an
// empty combination, a block that does not exist, or a task of another number of rows. O(N^2 (total width +
// combinations x log C)); memory (blocks + 1) x N floats a thread, and 53 KB and 208 bytes a class for every
// combination.
std::vector<RetrievalSummary> score_combinations(const DescriptorBase& base, const RetrievalTask& task,
                                                 std::span<const BlockCombination> combinations);

// What the best setting is best in; the larger the better.
enum class SettingCriterion : std::uint8_t {
  nearest_and_first_tier,  // the mean of the two
  nearest_neighbour,
  first_tier,
  second_tier,
  e_measure,
  dcg,
  average_precision
};
double criterion_of(const RetrievalScores& scores, SettingCriterion criterion);

// Settings ranked by their mean over queries. Values that differ by less than 1e-12 are equal: the earlier
// setting is taken, so that rounding decides nothing. Throws std::invalid_argument when there is none.
std::size_t best_setting(std::span<const RetrievalSummary> settings, SettingCriterion criterion);

// Cross-validation over classes (Stone 1974, with whole classes for the parts): the queries of class c are
// scored with the setting that is best for the queries of all other scored classes. Models of class c stand
// in the lists of those queries, as in any base, and among the pairs that scale combined descriptors; their
// own class is used for neither.
struct LeftOutScores {
  std::vector<std::size_t> setting;  // of every class; of those that are not scored no_setting
  static constexpr std::size_t no_setting = ~std::size_t{0};
  RetrievalSummary scores;  // by class with its setting; micro over queries; macro over classes
};

// settings: summaries of one task. Throws std::invalid_argument when there is none, or fewer than two scored
// classes. O(settings x classes).
LeftOutScores leave_one_class_out(const RetrievalTask& task, std::span<const RetrievalSummary> settings,
                                  SettingCriterion criterion);

// The same with choices that were made elsewhere, for each class without it. setting: of every class; of
// those that are not scored no_setting.
LeftOutScores left_out_scores(const RetrievalTask& task, std::span<const RetrievalSummary> settings,
                              std::vector<std::size_t> setting);

// A setting as a choice among them sees it: how many descriptors it takes, and its criterion in every class.
struct RatedSetting {
  std::size_t descriptors = 1;
  std::vector<double> by_class;
};
std::vector<double> criterion_by_class(const RetrievalSummary& summary, SettingCriterion criterion);

// The simplest of the settings that are as good as the best (the one standard error rule of Breiman,
// Friedman, Olshen and Stone 1984): of those whose mean over the queries falls short of the best one by at
// most the standard error of that difference over the classes, the one of the fewest descriptors; of equally
// many the best; of equally good ones the first. `without`: a class whose queries do not count, or no_class.
// Throws std::invalid_argument when there is none.
inline constexpr std::size_t no_class = ~std::size_t{0};
std::size_t simplest_setting(const RetrievalTask& task, std::span<const RatedSetting* const> settings,
                             std::size_t without = no_class);

// Weights of the blocks of a base that make a criterion large, by coordinate ascent over a grid: from the
// best start, one block after the other takes the weight with the largest mean criterion over the training
// queries, until a round over all blocks changes nothing: then no other weight of the grid of a single block
// is better. A block that can be left out as well is left out.
struct WeightSearch {
  std::vector<double> grid = {0, 0.125, 0.25, 0.5, 1, 2, 4};  // none negative
  std::size_t rounds = 3;                                     // at most
  SettingCriterion criterion = SettingCriterion::nearest_and_first_tier;
};

// What a search came by, from its start to its end: better and better. In the order of the blocks, the
// largest weight 1.
struct LearntSetting {
  BlockCombination combination;
  RatedSetting rated;
};
using LearntCourse = std::vector<LearntSetting>;

// Learnt from the queries of all scored classes, and for every scored class from those of all others: what is
// learnt there is tested on the class.
struct LearntWeights {
  LearntCourse all;
  std::vector<LearntCourse> without;  // by class; empty where it is not scored
};

// starts: combinations to begin with, scored: their summaries. Throws std::invalid_argument as
// score_combinations and leave_one_class_out, when there is no start and when they do not fit. Cost: that of
// score_combinations for at most rounds x blocks x grid combinations for each of classes + 1 courses of the
// search, which mostly coincide; memory 8 bytes a class for each. The same for every thread count.
LearntWeights learn_weights(const DescriptorBase& base, const RetrievalTask& task,
                            std::span<const BlockCombination> starts,
                            std::span<const RetrievalSummary> scored, const WeightSearch& search = {});

}  // namespace meander
