#include "jobs/inputs/inputs.h"

#include <algorithm>
#include <iostream>
#include <istream>
#include <optional>
#include <set>
#include <sstream>

#include "io/archive/model_bytes.h"
#include "io/file/file_error.h"
#include "io/file/read_file.h"
#include "io/item_id.h"
#include "jobs/cli/usage_error.h"
#include "jobs/inputs/item_names.h"
#include "jobs/inputs/label_file.h"

namespace meander {

namespace {

namespace fs = std::filesystem;

struct Found {
  std::string id;
  FoundFile file;
  std::string label;  // escaped like an id; empty: none
  Split split = Split::none;
  bool placed = false;              // in a folder or a list, whose layout may give its class
  std::uint32_t folders_above = 1;  // see ModelPlace
};

// The number of folders between a root and a file at this path below it.
std::uint32_t depth_of(std::string_view path) {
  return static_cast<std::uint32_t>(std::count(path.begin(), path.end(), '/'));
}

// The absolute path without dots; links are kept as they are written.
fs::path whole_path(const fs::path& path) { return fs::absolute(path).lexically_normal(); }

fs::path whole_folder(const fs::path& folder) {
  const fs::path whole = whole_path(folder);
  return whole.has_filename() || whole == whole.root_path() ? whole : whole.parent_path();
}

// The own name of a folder, even if it is written with a slash at its end or with dots.
std::string own_name(const fs::path& folder) { return whole_folder(folder).filename().string(); }

// The longest folder that holds all of the paths, which are absolute.
fs::path common_folder(const std::vector<fs::path>& paths) {
  fs::path common;
  for (std::size_t i = 0; i < paths.size(); ++i) {
    const fs::path folder = paths[i].parent_path();
    if (i == 0) common = folder;
    if (folder == common) continue;
    fs::path shared;
    auto a = common.begin();
    for (auto b = folder.begin(); a != common.end() && b != folder.end() && *a == *b; ++a, ++b) shared /= *a;
    common = shared;
  }
  return common;
}

// A folder or an archive among the arguments, or one that holds a file of labels.
struct InputRoot {
  fs::path path;
  std::shared_ptr<const Archive> archive;
  fs::path folder = {};  // in the archive

  // Whether it holds a file of this name, whose path is then path / name.
  bool has(const char* name) const {
    std::error_code error;
    return archive ? member(name).has_value() : fs::is_regular_file(path / name, error);
  }
  std::optional<std::size_t> member(const char* name) const {
    return archive->find((folder / name).generic_string());
  }
  std::string content(const char* name) const {
    if (!archive) return content_of_labels(path / name);
    try {
      return archive->unpack(*member(name));
    } catch (const ItemError& error) {
      throw UsageError("--labels: cannot read `" + (path / name).string() + "`: " + error.what());
    }
  }
};

class Collector {
 public:
  explicit Collector(const InputOptions& options) : options_(options) {}
  std::vector<Found> found;
  std::vector<InputRoot> roots;
  FolderSearch search;
  bool has_lists = false;

  void add_folder(const fs::path& root, bool prefixed) {
    std::error_code error;
    fs::directory_iterator(root, error);
    if (error) throw UsageError("cannot search `" + root.string() + "`: " + error.message());
    search.files.clear();
    roots.push_back({root, nullptr});
    search_folder(root, search);
    take_files(root, prefixed);
  }

  void add_archive(const fs::path& archive, bool prefixed) {
    search.files.clear();
    roots.push_back({archive, search_archive(archive, search)});
    if (!roots.back().archive)
      throw UsageError("cannot read the archive `" + archive.string() + "`: " + search.unread.back().reason);
    take_files(unpacked_path(archive), prefixed);
  }

  void add_file(const fs::path& path) {
    const FoundFile file = file_at(path);
    found.push_back({file.path.filename().string(), file, {}, Split::none, false});
  }

