// What a finished run prints and what it leaves beside the store.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "io/store/store_reader.h"
#include "jobs/inputs/inputs.h"
#include "jobs/inputs/run_report.h"
#include "jobs/rows/run_options.h"
#include "pipeline/sampling_graph.h"

namespace meander {

// Counts over all rows of a store, those of earlier processes included.
struct StoreSummary {
  std::uint64_t rows = 0;
  std::array<std::uint64_t, status_names.size()> by_status{};
  std::array<std::uint64_t, method_names.size()> by_method{};              // of ok rows
  std::array<std::uint64_t, order_reason_names.size()> by_order_reason{};  // of ok rows
  // A kind of repair or note: its number, the models that have it, and the first of these.
  struct Tally {
    std::uint64_t count = 0, models = 0;
    std::string example;       // an id
    std::string example_text;  // of a note: what it says
    void add(std::uint64_t more, const std::string& id);
  };
  std::array<Tally, repair_count> by_repair;
  std::array<Tally, note_count> by_note;
  bool has_colors = false;
  std::array<std::uint64_t, color_source_names.size()>
      by_color_source{};              // of ok rows of a store with colors
  std::uint64_t rows_with_fills = 0;  // of those
  bool has_sharp = false, has_sides = false;
  std::uint64_t rows_without_sharp =
      0;  // ok rows of a store with points on sharp edges that have no such edge
  // Attributes and texture coordinates, as users name them, with the ok rows that lack them at one sample or
  // more.
  std::vector<std::pair<std::string, std::uint64_t>> lacking;
  std::vector<std::string> absent;  // names of attributes that none of the ok rows has, where there are some
  std::vector<std::pair<std::string, std::uint64_t>>
      undescribed;  // see count_undescribed; empty: not counted
  // Of ok rows of a store with points that have a side: how it was decided, and of how many points it is not
  // certain.
  std::array<std::uint64_t, sign_rule_names.size()> by_sign{};
  std::uint64_t uncertain = 0;
  std::uint32_t queries = 0;  // points of a row
  struct FailedRow {
    std::uint64_t row;
    std::string id;
    Status status;
    std::string reason;
  };
  std::vector<FailedRow> failures;
  std::uint64_t failed() const { return rows - by_status[0]; }
};

// Attributes of the models that have names near that of an attribute of the run, the nearest first.
using NearAttributes = std::function<std::vector<std::string>(const std::string& name)>;

// Reads the items of the store, and its descriptors where those that are lacking are to be counted.
StoreSummary summarize(const StoreReader& store, bool count_descriptors);

class JsonWriter;
// A line for each kind of repair and of note that there is, and the members "repairs" and "notes".
void print_tallies(const StoreSummary& summary);
void write_tallies(JsonWriter& json, const StoreSummary& summary);
// What the text of the notes of a model (text_of) says of one kind.
std::string_view clause_of(std::string_view note_text, Note note);
// What there is to say of further sets of points, as a line and as members.
void print_sets(const StoreSummary& summary);
void write_sets(JsonWriter& json, const StoreSummary& summary);
// A line for each column and descriptor that models lack, and each attribute that none has; the members
// "items_that_lack" where there are such columns, "attributes_of_no_model", each with the names that are near
// it, where there are such, and "items_without_descriptor" where there are descriptors. `near` may be empty.
void print_lacking(const StoreSummary& summary, const NearAttributes& near = {});
void write_lacking(JsonWriter& json, const StoreSummary& summary, const NearAttributes& near = {});

// Everything that a run reports at the end.
struct RunOutcome {
  StoreSummary summary;
  InputNotes inputs;
  std::filesystem::path root;                  // of the ids of lists; see Inputs
  std::uint64_t added = 0;                     // items that joined a store that was there before
  std::vector<std::string> changed, vanished;  // ids of rows whose input is not what was sampled, or gone
  // What this process did; sums over all of its parts.
  std::uint64_t done_now = 0, requeued = 0, peak_reserved_bytes = 0;
  double seconds = 0, longest_wait_seconds = 0;
  std::vector<NodeStatistics> nodes;  // of the last part
  std::int64_t inputs_read_since_unix_ns = 0;
  std::set<std::string> builds = {build_text()};  // that made the rows of the store
  NearAttributes near;                            // may be empty

  int exit_code() const;
};

// The final table (or JSON) on standard output; what the user should know of and can do about on standard
// error. Its first line of detail, and "notice" in JSON, is the attribute of --density or --tensor where no
// model has it.
void print_summary(const RunOutcome& outcome, const RunOptions& options);

// STORE.run.json: what the store itself must not hold (times, machine, threads). STORE.failed.txt: `# id:
// status: reason` and the path of every failed item, fit to be given back as @STORE.failed.txt; removed when
// nothing failed. path_of: of the input of a row; empty when there is none any more.
// Each file is written whole or not at all; throws RunError when it cannot be.
void write_run_report(const RunOptions& options, const RunOutcome& outcome);
void write_failed_list(const RunOptions& options, const StoreSummary& summary,
                       const std::function<std::filesystem::path(std::uint64_t row)>& path_of);

}  // namespace meander
