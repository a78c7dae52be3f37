#include "jobs/laboratory/picture_subjects.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "io/file_kind.h"
#include "jobs/cli/usage_error.h"
#include "jobs/inputs/inputs.h"
#include "jobs/inputs/store_items.h"
#include "jobs/rows/described_meshes.h"

namespace meander {

namespace {

bool is_store(const std::string& path) {
  std::error_code none;
  return path != "-" && std::filesystem::is_regular_file(path, none) && kind_of_file(path) == FileKind::store;
}

}  // namespace

PictureSubjects::PictureSubjects(const SubjectArguments& arguments, OutputGuard& guard,
                                 const std::function<void(const StoreReader&, const std::string&)>& require) {
  if (is_store(arguments.inputs.front()))
    open_store(arguments, guard, require);
  else
    collect_files(arguments, guard);
}

void PictureSubjects::collect_files(const SubjectArguments& arguments, OutputGuard& guard) {
  if (!arguments.items.empty())
    throw UsageError(fmt::format("--item: `{}` is not a store: leave --item out", arguments.inputs.front()));
  Inputs inputs = collect_inputs(arguments.inputs, arguments.collect);
  print_unread(inputs.notes);
  guard.protect(input_files(arguments.inputs, inputs.items));
  folders_unread_ = !inputs.notes.unread.empty();
  for (PlanItem& item : inputs.items) {
    names_.push_back(item.id);
    files_.push_back(std::move(item));
  }
  if (names_.empty()) throw UsageError("there is no model in the INPUT");
}

void PictureSubjects::open_store(const SubjectArguments& arguments, OutputGuard& guard,
                                 const std::function<void(const StoreReader&, const std::string&)>& require) {
  const std::string& path = arguments.inputs.front();
  guard.protect(path, "the store itself");
  store_ = std::make_unique<StoreReader>(path, arguments.check);
  require(*store_, path);
  for (const std::string& item : arguments.items) rows_.push_back(find_item(*store_, item));
  if (arguments.items.empty())
    for (std::uint64_t row = 0; row < std::min<std::uint64_t>(store_->rows(), max_pictures + 1); ++row)
      rows_.push_back(row);
  if (rows_.empty()) throw UsageError(fmt::format("`{}` has no rows", path));
  for (const std::uint64_t row : rows_) names_.push_back(store_->id(row));
  files_.resize(rows_.size());
  const std::vector<std::string> inputs(arguments.inputs.begin() + 1, arguments.inputs.end());
  if (inputs.empty()) return;
  std::vector<std::string> ids;
  for (std::uint64_t row = 0; row < store_->rows(); ++row) ids.push_back(store_->id(row));
  const DescribedMeshes meshes(path, ids, inputs, arguments.collect);
  guard.protect(meshes.files_read());
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    PlanItem item;
    item.row = rows_[i];
    if (meshes.add_file(item)) files_[i] = std::move(item);
  }
}

}  // namespace meander
