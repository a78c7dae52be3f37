#include "kernels/retrieve/setting_choice.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <utility>

#include "kernels/core/parallel.h"

namespace meander {

namespace {

constexpr std::size_t queries_at_once = 256;
constexpr double equal_within = 1e-12;

// Distances of one query: of every block, and of one combination.
struct QueryLists {
  std::vector<float> of_blocks, combined;
};

std::span<const float> combined_distances(const DescriptorBase& base, const BlockCombination& combination,
                                          QueryLists& lists) {
  const std::size_t n = base.rows;
  const auto of_block = [&](std::size_t b) { return std::span(lists.of_blocks).subspan(b * n, n); };
  if (combination.size() == 1) return of_block(combination[0].block);
  for (std::size_t part = 0; part < combination.size(); ++part) {
    const auto& [block, weight] = combination[part];
    const std::span<const float> distances = of_block(block);
    const auto factor = static_cast<float>(weight / base.blocks[block].scale);
    for (std::size_t i = 0; i < n; ++i)
      lists.combined[i] = part == 0 ? distances[i] * factor : lists.combined[i] + distances[i] * factor;
  }
  return lists.combined;
}

}  // namespace

std::vector<RetrievalSummary> score_combinations(const DescriptorBase& base, const RetrievalTask& task,
                                                 std::span<const BlockCombination> combinations) {
  const std::size_t n = base.rows, classes = task.members.size(), settings = combinations.size();
  if (task.rows() != n) throw std::invalid_argument("a base and a task of different rows");
  std::vector<std::uint8_t> needed(base.blocks.size(), 0);
  for (const BlockCombination& combination : combinations) {
    if (combination.empty()) throw std::invalid_argument("a combination of no descriptors");
    for (const WeightedBlock& part : combination) {
      if (part.block >= base.blocks.size())
        throw std::invalid_argument("a combination of unknown descriptors");
      if (!(part.weight > 0)) throw std::invalid_argument("a combination with a weight that is not positive");
      needed[part.block] = 1;
    }
  }
  std::vector<RetrievalSummary> result(settings);
  for (RetrievalSummary& summary : result) summary.by_class.resize(classes);
  std::vector<std::size_t> queries;
  for (std::size_t row = 0; row < n; ++row)
    if (task.scores(row)) queries.push_back(row);
  std::vector<RetrievalScores> scores(queries_at_once * settings);
  for (std::size_t first = 0; first < queries.size(); first += queries_at_once) {
    const std::size_t count = std::min(queries_at_once, queries.size() - first);
    parallel_tasks(count, [&](std::size_t q) {
      const std::size_t query = queries[first + q];
      QueryLists lists{std::vector<float>(base.blocks.size() * n), std::vector<float>(n)};
      for (std::size_t b = 0; b < base.blocks.size(); ++b)
        if (needed[b] != 0) block_distances(base, b, query, 0, std::span(lists.of_blocks).subspan(b * n, n));
      for (std::size_t s = 0; s < settings; ++s)
        scores[q * settings + s] =
            score_query(task, query, combined_distances(base, combinations[s], lists)).scores;
    });
    // Sums are in the order of the rows, as in summarize.
    for (std::size_t q = 0; q < count; ++q)
      for (std::size_t s = 0; s < settings; ++s) {
        result[s].micro += scores[q * settings + s];
        result[s].by_class[task.label[queries[first + q]]] += scores[q * settings + s];
      }
  }
  for (RetrievalSummary& summary : result) {
    summary.queries = queries.size();
    summary.micro /= queries.size();
    for (std::size_t c = 0; c < classes; ++c) {
      if (task.scored[c] == 0) continue;
      ++summary.classes;
      summary.by_class[c] /= task.members[c].size();
      summary.macro += summary.by_class[c];
    }
    summary.macro /= summary.classes;
  }
  return result;
}

double criterion_of(const RetrievalScores& scores, SettingCriterion criterion) {
  switch (criterion) {
    case SettingCriterion::nearest_and_first_tier:
      return (scores.nearest_neighbor + scores.first_tier) / 2;
    case SettingCriterion::nearest_neighbor:
      return scores.nearest_neighbor;
    case SettingCriterion::first_tier:
      return scores.first_tier;
    case SettingCriterion::second_tier:
      return scores.second_tier;
    case SettingCriterion::e_measure:
      return scores.e_measure;
    case SettingCriterion::dcg:
      return scores.dcg;
    case SettingCriterion::average_precision:
      return scores.average_precision;
  }
  return 0;
}

namespace {

std::size_t first_of_largest(std::span<const double> values) {
  if (values.empty()) throw std::invalid_argument("no setting to choose from");
  const double max = *std::max_element(values.begin(), values.end());
  return static_cast<std::size_t>(
      std::find_if(values.begin(), values.end(), [&](double v) { return v >= max - equal_within; }) -
      values.begin());
}

}  // namespace

std::size_t best_setting(std::span<const RetrievalSummary> settings, SettingCriterion criterion) {
  std::vector<double> values;
  for (const RetrievalSummary& summary : settings) values.push_back(criterion_of(summary.micro, criterion));
  return first_of_largest(values);
}

namespace {

// The criterion of settings over the queries of all scored classes but one.
class TrainingValues {
 public:
  explicit TrainingValues(const RetrievalTask& task) : task_(task) {
    for (std::size_t c = 0; c < task.members.size(); ++c)
      if (task.scored[c] != 0) queries_ += members_of(c);
  }
  // by_class: the criterion of every class. without: a class, or no_class.
  double value(std::span<const double> by_class, std::size_t without) const {
    double total = 0;
    for (std::size_t c = 0; c < by_class.size(); ++c)
      if (task_.scored[c] != 0) total += by_class[c] * members_of(c);
    if (without == no_class) return total / queries_;
    return (total - by_class[without] * members_of(without)) / (queries_ - members_of(without));
  }
  // The standard error of the difference of two means, with classes drawn as a whole.
  double error_of_difference(std::span<const double> a, std::span<const double> b,
                             std::size_t without) const {
    const double mean = value(a, without) - value(b, without);
    double squares = 0, queries = 0;
    for (std::size_t c = 0; c < a.size(); ++c) {
      if (task_.scored[c] == 0 || c == without) continue;
      const double offset = members_of(c) * (a[c] - b[c] - mean);
      squares += offset * offset;
      queries += members_of(c);
    }
    return std::sqrt(squares) / queries;
  }

