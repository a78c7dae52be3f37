// Lists of texts in messages and names.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace meander {

// Joins the texts with `between`.
std::string joined_texts(std::span<const std::string> texts, std::string_view between = ", ");
std::string joined_texts(std::span<const std::string_view> texts, std::string_view between = ", ");

}  // namespace meander
