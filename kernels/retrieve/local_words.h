// Codes of models by words: what the local histograms of a base have in common, learnt without classes, and
// one row of values for each model.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/cancel.h"

namespace meander {

struct LocalWordParameters {
  std::uint32_t words = 32, axes = 32;  // a code has words x axes values
};

// Histograms less their mean are turned to their principal axes; words are centers of clusters there.
struct LocalWords {
  std::uint32_t width = 0, axes = 0, words = 0;
  std::vector<float> mean;     // width
  std::vector<float> turn;     // width x axes, row by row
  std::vector<float> centers;  // words x axes, row by row

  std::uint32_t values() const { return words * axes; }
  friend bool operator==(const LocalWords&, const LocalWords&) = default;
};

// The version of words and codes: raised whenever the same histograms give others.
inline constexpr std::uint32_t local_words_version = 2;

// Learns words from histograms, `width` numbers each, finite. Axes: orthogonal iteration on the covariance.
// Words: 15 rounds of Lloyd's from histograms at even distances in their order. Axes beyond the rank of the
// histograms are zero. The same bits for every thread count and processor; they depend on the order of the
// histograms. O(histograms x width^2). Throws std::invalid_argument when there are no histograms, lengths do
// not fit or a number is not finite; RunCanceled and ItemError(timeout) from `cancel`.
LocalWords learn_local_words(std::span<const float> histograms, std::uint32_t width,
                             const LocalWordParameters& parameters = {}, const CancelToken& cancel = {});

// The code of one model (vectors of locally aggregated descriptors, Jegou, Douze, Schmid and Perez 2010): for
// each word the sum of the histograms nearest to it less the word, of length 1; the signed square roots of
// all, again of length 1 (Arandjelovic and Zisserman 2013). All zeros where every histogram is a word.
// O(histograms x width x axes). Throws std::invalid_argument when lengths do not fit.
std::vector<float> local_code(const LocalWords& words, std::span<const float> histograms);

}  // namespace meander
