// Suggestions for misspelled names.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace meander {

// Edit distance (insertions, deletions, replacements, exchanged neighbors). O(|a| |b|).
std::size_t edit_distance(std::string_view a, std::string_view b);

// The candidate nearest to `word`, or an empty string when none is close enough.
std::string nearest(std::string_view word, std::span<const std::string> candidates);
std::string nearest(std::string_view word, std::span<const std::string_view> candidates);

// Says what is wrong with a text that is none of the words: one sentence, with the nearest word.
std::string none_of(std::string_view text, std::span<const std::string> words);
std::string none_of(std::string_view text, std::span<const std::string_view> words);

}  // namespace meander
