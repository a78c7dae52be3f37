#include "io/store/run_directory.h"

#include <fmt/format.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>

#include "io/file/directory.h"
#include "io/file/folder_lock.h"
#include "io/store/journal.h"
#include "io/store/journal_store.h"
#include "io/store/run_array.h"
#include "io/store/run_folder.h"
#include "io/store/store_file.h"
#include "kernels/core/parallel.h"

namespace meander {

namespace fs = std::filesystem;
using namespace store;

namespace {

constexpr std::uint8_t not_done = 0xFF;
constexpr const char* lock_name = "lock";  // in STORE.run

void check_header(const StoreHeader& header) {
  const auto refuse = [](const std::string& what) { throw ItemError(Status::internal, what); };
  if (header.samples == 0) refuse("a store needs one sample a row or more");
  if (header.labels.size() != header.ids.size())
    refuse(fmt::format("{} labels for {} items", header.labels.size(), header.ids.size()));
  if (!header.splits.empty() && header.splits.size() != header.ids.size())
    refuse(fmt::format("{} splits for {} items", header.splits.size(), header.ids.size()));
  for (std::size_t row = 1; row < header.ids.size(); ++row)
    if (header.ids[row - 1] >= header.ids[row])
      refuse(fmt::format("item \"{}\" precedes \"{}\"", header.ids[row - 1], header.ids[row]));
  for (const DescriptorSchema& descriptor : header.descriptors)
    if (descriptor.width == 0 || descriptor.name.empty() || descriptor.name.find('/') != std::string::npos)
      refuse(fmt::format("descriptor \"{}\" of width {}", descriptor.name, descriptor.width));
}

}  // namespace

struct RunDirectory::State {
  fs::path store, folder;
  RunPlan plan;
  const StoreHeader& header = plan.header;
  StoreLayout layout;
  FileDescriptor lock;
  Journals journals;
  std::vector<std::uint8_t> status;    // per row; not_done
  std::vector<RecordPlace> places;     // per row
  std::vector<std::uint64_t> missing;  // per journal: rows not done
  std::uint64_t done = 0;
  std::vector<std::uint64_t> suspects;
  std::unique_ptr<BegunLog> begun;

  State(const fs::path& store_path, const RunPlan& run_plan)
      : store(store_path),
        folder(with_suffix(store_path, ".run")),
        plan(run_plan),
        layout(make_layout(header)),
        lock(lock_folder(folder, lock_name, true)),
        journals(folder / "journal", (layout.rows + journal_rows - 1) / journal_rows),
        status(layout.rows, not_done),
        places(layout.rows) {
    for (std::uint64_t begin = 0; begin < layout.rows; begin += journal_rows)
      missing.push_back(std::min(journal_rows, layout.rows - begin));
  }

  void check_row(std::uint64_t row) const {
    if (row >= status.size())
      throw ItemError(Status::internal, fmt::format("row {} of a store of {} rows", row, status.size()));
  }

  void mark_done(std::uint64_t row, Status how) {
    status[row] = static_cast<std::uint8_t>(how);
    --missing[row / journal_rows];
    ++done;
  }

  void set_up() {
    if (plan_exists(folder)) {
      require_same_plan(folder, plan);
    } else {
      // Without run.json nothing was ever begun here: what a killed set-up left is replaced.
      std::error_code ignored;
      fs::remove_all(folder / "journal", ignored);
      fs::remove(folder / "begun.log", ignored);
      make_folder(folder / "journal");
      write_plan(folder, plan);
      sync_folder(folder.parent_path());
    }
    for (std::uint64_t journal = 0; journal < missing.size(); ++journal) replay(journal);
    read_begun();
  }

  void replay(std::uint64_t journal) {
    const std::uint64_t begin = journal * journal_rows;
    journals.replay(journal, begin, begin + missing[journal],
                    [&](const RecordHeader& record, std::uint64_t offset) {
                      if (status[record.row] != not_done) return;  // done twice: both records say the same
                      places[record.row] = {offset, record.payload_bytes};
                      mark_done(record.row, record.status);
                    });
  }

  void read_begun() {
    begun = std::make_unique<BegunLog>(folder / "begun.log");
    const std::vector<std::uint64_t> rows = begun->read(status.size());
    for (const std::uint64_t row : rows)
      if (status[row] == not_done) suspects.push_back(row);
    std::sort(suspects.begin(), suspects.end());
    suspects.erase(std::unique(suspects.begin(), suspects.end()), suspects.end());
    if (suspects.size() < rows.size()) begun->replace(suspects);
  }

  void append(const EncodedRow& encoded) {
    const auto record = read_record_header(encoded.bytes);
    if (!record || record->row != encoded.row ||
        record->payload_bytes != encoded.bytes.size() - record_header_bytes)
      throw ItemError(Status::internal, fmt::format("the encoded row {} is damaged", encoded.row));
    places[encoded.row] = {journals.append(encoded.row / journal_rows, encoded.bytes), record->payload_bytes};
    mark_done(encoded.row, record->status);
  }

