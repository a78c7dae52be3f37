#include "jobs/rows/described_meshes.h"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>
#include <utility>

#include "io/archive/model_bytes.h"
#include "jobs/cli/output_guard.h"
#include "jobs/cli/usage_error.h"
#include "jobs/inputs/inputs.h"
#include "kernels/core/parallel.h"
#include "pipeline/memory_estimate.h"

namespace meander {

DescribedMeshes::DescribedMeshes(const std::string& store, const std::vector<std::string>& ids,
                                 const std::vector<std::string>& paths, InputOptions collect) {
  collect.remembered_root = remembered_root(store);
  Inputs inputs = collect_inputs(paths, collect);
  index_bytes_ = inputs.index_bytes;
  print_unread(inputs.notes);
  read_ = input_files(paths, inputs.items);
  for (PlanItem& item : inputs.items) {
    const auto at = std::lower_bound(ids.begin(), ids.end(), item.id);
    if (at == ids.end() || *at != item.id) continue;
    item.row = static_cast<std::uint64_t>(at - ids.begin());
    files_.emplace(item.row, std::move(item));
  }
  if (files_.empty())
    throw UsageError(
        fmt::format("no item of `{}` is in the input: its ids look like `{}` (give the same "
                    "INPUT as to the run)",
                    store, ids.empty() ? "" : ids.front()));
}

const PlanItem* DescribedMeshes::find(std::uint64_t row) const {
  const auto file = files_.find(row);
  return file == files_.end() ? nullptr : &file->second;
}

bool DescribedMeshes::add_file(PlanItem& item) const {
  const PlanItem* const input = find(item.row);
  if (input == nullptr) return false;
  static_cast<ModelPlace&>(item) = *input;
  item.known_format = input->known_format;
  return true;
}

std::uint64_t DescribedMeshes::bytes(std::uint64_t row) const {
  const PlanItem* const item = find(row);
  if (item != nullptr && item->packed) return item->packed.facts().bytes;
  std::error_code error;
  const std::uintmax_t size = item == nullptr ? 0 : std::filesystem::file_size(item->path, error);
  return error ? 0 : size;
}

void reserve_described(std::span<PlanItem> plan, const SampleParameters& parameters, int threads,
                       std::uint64_t most_bytes) {
  const MemoryEstimate bytes_of(parameters, threads);
  parallel_tasks(plan.size(), [&](std::size_t i) {
    MeshEstimate estimate;
    try {
      if (plan[i].known_format) estimate = peek_model(plan[i]);
    } catch (const ItemError&) {
    }
    plan[i].reserved_bytes = std::min(most_bytes, bytes_of(estimate));
  });
}

}  // namespace meander