 private:
  double members_of(std::size_t c) const { return static_cast<double>(task_.members[c].size()); }

  const RetrievalTask& task_;
  double queries_ = 0;
};

void require_two_classes(const RetrievalTask& task) {
  if (std::count(task.scored.begin(), task.scored.end(), 1) < 2)
    throw std::invalid_argument("one class can only be left out of two or more");
}

}  // namespace

std::vector<double> criterion_by_class(const RetrievalSummary& summary, SettingCriterion criterion) {
  std::vector<double> values;
  for (const RetrievalScores& scores : summary.by_class) values.push_back(criterion_of(scores, criterion));
  return values;
}

std::size_t simplest_setting(const RetrievalTask& task, std::span<const RatedSetting* const> settings,
                             std::size_t without) {
  const TrainingValues training(task);
  std::vector<double> values;
  for (const RatedSetting* setting : settings) values.push_back(training.value(setting->by_class, without));
  const std::size_t best = first_of_largest(values);
  std::size_t taken = best;
  for (std::size_t s = 0; s < settings.size(); ++s) {
    const bool simpler = settings[s]->descriptors < settings[taken]->descriptors;
    const bool better =
        settings[s]->descriptors == settings[taken]->descriptors && values[s] > values[taken] + equal_within;
    if (!simpler && !better) continue;
    const double error =
        training.error_of_difference(settings[best]->by_class, settings[s]->by_class, without);
    if (values[best] - values[s] <= error + equal_within) taken = s;
  }
  return taken;
}

LeftOutScores left_out_scores(const RetrievalTask& task, std::span<const RetrievalSummary> settings,
                              std::vector<std::size_t> setting) {
  const std::size_t classes = task.members.size();
  LeftOutScores result;
  result.setting = std::move(setting);
  result.scores.by_class.resize(classes);
  for (std::size_t c = 0; c < classes; ++c) {
    if (task.scored[c] == 0) continue;
    const RetrievalScores& own = settings[result.setting[c]].by_class[c];
    result.scores.by_class[c] = own;
    result.scores.macro += own;
    RetrievalScores sum = own;
    sum *= task.members[c].size();
    result.scores.micro += sum;
    ++result.scores.classes;
    result.scores.queries += task.members[c].size();
  }
  result.scores.micro /= result.scores.queries;
  result.scores.macro /= result.scores.classes;
  return result;
}

LeftOutScores leave_one_class_out(const RetrievalTask& task, std::span<const RetrievalSummary> settings,
                                  SettingCriterion criterion) {
  require_two_classes(task);
  const TrainingValues training(task);
  std::vector<std::vector<double>> by_class;
  for (const RetrievalSummary& summary : settings) by_class.push_back(criterion_by_class(summary, criterion));
  std::vector<std::size_t> chosen(task.members.size(), LeftOutScores::no_setting);
  std::vector<double> values(settings.size());
  for (std::size_t c = 0; c < chosen.size(); ++c) {
    if (task.scored[c] == 0) continue;
    for (std::size_t s = 0; s < settings.size(); ++s) values[s] = training.value(by_class[s], c);
    chosen[c] = first_of_largest(values);
  }
  return left_out_scores(task, settings, std::move(chosen));
}

namespace {

// The weights of all blocks, with a maximum of 1, which identify a combination in the search.
using Weights = std::vector<double>;

Weights with_largest_one(Weights weights) {
  const double largest = *std::max_element(weights.begin(), weights.end());
  if (largest > 0)
    for (double& weight : weights) weight /= largest;
  return weights;
}

BlockCombination combination_of(const Weights& weights) {
  BlockCombination combination;
  for (std::uint32_t b = 0; b < weights.size(); ++b)
    if (weights[b] > 0) combination.emplace_back(b, weights[b]);
  return combination;
}

class WeightAscent {
 public:
  WeightAscent(const DescriptorBase& base, const RetrievalTask& task, const WeightSearch& search)
      : base_(base), task_(task), search_(search), training_(task) {
    courses_.push_back({no_class, {}});
    for (std::size_t c = 0; c < task.members.size(); ++c)
      if (task.scored[c] != 0) courses_.push_back({c, {}});
  }