  void add_list(std::istream& list, const std::string& name) {
    has_lists = true;
    std::string path;
    for (bool is_first = true; std::getline(list, path, options_.null_lists ? '\0' : '\n');
         is_first = false) {
      constexpr std::string_view byte_order_mark = "\xef\xbb\xbf";
      if (is_first && path.starts_with(byte_order_mark)) path.erase(0, byte_order_mark.size());
      if (!options_.null_lists) {
        if (path.ends_with('\r')) path.pop_back();
        if (path.starts_with('#') || path.find_first_not_of(" \t") == std::string::npos) continue;
        if (path.find('\0') != std::string::npos)
          throw UsageError("the paths of " + name + " are separated by NUL bytes: give --null");
      }
      if (!path.empty()) listed_.push_back(path);
    }
    if (list.bad()) throw UsageError("cannot read " + name + " to its end");
  }

  void add_classification(const fs::path& file) {
    const Classification read = read_classification(file);
    for (const Classification::Model& model : read.models)
      found.push_back(model_of(file.parent_path(), model.name, escape_id(read.classes[model.label])));
  }

  // The paths of all lists, with ids relative to the root, which is returned.
  fs::path take_lists() {
    search.files.clear();
    for (const std::string& path : listed_) {
      if (is_archive(path))
        search_archive(path, search);
      else
        search.files.push_back(file_at(path));
    }
    std::vector<fs::path> paths;
    for (const FoundFile& file : search.files) paths.push_back(whole_path(file.path));
    const std::string& given = options_.root.empty() ? options_.remembered_root : options_.root;
    const fs::path root = given.empty() ? common_folder(paths) : whole_folder(given);
    for (std::size_t i = 0; i < paths.size(); ++i) {
      const fs::path id = paths[i].lexically_relative(root);
      if (id.empty() || id == "." || *id.begin() == "..")
        throw UsageError(
            "`" + search.files[i].shown().string() + "` is outside `" + root.string() +
            "`, the root of the ids of lists" + (options_.root.empty() ? " since the store was made" : "") +
            ": give --root with a folder above all paths (other ids: a new store), or leave the path out");
      const std::string text = id.generic_string();
      found.push_back({text, search.files[i], {}, Split::none, true, std::max(depth_of(text), 1u)});
    }
    return root;
  }

  // Whether the path is an existing archive of many files.
  static bool is_archive(const fs::path& path) {
    std::error_code error;
    const auto kind = archive_kind_of(path);
    return kind && kind != ArchiveKind::gzip && fs::is_regular_file(path, error);
  }

 private:
  void take_files(const fs::path& root, bool prefixed) {
    for (const FoundFile& file : search.files) {
      std::string id = file.path.lexically_relative(root).generic_string();
      const std::uint32_t depth = depth_of(id);
      if (prefixed) id = own_name(root) + "/" + id;
      found.push_back({id, file, {}, Split::none, true, depth});
    }
  }

  // The file of an argument or of a path in a list; it may be in an archive.
  FoundFile file_at(const fs::path& path) {
    if (archive_kind_of(path) == ArchiveKind::gzip)
      return {unpacked_path(path), {std::make_shared<const Archive>(path), 0}};
    const fs::path archive = archive_in_path(path);
    if (archive.empty()) return {path, {}};
    std::shared_ptr<const Archive> opened = opened_at(archive, [&] { return open_archive(archive, search); });
    fs::path folder = unpacked_path(archive), name = path.lexically_relative(archive);
    if (const auto inner = inner_archive_in_path(*opened, name)) {
      const fs::path inner_name = opened->members()[inner->member].name;
      opened =
          opened_at(archive / inner_name, [&] { return open_inner_archive(opened, inner->member, search); });
      folder /= unpacked_path(inner_name);
      name = inner->rest;
    }
    const auto member = opened->find(name.generic_string());
    if (!member)
      throw UsageError("the archive `" + opened->shown().string() + "` has no member `" + name.string() +
                       "`");
    const auto kind = archive_kind_of(name);
    if (kind && kind != ArchiveKind::gzip)
      throw UsageError("`" + path.string() + "` is an archive in an archive: give `" + archive.string() +
                       "`, which includes it, or a mesh in it");
    return {folder / opened->members()[*member].name, {opened, *member}};
  }

