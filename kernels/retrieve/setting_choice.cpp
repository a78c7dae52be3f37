#include "kernels/retrieve/setting_choice.h"

#include <algorithm>
#include <stdexcept>

#include "kernels/core/parallel.h"

namespace meander {

namespace {

constexpr std::size_t queries_at_once = 256;
constexpr double equal_within = 1e-12;

// Distances of one query, of every block and of one combination.
struct QueryLists {
  std::vector<float> of_blocks, combined;
};

std::span<const float> combined_distances(const DescriptorBase& base, const BlockCombination& combination,
                                          QueryLists& lists) {
  const std::size_t n = base.rows;
  const auto of_block = [&](std::size_t b) { return std::span(lists.of_blocks).subspan(b * n, n); };
  if (combination.size() == 1) return of_block(combination[0]);
  for (std::size_t part = 0; part < combination.size(); ++part) {
    const std::span<const float> distances = of_block(combination[part]);
    const auto factor = static_cast<float>(1 / base.blocks[combination[part]].scale);
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
    for (const std::uint32_t block : combination) {
      if (block >= base.blocks.size()) throw std::invalid_argument("a combination of unknown descriptors");
      needed[block] = 1;
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
    // Sums in the order of the rows, as summarise takes them.
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
      return (scores.nearest_neighbour + scores.first_tier) / 2;
    case SettingCriterion::nearest_neighbour:
      return scores.nearest_neighbour;
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
  const double most = *std::max_element(values.begin(), values.end());
  return static_cast<std::size_t>(
      std::find_if(values.begin(), values.end(), [&](double v) { return v >= most - equal_within; }) -
      values.begin());
}

}  // namespace

std::size_t best_setting(std::span<const RetrievalSummary> settings, SettingCriterion criterion) {
  std::vector<double> values;
  for (const RetrievalSummary& summary : settings) values.push_back(criterion_of(summary.micro, criterion));
  return first_of_largest(values);
}

LeftOutScores leave_one_class_out(const RetrievalTask& task, std::span<const RetrievalSummary> settings,
                                  SettingCriterion criterion) {
  const std::size_t classes = task.members.size();
  if (std::count(task.scored.begin(), task.scored.end(), 1) < 2)
    throw std::invalid_argument("one class can only be left out of two or more");
  LeftOutScores result;
  result.setting.assign(classes, LeftOutScores::no_setting);
  result.scores.by_class.resize(classes);
  // Of all scored classes; those of all but one are the difference.
  std::vector<double> totals(settings.size(), 0), values(settings.size());
  double queries = 0;
  const auto members_of = [&](std::size_t c) { return static_cast<double>(task.members[c].size()); };
  for (std::size_t c = 0; c < classes; ++c) {
    if (task.scored[c] == 0) continue;
    queries += members_of(c);
    for (std::size_t s = 0; s < settings.size(); ++s)
      totals[s] += criterion_of(settings[s].by_class[c], criterion) * members_of(c);
  }
  for (std::size_t c = 0; c < classes; ++c) {
    if (task.scored[c] == 0) continue;
    for (std::size_t s = 0; s < settings.size(); ++s)
      values[s] = (totals[s] - criterion_of(settings[s].by_class[c], criterion) * members_of(c)) /
                  (queries - members_of(c));
    result.setting[c] = first_of_largest(values);
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

}  // namespace meander
