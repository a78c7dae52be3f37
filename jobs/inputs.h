// From the INPUT arguments of a run to its items: ids, files, labels.
#pragma once

#include <cstdint>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "pipeline/sampling_graph.h"

namespace meander {

// A mistake in the arguments; the job ends with exit_usage.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct Inputs {
  std::vector<PlanItem> items;                   // ascending by id (bytes), row = position; ids are unique
  std::vector<std::string> label_names;          // class names; PlanItem::label is a position in it
  std::map<std::string, std::uint64_t> skipped;  // files found in folders with other extensions, by extension
};

// Folders are searched recursively (symbolic links to folders are not followed); only files with an extension
// of a known format make rows there, the others are counted. A file named explicitly, or in a list
// (`@list.txt`, `-` for standard input: one path a line, blank lines and lines that begin with # are left
// out) always makes a row. `.cla` files (Princeton Shape Benchmark) give items with labels. Ids: the path
// relative to the folder, file names for explicit files, the path as written for lists, db/... for .cla; with
// several folders prefixed by the folder's own name. label_from_folder: label = name of the parent folder,
// for items without a class. Throws UsageError: an input that does not exist, a .cla that cannot be read, two
// equal ids (both paths are named).
Inputs collect_inputs(const std::vector<std::string>& arguments, bool label_from_folder);

}  // namespace meander
