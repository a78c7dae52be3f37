#include "jobs/rows/column_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace meander {

namespace {

constexpr std::array<SampleColumn, sample_column_names.size()> all_sample_columns = {
    SampleColumn::normals, SampleColumn::face,       SampleColumn::corners, SampleColumn::barycentric,
    SampleColumn::uv,      SampleColumn::curve_rank, SampleColumn::density, SampleColumn::tensor};

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
