#include "kernels/retrieve/local_words.h"

#include <cmath>
#include <limits>
#include <stdexcept>

#include "kernels/core/random.h"
#include "support/catch.h"
#include "support/threads.h"

using namespace meander;

namespace {

// Histograms in a plane of five dimensions: two heaps around (0, +-4) in its axes, 1.6 wide and 0.2 high.
std::vector<float> two_heaps(std::size_t each) {
  const RandomKey key = make_random_key(3, {});
  std::vector<float> values;
  for (std::size_t i = 0; i < 2 * each; ++i) {
    const UnitPair u = random_pair(key, Stream::sequence, i);
    const double along = (i % 2 == 0 ? 4 : -4) + 0.2 * (u.second - 0.5), across = 1.6 * (u.first - 0.5);
    for (const double v : {1.0, 0.6 * along - 0.8 * across, 2.0, 0.8 * along + 0.6 * across, 0.0})
      values.push_back(static_cast<float>(v));
  }
  return values;
}

}  // namespace

TEST_CASE("local words: axes are principal, words the centers of heaps, codes what is left of them") {
  const std::vector<float> histograms = two_heaps(300);
  const LocalWords words = learn_local_words(histograms, 5, {.words = 2, .axes = 3});
  REQUIRE(words.turn.size() == 15);
  // The first axis is (0, 0.6, 0, 0.8, 0), the second across; the third has nothing left.
  const double first[] = {0, 0.6, 0, 0.8, 0}, second[] = {0, 0.8, 0, -0.6, 0};
  for (std::size_t k = 0; k < 5; ++k) {
    CHECK(static_cast<double>(words.turn[3 * k]) == Approx(first[k]).margin(0.01));
    CHECK(std::abs(static_cast<double>(words.turn[3 * k + 1])) == Approx(std::abs(second[k])).margin(0.01));
    CHECK(words.turn[3 * k + 2] == 0);
  }
  REQUIRE(words.centers.size() == 6);
  for (std::size_t w = 0; w < 2; ++w) {
    CHECK(std::abs(static_cast<double>(words.centers[3 * w])) == Approx(4).margin(0.05));
    CHECK(static_cast<double>(words.centers[3 * w + 1]) == Approx(0).margin(0.2));
  }
  CHECK(words.centers[0] * words.centers[3] < 0);
  // One histogram one step along the first axis from a word: its code is that direction alone.
  std::vector<float> one(5);
  for (std::size_t k = 0; k < 5; ++k) {
    one[k] = words.mean[k];
    for (std::size_t a = 0; a < 2; ++a)
      one[k] += words.turn[3 * k + a] * (words.centers[a] + (a == 0 ? 0.5f : 0.0f));
  }
  const std::vector<float> code = local_code(words, one);
  REQUIRE(code.size() == words.values());
  CHECK(static_cast<double>(code[0]) == Approx(1).margin(1e-3));
  for (std::size_t k = 1; k < code.size(); ++k) CHECK(static_cast<double>(code[k]) == Approx(0).margin(0.05));
}

TEST_CASE(
    "local words: the same bits for every number of threads, whatever the order of a model's histograms") {
  const RandomKey key = make_random_key(8, {});
  constexpr std::uint32_t width = 40;
  std::vector<float> histograms;
  for (std::size_t i = 0; i < 900 * width; ++i)
    histograms.push_back(static_cast<float>(random_pair(key, Stream::sequence, i).first));
  const auto learn = [&] { return learn_local_words(histograms, width, {.words = 5, .axes = 8}); };
  const LocalWords words = learn();
  for (const std::size_t threads : {1u, 2u, 4u}) CHECK(test::on_threads(threads, learn) == words);
  const std::vector<float> code = local_code(words, histograms);
  double squares = 0;
  for (const float value : code) squares += static_cast<double>(value) * static_cast<double>(value);
  CHECK(squares == Approx(1).epsilon(1e-5));
  std::vector<float> reversed;
  for (std::size_t i = 900; i-- > 0;)
    reversed.insert(reversed.end(), histograms.begin() + static_cast<std::ptrdiff_t>(i * width),
                    histograms.begin() + static_cast<std::ptrdiff_t>((i + 1) * width));
  const std::vector<float> other = local_code(words, reversed);
  for (std::size_t k = 0; k < code.size(); ++k)
    CHECK(static_cast<double>(other[k]) == Approx(static_cast<double>(code[k])).margin(1e-4));
}

TEST_CASE("local words: few histograms, equal ones, and invalid input") {
  const std::vector<float> equal(12, 0.5f);
  const LocalWords words = learn_local_words(equal, 4, {.words = 3, .axes = 2});
  CHECK(local_code(words, equal) == std::vector<float>(6, 0.0f));
  CHECK_THROWS_AS(learn_local_words({}, 4), std::invalid_argument);
  CHECK_THROWS_AS(learn_local_words(equal, 5), std::invalid_argument);
  CHECK_THROWS_AS(local_code(words, std::span(equal).first(5)), std::invalid_argument);
  std::vector<float> infinite = equal;
  infinite[3] = std::numeric_limits<float>::infinity();
  CHECK_THROWS_AS(learn_local_words(infinite, 4), std::invalid_argument);
}
