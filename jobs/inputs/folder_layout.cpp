#include "jobs/inputs/folder_layout.h"
#include "io/word_list.h"

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <vector>

namespace meander {

namespace {

constexpr std::array<std::string_view, 4> layout_names = {"auto", "flat", "modelnet", "shapenet"};

// The folders of an id and, last, the name of the file.
std::vector<std::string_view> parts_of(std::string_view id) {
  std::vector<std::string_view> parts;
  for (;;) {
    const std::size_t slash = id.find('/');
    parts.push_back(id.substr(0, slash));
    if (slash == std::string_view::npos) return parts;
    id.remove_prefix(slash + 1);
  }
}

ItemPlace modelnet_place(const std::vector<std::string_view>& parts) {
  for (std::size_t at = parts.size() - 1; at-- > 0;) {
    const Split split = split_of_word(parts[at]);
    if (split == Split::none) continue;
    const bool own_folder = at + 2 == parts.size();
    if (!own_folder) return {std::string(parts[at + 1]), split};
    return {at > 0 ? std::string(parts[at - 1]) : std::string(), split};
  }
  return {};
}

ItemPlace shapenet_place(const std::vector<std::string_view>& parts) {
  const std::size_t folders = parts.size() - 1;
  const std::size_t above = folders > 0 && parts[folders - 1] == "models" ? 3 : 2;
  return {folders >= above ? std::string(parts[folders - above]) : std::string(), Split::none};
}

bool fits_shapenet(const std::vector<std::string_view>& parts) {
  const std::size_t folders = parts.size() - 1;
  if (folders >= 3 && parts[folders - 1] == "models") return is_synset(parts[folders - 3]);
  return folders >= 2 && is_synset(parts[folders - 2]) && parts[folders].starts_with("model.");
}

// The split of an item whose split is the folder `from_end` places before its file (1: the one it stands in).
Split split_at(const std::vector<std::string_view>& parts, std::size_t from_end) {
  return parts.size() >= 3 ? split_of_word(parts[parts.size() - 1 - from_end]) : Split::none;
}

// Whether the folders of SPLIT/FOLDER/FILE hold one model each (train/UID/model.obj): no folder is in two
// splits, and there are fewer names of files than folders. A class has several models, or its own names for
// them.
bool are_models(std::span<const std::string> ids) {
  std::map<std::string_view, Split> folders;
  std::set<std::string_view> files;
  for (const std::string& id : ids) {
    const std::vector<std::string_view> parts = parts_of(id);
    const Split split = split_at(parts, 2);
    const auto [at, is_new] = folders.emplace(parts[parts.size() - 2], split);
    if (at->second != split) return false;
    files.insert(parts.back());
  }
  return files.size() < folders.size();
}

bool fits_modelnet(std::span<const std::string> ids, std::size_t from_end) {
  bool train = false, test = false;
  for (const std::string& id : ids) {
    const Split split = split_at(parts_of(id), from_end);
    if (split == Split::none) return false;
    train = train || split == Split::train;
    test = test || split == Split::test;
  }
  return train && test && (from_end == 1 || !are_models(ids));
}

}  // namespace

std::string_view name_of(FolderLayout layout) { return layout_names[static_cast<std::size_t>(layout)]; }

Split split_of_word(std::string_view word) {
  const std::string lower = lower_ascii(word);
  if (lower == "train" || lower == "training") return Split::train;
  if (lower == "test" || lower == "testing") return Split::test;
  if (lower == "val" || lower == "valid" || lower == "validation") return Split::validation;
  return Split::none;
}

bool is_synset(std::string_view name) {
  return name.size() == 8 &&
         std::all_of(name.begin(), name.end(), [](char c) { return c >= '0' && c <= '9'; });
}

ItemPlace place_of(std::string_view id, FolderLayout layout) {
  if (layout == FolderLayout::modelnet) return modelnet_place(parts_of(id));
  if (layout == FolderLayout::shapenet) return shapenet_place(parts_of(id));
  return {};
}

FolderLayout recognize_layout(std::span<const std::string> ids) {
  if (ids.empty()) return FolderLayout::flat;
  if (fits_modelnet(ids, 1) || fits_modelnet(ids, 2)) return FolderLayout::modelnet;
  const bool shapenet =
      std::all_of(ids.begin(), ids.end(), [](const std::string& id) { return fits_shapenet(parts_of(id)); });
  return shapenet ? FolderLayout::shapenet : FolderLayout::flat;
}

}  // namespace meander
