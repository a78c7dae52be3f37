#include "jobs/laboratory/colored_samples.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

namespace meander {

namespace {

constexpr Rgb no_value{150, 150, 150};
const SrgbColor no_value_color = srgb(no_value);

bool is_along_curve(const SampleColoring& coloring) {
  return coloring.column == column_of(&Samples::curve_rank);
}

SrgbColor class_color(std::int64_t number) {
  return number < 0 ? no_value_color : srgb(palette_color(static_cast<std::size_t>(number)));
}

}  // namespace

std::vector<SrgbColor> colors_of(const Samples& samples, std::int32_t label, std::size_t count,
                                 const SampleColoring& coloring, const ColorScale& scale, SrgbColor plain) {
  std::vector<SrgbColor> colors(count);
  switch (coloring.kind) {
    case ColoringKind::plain:
      return {plain};
    case ColoringKind::label:
      return {class_color(label)};
    case ColoringKind::number: {
      const std::vector<float> numbers = coloring_numbers(coloring, samples, count);
      const double range = std::max(scale.high - scale.low, 1e-300);
      for (std::size_t i = 0; i < count; ++i)
        colors[i] =
            std::isnan(numbers[i]) ? no_value_color : srgb(map_color((numbers[i] - scale.low) / range));
      return colors;
    }
    case ColoringKind::classes: {
      const std::vector<std::int64_t> classes = coloring_classes(coloring, samples, count);
      std::transform(classes.begin(), classes.end(), colors.begin(), class_color);
      return colors;
    }
    case ColoringKind::rgb:
    case ColoringKind::direction:
    case ColoringKind::plane:
      break;
  }
  const std::vector<std::uint8_t> bytes = coloring_bytes(coloring, samples, count);
  for (std::size_t i = 0; i < count; ++i) colors[i] = {bytes[3 * i], bytes[3 * i + 1], bytes[3 * i + 2]};
  return colors;
}

ColorScale color_scale(const StoreReader& store, std::span<const std::uint64_t> rows, std::size_t count,
                       const SampleColoring& coloring) {
  ColorScale scale;
  const bool is_number = coloring.kind == ColoringKind::number, is_rank = is_along_curve(coloring);
  if ((!is_number && coloring.kind != ColoringKind::classes) || is_rank) return scale;
  scale.low = std::numeric_limits<double>::infinity();
  scale.high = -scale.low;
  std::set<std::int64_t> classes;
  bool is_first = true;
  for (const std::uint64_t number_of_row : rows) {
    const Row row = store.read_row(number_of_row);
    if (row.report.status != Status::ok) continue;
    const std::size_t all = row.samples.count(), drawn = count == 0 ? all : std::min(all, count);
    if (is_number) {
      for (const float number : coloring_numbers(coloring, row.samples, drawn)) {
        scale.lacking |= std::isnan(number);
        if (!std::isfinite(number)) continue;
        scale.low = std::min(scale.low, double{number});
        scale.high = std::max(scale.high, double{number});
      }
      continue;
    }
    for (const std::int64_t number : coloring_classes(coloring, row.samples, drawn)) {
      scale.lacking |= number < 0;
      if (number >= 0 && classes.size() <= ColorScale::most_keys) classes.insert(number);
    }
    std::vector<std::string> names = class_names(coloring, store.columns(), row.names);
    if (!is_first && names != scale.names) names.clear();
    scale.names = std::move(names);
    is_first = false;
  }
  scale.classes.assign(classes.begin(), classes.end());
  if (!(scale.low <= scale.high)) scale.low = scale.high = 0;
  return scale;
}

namespace {

// The classes that are drawn, by their names where they have the same in all models, else by their numbers.
SheetLegend class_legend(const ColorScale& scale, const SampleColoring& coloring) {
  if (scale.classes.size() > ColorScale::most_keys)
    return {fmt::format("{}: a color for each{}", coloring.title, scale.lacking ? ", gray: none" : ""), false,
            "", ""};
  constexpr std::size_t longest_name = 40;  // bytes
  SheetLegend legend{coloring.title, false, "", "", {}};
  for (const std::int64_t number : scale.classes) {
    const auto n = static_cast<std::size_t>(number);
    const bool is_named = n < scale.names.size() && scale.names[n].size() <= longest_name;
    legend.keys.push_back({palette_color(n), is_named ? scale.names[n] : std::to_string(number)});
  }
  if (scale.lacking) legend.keys.push_back({no_value, "none"});
  return legend;
}

SheetLegend number_legend(const ColorScale& scale, const SampleColoring& coloring) {
  const std::string title = coloring.title + (scale.lacking ? " (gray: no value)" : "");
  if (is_along_curve(coloring)) return {title, true, "first", "last"};
  if (scale.high - scale.low <= 0.0005 * std::abs(scale.low))
    return {fmt::format("{} {:.3g} everywhere", title, scale.low), false, "", ""};
  return {title, true, fmt::format("{:.3g}", scale.low), fmt::format("{:.3g}", scale.high)};
}

}  // namespace

std::optional<SheetLegend> legend_of(const ColorScale& scale, const SampleColoring& coloring) {
  switch (coloring.kind) {
    case ColoringKind::plain:
      return {};
    case ColoringKind::label:
      return SheetLegend{"color: the class, named below each model", false, "", ""};
    case ColoringKind::rgb:
      return SheetLegend{"color: " + coloring.title, false, "", ""};
    case ColoringKind::direction:
      return SheetLegend{"color: the " + coloring.title + ", red x, green y, blue z", false, "", ""};
    case ColoringKind::plane:
      return SheetLegend{"color: " + coloring.title + ", red u, green v, from 0 to 1 and again", false, "",
                         ""};
    case ColoringKind::number:
      return number_legend(scale, coloring);
    case ColoringKind::classes:
      return class_legend(scale, coloring);
  }
  return {};
}

}  // namespace meander
