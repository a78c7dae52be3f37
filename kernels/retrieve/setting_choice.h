// The choice of descriptors and distance that finds classes best, and its scores on classes that did not take
// part in the choice.
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

// The scores of every combination, from one pass over the distances of each block. The base holds all blocks.
// A combination of several adds their distances times their weights over their scales; one of a single block
// takes them as they are: the same bits as a base of these blocks alone by make_descriptor_base. Summaries
// carry no confusion matrix. The same for every thread count. Throws std::invalid_argument for an empty
// combination, a block that does not exist, or a task of another number of rows. O(N^2 (total width +
// combinations x log C)); memory: (blocks + 1) x N floats a thread, and a summary for every combination.
std::vector<RetrievalSummary> score_combinations(const DescriptorBase& base, const RetrievalTask& task,
                                                 std::span<const BlockCombination> combinations);

// The criterion of the best setting; larger values are better.
enum class SettingCriterion : std::uint8_t {
  nearest_and_first_tier,  // the mean of the two
  nearest_neighbor,
  first_tier,
  second_tier,
  e_measure,
  dcg,
  average_precision
};
double criterion_of(const RetrievalScores& scores, SettingCriterion criterion);

// The setting with the best mean over queries. Values that differ by less than 1e-12 are equal: the earlier
// setting is taken, so that rounding decides nothing. Throws std::invalid_argument when there is none.
std::size_t best_setting(std::span<const RetrievalSummary> settings, SettingCriterion criterion);

// Cross-validation over classes (Stone 1974, with whole classes for the parts): the queries of class c are
// scored with the setting that is best for the queries of all other scored classes. Models of class c stand
// in the lists of those queries, as in any base, and among the pairs that scale combined descriptors; their
// class is used for neither.
struct LeftOutScores {
  std::vector<std::size_t> setting;  // by class; no_setting where the class is not scored
  static constexpr std::size_t no_setting = ~std::size_t{0};
  RetrievalSummary scores;  // by class with its setting; micro over queries; macro over classes
};

// settings: summaries of one task. Throws std::invalid_argument when there is none, or fewer than two scored
// classes. O(settings x classes).
LeftOutScores leave_one_class_out(const RetrievalTask& task, std::span<const RetrievalSummary> settings,
                                  SettingCriterion criterion);

// The same with choices that were made elsewhere, for each class without it. setting: as
// LeftOutScores::setting.
LeftOutScores left_out_scores(const RetrievalTask& task, std::span<const RetrievalSummary> settings,
                              std::vector<std::size_t> setting);

// The properties of a setting that a choice compares: its number of descriptors, and its criterion in every
// class.
struct RatedSetting {
  std::size_t descriptors = 1;
  std::vector<double> by_class;
};
std::vector<double> criterion_by_class(const RetrievalSummary& summary, SettingCriterion criterion);

// The simplest of the settings that are as good as the best (the one-standard-error rule of Breiman,
// Friedman, Olshen and Stone 1984): of those whose mean over the queries falls short of the best one by at
// most the standard error of that difference over the classes, the one of the fewest descriptors; the best of
// those with equally many; the first of equally good ones. `without`: a class whose queries do not count, or
// no_class. Throws std::invalid_argument when there is none.
inline constexpr std::size_t no_class = ~std::size_t{0};
std::size_t simplest_setting(const RetrievalTask& task, std::span<const RatedSetting* const> settings,
                             std::size_t without = no_class);

// The search for weights of the blocks of a base that make a criterion large, by coordinate ascent over a
// grid: from the best start, one block after the other takes the weight with the largest mean criterion over
// the training queries, until a round over all blocks changes nothing: then no other weight of the grid for a
// single block is better. A block is left out where that is as good.
struct WeightSearch {
  std::vector<double> grid = {0, 0.125, 0.25, 0.5, 1, 2, 4};  // none negative
  std::size_t rounds = 3;                                     // a maximum
  SettingCriterion criterion = SettingCriterion::nearest_and_first_tier;
};

// A step of a search, each better than the one before. Weights are in the order of the blocks, with a maximum
// of 1.
struct LearntSetting {
  BlockCombination combination;
  RatedSetting rated;
};
using LearntCourse = std::vector<LearntSetting>;

// Weights learned from the queries of all scored classes, and for every scored class from those of all
// others, so that they can be tested on that class.
struct LearntWeights {
  LearntCourse all;
  std::vector<LearntCourse> without;  // by class; empty where it is not scored
};

// Learns weights. starts: combinations to begin with; scored: their summaries. Throws std::invalid_argument
// as score_combinations and leave_one_class_out, when there is no start and when they do not fit. Cost: that
// of score_combinations for at most rounds x blocks x grid combinations for each of classes + 1 courses of
// the search, which mostly coincide. The same for every thread count.
LearntWeights learn_weights(const DescriptorBase& base, const RetrievalTask& task,
                            std::span<const BlockCombination> starts,
                            std::span<const RetrievalSummary> scored, const WeightSearch& search = {});

}  // namespace meander
