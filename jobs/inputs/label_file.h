// Classes and splits of items from a file: a table, a list of ids, or a file that comes with a data set.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "kernels/data/samples.h"

namespace meander {

// The class and the split that a file gives one item.
struct LabelLine {
  std::vector<std::string> names;  // of the item; the first that ItemNames knows counts; not empty
  std::string synset;              // later names mean nothing below a folder of another synset
  std::string label;               // empty: no class
  Split split = Split::none;       // none: no split
  std::uint64_t line = 0;          // where it begins, from 1; in JSON the number of the value
};

struct LabelFile {
  std::string name;              // the path, for messages
  bool is_json = false;          // messages say "entry" instead of "line"
  bool is_shapenet = false;      // an all.csv, whose classes are numbers of synsets
  std::vector<LabelLine> lines;  // in the order of the file; no first name occurs twice
  // The names of classes that are numbers of synsets (taxonomy.json): see name_synsets.
  std::map<std::string, std::string> class_names;

  std::string place_of(const LabelLine& line) const;  // "`FILE` line 3"
};

// Reads `[SPLIT=]FILE`. The split applies to all lines without a split of their own. FILE may be packed by
// gzip, or be ARCHIVE/MEMBER, and has one of these forms:
//   * A table (RFC 4180): `id,class[,split]`, one item per line. Quoted fields may hold commas, line ends and
//     doubled quotation marks. Blanks around other fields, empty lines, a byte-order mark and lines of one
//     field that begin with # are ignored. A first line with the name of an id column (id, uid, object_id,
//     anno_id, model_id, modelId, file_id) names the columns in any order: class (or label, category), split
//     or both; others are ignored.
//   * all.csv of ShapeNet: a header with synsetId and modelId. The class is the synset; the item is
//     SYNSET/MODEL, else a MODEL that occurs once in the file, else model_ID (SHREC 2016).
//   * A list: one id per line; lines that begin with # are ignored. The split is that of SPLIT=, else the one
//     that the name of the file contains (modelnet40_train.txt).
//   * Names of classes: `NAME SYNSET`, one per line (synsetoffset2category.txt of ShapeNetPart).
//   * JSON (a name with .json): a list of ids; a list of objects with an id and a class or a split, as in a
//     table (model_info.json of 3D-FUTURE); an object of lists of ids by class or split, which may be nested
//     (LVIS of Objaverse, DeepSDF); an object of splits by id; taxonomy.json of ShapeNet. A line without a
//     split has the one in the name of the file.
//
// Splits: see split_of_word. Throws UsageError, with the line, for a file that cannot be read or has none of
// these forms, too few or too many fields, an invalid split, an open quotation mark, two lines that
// contradict each other, and a list without a split.
LabelFile read_label_file(const std::string& argument);
// The path in such an argument.
std::filesystem::path path_of_labels(const std::string& argument);

// The unpacked content of such a file. Throws UsageError.
std::string content_of_labels(const std::filesystem::path& path);
// A taxonomy.json of this text; `name` is for messages. Throws UsageError when it is not one.
LabelFile read_taxonomy(const std::string& text, const std::string& name);

// A classification file of the Princeton Shape Benchmark (.cla).
struct Classification {
  struct Model {
    std::string name;  // as written: a number in the benchmark itself, any word in later ones
    std::uint32_t label = 0;
  };
  // Names as written; a name of several classes is prefixed by that of its parent (`parent/name`).
  std::vector<std::string> classes;
  std::vector<Model> models;  // in the order of the file
};

// Reads `PSB 1`, then `classes models`, then for each class `name parent count` and `count` names of models,
// separated by any white space. Throws UsageError, which names the place of the mistake.
Classification read_classification(const std::filesystem::path& file);

}  // namespace meander
