// Models of a store as one HTML page to turn them in.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "io/store/store_reader.h"
#include "jobs/cli/output_guard.h"

namespace meander {

class Command;
class Option;

struct PageExport {
  std::string output;                  // the page; empty: none is wanted
  Existing existing = Existing::keep;  // of it
  std::vector<std::uint64_t> rows;     // those asked for, all ok; empty: all ok rows
  std::uint64_t models = 1000;         // on the page at most, and failures listed
  std::uint64_t points = 0;            // of a model at most; 0: page_points over the models
  bool shapes_page = false;            // one of the two was given
};

// Points on a page whose number is not asked for: 42 MB, 56 MB as text. Where each has colors or attributes,
// fewer take as much.
inline constexpr std::uint64_t page_points = std::uint64_t{1} << 22;

// Returns --html.
Option add_page_export_options(const Command& command, PageExport& options);

// Writes the page, whole or not at all, when the guard lets it through, and says what is on it and what was
// left out. `store_name`: what the page calls the store. Of more models than fit every k-th stays; of more
// samples the first, which are a set of their own, or in the order of the curve every k-th. The same store
// and options make the same bytes. Memory: a model, and the descriptors of the models on the page twice.
// Time: models^2 x values of the histograms for the nearest models. Returns the exit code.
int export_page(const StoreReader& store, const std::string& store_name, const PageExport& options,
                OutputGuard& guard);

}  // namespace meander
