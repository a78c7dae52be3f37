// Turns the INPUT arguments of a run into its items: ids, files, labels, splits.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "jobs/inputs/folder_layout.h"
#include "jobs/inputs/folder_search.h"
#include "pipeline/sampling_graph.h"

namespace meander {

// How INPUT arguments are read.
struct InputOptions {
  bool null_lists = false;         // --null: paths in lists end with a NUL byte instead of a line end
  std::string root;                // --root: the folder that ids of lists are relative to; may be empty
  std::string remembered_root;     // used when no root is given: that of the run that made the store
  bool label_from_folder = false;  // --label-from-folder
  FolderLayout layout = FolderLayout::automatic;  // --layout
  std::vector<std::string> labels;                // --labels: files, see label_file.h
};

// The findings on the way from the arguments to the items, for the summary.
struct InputNotes {
  std::map<std::string, std::uint64_t> skipped;  // counts of files with other extensions, by extension
  std::uint64_t hidden = 0;                      // skipped hidden files and folders
  std::uint64_t written_points = 0;              // skipped files of points that `export` made
  std::uint64_t links_back = 0;                  // links to a folder around them, not followed
  std::vector<UnreadFolder> unread;              // ascending; with any, the run does not end with success
  FolderLayout layout = FolderLayout::flat;      // gave classes and splits; never automatic
  std::uint64_t items_in_layout = 0, items_outside_layout = 0;  // of those that it can place
  std::string item_outside_layout;                              // the first one
  // Counts of lines in files of labels that name no item or several, and of items that no line names, with
  // the first of each.
  bool has_label_file = false;
  std::uint64_t lines_without_item = 0, ambiguous_lines = 0, items_without_line = 0;
  std::string line_without_item, ambiguous_line, item_without_line;
  std::string class_names;                      // the file with the names of synsets; empty: none
  std::uint64_t named_items = 0;                // items whose class got its name from it
  std::vector<std::string> unused_label_files;  // all.csv and taxonomy.json of the input without --labels
};

struct Inputs {
  std::vector<PlanItem> items;           // ascending by id (bytes), row = position; ids are unique
  std::vector<std::string> label_names;  // class names, ascending; PlanItem::label is a position in it
  InputNotes notes;
  std::uint64_t index_bytes = 0;  // memory of the access points of .tar.gz archives
  // The absolute folder that the ids of lists are relative to; without a list among the arguments, the
  // remembered one, which lists of a later run need.
  std::filesystem::path root;
};

// Archives: an archive (.zip, .tar, .tar.gz, .tgz) stands for the folder beside it with its name without the
// extension, whether it is an argument, in a folder or in a list. A mesh in a .gz file stands for the
// unpacked file. Arguments and paths in lists may name a member: ARCHIVE/MEMBER.
//
// Rows: folders are searched by search_folder, and files in them make rows if they have an extension of a
// known format and are no points that `export` wrote; others are counted. A file that is an argument or in a
// list (`@list.txt`, `-` for standard input) always makes a row. Lists have one path per line; blank lines
// and lines that begin with # are skipped. With null_lists every byte but NUL is part of a path. `.cla` files
// (Princeton Shape Benchmark) give labeled items.
//
// Ids (escape_id of): the path relative to the folder, prefixed by the folder's own name if there are
// several; the file name for files that are arguments; db/... for .cla; the path relative to the root for
// lists. The root is that of the options, else the remembered one, else the longest folder that all paths of
// all lists have in common.
//
// The class and the split of an item come from the files of labels, else from the .cla, else from the layout
// (for items in folders and lists), else, with label_from_folder, from the name of the parent folder. The
// name for a class that is the number of a synset comes from a taxonomy.json among the files of labels; if
// those have an all.csv, from the taxonomy.json beside it, else from the one in the input.
//
// Throws UsageError for an input that does not exist, an argument that is an unreadable folder, an invalid
// .cla or file of labels, two lines of labels that contradict each other, two equal ids (both paths are
// named), a path of a list outside the root, and options for lists without a list.
Inputs collect_inputs(const std::vector<std::string>& arguments, const InputOptions& options = {});

}  // namespace meander
