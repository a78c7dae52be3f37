// The rows of a store that are compared with each other, their descriptors and their classes.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "io/store/store.h"
#include "kernels/retrieve/descriptor_distance.h"

namespace meander {

struct RetrievalBase {
  std::vector<std::string> descriptors;  // names, as combined
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

}  // namespace meander
