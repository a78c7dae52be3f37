// From the INPUT arguments of a run to its items: ids, files, labels, splits.
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
  bool null_lists = false;         // --null: the paths of lists end with a NUL byte instead of a line end
  std::string root;                // --root: what the ids of lists are relative to; empty: see Inputs::root
  std::string remembered_root;     // stands in where no root is given: that of the run that made the store
  bool label_from_folder = false;  // --label-from-folder
  FolderLayout layout = FolderLayout::automatic;  // --layout
  std::vector<std::string> labels;                // --labels: files, see label_file.h
};

// What happened on the way from the arguments to the items, for the summary.
struct InputNotes {
  std::map<std::string, std::uint64_t> skipped;  // files in folders with other extensions, by extension
  std::uint64_t hidden = 0;                      // hidden files and folders left out
  std::uint64_t links_back = 0;                  // links to a folder around them, not followed
  std::vector<UnreadFolder> unread;              // ascending; the run must not end with success
  FolderLayout layout = FolderLayout::flat;      // that gave classes and splits; never automatic
  // Of the files of labels: how many lines name no item, or several, and how many items no line names, with
  // the first of each.
  bool has_label_file = false;
  std::uint64_t lines_without_item = 0, ambiguous_lines = 0, items_without_line = 0;
  std::string line_without_item, ambiguous_line, item_without_line;
  std::string class_names;                      // the file of the names of synsets; empty: none
  std::uint64_t named_items = 0;                // that have a class from it
  std::vector<std::string> unused_label_files;  // all.csv and taxonomy.json of the input, of no use as it is
};

struct Inputs {
  std::vector<PlanItem> items;           // ascending by id (bytes), row = position; ids are unique
  std::vector<std::string> label_names;  // class names, ascending; PlanItem::label is a position in it
  InputNotes notes;
  std::uint64_t index_bytes = 0;  // of memory that the access points of .tar.gz archives take
  // The folder that the ids of lists are relative to, absolute; where the arguments name no list, the
  // remembered one, which lists of a later run need.
  std::filesystem::path root;
};

// An archive (.zip, .tar, .tar.gz, .tgz) stands for the folder that it would be unpacked to, of its name
// without the extension, wherever it is met: as an argument, in a folder, in a list. A mesh in a .gz file
// stands for the unpacked file. Paths of lists, and arguments, may name a member: ARCHIVE/MEMBER.
//
// Folders are searched as search_folder does it: links are followed, hidden files are left out, and only
// files with an extension of a known format make rows, the others are counted. A file named explicitly, or in
// a list (`@list.txt`, `-` for standard input), always makes a row. Lists have one path a line, blank lines
// and lines that begin with # are left out; with null_lists every byte but NUL is part of a path. `.cla`
// files (Princeton Shape Benchmark) give items with labels.
//
// Ids (escape_id of): the path relative to the folder, with several folders prefixed by the folder's own
// name; file names for explicit files; db/... for .cla; the path relative to the root for lists. The root is
// that of the options, else the remembered one, else the longest folder that all paths of all lists have in
// common.
//
// Class and split of an item: what the files of labels say, else the .cla, else the layout (of items from
// folders and lists), else with label_from_folder the name of the folder that the file stands in. A class
// that is the number of a synset has its name from a taxonomy.json among the files of labels; with an all.csv
// among them, from the one beside it, else from that in the input.
//
// Throws UsageError: an input that does not exist, a folder given that cannot be read, a .cla or a file of
// labels that is none, two lines of labels that say different things of one item, two equal ids (both paths
// are named), a path of a list outside the root, options for lists without a list.
Inputs collect_inputs(const std::vector<std::string>& arguments, const InputOptions& options = {});

}  // namespace meander
