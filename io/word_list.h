// Words in messages and names.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace meander {

// "a, b, c", or with a conjunction "a, b or c".
std::string word_list(std::span<const std::string_view> words, std::string_view conjunction = {});

// ASCII letters alone: other bytes stay.
std::string lower_ascii(std::string_view text);

}  // namespace meander
