#include "jobs/column_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

namespace meander {

namespace {

constexpr std::array<SampleColumn, sample_column_names.size()> all_sample_columns = {
    SampleColumn::normals, SampleColumn::face,       SampleColumn::corners, SampleColumn::barycentric,
    SampleColumn::uv,      SampleColumn::curve_rank, SampleColumn::density, SampleColumn::tensor};

// The words behind the name and the width.
constexpr std::array<std::pair<std::string_view, AttributeKind>, 2> kind_words = {
    {{"class", AttributeKind::classes}, {"linear", AttributeKind::linear}}};

// Takes what stands behind the last colon away; empty where there is none.
std::string take_word(std::string& text) {
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos) return {};
  std::string word = text.substr(colon + 1);
  text.erase(colon);
  return word;
}

AttributeColumn parse_attribute(const std::string& text, std::vector<std::string>& problems) {
  AttributeColumn column;
  std::string rest = text;
  bool has_width = rest.find(':') != std::string::npos;
  std::string word = take_word(rest);
  for (const auto& [known, kind] : kind_words) {
    if (word != known || column.kind != AttributeKind::plain) continue;
    column.kind = kind;
    has_width = rest.find(':') != std::string::npos;
    word = take_word(rest);
  }
  column.name = rest;
  if (const std::string problem = attribute_name_problem(column.name); !problem.empty())
    problems.push_back(fmt::format("--attribute: `{}` {}", text, problem));
  if (!has_width) return column;
  if (word.size() == 1 && word[0] >= '1' && word[0] <= '4')
    column.width = static_cast<std::uint32_t>(word[0] - '0');
  else
    problems.push_back(fmt::format(
        "--attribute: `{}` has `{}` behind its name, where a width of 1, 2, 3 or 4 may stand, and then "
        "`class` or `linear`",
        text, word));
  return column;
}

// Columns that have options of their own.
struct OwnOption {
  std::string_view word, option;
  bool (*asked)(const StoreColumns&);
};
constexpr std::array<OwnOption, 3> own_options = {
    {{"rgb", "--colors", [](const StoreColumns& c) { return c.colors; }},
     {"texcoord", "--texcoord", [](const StoreColumns& c) { return c.texcoord; }},
     {"attributes", "--attribute", [](const StoreColumns& c) { return !c.attributes.empty(); }}}};

}  // namespace

void add_store_columns_option(Command command, RowKind rows, std::vector<std::string>& stored) {
  const bool surfaces = rows == RowKind::surfaces;
  std::vector<std::string> words = {"points"};
  for (const std::string_view name : sample_column_names) words.emplace_back(name);
  for (const OwnOption& own : own_options) words.emplace_back(own.word);
  if (surfaces) words = {"points", "normals", "uv", "curve_rank", "density"};
  command
      .add_option("--store", stored,
                  std::string("Columns of the samples to store, separated by commas (default: all); points "
                              "always are") +
                      (surfaces ? "" : ", and what --colors, --texcoord and --attribute ask for"))
      .separator(',')
      .one_at_a_time()
      .one_of(words);
}

std::vector<AttributeColumn> parse_attributes(const std::vector<std::string>& texts,
                                              std::vector<std::string>& problems) {
  std::vector<AttributeColumn> columns;
  for (const std::string& text : texts) columns.push_back(parse_attribute(text, problems));
  std::sort(columns.begin(), columns.end(),
            [](const AttributeColumn& a, const AttributeColumn& b) { return a.name < b.name; });
  for (std::size_t i = 1; i < columns.size(); ++i)
    if (columns[i].name == columns[i - 1].name && (i < 2 || columns[i].name != columns[i - 2].name))
      problems.push_back(fmt::format("--attribute: `{}` is named more than once", columns[i].name));
  return columns;
}

std::string text_of(const std::vector<AttributeColumn>& attributes) {
  std::string text;
  for (const AttributeColumn& column : attributes) {
    text += (text.empty() ? "" : ",") + column.name;
    if (column.width > 1) text += fmt::format(":{}", column.width);
    for (const auto& [word, kind] : kind_words)
      if (column.kind == kind) text += fmt::format(":{}", word);
  }
  return text;
}

std::uint32_t parse_left_out(const std::vector<std::string>& words, const StoreColumns& columns,
                             std::vector<std::string>& problems) {
  if (words.empty()) return 0;
  const auto named = [&](std::string_view word) {
    return std::find(words.begin(), words.end(), word) != words.end();
  };
  StoreColumns stored = columns;
  for (const SampleColumn column : all_sample_columns) {
    const std::string_view name = name_of(column);
    if (columns.applies(column) && !named(name)) stored.leave_out(column);
    if (columns.applies(column) || !named(name)) continue;
    if (column == SampleColumn::tensor)
      problems.emplace_back("--store: `tensor` needs --method anisotropic");
    else
      problems.push_back(fmt::format("--store: only parametric surfaces have `{}`", name));
  }
  for (const OwnOption& own : own_options)
    if (named(own.word) && !own.asked(columns))
      problems.push_back(fmt::format("--store: `{}` needs {}", own.word, own.option));
  return stored.left_out;
}

std::string stored_words(const StoreColumns& columns) {
  std::string words = "points";
  for (const SampleColumn column : all_sample_columns)
    if (columns.has(column)) words += "," + std::string(name_of(column));
  return words;
}

}  // namespace meander
