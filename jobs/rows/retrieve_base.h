// The rows of a store that are compared with each other, their descriptors and their classes.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "io/json_writer.h"
#include "io/store/store_reader.h"
#include "jobs/cli/command_line.h"
#include "jobs/rows/described_rows.h"
#include "kernels/retrieve/descriptor_distance.h"
#include "kernels/retrieve/nearest_rows.h"
#include "kernels/retrieve/retrieval_scores.h"
#include "kernels/retrieve/row_ranking.h"

namespace meander {

// What every comparison of models is told.
struct CompareOptions {
  std::string store, descriptor, distance = "l1", rank, vectors, ids, csv, memory = "4G";
  bool json = false;
  StoreCheck check = StoreCheck::every_byte;

  DistanceKind kind() const;
};
void add_compare_options(Command& command, CompareOptions& options);
// The same without --json and --csv.
void add_comparison_options(Command& command, CompareOptions& options);

// How a column of separate values is scaled: (value - mean) / deviation is compared; 0 where the deviation is
// 0.
struct ColumnScale {
  double mean = 0, deviation = 0;
};

struct RetrievalBase {
  std::vector<DescriptorTerm> terms;              // as combined
  std::vector<std::vector<ColumnScale>> columns;  // of each; empty for a histogram
  DescriptorBase base;                            // without rows where they are searched in parts
  RowRanking ranking;                             // of a base in memory
  std::vector<std::uint64_t> rows;                // of the store, in the order of the base
  // Rows left out, each counted once: with no samples at all; with a descriptor that is not finite or that
  // could not be made (see is_described); without a class. not_in_store: models of the .cla that the store
  // does not have.
  std::uint64_t not_ok = 0, not_finite = 0, without_class = 0, not_in_store = 0;
  std::vector<std::string> classes;
  std::vector<std::uint32_t> labels;  // of the rows of the base
};

// Why a distance does not compare a descriptor, as a sentence; empty when it does. emd: bins that lie in a
// line; chi2: histograms.
std::string misfit(const DescriptorSchema& schema, DistanceKind distance);

// What is compared. descriptors: see chosen_descriptors. The columns of separate values are brought to mean 0
// and standard deviation 1 over the rows. Throws UsageError (no descriptors at all, an unknown one with the
// nearest name, no row left, a distance that does not fit, more memory than `memory`) and RunError.
struct BaseRequest {
  std::string descriptor;
  DistanceKind distance = DistanceKind::l1;
  RankParameters rank = {};                       // of a base in memory
  std::uint64_t memory = std::uint64_t{4} << 30;  // bytes, of the whole process
  std::uint64_t held = 0;                         // bytes that are taken besides
  SideVectorsList side = {};                      // besides those of the store
  std::string graph_of = {};  // the store whose STORE.graph is taken where it fits; empty: none
  // Rows without one of these are left out, too; their values are not read into the base.
  std::string also_described = {};
};

inline constexpr std::uint64_t max_ranked_rows = 4096;
// The request of options. Without --descriptor, of what the store and STORE.words have: pairs (or else
// pairs-unsigned), views and local-pairs; where there is none of these, the first descriptor; with --vectors,
// these alone. Without --rank, diffusion for a choice of the first kind of at most max_ranked_rows, and plain
// for others. More rows are ranked without --rank where there is STORE.graph, which must fit then. Throws
// UsageError.
BaseRequest request_of(const StoreReader& store, const CompareOptions& options);

// A base whose rows stay in the store: see search_store. It knows the layout and the scales of its blocks.
RetrievalBase load_searched_base(const StoreReader& store, const BaseRequest& request);

// Reads the rows that have the descriptors, part by part, and searches each: `search` answers its queries
// (made by query_of) with rows of the store. Fills in the rows and the counts of the base. Memory: parts that
// fit into `memory` beside `held` bytes, at least 256 rows.
void search_store(const StoreReader& store, RetrievalBase& base, NearestSearch& search, std::uint64_t memory,
                  std::uint64_t held);

// A base in memory, of rows of known class only: those of the store's labels, in its order, or of a .cla
// file, in the order of that file (whose models are found by id, file name, or file name without its
// extension, each with or without `m` in front). Throws UsageError also when there are no labels.
RetrievalBase load_labeled_base(const StoreReader& store, const BaseRequest& request,
                                const std::string& classification);

// A base in memory of all rows that have the descriptors, of no class.
RetrievalBase load_ranked_base(const StoreReader& store, const BaseRequest& request);

// The rules of scoring a labeled base. Throws UsageError when no class can be scored.
RetrievalTask labeled_task(const RetrievalBase& base, bool psb_compat);
const char* rules_text(bool psb_compat);

// A row as a query. values: of all descriptors, one after the other. Empty where one of them could not be
// made.
std::optional<DescriptorQuery> query_of(const RetrievalBase& base, std::span<const float> values);
// The query for a row of the store.
std::optional<DescriptorQuery> query_of(const StoreReader& store, const RetrievalBase& base,
                                        std::uint64_t row);

// "3 not ok, 1 without a class"; empty when every row is there.
std::string left_out_text(const RetrievalBase& base);
void write_left_out(JsonWriter& json, const RetrievalBase& base);  // member left_out

}  // namespace meander
