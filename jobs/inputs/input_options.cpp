#include "jobs/inputs/input_options.h"

#include <fmt/format.h>

#include "io/item_id.h"
#include "jobs/cli/command_line.h"
#include "jobs/cli/option_words.h"
#include "jobs/inputs/run_report.h"

namespace meander {

namespace {

constexpr Word<FolderLayout> layout_words[] = {{"auto", FolderLayout::automatic},
                                               {"flat", FolderLayout::flat},
                                               {"modelnet", FolderLayout::modelnet},
                                               {"shapenet", FolderLayout::shapenet}};

}  // namespace

void add_list_options(Command& command, InputOptions& options) {
  command.add_option("--root", options.root,
                     "Folder that the ids of lists are relative to (default: the one that made the store, "
                     "else the longest folder common to all paths)");
  command.add_flag("-0,--null", options.null_lists,
                   "Paths of lists end with a NUL byte, as find -print0 writes them");
}

void add_label_options(Command& command, InputOptions& options) {
  command
      .add_option(
          "--layout", [&options](const std::string& word) { options.layout = value_of(layout_words, word); },
          "Class and split by folders: modelnet (chair/train/x.off, train/chair/x.off), shapenet "
          "(synset/id/models/x.obj), flat (neither); auto: modelnet or shapenet if all items fit, else flat")
      .show_default("auto")
      .common()
      .one_of(all_words(layout_words));
  command
      .add_option(
          "--labels", options.labels,
          "File of classes and splits: a table id,class[,split], ShapeNet's all.csv or taxonomy.json, a list "
          "of ids (split by train=FILE or by its name), other JSON; may be given several times")
      .common()
      .one_at_a_time();
  command.add_flag("--label-from-folder", options.label_from_folder,
                   "Class = name of the parent folder, for items without a class");
}

std::string remembered_root(const std::filesystem::path& store) { return read_run_report(store).root; }

void print_unread(const InputNotes& notes) {
  for (const UnreadFolder& folder : notes.unread)
    fmt::print(stderr, "meander: cannot search `{}`: {}; {} not in the store\n",
               escape_id(folder.path.string()), folder.reason,
               folder.partly ? "its other members are" : "its contents are");
}

void print_notes(const InputNotes& notes) {
  if (!notes.unread.empty()) fmt::print("  {:<20}{:>10}\n", "unread folders", notes.unread.size());
  if (!notes.skipped.empty()) {
    fmt::print("  other files skipped:");
    for (const auto& [extension, count] : notes.skipped)
      fmt::print(" {} {}", extension.empty() ? "(no extension)" : extension, count);
    fmt::print("\n");
  }
  if (notes.hidden > 0) fmt::print("  hidden files and folders skipped: {}\n", notes.hidden);
  if (notes.written_points > 0)
    fmt::print("  point files of `meander export` skipped: {}\n", notes.written_points);
  if (notes.links_back > 0) fmt::print("  links to an enclosing folder skipped: {}\n", notes.links_back);
  if (notes.layout != FolderLayout::flat) {
    fmt::print("  classes and splits of the folders: layout {}\n", name_of(notes.layout));
    if (notes.items_outside_layout > 0)
      fmt::print("    {} of {} items do not stand as it says, and get no class from it, as `{}`{}\n",
                 notes.items_outside_layout, notes.items_in_layout + notes.items_outside_layout,
                 notes.item_outside_layout,
                 notes.items_in_layout == 0 ? ": --label-from-folder takes the folder of each file" : "");
  }
  for (const std::string& file : notes.unused_label_files)
    fmt::print("  classes and splits of `{0}` are not used (--labels {0} uses them)\n", escape_id(file));
  if (!notes.has_label_file) return;
  fmt::print("  labels: {} items without a line, {} lines without an item\n", notes.items_without_line,
             notes.lines_without_item);
  if (notes.items_without_line > 0) fmt::print("    no line: `{}`\n", notes.item_without_line);
  if (notes.lines_without_item > 0) fmt::print("    no item: {}\n", escape_id(notes.line_without_item));
  if (notes.ambiguous_lines > 0)
    fmt::print(
        "  labels: {} lines name several items and are ignored (give more of the path)\n    several: {}\n",
        notes.ambiguous_lines, escape_id(notes.ambiguous_line));
  if (!notes.class_names.empty())
    fmt::print("  names of classes: {} items from `{}`{}\n", notes.named_items, escape_id(notes.class_names),
               notes.named_items == 0
                   ? ": no item has the number of a synset as its class (--layout shapenet?)"
                   : "");
}

void write_notes(JsonWriter& json, const InputNotes& notes) {
  json.object("skipped", [&] {
    for (const auto& [extension, count] : notes.skipped) json.member(extension, count);
  });
  json.member("hidden", notes.hidden);
  json.member("written_points", notes.written_points);
  json.member("links_back", notes.links_back);
  json.list("unread_folders", notes.unread, [&](const UnreadFolder& folder) {
    json.member("path", escape_id(folder.path.string()));
    json.member("reason", folder.reason);
  });
  json.member("layout", name_of(notes.layout));
  if (!notes.unused_label_files.empty()) {
    json.key("unused_label_files");
    json.begin_array();
    for (const std::string& file : notes.unused_label_files) json.value(escape_id(file));
    json.end_array();
  }
  if (!notes.has_label_file) return;
  json.member("items_without_label_line", notes.items_without_line);
  json.member("label_lines_without_item", notes.lines_without_item);
  json.member("ambiguous_label_lines", notes.ambiguous_lines);
  if (notes.items_without_line > 0) json.member("item_without_label_line", notes.item_without_line);
  if (notes.lines_without_item > 0)
    json.member("label_line_without_item", escape_id(notes.line_without_item));
  if (notes.ambiguous_lines > 0) json.member("ambiguous_label_line", escape_id(notes.ambiguous_line));
  if (!notes.class_names.empty()) {
    json.member("class_names", escape_id(notes.class_names));
    json.member("items_with_class_names", notes.named_items);
  }
}

}  // namespace meander
