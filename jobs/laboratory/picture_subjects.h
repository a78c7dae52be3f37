// Models of pictures: mesh files, or rows of a store with their files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "io/store/store_reader.h"
#include "jobs/cli/output_guard.h"
#include "jobs/inputs/input_options.h"
#include "pipeline/sampling_graph.h"

namespace meander {

// On one sheet.
inline constexpr std::size_t max_pictures = 400;

struct SubjectArguments {
  // Meshes, or a store followed by the inputs of its run.
  const std::vector<std::string>& inputs;
  const std::vector<std::string>& items;  // of a store; none: all of its rows, up to max_pictures + 1
  const InputOptions& collect;
  StoreCheck check = StoreCheck::every_byte;
};

// The models of the arguments, which the guard protects. require: throws UsageError for a store, named by its
// path, that lacks what is drawn. Throws UsageError where there is no model, and for items without a store.
class PictureSubjects {
 public:
  PictureSubjects(const SubjectArguments& arguments, OutputGuard& guard,
                  const std::function<void(const StoreReader&, const std::string&)>& require);

  std::size_t count() const { return names_.size(); }
  const std::string& name(std::size_t i) const { return names_[i]; }
  bool stored() const { return store_ != nullptr; }
  bool folders_unread() const { return folders_unread_; }
  const std::optional<PlanItem>& file(std::size_t i) const { return files_[i]; }
  Row row(std::size_t i) const { return store_->read_row(rows_[i]); }
  std::uint32_t samples() const { return store_->samples(); }

 private:
  void collect_files(const SubjectArguments& arguments, OutputGuard& guard);
  void open_store(const SubjectArguments& arguments, OutputGuard& guard,
                  const std::function<void(const StoreReader&, const std::string&)>& require);

  std::unique_ptr<StoreReader> store_;
  std::vector<std::uint64_t> rows_;
  std::vector<std::string> names_;
  std::vector<std::optional<PlanItem>> files_;
  bool folders_unread_ = false;
};

}  // namespace meander
