#include "kernels/retrieve/local_words.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "kernels/core/parallel.h"

namespace meander {

namespace {

constexpr int turns_of_axes = 60, rounds_of_words = 15;
constexpr std::uint32_t spare_axes = 8;  // turned along, so that the last ones that are kept settle
constexpr std::size_t histograms_at_once = 256, rows_at_once = 16;

void check_histograms(std::span<const float> histograms, std::uint32_t width) {
  if (width == 0 || histograms.size() % width != 0)
    throw std::invalid_argument("local histograms of another width than the words");
}

std::vector<double> mean_of(std::span<const float> histograms, std::uint32_t width) {
  std::vector<double> mean(width, 0);
  for (std::size_t at = 0; at < histograms.size(); at += width)
    for (std::size_t k = 0; k < width; ++k) mean[k] += static_cast<double>(histograms[at + k]);
  for (double& value : mean) value /= static_cast<double>(histograms.size() / width);
  return mean;
}

// Sums of products about the mean, width x width. Each sum runs over the histograms in their order.
std::vector<double> products_of(std::span<const float> histograms, std::uint32_t width,
                                std::span<const double> mean, const CancelToken& cancel) {
  std::vector<double> products(std::size_t{width} * width, 0);
  parallel_tasks((width + rows_at_once - 1) / rows_at_once, [&](std::size_t task) {
    const std::size_t first = task * rows_at_once, last = std::min<std::size_t>(width, first + rows_at_once);
    std::vector<double> offsets(width);
    for (std::size_t at = 0; at < histograms.size(); at += width) {
      if (at % (1024 * std::size_t{width}) == 0) cancel.check();
      for (std::size_t k = 0; k < width; ++k) offsets[k] = static_cast<double>(histograms[at + k]) - mean[k];
      for (std::size_t i = first; i < last; ++i) {
        double* const row = products.data() + i * width;
        const double own = offsets[i];
        for (std::size_t k = 0; k < width; ++k) row[k] += own * offsets[k];
      }
    }
  });
  return products;
}

// Makes each column orthogonal to those before and of length 1; one that lies in their space becomes 0.
void orthonormalize(std::vector<std::vector<double>>& columns, double largest) {
  constexpr double negligible = 1e-9;
  for (std::size_t c = 0; c < columns.size(); ++c) {
    for (int again = 0; again < 2; ++again)
      for (std::size_t b = 0; b < c; ++b) {
        const double* const before = columns[b].data();
        double* const column = columns[c].data();
        double dot = 0;
        for (std::size_t k = 0; k < columns[c].size(); ++k) dot += before[k] * column[k];
        for (std::size_t k = 0; k < columns[c].size(); ++k) column[k] -= dot * before[k];
      }
    double squares = 0;
    for (const double value : columns[c]) squares += value * value;
    const double length = std::sqrt(squares);
    for (double& value : columns[c]) value = length > negligible * largest ? value / length : 0;
  }
}

// The first `count` principal axes, from the bins of the largest variance on; the largest value of each is
// positive.
std::vector<std::vector<double>> principal_axes(std::span<const double> products, std::uint32_t width,
                                                std::uint32_t count, const CancelToken& cancel) {
  double trace = 0;
  std::vector<std::size_t> bins(width);
  for (std::size_t k = 0; k < width; ++k) {
    trace += products[k * width + k];
    bins[k] = k;
  }
  std::stable_sort(bins.begin(), bins.end(), [&](std::size_t a, std::size_t b) {
    return products[a * width + a] > products[b * width + b];
  });
  std::vector<std::vector<double>> columns(std::min(width, count + spare_axes),
                                           std::vector<double>(width, 0));
  for (std::size_t c = 0; c < columns.size(); ++c) columns[c][bins[c]] = 1;
  for (int turn = 0; turn < turns_of_axes; ++turn) {
    cancel.check();
    parallel_tasks(columns.size(), [&](std::size_t c) {
      std::vector<double> turned(width, 0);
      double* const to = turned.data();
      for (std::size_t i = 0; i < width; ++i) {
        const double own = columns[c][i];
        const double* const row = products.data() + i * width;
        for (std::size_t k = 0; k < width; ++k) to[k] += own * row[k];
      }
      columns[c] = std::move(turned);
    });
    orthonormalize(columns, trace);
  }
  columns.resize(count, std::vector<double>(width, 0));
  for (std::vector<double>& column : columns) {
    const auto largest = std::max_element(column.begin(), column.end(),
                                          [](double a, double b) { return std::abs(a) < std::abs(b); });
    if (*largest < 0)
      for (double& value : column) value = -value;
  }
  return columns;
}

// Histograms less the mean in the axes: count x axes. Most bins of a histogram are empty, and cost nothing.
std::vector<float> turned(const LocalWords& words, std::span<const float> histograms) {
  const std::size_t count = histograms.size() / words.width, axes = words.axes;
  std::vector<float> less(axes, 0.0f);
  for (std::size_t k = 0; k < words.width; ++k)
    for (std::size_t a = 0; a < axes; ++a) less[a] -= words.mean[k] * words.turn[k * axes + a];
  std::vector<float> result(count * axes);
  parallel_blocks(count, histograms_at_once, [&](std::size_t begin, std::size_t end) {
    for (std::size_t h = begin; h < end; ++h) {
      float* const to = result.data() + h * axes;
      const float* const from = histograms.data() + h * words.width;
      std::copy(less.begin(), less.end(), to);
      for (std::size_t k = 0; k < words.width; ++k) {
        if (from[k] == 0) continue;
        const float* const row = words.turn.data() + k * axes;
        for (std::size_t a = 0; a < axes; ++a) to[a] += from[k] * row[a];
      }
    }
  });
  return result;
}

// The word nearest to each; of equally near ones the first.
std::vector<std::uint32_t> nearest_words(const LocalWords& words, std::span<const float> places) {
  const std::size_t axes = words.axes, count = places.size() / axes;
  std::vector<float> across(axes * words.words);  // axis by axis, so that the words are lanes
  for (std::size_t w = 0; w < words.words; ++w)
    for (std::size_t a = 0; a < axes; ++a) across[a * words.words + w] = words.centers[w * axes + a];
  std::vector<std::uint32_t> nearest(count);
  parallel_blocks(count, histograms_at_once, [&](std::size_t begin, std::size_t end) {
    std::vector<float> squares(words.words);
    for (std::size_t h = begin; h < end; ++h) {
      std::fill(squares.begin(), squares.end(), 0.0f);
      for (std::size_t a = 0; a < axes; ++a) {
        const float own = places[h * axes + a];
        const float* const row = across.data() + a * words.words;
        for (std::size_t w = 0; w < words.words; ++w) squares[w] += (own - row[w]) * (own - row[w]);
      }
      nearest[h] =
          static_cast<std::uint32_t>(std::min_element(squares.begin(), squares.end()) - squares.begin());
    }
  });
  return nearest;
}

// One round of Lloyd's: words move to the mean of what is nearest to them; a word that nothing is nearest to
// stays.
void move_words(LocalWords& words, std::span<const float> places) {
  const std::size_t axes = words.axes;
  const std::vector<std::uint32_t> nearest = nearest_words(words, places);
  std::vector<double> sums(words.centers.size(), 0);
  std::vector<std::size_t> counts(words.words, 0);
  for (std::size_t h = 0; h < nearest.size(); ++h) {
    ++counts[nearest[h]];
    for (std::size_t a = 0; a < axes; ++a)
      sums[nearest[h] * axes + a] += static_cast<double>(places[h * axes + a]);
  }
  for (std::size_t w = 0; w < words.words; ++w)
    for (std::size_t a = 0; a < axes && counts[w] > 0; ++a)
      words.centers[w * axes + a] = static_cast<float>(sums[w * axes + a] / static_cast<double>(counts[w]));
}

}  // namespace

LocalWords learn_local_words(std::span<const float> histograms, std::uint32_t width,
                             const LocalWordParameters& parameters, const CancelToken& cancel) {
  check_histograms(histograms, width);
  if (histograms.empty()) throw std::invalid_argument("there are no local histograms to learn words from");
  for (const float value : histograms)
    if (!std::isfinite(value)) throw std::invalid_argument("a local histogram that is not finite");
  LocalWords words;
  words.width = width;
  words.axes = parameters.axes;
  words.words = parameters.words;
  const std::vector<double> mean = mean_of(histograms, width);
  words.mean.assign(mean.begin(), mean.end());
  const std::vector<std::vector<double>> axes =
      principal_axes(products_of(histograms, width, mean, cancel), width, words.axes, cancel);
  for (std::size_t k = 0; k < width; ++k)
    for (const std::vector<double>& axis : axes) words.turn.push_back(static_cast<float>(axis[k]));
  const std::vector<float> places = turned(words, histograms);
  const std::size_t count = places.size() / words.axes;
  for (std::size_t w = 0; w < words.words; ++w) {
    const std::size_t drawn = (2 * w + 1) * count / (2 * words.words) * words.axes;
    words.centers.insert(words.centers.end(), places.begin() + static_cast<std::ptrdiff_t>(drawn),
                         places.begin() + static_cast<std::ptrdiff_t>(drawn + words.axes));
  }
  for (int round = 0; round < rounds_of_words; ++round) {
    cancel.check();
    move_words(words, places);
  }
  return words;
}

std::vector<float> local_code(const LocalWords& words, std::span<const float> histograms) {
  check_histograms(histograms, words.width);
  const std::vector<float> places = turned(words, histograms);
  const std::vector<std::uint32_t> nearest = nearest_words(words, places);
  const std::size_t axes = words.axes;
  std::vector<double> sums(words.values(), 0);
  for (std::size_t h = 0; h < nearest.size(); ++h)
    for (std::size_t a = 0; a < axes; ++a)
      sums[nearest[h] * axes + a] += static_cast<double>(places[h * axes + a]) -
                                     static_cast<double>(words.centers[nearest[h] * axes + a]);
  double all = 0;
  for (std::size_t w = 0; w < words.words; ++w) {
    double squares = 0;
    for (std::size_t a = 0; a < axes; ++a) squares += sums[w * axes + a] * sums[w * axes + a];
    const double length = std::sqrt(squares);
    for (std::size_t a = 0; a < axes; ++a) {
      double& value = sums[w * axes + a];
      if (length > 0) value = std::copysign(std::sqrt(std::abs(value) / length), value);
      all += value * value;
    }
  }
  std::vector<float> code;
  for (const double value : sums) code.push_back(all > 0 ? static_cast<float>(value / std::sqrt(all)) : 0.0f);
  return code;
}

}  // namespace meander
