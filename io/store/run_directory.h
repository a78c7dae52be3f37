// The crash-safe folder beside a store while a run is under way.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <vector>

#include "io/store/row_codec.h"
#include "io/store/run_plan.h"

namespace meander {

// STORE.run/: journals of finished rows, 4096 rows each, the log of begun ones, a lock. kill -9 at any moment
// loses only the rows in flight.
// begin_item may be called from one thread while end_item is called from another; otherwise not thread-safe.
class RunDirectory {
 public:
  // Opens STORE.run/ (creating it, or continuing what is there after replaying its journals). Throws
  // RunError: stopped when another process holds it or the disk is full; unusable when it was begun with
  // other parameters or other items (the message names the first difference), or is damaged beyond replay.
  RunDirectory(const std::filesystem::path& store, const RunPlan& plan);
  RunDirectory(const std::filesystem::path& store, const StoreHeader& header)
      : RunDirectory(store, RunPlan{header}) {}
  ~RunDirectory();
  RunDirectory(const RunDirectory&) = delete;
  RunDirectory& operator=(const RunDirectory&) = delete;

  bool done(std::uint64_t row) const;
  std::uint64_t done_count() const;
  Status status(std::uint64_t row) const;       // of a done row
  std::vector<std::uint64_t> suspects() const;  // begun by an earlier process but never ended, ascending
  void begin_item(std::uint64_t row);
  // Appends the row to its journal, and brings that to the disk when no row of it is missing, unless it is
  // the last of all rows: then the store is. What the blocks of a row throw is rethrown: nothing has changed
  // then, and the row may be ended with another status.
  void end_item(EncodedRow encoded);
  // In a forked child: closes its copy of the lock, which then ends with the parent, however that ends.
  void leave_lock_to_parent();
  // No row is in work: rows begun but not ended are not suspects for the next process.
  void forget_begun();
  void sync();  // fdatasync of the journals that have changed
  // Writes STORE from the journals, whose chunks of one row are copied: temporary name, fsync, rename, fsync
  // of the folder; calls `finished`, which writes what else belongs to the store; then removes STORE.run/. A
  // process that dies in between leaves a run whose next process does all of this again. Requires
  // done_count() == M.
  void finish(const std::function<void()>& finished = {});

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// How many of the first `rows` rows STORE.run/ has recorded, and how many of these failed, while a process
// may be at work on it. Reads one header a row; that of a row whose payload is damaged counts.
struct RecordedRows {
  std::uint64_t done = 0, failed = 0;
};
RecordedRows recorded_rows(const std::filesystem::path& store, std::uint64_t rows);

// Removes STORE.run/ and what killed processes left beside it (for --fresh); a finished STORE stays until
// another is renamed over it. Throws RunError(stopped) when another process holds the run, or a shard of it.
void discard_run(const std::filesystem::path& store);

// Removes what killed processes left beside a store: one half written, a run half removed. Does nothing while
// there is a STORE.run/, which is continued or discarded.
void tidy_store(const std::filesystem::path& store);

}  // namespace meander
