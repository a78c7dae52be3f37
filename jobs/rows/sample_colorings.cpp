#include "jobs/rows/sample_colorings.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "io/json/json_tree.h"
#include "jobs/cli/usage_error.h"
#include "kernels/core/joined_texts.h"
#include "kernels/core/spelling.h"
#include "kernels/core/status.h"

namespace meander {

namespace {

constexpr std::uint8_t no_value = 150;  // the gray of samples without a value

constexpr std::string_view attribute_word = "attribute:";

// What columns are called where the name of their array says too little: by that name, a shorter word, and
// the title of legends.
struct ColumnWords {
  std::string_view array, word, title;
};
constexpr auto column_words =
    std::to_array<ColumnWords>({{"normals", "normal", "unit normal"},
                                {"uv", "uv", "parameters"},
                                {"face_index", "face_index", "number of the polygon"},
                                {"curve_rank", "rank", "position along the curve"},
                                {"tensor_direction", "tensor_direction", "direction of the long spacing"},
                                {"tensor_spacing", "tensor_spacing", "length of both spacings"},
                                {"rgb", "rgb", "colors of the model"}});
ColumnWords column_words_of(const std::string& array) {
  for (const ColumnWords& words : column_words)
    if (words.array == array) return words;
  return {array, array, array};
}

// What else they may be called.
constexpr auto other_words =
    std::to_array<std::pair<std::string_view, std::string_view>>({{"curve_rank", "rank"},
                                                                  {"normals", "normal"},
                                                                  {"texture", "texcoord"},
                                                                  {"color", "rgb"},
                                                                  {"colors", "rgb"},
                                                                  {"class", "label"}});

// Columns that say where a sample is have no color.
std::optional<ColoringKind> kind_of(const SampleColumn& column) {
  if (!column.is_of_samples()) return std::nullopt;
  switch (column.values) {
    case Values::unit_vectors:
      return ColoringKind::direction;
    case Values::parameters:
    case Values::optional:
      return ColoringKind::plane;
    case Values::not_negative:
    case Values::positive:
    case Values::ranks:
      return ColoringKind::number;
    case Values::faces:
      return ColoringKind::classes;
    case Values::any:
      if (std::holds_alternative<std::vector<std::uint8_t> Samples::*>(column.array))
        return ColoringKind::rgb;
      return std::nullopt;
    case Values::at_box:
    case Values::weights:
    case Values::vertices:
    case Values::sharp_points:
    case Values::sharp_vectors:
    case Values::sharp_edges:
    case Values::truths:
    case Values::groups:
    case Values::windings:
      return std::nullopt;
  }
  return std::nullopt;
}

// Of the sample: one value, or the length of several.
template <class Value>
float number_at(const std::vector<Value>& values, std::size_t each, std::size_t i) {
  if (each == 1) return static_cast<float>(values[i]);
  double sum = 0;
  for (std::size_t k = each * i; k < each * (i + 1); ++k)
    sum += static_cast<double>(values[k]) * static_cast<double>(values[k]);
  return static_cast<float>(std::sqrt(sum));
}

std::uint8_t byte_share(double share) {
  return static_cast<std::uint8_t>(std::lround(255 * std::clamp(share, 0.0, 1.0)));
}

}  // namespace

std::vector<SampleColoring> colorings_of(const StoreReader& store) {
  const StoreColumns& columns = store.columns();
  std::vector<SampleColoring> all = {{}};
  if (!store.label_names().empty()) all.push_back({"label", "class", ColoringKind::label, {}, {}});
  for (std::size_t c = 0; c < sample_columns.size(); ++c)
    if (const auto kind = kind_of(sample_columns[c]); kind && columns.has(c)) {
      const std::string array = sample_columns[c].array_name();
      const std::string_view title = sample_columns[c].title;
      all.push_back({std::string(column_words_of(array).word),
                     std::string(title.empty() ? column_words_of(array).title : title),
                     *kind,
                     c,
                     {}});
    }
  const std::size_t named = all.size();
  for (std::size_t a = 0; a < columns.attributes.size(); ++a) {
    const AttributeColumn& column = columns.attributes[a];
    const bool is_taken = std::any_of(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(named),
                                      [&](const SampleColoring& c) { return c.word == column.name; });
    all.push_back({(is_taken ? std::string(attribute_word) : "") + column.name,
                   column.width > 1 && !column.is_classes() ? "length of " + column.name : column.name,
                   column.is_classes() ? ColoringKind::classes : ColoringKind::number,
                   {},
                   a});
  }
  return all;
}

SampleColoring coloring_named(const StoreReader& store, const std::string& word, const std::string& option) {
  const std::vector<SampleColoring> all = colorings_of(store);
  const auto find = [&](std::string_view wanted) -> const SampleColoring* {
    const auto at =
        std::find_if(all.begin(), all.end(), [&](const SampleColoring& c) { return c.word == wanted; });
    return at == all.end() ? nullptr : &*at;
  };
  if (const SampleColoring* const found = find(word)) return *found;
  std::string wanted = word;
  for (const auto& [other, of] : other_words)
    if (word == other) wanted = of;
  if (wanted.starts_with(attribute_word)) wanted.erase(0, attribute_word.size());
  if (const SampleColoring* const found = find(wanted)) return *found;
  std::vector<std::string> words;
  for (const SampleColoring& coloring : all) words.push_back(coloring.word);
  std::string why = "the store has neither a column nor an attribute of this name";
  for (std::size_t c = 0; c < sample_columns.size(); ++c) {
    const SampleColumn& column = sample_columns[c];
    if (column_words_of(column.array_name()).word != wanted) continue;
    if (store.columns().has(c))
      why = "it says where samples are, and has no colors";
    else if (store.columns().applies(c))
      why = "the store was made with a --store that leaves it out";
    else
      why = "the store has none: " + store.columns().why_without(c);
  }
  if (wanted == "label") why = "the models of the store have no classes";
  const std::string near = nearest(word, words);
  throw UsageError(fmt::format("{}: no color for `{}`: {}{}; there are {}", option, word, why,
                               near.empty() ? "" : fmt::format(" (did you mean `{}`?)", near),
                               joined_texts(words)));
}

std::string coloring_words() {
  std::string words = "plain, label (class)";
  for (const SampleColumn& column : sample_columns)
    if (kind_of(column)) words.append(", ").append(column_words_of(column.array_name()).word);
  return words;
}

std::vector<float> coloring_numbers(const SampleColoring& coloring, const Samples& samples,
                                    std::size_t count) {
  std::vector<float> numbers(count);
  const auto fill = [&](const auto& values, std::size_t each) {
    for (std::size_t i = 0; i < count; ++i) numbers[i] = number_at(values, each, i);
  };
  if (coloring.attribute) {
    const std::vector<float>& values = samples.attributes.at(*coloring.attribute);
    fill(values, values.size() / std::max<std::size_t>(1, samples.count()));
    return numbers;
  }
  const SampleColumn& column = sample_columns.at(coloring.column.value());
  with_array(column, samples, [&](const auto& values) { fill(values, column.values_each()); });
  if (column.values == Values::ranks)
    for (float& rank : numbers)
      rank = static_cast<float>(double{rank} / std::max(1.0, static_cast<double>(samples.count()) - 1));
  return numbers;
}

std::vector<std::int64_t> coloring_classes(const SampleColoring& coloring, const Samples& samples,
                                           std::size_t count) {
  std::vector<std::int64_t> classes(count);
  if (!coloring.attribute) {
    with_array(sample_columns.at(coloring.column.value()), samples, [&](const auto& values) {
      for (std::size_t i = 0; i < count; ++i) classes[i] = static_cast<std::int64_t>(values[i]);
    });
    return classes;
  }
  const std::vector<std::int32_t>& values = samples.classes.at(*coloring.attribute);
  const std::size_t each = values.size() / std::max<std::size_t>(1, samples.count());
  for (std::size_t i = 0; i < count; ++i) classes[i] = values[each * i];
  return classes;
}

std::vector<std::uint8_t> coloring_bytes(const SampleColoring& coloring, const Samples& samples,
                                         std::size_t count) {
  const SampleColumn& column = sample_columns.at(coloring.column.value());
  if (coloring.kind == ColoringKind::rgb)
    return {samples.rgb.begin(), samples.rgb.begin() + static_cast<std::ptrdiff_t>(3 * count)};
  const bool has_signs = column.array != SampleArray(&Samples::tensor_direction);
  std::vector<std::uint8_t> bytes(3 * count);
  with_array(column, samples, [&](const auto& values) {
    const std::size_t each = column.values_each();
    for (std::size_t i = 0; i < count; ++i) {
      std::uint8_t* const color = &bytes[3 * i];
      if (coloring.kind == ColoringKind::direction) {
        for (std::size_t k = 0; k < 3; ++k) {
          const auto x = static_cast<double>(values[each * i + k]);
          color[k] = byte_share(has_signs ? 0.5 + 0.5 * x : std::abs(x));
        }
        continue;
      }
      const std::array<double, 2> at = {static_cast<double>(values[each * i]),
                                        static_cast<double>(values[each * i + 1])};
      const bool is_known = std::isfinite(at[0] + at[1]);
      std::fill_n(color, 3, is_known ? std::uint8_t{60} : no_value);
      if (!is_known) continue;
      // The far edge of a picture is 1, not 0 of the next one.
      for (std::size_t k = 0; k < 2; ++k) color[k] = byte_share(at[k] == 1 ? 1 : at[k] - std::floor(at[k]));
    }
  });
  return bytes;
}

std::vector<std::string> class_names(const SampleColoring& coloring, const StoreColumns& columns,
                                     const std::string& row_names) {
  std::vector<std::string> names;
  if (row_names.empty() || !coloring.attribute) return names;
  try {
    const JsonTree tree(row_names);
    for (const JsonValue& name : tree.root().member(columns.attributes.at(*coloring.attribute).name).items())
      names.emplace_back(name.text().value_or(""));
  } catch (const ItemError&) {
    return {};  // `verify` says so
  }
  return names;
}

}  // namespace meander
