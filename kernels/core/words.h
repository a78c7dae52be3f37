// Words for the values of an enum: arrays of rows that are a Word, or begin with one.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace meander {

// A value of an enum and its word.
template <class Enum>
struct Word {
  const char* text;
  Enum value;
};

template <class Words>
std::vector<std::string> all_words(const Words& words) {
  std::vector<std::string> texts;
  for (const auto& word : words) texts.emplace_back(word.text);
  return texts;
}

// The word of a value; empty for one that has none.
template <class Words, class Enum>
const char* text_of(const Words& words, Enum value) {
  for (const auto& word : words)
    if (word.value == value) return word.text;
  return "";
}

// Sets the value of a word; false, nothing changed, for other texts.
template <class Words, class Enum>
bool take_word(const Words& words, std::string_view text, Enum& value) {
  for (const auto& word : words)
    if (text == word.text) {
      value = word.value;
      return true;
    }
  return false;
}

// The row of a value in a table that has them in the order of the enum.
template <class Rows, class Enum>
constexpr const auto& row_of(const Rows& rows, Enum value) {
  return rows[static_cast<std::size_t>(value)];
}
template <class Rows>
constexpr bool is_in_order(const Rows& rows) {
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (static_cast<std::size_t>(rows[i].value) != i) return false;
  return true;
}

}  // namespace meander
