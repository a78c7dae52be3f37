#include "kernels/sample/attribute_text.h"

#include <algorithm>
#include <array>
#include <utility>

#include "kernels/core/setting.h"

namespace meander {

namespace {

// The words behind the name and the width.
constexpr std::array<std::pair<std::string_view, AttributeKind>, 2> kind_words = {
    {{"class", AttributeKind::classes}, {"linear", AttributeKind::linear}}};

// Takes what stands behind the last colon away; empty where there is none.
std::string take_last(std::string& text) {
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos) return {};
  std::string word = text.substr(colon + 1);
  text.erase(colon);
  return word;
}

std::string take_attribute(std::string_view text, AttributeColumn& column) {
  std::string rest(text);
  bool has_width = rest.find(':') != std::string::npos;
  std::string word = take_last(rest);
  for (const auto& [known, kind] : kind_words) {
    if (word != known || column.kind != AttributeKind::plain) continue;
    column.kind = kind;
    has_width = rest.find(':') != std::string::npos;
    word = take_last(rest);
  }
  column.name = rest;
  if (has_width && word.size() == 1 && word[0] >= '1' && word[0] <= '4')
    column.width = static_cast<std::uint32_t>(word[0] - '0');
  else if (has_width)
    return "`" + std::string(text) + "` has `" + word +
           "` behind its name, where a width of 1, 2, 3 or 4 may stand, and then `class` or `linear`";
  return "";
}

}  // namespace

std::string take_attributes(std::string_view text, std::vector<AttributeColumn>& columns) {
  columns.clear();
  std::string problems;
  for_each_word(text, [&](std::string_view one) {
    if (const std::string problem = take_attribute(one, columns.emplace_back()); !problem.empty())
      problems += (problems.empty() ? "" : "; ") + problem;
  });
  std::sort(columns.begin(), columns.end(),
            [](const AttributeColumn& a, const AttributeColumn& b) { return a.name < b.name; });
  for (std::size_t i = 1; i < columns.size(); ++i)
    if (columns[i].name == columns[i - 1].name && (i < 2 || columns[i].name != columns[i - 2].name))
      problems += (problems.empty() ? "" : "; ") + ("`" + columns[i].name + "` is named more than once");
  return problems;
}

std::string attributes_text(const std::vector<AttributeColumn>& columns) {
  std::string text;
  for (const AttributeColumn& column : columns) {
    text += (text.empty() ? "" : ",") + column.name;
    if (column.width > 1) text += ":" + std::to_string(column.width);
    for (const auto& [word, kind] : kind_words)
      if (column.kind == kind) text += ":" + std::string(word);
  }
  return text;
}

}  // namespace meander