  // Some parts are made at a time, as many as there are threads, and then written.
  void append_blocks(const EncodedRow& encoded) {
    RecordInParts record(header, encoded.row, *encoded.report, encoded.names);
    std::vector<RecordInParts::Part> made;
    std::size_t written = 0;  // of those
    std::uint32_t next = 0;
    const auto next_part = [&]() -> std::span<const std::byte> {
      if (written == made.size()) {
        const auto at_once = static_cast<std::uint32_t>(std::min<std::size_t>(
            static_cast<std::size_t>(oneapi::tbb::this_task_arena::max_concurrency()),
            oneapi::tbb::global_control::active_value(oneapi::tbb::global_control::max_allowed_parallelism)));
        made.clear();
        made.resize(std::min(at_once, record.parts() - next));
        written = 0;
        parallel_tasks(made.size(), [&](std::size_t i) {
          const std::uint32_t part = next + static_cast<std::uint32_t>(i);
          made[i] = record.encode(part, encoded.blocks(record.begin_of(part), record.end_of(part)));
        });
        next += static_cast<std::uint32_t>(made.size());
        if (made.empty()) return record.take_names();
      }
      record.add(made[written]);
      return made[written++].bytes;
    };
    const std::uint64_t offset = journals.append_in_parts(encoded.row / journal_rows, record.head_bytes(),
                                                          next_part, [&] { return record.head(); });
    places[encoded.row] = {offset, record.payload_bytes()};
    mark_done(encoded.row, encoded.report->status);
  }

  // All rows of it are there: a power cut takes none of them any more.
  void sync_full(std::uint64_t journal) {
    if (missing[journal] == 0 && done < layout.rows) journals.sync(journal);
  }
};

RunDirectory::RunDirectory(const fs::path& store, const RunPlan& plan) {
  check_header(plan.header);
  state_ = std::make_unique<State>(store, plan);
  remove_leftovers(store);
  state_->set_up();
}

RunDirectory::~RunDirectory() = default;

bool RunDirectory::done(std::uint64_t row) const {
  state_->check_row(row);
  return state_->status[row] != not_done;
}

std::uint64_t RunDirectory::done_count() const { return state_->done; }

Status RunDirectory::status(std::uint64_t row) const {
  if (!done(row)) throw ItemError(Status::internal, fmt::format("row {} is not done", row));
  return static_cast<Status>(state_->status[row]);
}

std::vector<std::uint64_t> RunDirectory::suspects() const { return state_->suspects; }

void RunDirectory::begin_item(std::uint64_t row) {
  state_->check_row(row);
  state_->begun->append(row);
}

void RunDirectory::end_item(EncodedRow encoded) {
  State& state = *state_;
  state.check_row(encoded.row);
  if (state.status[encoded.row] != not_done) return;
  if (encoded.blocks)
    state.append_blocks(encoded);
  else
    state.append(encoded);
  state.sync_full(encoded.row / journal_rows);
}

void RunDirectory::leave_lock_to_parent() { state_->lock = {}; }

void RunDirectory::forget_begun() {
  state_->begun->replace({});
  state_->suspects.clear();
}

void RunDirectory::sync() { state_->journals.sync(); }

void RunDirectory::finish(const std::function<void()>& finished) {
  State& state = *state_;
  if (state.done != state.layout.rows)
    throw ItemError(Status::internal, fmt::format("{} of {} rows are done", state.done, state.layout.rows));
  const fs::path part = part_of_store(state.store);
  write_store_of_journals(part, state.header, state.layout, state.journals, state.status, state.places);
  const std::vector<fs::path> replaced = packs_of_store(state.store);
  rename_file(part, state.store);
  remove_packs(replaced);
  if (finished) finished();
  remove_run_folder(state.store);
}

RecordedRows recorded_rows(const fs::path& store, std::uint64_t rows) {
  const Journals journals(with_suffix(store, ".run") / "journal", (rows + journal_rows - 1) / journal_rows);
  std::vector<bool> known(rows, false);
  RecordedRows recorded;
  for (std::uint64_t first = 0; first < rows; first += journal_rows)
    read_record_headers(journals.path(first / journal_rows), first, std::min(rows, first + journal_rows),
                        [&](const RecordHeader& record) {
                          if (known[record.row]) return;
                          known[record.row] = true;
                          ++recorded.done;
                          recorded.failed += record.status != Status::ok;
                        });
  return recorded;
}

namespace {

// Throws RunError(stopped) while a task of an array is at work. A description that cannot be read names none.
void require_no_task(const fs::path& store) {
  std::optional<RunArray> array;
  try {
    array = read_run_array(store);
  } catch (const RunError&) {
  }
  for (std::size_t s = 0; array && s < array->shards.size(); ++s)
    if (fs::exists(shard_folder(store, s) / lock_name)) lock_folder(shard_folder(store, s), lock_name, false);
}

}  // namespace

void discard_run(const fs::path& store) {
  require_no_task(store);
  const FileDescriptor lock = lock_folder(with_suffix(store, ".run"), lock_name, false);
  if (lock) {
    discard_packs_in_work(store);
    remove_run_folder(store);
  }
  remove_leftovers(store);
}

void tidy_store(const fs::path& store) {
  if (!fs::exists(with_suffix(store, ".run"))) remove_leftovers(store);
}

}  // namespace meander
