#include "jobs/inputs.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <optional>
#include <set>
#include <sstream>

#include "jobs/classification.h"

namespace meander {

namespace {

namespace fs = std::filesystem;

struct Found {
  std::string id;
  fs::path path;
  std::string label;  // empty: none
};

// The own name of a folder, whatever slashes and dots it was written with.
std::string own_name(const fs::path& folder) {
  const fs::path whole = fs::absolute(folder).lexically_normal();
  return (whole.has_filename() ? whole : whole.parent_path()).filename().string();
}

class Collector {
 public:
  explicit Collector(Inputs& inputs) : inputs_(inputs) {}
  std::vector<Found> found;

  void add_folder(const fs::path& root, bool prefixed) {
    std::error_code error;
    fs::recursive_directory_iterator at(root, fs::directory_options::skip_permission_denied, error);
    if (error) throw UsageError("cannot search `" + root.string() + "`: " + error.message());
    for (; at != fs::recursive_directory_iterator(); at.increment(error)) {
      if (error) throw UsageError("cannot search `" + root.string() + "`: " + error.message());
      if (at->is_directory(error)) continue;
      MeshFormat format;
      if (!mesh_format_of(at->path(), format)) {
        ++inputs_.skipped[at->path().extension().string()];
        continue;
      }
      std::string id = at->path().lexically_relative(root).generic_string();
      if (prefixed) id = own_name(root) + "/" + id;
      found.push_back({id, at->path(), {}});
    }
  }

  void add_list(std::istream& lines) {
    std::string line;
    while (std::getline(lines, line)) {
      if (line.ends_with('\r')) line.pop_back();
      if (line.empty() || line.starts_with('#')) continue;
      std::string id = fs::path(line).lexically_normal().generic_string();
      while (id.starts_with('/') || id.starts_with("../")) id.erase(0, id.starts_with('/') ? 1 : 3);
      found.push_back({id, line, {}});
    }
  }

  void add_classification(const fs::path& file) {
    const Classification read = read_classification(file);
    for (const Classification::Model& model : read.models)
      found.push_back(model_of(file.parent_path(), model.name, read.classes[model.label]));
  }

 private:
  static Found model_of(const fs::path& folder, const std::string& number, const std::string& label) {
    const std::string short_name = "m" + number;
    std::uint64_t value = 0;
    for (const char c : number) {
      if (c < '0' || c > '9') throw UsageError("`" + number + "` is no model number of a .cla file");
      value = value * 10 + static_cast<std::uint64_t>(c - '0');
    }
    const std::string id = "db/" + std::to_string(value / 100) + "/" + short_name + "/" + short_name + ".off";
    const fs::path candidates[] = {folder / id, folder / ".." / id, folder / ".." / ".." / id,
                                   folder / (short_name + ".off")};
    for (const fs::path& path : candidates)
      if (fs::exists(path)) return {id, path, label};
    return {id, candidates[0], label};  // the row will say that it cannot be read
  }

  Inputs& inputs_;
};

void number_labels(std::vector<Found>& found, Inputs& inputs, bool label_from_folder) {
  std::set<std::string> names;
  for (Found& f : found) {
    if (f.label.empty() && label_from_folder)
      f.label = fs::absolute(f.path).lexically_normal().parent_path().filename().string();
    if (!f.label.empty()) names.insert(f.label);
  }
  inputs.label_names.assign(names.begin(), names.end());
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (found[i].label.empty()) continue;
    const auto at = std::lower_bound(inputs.label_names.begin(), inputs.label_names.end(), found[i].label);
    inputs.items[i].label = static_cast<std::int32_t>(at - inputs.label_names.begin());
  }
}

}  // namespace

Inputs collect_inputs(const std::vector<std::string>& arguments, bool label_from_folder) {
  Inputs inputs;
  Collector collector(inputs);
  const auto is_folder = [](const std::string& argument) {
    std::error_code error;
    return fs::is_directory(argument, error);
  };
  const bool prefixed = std::count_if(arguments.begin(), arguments.end(), is_folder) > 1;
  for (const std::string& argument : arguments) {
    if (argument == "-") {
      collector.add_list(std::cin);
    } else if (argument.starts_with('@')) {
      std::ifstream list(argument.substr(1));
      if (!list) throw UsageError("cannot read the list `" + argument.substr(1) + "`");
      collector.add_list(list);
    } else if (is_folder(argument)) {
      collector.add_folder(argument, prefixed);
    } else if (!fs::exists(argument)) {
      throw UsageError("there is no `" + argument + "`");
    } else if (fs::path(argument).extension() == ".cla") {
      collector.add_classification(argument);
    } else {
      collector.found.push_back({fs::path(argument).filename().string(), argument, {}});
    }
  }
  std::vector<Found>& found = collector.found;
  std::sort(found.begin(), found.end(), [](const Found& a, const Found& b) { return a.id < b.id; });
  for (std::size_t i = 1; i < found.size(); ++i)
    if (found[i].id == found[i - 1].id)
      throw UsageError("two items would have the id `" + found[i].id + "`: `" + found[i - 1].path.string() +
                       "` and `" + found[i].path.string() + "`");
  inputs.items.resize(found.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    PlanItem& item = inputs.items[i];
    item.row = i;
    item.id = found[i].id;
    item.path = found[i].path;
    item.known_format = mesh_format_of(item.path, item.format);
  }
  number_labels(found, inputs, label_from_folder);
  return inputs;
}

}  // namespace meander
