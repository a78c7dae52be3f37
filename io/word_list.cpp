#include "io/word_list.h"

#include "kernels/core/joined_texts.h"

namespace meander {

std::string word_list(std::span<const std::string_view> words, std::string_view conjunction) {
  if (conjunction.empty() || words.size() < 2) return joined_texts(words);
  return joined_texts(words.first(words.size() - 1)) + " " + std::string(conjunction) + " " +
         std::string(words.back());
}

std::string lower_ascii(std::string_view text) {
  std::string lower(text);
  for (char& c : lower)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return lower;
}

}  // namespace meander