  template <class Open>
  std::shared_ptr<const Archive> opened_at(const fs::path& path, const Open& open) {
    std::shared_ptr<const Archive>& opened = opened_[path];
    try {
      if (!opened) opened = open();
    } catch (const ItemError& error) {
      throw UsageError("cannot read the archive `" + path.string() + "`: " + error.what());
    }
    return opened;
  }

  static Found model_of(const fs::path& folder, const std::string& number, const std::string& label) {
    const std::string short_name = "m" + number;
    std::uint64_t value = 0;
    for (const char c : number) {
      if (c < '0' || c > '9') throw UsageError("`" + number + "` is not a model number of a .cla file");
      value = value * 10 + static_cast<std::uint64_t>(c - '0');
    }
    const std::string id = "db/" + std::to_string(value / 100) + "/" + short_name + "/" + short_name + ".off";
    const fs::path candidates[] = {folder / id, folder / ".." / id, folder / ".." / ".." / id,
                                   folder / (short_name + ".off")};
    for (const fs::path& path : candidates)
      if (fs::exists(path)) return {id, {path, {}}, label};
    return {id, {candidates[0], {}}, label};  // its row will say that it cannot be read
  }

  const InputOptions& options_;
  std::vector<std::string> listed_;
  std::map<fs::path, std::shared_ptr<const Archive>> opened_;  // of paths that name members
};

void add_argument(const std::string& argument, bool prefixed, Collector& collector) {
  std::error_code error;
  if (argument == "-") {
    collector.add_list(std::cin, "standard input");
  } else if (argument.starts_with('@')) {
    const std::string name = "`" + argument.substr(1) + "`";
    try {
      std::istringstream list(content_of_file(argument.substr(1)));
      collector.add_list(list, name);
    } catch (const FileError& failure) {
      throw UsageError("cannot read the list " + name + ": " + failure.code().message());
    }
  } else if (fs::is_directory(argument, error)) {
    collector.add_folder(argument, prefixed);
  } else if (Collector::is_archive(argument)) {
    collector.add_archive(argument, prefixed);
  } else if (!fs::exists(argument, error) && archive_in_path(argument).empty()) {
    throw UsageError(error ? "cannot open `" + argument + "`: " + error.message()
                           : "there is no `" + argument + "`");
  } else if (fs::path(argument).extension() == ".cla") {
    collector.add_classification(argument);
  } else {
    collector.add_file(argument);
  }
}

// Escapes the ids as stores have them and sorts the items by them; refuses equal ids.
void order_by_id(std::vector<Found>& found) {
  for (Found& f : found) f.id = escape_id(f.id);
  std::sort(found.begin(), found.end(), [](const Found& a, const Found& b) { return a.id < b.id; });
  for (std::size_t i = 1; i < found.size(); ++i)
    if (found[i].id == found[i - 1].id)
      throw UsageError("two items would have the id `" + found[i].id + "`: `" +
                       found[i - 1].file.shown().string() + "` and `" + found[i].file.shown().string() + "`");
}

void place_in_layout(std::vector<Found>& found, FolderLayout wanted, InputNotes& notes) {
  notes.layout = wanted;
  if (wanted == FolderLayout::automatic) {
    std::vector<std::string> ids;
    for (const Found& f : found)
      if (f.placed) ids.push_back(f.id);
    notes.layout = recognize_layout(ids);
  }
  for (Found& f : found) {
    if (!f.placed) continue;
    ItemPlace place = place_of(f.id, notes.layout);
    if (!place.label.empty())
      ++notes.items_in_layout;
    else if (notes.items_outside_layout++ == 0)
      notes.item_outside_layout = f.id;
    f.label = std::move(place.label);
    f.split = place.split;
  }
}

// Gives items the classes and splits of the files of labels.
class Labels {
 public:
  Labels(std::vector<Found>& found, InputNotes& notes) : found_(found), notes_(notes), stated_(found.size()) {
    for (const Found& f : found) names_.add(f.id, f.file.path);
    names_.finish();
    notes_.has_label_file = true;
  }

