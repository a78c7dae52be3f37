// The files of io/page, as they are in the source tree, that make every page of models.
#pragma once

#include <string_view>

namespace meander::page_parts {

extern const std::string_view markup;      // page.html, with marks for the others: see model_page.cpp
extern const std::string_view style;       // page.css
extern const std::string_view scripts[5];  // in their order

}  // namespace meander::page_parts
