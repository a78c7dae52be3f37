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

// Blocks of a base whose distances are added, in this order.
using BlockCombination = std::vector<std::uint32_t>;

// Scores of every combination, from one pass over the distances of each block. The base holds all blocks; a
// combination of several adds their distances over their scales, one of a single block takes them as they
// are: the same bits as of a base that make_descriptor_base makes of these blocks alone. Summaries carry no
// confusion matrix. The same for every thread count. Throws std::invalid_argument for an empty combination, a
// block that does not exist, or a task of another number of rows. O(N^2 (total width + combinations x log
// C)); memory (blocks + 1) x N floats a thread, and 53 KB and 208 bytes a class for every combination.
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

}  // namespace meander
