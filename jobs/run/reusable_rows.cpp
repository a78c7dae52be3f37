#include "jobs/run/reusable_rows.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "io/run_error.h"
#include "jobs/cli/usage_error.h"
#include "jobs/inputs/store_items.h"

namespace meander {

namespace {

bool depends_on_machine(Status status) {
  return status == Status::timeout || status == Status::out_of_memory || status == Status::too_large ||
         status == Status::crashed || status == Status::internal || status == Status::unsupported_format ||
         status == Status::unreadable;
}

std::string key_of(const std::array<std::uint8_t, 32>& content, MeshFormat format) {
  std::string key(content.begin(), content.end());
  key.push_back(static_cast<char>(format));
  return key;
}

}  // namespace

ReusableRows::ReusableRows(const std::string& path, StoreCheck check, const StoreHeader& header)
    : store_(path, check) {
  if (const std::string otherwise = parameter_mismatch(store_, header); !otherwise.empty())
    throw UsageError("--reuse: `" + path + "` was made with other parameters: " + otherwise);
  const std::vector<std::string> ids = store_.header().ids;
  for (std::uint64_t row = 0; row < store_.rows(); ++row) {
    const ItemReport report = store_.report(row);
    MeshFormat format{};
    if (!depends_on_machine(report.status) && mesh_format_of(ids[row], format))
      rows_.emplace(key_of(report.content_sha256, format), row);
  }
}

std::optional<CopiedRow> ReusableRows::find(const std::array<std::uint8_t, 32>& content,
                                            MeshFormat format) const {
  const auto at = rows_.find(key_of(content, format));
  if (at == rows_.end()) return std::nullopt;
  try {
    CopiedRow found = store_.copy_row(at->second);
    // The row is read once, some blocks at a time: a failure while it is written would come too late.
    constexpr std::uint64_t step = 1 << 18;
    for (std::uint64_t begin = 0; found.blocks && begin < store_.samples(); begin += step)
      found.blocks(begin, std::min<std::uint64_t>(begin + step, store_.samples()));
    return found;
  } catch (const RunError&) {  // the older store cannot be read: the item is sampled, with the same bytes
    return std::nullopt;
  }
}

}  // namespace meander
