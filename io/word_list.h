// Lists of words in messages.
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

}  // namespace meander
