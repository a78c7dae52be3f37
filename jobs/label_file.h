// Classes and splits of items from a CSV file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

#include "kernels/sample/samples.h"

namespace meander {

struct LabelLine {
  std::string label;          // empty: the file says nothing of the class
  Split split = Split::none;  // none: nothing of the split
  std::uint64_t line = 0;     // where it begins, from 1
};

// By id, as written in the file.
using LabelFile = std::map<std::string, LabelLine>;

// Reads `id, class[, split]`, one item a line, as RFC 4180 has it: fields in quotation marks may hold commas,
// line ends and doubled quotation marks. Blanks around fields without quotation marks do not count, nor do
// empty lines and a byte-order mark. A first line with a field `id` names the columns (id, class or label,
// split; others are left out) in any order. Splits: see split_of_word. Throws UsageError with the line: a
// file that cannot be read, too few or too many fields, a split that is none, broken quotation, two lines
// that say different things of one id.
LabelFile read_label_file(const std::filesystem::path& path);

}  // namespace meander
