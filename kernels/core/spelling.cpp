#include "kernels/core/spelling.h"

#include <algorithm>
#include <vector>

#include "kernels/core/joined_texts.h"

namespace meander {

namespace {

template <class Text>
std::string nearest_of(std::string_view word, std::span<const Text> candidates) {
  std::string best;
  std::size_t closest = std::max<std::size_t>(2, word.size() / 3) + 1;
  for (const std::string_view candidate : candidates) {
    std::size_t distance = edit_distance(word, candidate);
    if (word.size() >= 3 && candidate.starts_with(word)) distance = std::min<std::size_t>(distance, 1);
    if (distance < closest) {
      closest = distance;
      best = candidate;
    }
  }
  return best;
}

template <class Text>
std::string none_of_words(std::string_view text, std::span<const Text> words) {
  const std::string near = nearest_of(text, words);
  return "`" + std::string(text) + "` is none of " + joined_texts(words, "|") +
         (near.empty() ? "" : "; did you mean `" + near + "`?");
}

}  // namespace

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::vector<std::size_t>> table(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) table[i][0] = i;
  for (std::size_t j = 0; j <= b.size(); ++j) table[0][j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i)
    for (std::size_t j = 1; j <= b.size(); ++j) {
      table[i][j] =
          std::min({table[i - 1][j] + 1, table[i][j - 1] + 1, table[i - 1][j - 1] + (a[i - 1] != b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        table[i][j] = std::min(table[i][j], table[i - 2][j - 2] + 1);
    }
  return table[a.size()][b.size()];
}

std::string nearest(std::string_view word, std::span<const std::string> candidates) {
  return nearest_of(word, candidates);
}

std::string nearest(std::string_view word, std::span<const std::string_view> candidates) {
  return nearest_of(word, candidates);
}

std::string none_of(std::string_view text, std::span<const std::string> words) {
  return none_of_words(text, words);
}

std::string none_of(std::string_view text, std::span<const std::string_view> words) {
  return none_of_words(text, words);
}

}  // namespace meander
