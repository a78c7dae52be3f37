// The rows of a store that are compared with each other, their descriptors and their classes.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "io/json_writer.h"
#include "io/store/store.h"
#include "jobs/command_line.h"
#include "kernels/retrieve/descriptor_distance.h"
#include "kernels/retrieve/retrieval_scores.h"

namespace meander {

// What every comparison of models is told.
struct CompareOptions {
  std::string store, descriptor, distance = "l1", csv;
  bool json = false;
  StoreCheck check = StoreCheck::every_byte;

  DistanceKind kind() const;
};
void add_compare_options(Command& command, CompareOptions& options);

// Of a column of separate values: (value - mean) / deviation is compared; 0 where the deviation is 0.
struct ColumnScale {
  double mean = 0, deviation = 0;
};

struct RetrievalBase {
  std::vector<std::string> descriptors;           // names, as combined
  std::vector<DescriptorSchema> schemas;          // of these
  std::vector<std::vector<ColumnScale>> columns;  // of each; empty for a histogram
  DescriptorBase base;
  std::vector<std::uint64_t> rows;  // of the store, in the order of the base
  // Rows left out, each counted once: with no samples at all; with a descriptor that is not finite or that
  // could not be made (see is_described); without a class. not_in_store: models of the .cla that the store
  // does not have.
  std::uint64_t not_ok = 0, not_finite = 0, without_class = 0, not_in_store = 0;
  std::vector<std::string> classes;
  std::vector<std::uint32_t> labels;  // of the rows of the base
};

// The descriptors of names joined by `+`; empty: the first of the store. Throws UsageError with the nearest
// name.
std::vector<DescriptorSchema> chosen_descriptors(const StoreReader& store, const std::string& wanted);

// `descriptor`: names joined by `+`; empty: the first of the store. Throws UsageError (no descriptors at all,
// an unknown one with the nearest name, no row left, a distance of histograms for separate values) and
// RunError. The columns of separate values are brought to mean 0 and standard deviation 1 over the rows.
RetrievalBase load_base(const StoreReader& store, const std::string& descriptor, DistanceKind distance);

// The same for rows of known class only: those of the store's labels, in its order, or of a .cla file, in the
// order of that file (whose models are found by id, file name, or file name without its extension, each with
// or without `m` in front). Throws UsageError also when there are no labels.
RetrievalBase load_labelled_base(const StoreReader& store, const std::string& descriptor,
                                 DistanceKind distance, const std::string& classification);

// The rules of scoring a labelled base. Throws UsageError when no class can be scored.
RetrievalTask labelled_task(const RetrievalBase& base, bool psb_compat);
const char* rules_text(bool psb_compat);

// A row that the store does not have, as a query. values: of all descriptors, one after the other. Empty
// where one of them could not be made.
std::optional<DescriptorQuery> query_of(const RetrievalBase& base, std::span<const float> values);

std::string joined(const std::vector<std::string>& names);  // "a+b"
// "3 not ok, 1 without a class"; empty when every row is there.
std::string left_out_text(const RetrievalBase& base);
void write_left_out(JsonWriter& json, const RetrievalBase& base);  // member left_out

}  // namespace meander
