#include "kernels/retrieve/retrieval_scores.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <stdexcept>

#include "kernels/core/portable_functions.h"

namespace meander {

namespace {

// Places of a ranked list that belong together: `hits` rows of the query's class among `size` rows at one
// distance, behind `rows_before` rows of which `hits_before` are hits.
struct TiedPlaces {
  std::size_t rows_before = 0, hits_before = 0, size = 0, hits = 0;
};

// Sorts like the ranked list: by distance (not negative, so that its bits are in order), then, where ties
// have an order, by row.
std::uint64_t place_key(float distance, std::uint32_t row, bool by_row) {
  return std::uint64_t{std::bit_cast<std::uint32_t>(distance)} << 32 | (by_row ? row : 0);
}

// Does the work of std::lower_bound without branches: the half that a row falls into cannot be predicted.
std::size_t first_not_below(std::span<const std::uint64_t> keys, std::uint64_t key) {
  const std::uint64_t* at = keys.data();
  for (std::size_t left = keys.size(); left > 1;) {
    const std::size_t half = left / 2;
    at = at[half - 1] < key ? at + half : at;
    left -= half;
  }
  return static_cast<std::size_t>(at - keys.data()) + (*at < key ? 1 : 0);
}

// The places of the hits, from the distances alone: the other rows are only counted between them, so that
// only the list of hits is sorted.
std::vector<TiedPlaces> places_of_hits(const RetrievalTask& task, std::size_t query,
                                       std::span<const float> distances) {
  const std::uint32_t own = task.label[query];
  const bool by_row = task.psb_compat;
  std::vector<std::uint64_t> hits;
  for (const std::uint32_t row : task.members[own])
    if (row != query) hits.push_back(place_key(distances[row], row, by_row));
  std::sort(hits.begin(), hits.end());
  std::vector<std::uint64_t> heads;  // one for each group of ties
  std::vector<TiedPlaces> places;
  for (const std::uint64_t hit : hits) {
    if (heads.empty() || heads.back() != hit) {
      heads.push_back(hit);
      places.emplace_back();
    }
    ++places.back().hits;
  }
  // others[g]: rows behind group g-1 and before group g; tied[g]: rows level with group g. All rows are
  // counted, then those of the class are subtracted: cheaper than testing every label.
  std::vector<std::size_t> others(heads.size() + 1, 0), tied(heads.size() + 1, 0);
  heads.push_back(~std::uint64_t{0});
  for (std::size_t row = 0; row < distances.size(); ++row) {
    const std::uint64_t key = place_key(distances[row], static_cast<std::uint32_t>(row), by_row);
    const std::size_t g = first_not_below(heads, key);
    const std::size_t level = heads[g] == key ? 1 : 0;
    tied[g] += level;
    others[g] += 1 - level;
  }
  for (std::size_t g = 0; g < places.size(); ++g) tied[g] -= places[g].hits;
  const std::uint64_t own_key = place_key(distances[query], static_cast<std::uint32_t>(query), by_row);
  const std::size_t own_group = first_not_below(heads, own_key);
  --(heads[own_group] == own_key ? tied : others)[own_group];
  std::size_t rows = 0, found = 0;
  for (std::size_t g = 0; g < places.size(); ++g) {
    rows += others[g];
    places[g].rows_before = rows;
    places[g].hits_before = found;
    places[g].size = places[g].hits + tied[g];
    rows += places[g].size;
    found += places[g].hits;
  }
  return places;
}

// The expected number of hits in the first `length` places.
double expected_hits(std::span<const TiedPlaces> places, std::size_t length) {
  double sum = 0;
  for (const TiedPlaces& p : places) {
    if (p.rows_before >= length) break;
    const std::size_t inside = std::min(p.size, length - p.rows_before);
    sum += static_cast<double>(p.hits) * static_cast<double>(inside) / static_cast<double>(p.size);
  }
  return sum;
}

// The expected value of (H + m) / (P + X), with X the place of the m-th of r hits that stand in random order
// among n places: Pr(X = x) ~ C(x-1, m-1) C(n-x, r-m). The weights are built up from the most likely place to
// both sides until they are negligible.
double expected_precision(const TiedPlaces& p, std::size_t m) {
  const std::size_t n = p.size, r = p.hits;
  const auto precision = [&](std::size_t x) {
    return static_cast<double>(p.hits_before + m) / static_cast<double>(p.rows_before + x);
  };
  if (n == r) return precision(m);
  // Pr(x + 1) / Pr(x)
  const auto step = [&](std::size_t x) {
    return static_cast<double>(x) / static_cast<double>(x - m + 1) * static_cast<double>(n - x - (r - m)) /
           static_cast<double>(n - x);
  };
  constexpr double negligible = 1e-18;
  const std::size_t min = m, max = n - r + m;
  // The ratio falls with x: the mode is where it passes 1.
  std::size_t low = min, high = max;
  while (low < high) {
    const std::size_t middle = low + (high - low) / 2;
    if (step(middle) >= 1)
      low = middle + 1;
    else
      high = middle;
  }
  double weight = 1, weights = 1, sum = precision(low);
  for (std::size_t x = low; x < max; ++x) {
    weight *= step(x);
    if (weight < negligible) break;
    weights += weight;
    sum += weight * precision(x + 1);
  }
  weight = 1;
  for (std::size_t x = low; x > min; --x) {
    weight /= step(x - 1);
    if (weight < negligible) break;
    weights += weight;
    sum += weight * precision(x - 1);
  }
  return sum / weights;
}

std::vector<std::pair<std::uint32_t, double>> classes_of_nearest(const RetrievalTask& task, std::size_t query,
                                                                 std::span<const float> distances) {
  float nearest = std::numeric_limits<float>::infinity();
  for (std::size_t row = 0; row < distances.size(); ++row)
    if (row != query) nearest = std::min(nearest, distances[row]);
  std::vector<std::uint32_t> classes;
  for (std::size_t row = 0; row < distances.size(); ++row)
    if (row != query && distances[row] == nearest) {
      classes.push_back(task.label[row]);
      if (task.psb_compat) break;
    }
  std::sort(classes.begin(), classes.end());
  std::vector<std::pair<std::uint32_t, double>> shares;
  for (std::size_t begin = 0, end = 0; begin < classes.size(); begin = end) {
    while (end < classes.size() && classes[end] == classes[begin]) ++end;
    shares.emplace_back(classes[begin],
                        static_cast<double>(end - begin) / static_cast<double>(classes.size()));
  }
  return shares;
}

// Applies change(own, other's) to every score.
template <class Change>
void change_each(RetrievalScores& scores, const RetrievalScores& other, const Change& change) {
  change(scores.nearest_neighbor, other.nearest_neighbor);
  change(scores.first_tier, other.first_tier);
  change(scores.second_tier, other.second_tier);
  change(scores.e_measure, other.e_measure);
  change(scores.dcg, other.dcg);
  change(scores.average_precision, other.average_precision);
  for (std::size_t i = 0; i < recall_levels; ++i) change(scores.precision[i], other.precision[i]);
}

}  // namespace

RetrievalScores& RetrievalScores::operator+=(const RetrievalScores& other) {
  change_each(*this, other, [](double& own, double more) { own += more; });
  return *this;
}

RetrievalScores& RetrievalScores::operator*=(std::size_t count) {
  const auto factor = static_cast<double>(count);
  change_each(*this, *this, [factor](double& own, double) { own *= factor; });
  return *this;
}

RetrievalScores& RetrievalScores::operator/=(std::size_t count) {
  const double divisor = count > 0 ? static_cast<double>(count) : 1;
  change_each(*this, *this, [divisor](double& own, double) { own /= divisor; });
  return *this;
}

RetrievalTask make_retrieval_task(std::span<const std::uint32_t> labels, std::size_t classes, bool psb_compat,
                                  std::span<const std::uint32_t> left_out) {
  RetrievalTask task;
  task.label.assign(labels.begin(), labels.end());
  task.members.resize(classes);
  task.psb_compat = psb_compat;
  for (std::size_t row = 0; row < labels.size(); ++row) {
    if (labels[row] >= classes) throw std::invalid_argument("a label names no class");
    task.members[labels[row]].push_back(static_cast<std::uint32_t>(row));
  }
  task.scored.resize(classes);
  for (std::size_t c = 0; c < classes; ++c)
    task.scored[c] = task.members[c].size() > (psb_compat ? 2u : 1u) ? 1 : 0;
  if (psb_compat)
    for (const std::uint32_t c : left_out) task.scored.at(c) = 0;
  task.discount.resize(labels.size());
  for (std::size_t i = 0; i < labels.size(); ++i)
    task.discount[i] = i == 0 ? 1 : 1 / portable::log2(static_cast<double>(i + 1));
  return task;
}

QueryScores score_query(const RetrievalTask& task, std::size_t query, std::span<const float> distances) {
  if (distances.size() != task.rows() || query >= task.rows() || !task.scores(query))
    throw std::invalid_argument("a query that cannot be scored");
  const std::size_t wanted = task.members[task.label[query]].size() - 1, others = task.rows() - 1;
  const std::vector<TiedPlaces> places = places_of_hits(task, query, distances);
  const auto count = static_cast<double>(wanted);
  QueryScores result;
  RetrievalScores& scores = result.scores;
  scores.nearest_neighbor = expected_hits(places, 1);
  scores.first_tier = expected_hits(places, wanted) / count;
  scores.second_tier = expected_hits(places, std::min(2 * wanted, others)) / count;
  const std::size_t first = std::min<std::size_t>(32, others);
  scores.e_measure = 2 * expected_hits(places, first) / static_cast<double>(first + wanted);

  double gain = 0, ideal = 0, precisions = 0;
  for (std::size_t i = 0; i < wanted; ++i) ideal += task.discount[i];
  std::vector<double> precision_at_hit;
  precision_at_hit.reserve(wanted);
  for (const TiedPlaces& p : places) {
    const double share = static_cast<double>(p.hits) / static_cast<double>(p.size);
    double discounts = 0;
    for (std::size_t j = 0; j < p.size; ++j) discounts += task.discount[p.rows_before + j];
    gain += share * discounts;
    for (std::size_t m = 1; m <= p.hits; ++m) {
      precision_at_hit.push_back(expected_precision(p, m));
      precisions += precision_at_hit.back();
    }
  }
  scores.dcg = gain / ideal;
  scores.average_precision = precisions / count;
  for (std::size_t i = wanted - 1; i-- > 0;)
    precision_at_hit[i] = std::max(precision_at_hit[i], precision_at_hit[i + 1]);
  for (std::size_t i = 0; i < recall_levels; ++i)  // the first hit whose recall reaches the level
    scores.precision[i] = precision_at_hit[((i + 1) * wanted + recall_levels - 1) / recall_levels - 1];
  result.nearest_classes = classes_of_nearest(task, query, distances);
  return result;
}

RetrievalSummary summarize(const RetrievalTask& task, std::span<const QueryScores> queries,
                           bool with_confusion) {
  const std::size_t classes = task.members.size();
  RetrievalSummary summary;
  summary.by_class.resize(classes);
  if (with_confusion) summary.confusion.assign(classes * classes, 0);
  for (std::size_t row = 0; row < task.rows(); ++row) {
    if (!task.scores(row)) continue;
    const std::uint32_t own = task.label[row];
    ++summary.queries;
    summary.micro += queries[row].scores;
    summary.by_class[own] += queries[row].scores;
    if (!with_confusion) continue;
    for (const auto& [other, share] : queries[row].nearest_classes)
      summary.confusion[own * classes + other] += share;
  }
  for (std::size_t c = 0; c < classes; ++c) {
    if (!task.scored[c]) continue;
    ++summary.classes;
    summary.by_class[c] /= task.members[c].size();
    for (std::size_t other = 0; with_confusion && other < classes; ++other)
      summary.confusion[c * classes + other] /= static_cast<double>(task.members[c].size());
    summary.macro += summary.by_class[c];
  }
  summary.micro /= summary.queries;
  summary.macro /= summary.classes;
  return summary;
}

}  // namespace meander
