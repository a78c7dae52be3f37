// Descriptors of a store as one file: CSV, fbin, npy, or the HDF5 file of ANN-benchmarks.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "io/store/store_reader.h"
#include "jobs/cli/output_guard.h"

namespace meander {

class Command;

struct DescriptorExport {
  std::string store;        // its path, beside which STORE.words is
  std::string descriptors;  // names joined by `+`
  std::string format;       // of ExportContent::descriptors
  std::string output;
  Existing existing = Existing::keep;  // of the file and of its list
  std::vector<std::uint64_t> rows;     // those asked for; empty: all
  // ann-hdf5: how many rows are queries, by their number or their share, and how many neighbors each has.
  double test_share = 0.1;
  std::uint64_t queries = 0;  // 0: by the share
  std::uint32_t neighbors = 100;
  std::string distance = "l2";
  bool shapes_split = false;     // any of the four was given
  bool wants_neighbors = false;  // --neighbors was given
};

void add_descriptor_export_options(const Command& command, DescriptorExport& options);
// Throws UsageError when the options do not fit together.
void check_descriptor_export(const DescriptorExport& options, const std::string& format,
                             const std::string& output);

// Writes the file, whole or not at all, and for all but csv the list of its rows beside it
// (FILE.ids.csv), when the guard lets both through. Rows that are not ok or lack a descriptor are left out
// and counted. Memory: one block of rows; for ann-hdf5 the vectors once. Returns the exit code.
int export_descriptors(const StoreReader& store, const DescriptorExport& options, OutputGuard& guard);

}  // namespace meander
