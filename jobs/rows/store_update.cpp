#include "jobs/rows/store_update.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <set>

#include "io/archive/model_bytes.h"
#include "jobs/inputs/run_report.h"
#include "kernels/core/parallel.h"

namespace meander {

namespace {

using TimePoint = std::chrono::system_clock::time_point;

TimePoint modification_time(const struct stat& facts) {
  return TimePoint(std::chrono::duration_cast<TimePoint::duration>(
      std::chrono::seconds(facts.st_mtim.tv_sec) + std::chrono::nanoseconds(facts.st_mtim.tv_nsec)));
}

bool is_unknown(const std::array<std::uint8_t, 32>& digest) {
  return std::all_of(digest.begin(), digest.end(), [](std::uint8_t byte) { return byte == 0; });
}

bool can_be_read(const PlanItem& item) {
  if (!item.packed) return ::access(item.path.c_str(), R_OK) == 0;
  try {
    item.packed.archive->unpack(item.packed.member);
    return true;
  } catch (const ItemError&) {
    return false;
  }
}

// Whether the files of a model have the size that they had together, and none was changed since then. Throws
// ItemError when the model's own file cannot be read.
bool files_are_as_old(const PlanItem& item, const ItemReport& report, TimePoint since) {
  const MeshEstimate now = peek_model(item);
  if (now.file_bytes != report.file_bytes) return false;
  const std::vector<std::filesystem::path> files = companion_files(now, item);
  return std::none_of(files.begin(), files.end(), [&](const std::filesystem::path& file) {
    struct stat facts {};
    return ::stat(file.c_str(), &facts) == 0 && modification_time(facts) >= since;
  });
}

// Whether the file has other bytes than those that the row came from.
bool has_changed(const PlanItem& item, const ItemReport& report, TimePoint since) {
  struct stat facts {};
  const std::filesystem::path& path = file_of(item);
  const bool there = ::stat(path.c_str(), &facts) == 0 && S_ISREG(facts.st_mode);
  if (is_unknown(report.content_sha256))  // never opened; other statuses say nothing of the bytes
    return there && report.status == Status::unreadable && can_be_read(item);
  if (!there) return true;
  // The size of a mesh in a .gz file is not known before it is unpacked.
  const std::uint64_t size = !item.packed                                       ? facts.st_size
                             : item.packed.archive->kind() == ArchiveKind::gzip ? report.file_bytes
                                                                                : item.packed.facts().bytes;
  const bool may_name_files = row_of(item.format).companions != nullptr;
  if (!may_name_files && report.file_bytes != 0 && report.file_bytes != size) return true;
  try {
    // Materials are small: they are read rather than dated.
    if (!is_unknown(report.color_sha256) &&
        ModelBytes(item, ~std::uint64_t{0}, true).color_sha256() != report.color_sha256)
      return true;
    const bool is_as_old = modification_time(facts) < since;
    if (is_as_old && (!may_name_files || files_are_as_old(item, report, since))) return false;
    return ModelBytes(item).content_sha256() != report.content_sha256;
  } catch (const ItemError&) {
    return true;  // it can no longer be read
  }
}

std::string label_name(const std::vector<std::string>& names, std::int32_t label) {
  return label < 0 ? std::string() : names[static_cast<std::size_t>(label)];
}

bool has_status(const RetryOptions& retry, Status status) {
  return std::find(retry.statuses.begin(), retry.statuses.end(), status) != retry.statuses.end();
}

// A row of the new store before its header is written.
struct PlannedRow {
  std::string id, label;
  Split split = Split::none;
};

}  // namespace

StoreComparison compare_with_inputs(const StoreReader& store, const std::vector<PlanItem>& items,
                                    const StoreHeader& header, TimePoint since) {
  StoreComparison compared;
  std::vector<std::pair<std::uint64_t, std::uint64_t>> common;  // row and item
  std::uint64_t item = 0;
  for (std::uint64_t row = 0; row < store.rows(); ++row) {
    const std::string id = store.id(row);
    while (item < items.size() && items[item].id < id) compared.added.push_back(item++);
    if (item == items.size() || items[item].id != id) {
      compared.vanished.push_back(row);
      continue;
    }
    common.emplace_back(row, item);
    compared.relabeled |= label_name(store.label_names(), store.label(row)) !=
                              label_name(header.label_names, header.labels[item]) ||
                          store.split(row) != header.split(item);
    ++item;
  }
  while (item < items.size()) compared.added.push_back(item++);
  std::vector<ItemReport> reports;
  for (const auto& [row, unused] : common) reports.push_back(store.report(row));
  std::vector<std::uint8_t> changed(common.size(), 0);
  parallel_tasks(common.size(), [&](std::size_t i) {
    changed[i] = has_changed(items[common[i].second], reports[i], since);
  });
  for (std::size_t i = 0; i < common.size(); ++i)
    if (changed[i]) compared.changed.push_back(common[i].first);
  return compared;
}

RunPlan plan_update(const StoreReader& store, const StoreHeader& header, const StoreComparison& compared,
                    const RetryOptions& retry) {
  std::vector<PlannedRow> rows;
  for (std::uint64_t item = 0; item < header.ids.size(); ++item)
    rows.push_back(
        {header.ids[item], label_name(header.label_names, header.labels[item]), header.split(item)});
  if (!retry.vanished)
    for (const std::uint64_t row : compared.vanished)
      rows.push_back({store.id(row), label_name(store.label_names(), store.label(row)), store.split(row)});
  std::sort(rows.begin(), rows.end(), [](const PlannedRow& a, const PlannedRow& b) { return a.id < b.id; });
  std::set<std::string> names(header.label_names.begin(), header.label_names.end());
  for (const PlannedRow& row : rows)
    if (!row.label.empty()) names.insert(row.label);
  RunPlan plan{header, RunPurpose::update, {}, words_of(retry)};
  StoreHeader& updated = plan.header;
  updated.label_names.assign(names.begin(), names.end());
  updated.ids.clear();
  updated.labels.clear();
  updated.splits.clear();
  for (const PlannedRow& row : rows) {
    const auto name = std::lower_bound(updated.label_names.begin(), updated.label_names.end(), row.label);
    updated.ids.push_back(row.id);
    updated.labels.push_back(
        row.label.empty() ? -1 : static_cast<std::int32_t>(name - updated.label_names.begin()));
    updated.splits.push_back(row.split);
  }
  return plan;
}

PlannedStore planned_store(RunPlan plan, const std::vector<PlanItem>& items, const StoreReader* store,
                           const StoreComparison& compared, const RetryOptions& retry) {
  PlannedStore planned;
  planned.plan = std::move(plan);
  const StoreHeader& header = planned.plan.header;
  planned.items.resize(header.ids.size());
  planned.kept.resize(header.ids.size());
  const std::set<std::uint64_t> changed(compared.changed.begin(), compared.changed.end());
  // Both lists of ids ascend: the store is read from its front to its end, and not searched for each row.
  const std::uint64_t old_rows = store == nullptr ? 0 : store->rows();
  std::uint64_t next_old = 0;
  for (std::uint64_t row = 0; row < header.ids.size(); ++row) {
    const std::string& id = header.ids[row];
    PlanItem& item = planned.items[row];
    const auto at =
        std::lower_bound(items.begin(), items.end(), id,
                         [](const PlanItem& one, const std::string& name) { return one.id < name; });
    if (at != items.end() && at->id == id) item = *at;
    item.row = row;
    item.id = id;
    while (next_old < old_rows && store->id(next_old) < id) ++next_old;
    if (next_old == old_rows || store->id(next_old) != id) continue;
    const bool again =
        has_status(retry, store->report(next_old).status) || (retry.changed && changed.contains(next_old));
    if (!again || item.path.empty()) planned.kept[row] = next_old;
  }
  return planned;
}

std::optional<RetryOptions> retry_of(const RunPlan& plan) {
  if (plan.purpose != RunPurpose::update) return std::nullopt;
  RetryOptions retry;
  for_each_word(plan.retry, [&](std::string_view word) { add_retry_word(std::string(word), retry); });
  return retry;
}

bool copy_kept_rows(const StoreReader& store, const PlannedStore& planned, RunDirectory& directory,
                    const std::atomic<bool>& stop) {
  constexpr std::uint64_t batch_bytes = std::uint64_t{32} << 20, bytes_per_sample = 56;
  const std::uint64_t batch = std::clamp<std::uint64_t>(
      batch_bytes / (bytes_per_sample * std::max<std::uint32_t>(1, store.samples())), 1, 256);
  const StoreHeader& header = planned.plan.header;
  std::vector<std::uint64_t> rows;
  std::vector<EncodedRow> encoded;
  const auto flush = [&] {
    encoded.assign(rows.size(), {});
    parallel_tasks(rows.size(), [&](std::size_t i) {
      encoded[i] = encode_row(header, rows[i], store.copy_row(*planned.kept[rows[i]]));
    });
    for (EncodedRow& row : encoded) directory.end_item(std::move(row));
    rows.clear();
  };
  for (std::uint64_t row = 0; row < planned.kept.size(); ++row) {
    if (stop) return false;
    if (!planned.kept[row] || directory.done(row)) continue;
    rows.push_back(row);
    if (rows.size() == batch) flush();
  }
  flush();
  return true;
}

TimePoint run_begun(const std::string& store) {
  struct stat facts {};
  constexpr auto coarseness = std::chrono::seconds(2);  // of the times that file systems keep
  return ::stat((store + ".run/run.json").c_str(), &facts) == 0 ? modification_time(facts) - coarseness
                                                                : TimePoint::min();
}

TimePoint inputs_read_since(const std::string& store) {
  if (const auto since = read_run_report(store).inputs_read_since) return *since;
  struct stat facts {};
  return ::stat(store.c_str(), &facts) == 0 ? modification_time(facts) : TimePoint::min();
}

}  // namespace meander