  void take(const LabelFile& file) {
    // In a file that has ids every name is an id: an unknown one belongs to an item that is not here.
    const bool has_ids = std::any_of(file.lines.begin(), file.lines.end(), [this](const LabelLine& line) {
      const ItemNames::Items found = names_.find_id(line);
      return found.begin != found.end;
    });
    for (const LabelLine& line : file.lines) {
      const ItemNames::Items items = has_ids ? names_.find_id(line) : names_.find(line);
      if (items.is_ambiguous)
        count(notes_.ambiguous_lines, notes_.ambiguous_line, line, file);
      else if (items.begin == items.end)
        count(notes_.lines_without_item, notes_.line_without_item, line, file);
      else
        for (std::size_t item = items.begin; item < items.end; ++item) state(item, line, file);
    }
    for (const auto& [number, name] : file.class_names)
      if (!class_names_.emplace(number, name).second && class_names_[number] != name)
        throw UsageError("--labels: `" + file.name + "` has another name for the synset " + number +
                         " than an earlier file");
    if (!file.class_names.empty()) notes_.class_names = file.name;
  }

  bool has_class_names() const { return !class_names_.empty(); }

  void finish() {
    for (std::size_t item = 0; item < found_.size(); ++item) {
      const Stated& stated = stated_[item];
      if (!stated.line) {
        if (notes_.items_without_line++ == 0) notes_.item_without_line = found_[item].id;
        continue;
      }
      if (stated.label) found_[item].label = escape_id(stated.label->label);
      if (stated.split) found_[item].split = stated.split->split;
    }
  }

  // Called last, when all items have their classes.
  void name_classes() {
    for (Found& f : found_) {
      const auto name = class_names_.find(f.label);
      if (name == class_names_.end()) continue;
      f.label = escape_id(name->second);
      ++notes_.named_items;
    }
  }

 private:
  // The lines that give an item its class and its split, with their files.
  struct Stated {
    const LabelLine *line = nullptr, *label = nullptr, *split = nullptr;
    const LabelFile *label_file = nullptr, *split_file = nullptr;
  };

  static void count(std::uint64_t& counted, std::string& first, const LabelLine& line,
                    const LabelFile& file) {
    if (counted++ == 0) first = "`" + line.names.front() + "`, " + file.place_of(line);
  }

  void state(std::size_t item, const LabelLine& line, const LabelFile& file) {
    Stated& stated = stated_[item];
    stated.line = &line;
    const auto refuse = [&](const char* what, const LabelFile& other_file, const LabelLine& other) {
      throw UsageError("--labels: " + file.place_of(line) + " gives `" + found_[item].id + "` another " +
                       what + " than " + other_file.place_of(other));
    };
    if (!line.label.empty()) {
      if (stated.label && stated.label->label != line.label)
        refuse("class", *stated.label_file, *stated.label);
      if (!stated.label) stated.label = &line, stated.label_file = &file;
    }
    if (line.split != Split::none) {
      if (stated.split && stated.split->split != line.split)
        refuse("split", *stated.split_file, *stated.split);
      if (!stated.split) stated.split = &line, stated.split_file = &file;
    }
  }