  LearntWeights run(std::span<const BlockCombination> starts, std::span<const RetrievalSummary> scored) {
    std::vector<Weights> candidates;
    for (std::size_t s = 0; s < starts.size(); ++s) {
      Weights weights(base_.blocks.size(), 0.0);
      for (const WeightedBlock& part : starts[s]) weights.at(part.block) = part.weight;
      candidates.push_back(with_largest_one(std::move(weights)));
      known_.try_emplace(candidates.back(), criterion_by_class(scored[s], search_.criterion));
    }
    for (Course& course : courses_) course.path = {best_of(candidates, course.without)};
    bool changed = true;
    for (std::size_t round = 0; round < search_.rounds && changed; ++round) {
      changed = false;
      for (std::size_t block = 0; block < base_.blocks.size(); ++block) changed |= climb(block);
    }
    LearntWeights result;
    result.without.resize(task_.members.size());
    for (const Course& course : courses_) {
      LearntCourse& learnt = course.without == no_class ? result.all : result.without[course.without];
      for (const Weights& weights : course.path) {
        BlockCombination combination = combination_of(weights);
        const std::size_t descriptors = combination.size();
        learnt.push_back({std::move(combination), {descriptors, known_.at(weights)}});
      }
    }
    return result;
  }

 private:
  struct Course {
    std::size_t without;
    std::vector<Weights> path;  // the present weights last
  };

  // Takes the best weight of one block in every course. True when a course changed.
  bool climb(std::size_t block) {
    std::vector<std::vector<Weights>> of_course;
    std::vector<Weights> all;
    for (const Course& course : courses_) {
      std::vector<Weights>& candidates = of_course.emplace_back();
      for (const double weight : search_.grid) {
        Weights weights = course.path.back();
        weights[block] = weight;
        if (combination_of(weights).empty()) continue;
        candidates.push_back(with_largest_one(std::move(weights)));
      }
      all.insert(all.end(), candidates.begin(), candidates.end());
    }
    score(all);
    bool changed = false;
    for (std::size_t i = 0; i < courses_.size(); ++i) {
      Course& course = courses_[i];
      const Weights& best = best_of(of_course[i], course.without);
      const Weights& present = course.path.back();
      const double gain = value_of(best, course.without) - value_of(present, course.without);
      const bool leaves_out = best[block] == 0 && present[block] > 0;
      if (gain <= (leaves_out ? -equal_within : equal_within)) continue;
      course.path.push_back(best);
      changed = true;
    }
    return changed;
  }

  // Scores the weights that are not known yet.
  void score(const std::vector<Weights>& wanted) {
    std::vector<Weights> missing;
    std::vector<BlockCombination> combinations;
    for (const Weights& weights : wanted)
      if (known_.try_emplace(weights).second) {
        missing.push_back(weights);
        combinations.push_back(combination_of(weights));
      }
    constexpr std::size_t at_once = 256;  // summaries in memory
    for (std::size_t begin = 0; begin < missing.size(); begin += at_once) {
      const std::size_t count = std::min(at_once, missing.size() - begin);
      const std::vector<RetrievalSummary> summaries =
          score_combinations(base_, task_, std::span(combinations).subspan(begin, count));
      for (std::size_t i = 0; i < count; ++i)
        known_[missing[begin + i]] = criterion_by_class(summaries[i], search_.criterion);
    }
  }

  double value_of(const Weights& weights, std::size_t without) const {
    return training_.value(known_.at(weights), without);
  }

  const Weights& best_of(const std::vector<Weights>& candidates, std::size_t without) const {
    std::vector<double> values;
    for (const Weights& weights : candidates) values.push_back(value_of(weights, without));
    return candidates[first_of_largest(values)];
  }

  const DescriptorBase& base_;
  const RetrievalTask& task_;
  const WeightSearch& search_;
  const TrainingValues training_;
  std::vector<Course> courses_;
  std::map<Weights, std::vector<double>> known_;  // the criterion of every class
};

}  // namespace

LearntWeights learn_weights(const DescriptorBase& base, const RetrievalTask& task,
                            std::span<const BlockCombination> starts,
                            std::span<const RetrievalSummary> scored, const WeightSearch& search) {
  require_two_classes(task);
  if (starts.size() != scored.size()) throw std::invalid_argument("not one summary for each start");
  return WeightAscent(base, task, search).run(starts, scored);
}

}  // namespace meander
