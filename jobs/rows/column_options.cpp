#include "jobs/rows/column_options.h"

#include <fmt/format.h>

#include <algorithm>

#include "kernels/core/joined_texts.h"

namespace meander {

namespace {

constexpr std::string_view attributes_word = "attributes";

// Whether --store can leave the column out.
bool is_choice(const SampleColumn& column) { return column.option.empty() && column.name != "points"; }

void add_word(std::string_view word, std::vector<std::string>& words) {
  if (words.empty() || words.back() != word) words.emplace_back(word);  // both tensors have one
}

}  // namespace

void add_store_columns_option(Command command, RowKind rows, std::vector<std::string>& stored) {
  const bool surfaces = rows == RowKind::surfaces;
  std::vector<std::string> words, former;
  for (const SampleColumn& column : sample_columns)
    if (column.is_of_samples() &&
        (!surfaces || column.having == Having::all || column.having == Having::surfaces)) {
      add_word(column.word(), words);
      if (column.recorded_word() != column.word()) add_word(column.recorded_word(), former);
    }
  if (!surfaces) words.emplace_back(attributes_word);
  command
      .add_option("--store", stored,
                  std::string("Columns of the samples to store, separated by commas (default: all); points "
                              "always are") +
                      (surfaces ? "" : ", and what other options ask for"))
      .separator(',')
      .one_at_a_time()
      .one_of(words, former);
}

ColumnSet parse_left_out(const std::vector<std::string>& words, const StoreColumns& columns,
                         std::vector<std::string>& problems) {
  ColumnSet left_out;
  if (words.empty()) return left_out;
  const auto named = [&](std::string_view word) {
    return std::find(words.begin(), words.end(), word) != words.end();
  };
  const auto is_named = [&](const SampleColumn& column) {
    return named(column.word()) || named(column.recorded_word());
  };
  const auto complain = [&](std::string problem) {
    if (problems.empty() || problems.back() != problem) problems.push_back(std::move(problem));
  };
  for (std::size_t c = 0; c < sample_columns.size(); ++c) {
    const SampleColumn& column = sample_columns[c];
    if (columns.applies(c))
      left_out[c] = is_choice(column) && !is_named(column);
    else if (is_named(column))
      complain(!column.option.empty() ? fmt::format("--store: `{}` needs --{}", column.word(), column.option)
               : column.having == Having::tensors
                   ? fmt::format("--store: `{}` needs --method anisotropic", column.word())
                   : fmt::format("--store: only parametric surfaces have `{}`", column.word()));
  }
  if (named(attributes_word) && columns.attributes.empty())
    complain(fmt::format("--store: `{}` needs --attribute", attributes_word));
  return left_out;
}

std::string stored_words(const StoreColumns& columns) {
  std::vector<std::string> words = {"points"};
  for (std::size_t c = 0; c < sample_columns.size(); ++c)
    if (is_choice(sample_columns[c]) && columns.has(c)) add_word(sample_columns[c].recorded_word(), words);
  return joined_texts(words, ",");
}

}  // namespace meander
