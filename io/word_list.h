// Words in messages and names.
#pragma once

#include <fmt/format.h>

#include <span>
#include <string>
#include <string_view>

namespace meander {

// "a, b, c", or with a conjunction "a, b or c".
inline std::string word_list(std::span<const std::string_view> words, std::string_view conjunction = {}) {
  if (conjunction.empty() || words.size() < 2) return fmt::format("{}", fmt::join(words, ", "));
  return fmt::format("{} {} {}", fmt::join(words.first(words.size() - 1), ", "), conjunction, words.back());
}

// ASCII letters alone: other bytes stay.
inline std::string lower_ascii(std::string_view text) {
  std::string lower(text);
  for (char& c : lower)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return lower;
}

}  // namespace meander
