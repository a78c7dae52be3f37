// What samples can be colored by, for pictures and pages: their columns and attributes, by a word each.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "io/store/store_reader.h"

namespace meander {

enum class ColoringKind : std::uint8_t {
  plain,      // one color
  label,      // that of the class of the model
  rgb,        // the samples have colors
  direction,  // unit vectors
  plane,      // two coordinates, of a texture or of a surface
  number,     // through a map of colors
  classes     // whole numbers, each a color of its own
};

struct SampleColoring {
  std::string word = "plain";
  std::string title = {};  // for legends: what the column holds
  ColoringKind kind = ColoringKind::plain;
  std::optional<std::size_t> column = {};     // of sample_columns,
  std::optional<std::size_t> attribute = {};  // or of the attributes of the store
  friend bool operator==(const SampleColoring&, const SampleColoring&) = default;
};

// Everything that the samples of the store can be colored by, in the order of its columns: `plain`, `label`
// where there are classes, columns by the names of their arrays (`rank`, `normal` for short), attributes by
// their names, or as `attribute:NAME` where a column has the same.
std::vector<SampleColoring> colorings_of(const StoreReader& store);

// The coloring of this word, of what else it is called (`texture`, `colors`, `class` ...), or of the name of
// an attribute behind `attribute:`. Throws UsageError, with `option` in front, for what the store does not
// have: it says why, and names what there is.
SampleColoring coloring_named(const StoreReader& store, const std::string& word, const std::string& option);

// The words that any store may have, for help.
std::string coloring_words();

// The first `count` values of a coloring.
// number: NaN where there is none; the length of vectors; of the rank its place between 0 and 1.
std::vector<float> coloring_numbers(const SampleColoring& coloring, const Samples& samples,
                                    std::size_t count);
// classes: no_sample_class where there is none.
std::vector<std::int64_t> coloring_classes(const SampleColoring& coloring, const Samples& samples,
                                           std::size_t count);
// rgb: 3 bytes each; direction: bytes as of a color, 128 (1 + x) of each axis, |x| where signs mean nothing;
// plane: the fractions of both coordinates as red and green; gray where there are none.
std::vector<std::uint8_t> coloring_bytes(const SampleColoring& coloring, const Samples& samples,
                                         std::size_t count);

// The names of the classes of a row, by number; empty where it has none. Those of a coloring by other values
// have none either.
std::vector<std::string> class_names(const SampleColoring& coloring, const StoreColumns& columns,
                                     const std::string& row_names);

}  // namespace meander