  std::vector<Found>& found_;
  InputNotes& notes_;
  std::vector<Stated> stated_;
  ItemNames names_;
  std::map<std::string, std::string> class_names_;  // by the number of the synset
};

// The folder, or the archive, that holds a file of labels.
InputRoot place_of_labels(const fs::path& file) {
  InputRoot place{file.parent_path(), nullptr};
  if (archive_in_path(file).empty()) return place;
  try {
    const PackedFile packed = find_packed(file);
    if (packed) place.folder = fs::path(packed.facts().name).parent_path();
    place.archive = packed.archive;
  } catch (const ItemError& error) {
    throw UsageError("--labels: cannot read `" + file.string() + "`: " + error.what());
  }
  return place;
}

// The taxonomy.json beside one of the files, else the first in a folder or an archive of the input.
std::optional<LabelFile> find_taxonomy(const std::vector<LabelFile>& files,
                                       const std::vector<InputRoot>& roots) {
  std::vector<InputRoot> places;
  for (const LabelFile& file : files)
    if (file.is_shapenet) places.push_back(place_of_labels(file.name));
  if (places.empty()) return std::nullopt;
  places.insert(places.end(), roots.begin(), roots.end());
  constexpr const char* name = "taxonomy.json";
  for (const InputRoot& place : places)
    if (place.has(name)) return read_taxonomy(place.content(name), (place.path / name).string());
  return std::nullopt;
}

// Notes the files of labels that ShapeNet has in its root.
void note_unused_labels(const std::vector<InputRoot>& roots, InputNotes& notes) {
  if (notes.layout != FolderLayout::shapenet) return;
  for (const InputRoot& root : roots)
    for (const char* name : {"all.csv", "taxonomy.json"})
      if (root.has(name)) notes.unused_label_files.push_back((root.path / name).string());
}

void label_by_folder(std::vector<Found>& found) {
  for (Found& f : found)
    if (f.label.empty()) f.label = escape_id(whole_path(f.file.path).parent_path().filename().string());
}

void number_labels(const std::vector<Found>& found, Inputs& inputs) {
  std::set<std::string> names;
  for (const Found& f : found)
    if (!f.label.empty()) names.insert(f.label);
  inputs.label_names.assign(names.begin(), names.end());
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (found[i].label.empty()) continue;
    const auto at = std::lower_bound(inputs.label_names.begin(), inputs.label_names.end(), found[i].label);
    inputs.items[i].label = static_cast<std::int32_t>(at - inputs.label_names.begin());
  }
}

void take_notes(FolderSearch& search, InputNotes& notes) {
  std::sort(search.unread.begin(), search.unread.end(),
            [](const UnreadFolder& a, const UnreadFolder& b) { return a.path < b.path; });
  notes.skipped = std::move(search.skipped);
  notes.hidden = search.hidden;
  notes.written_points = search.written_points;
  notes.links_back = search.links_back;
  notes.unread = std::move(search.unread);
}

}  // namespace

Inputs collect_inputs(const std::vector<std::string>& arguments, const InputOptions& options) {
  Inputs inputs;
  Collector collector(options);
  const auto is_folder = [](const std::string& argument) {
    std::error_code error;
    return fs::is_directory(argument, error) || Collector::is_archive(argument);
  };
  const bool prefixed = std::count_if(arguments.begin(), arguments.end(), is_folder) > 1;
  for (const std::string& argument : arguments) add_argument(argument, prefixed, collector);
  inputs.root = collector.has_lists ? collector.take_lists() : fs::path(options.remembered_root);
  if (!collector.has_lists && (options.null_lists || !options.root.empty()))
    throw UsageError(std::string(options.null_lists ? "--null" : "--root") +
                     " applies to lists (@FILE, or - for standard input), and the input has none");
  std::vector<Found>& found = collector.found;
  order_by_id(found);
  inputs.index_bytes = collector.search.index_bytes();
  take_notes(collector.search, inputs.notes);
  place_in_layout(found, options.layout, inputs.notes);
  std::vector<LabelFile> label_files;
  for (const std::string& file : options.labels) label_files.push_back(read_label_file(file));
  std::optional<Labels> labels;
  if (!label_files.empty()) {
    labels.emplace(found, inputs.notes);
    for (const LabelFile& file : label_files) labels->take(file);
    labels->finish();
    if (!labels->has_class_names())
      if (const auto taxonomy = find_taxonomy(label_files, collector.roots)) labels->take(*taxonomy);
  }
  if (options.label_from_folder) label_by_folder(found);
  if (labels)
    labels->name_classes();
  else
    note_unused_labels(collector.roots, inputs.notes);
  inputs.items.resize(found.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    PlanItem& item = inputs.items[i];
    item.row = i;
    item.id = found[i].id;
    item.path = found[i].file.shown();
    item.packed = found[i].file.packed;
    item.split = found[i].split;
    item.folders_above = found[i].folders_above;
    item.known_format = mesh_format_of(found[i].file.path, item.format);
  }
  number_labels(found, inputs);
  return inputs;
}

}  // namespace meander
