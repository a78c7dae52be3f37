// Classes and splits of items from a file: tables, lists of ids, and the files that data sets come with.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "kernels/data/samples.h"

namespace meander {

// What a file says of one item.
struct LabelLine {
  std::vector<std::string> names;  // of the item, see ItemNames: the first that names one counts; not empty
  std::string synset;              // names behind the first name nothing below a folder of another synset
  std::string label;               // empty: the file says nothing of the class
  Split split = Split::none;       // none: nothing of the split
  std::uint64_t line = 0;          // where it begins, from 1; in JSON which value it is
};

struct LabelFile {
  std::string name;              // the path, for messages
  bool is_json = false;          // "entry" for "line" in messages
  bool is_shapenet = false;      // an all.csv: its classes are numbers of synsets
  std::vector<LabelLine> lines;  // in the order of the file; no first name occurs twice
  // The names of classes that are numbers of synsets (taxonomy.json): see name_synsets.
  std::map<std::string, std::string> class_names;

  std::string place_of(const LabelLine& line) const;  // "`FILE` line 3"
};

// Reads `[SPLIT=]FILE`. The split counts for all lines that have none of their own.
//   * A table: `id,class[,split]`, one item a line, as RFC 4180 has it: fields in quotation marks may hold
//     commas, line ends and doubled quotation marks. Blanks around fields without quotation marks do not
//     count, nor do empty lines, a byte-order mark and lines of one field that begin with #. A first line
//     with an id (id, uid, object_id, anno_id, model_id, modelId, file_id) names the columns in any order:
//     class (or label, category) and split, one of them at least; others are left out.
//   * all.csv of ShapeNet: a header with synsetId and modelId. The class is the synset, the item is
//     SYNSET/MODEL, else a MODEL that the file has once, else model_ID (SHREC 2016).
//   * A list: one id a line, lines that begin with # left out. The split is that of SPLIT=, else the one that
//     a word of the file's name names (modelnet40_train.txt).
//   * Names of classes: `NAME SYNSET`, one a line (synsetoffset2category.txt of ShapeNetPart).
//   * JSON (a name with .json): a list of ids; a list of objects with an id, and a class or a split, as in a
//     table (model_info.json of 3D-FUTURE); an object of lists of ids, whose names are classes or splits,
//     also below each other (LVIS of Objaverse, DeepSDF); an object of splits by id; taxonomy.json of
//     ShapeNet. Without a split of its own a line has that of the file's name.
// FILE may be packed by gzip, or be ARCHIVE/MEMBER.
//
// Splits: see split_of_word. Throws UsageError with the line: a file that cannot be read or is none of these,
// too few or too many fields, a split that is none, broken quotation, two lines that say different things of
// one id, a list without a split.
LabelFile read_label_file(const std::string& argument);
// The file of such an argument, without the split.
std::filesystem::path path_of_labels(const std::string& argument);

// The content of a file that is read so, unpacked. Throws UsageError.
std::string content_of_labels(const std::filesystem::path& path);
// The same for a taxonomy.json that has been read. Throws UsageError where it is none.
LabelFile read_taxonomy(const std::string& text, const std::string& name);

// A classification file of the Princeton Shape Benchmark (.cla).
struct Classification {
  struct Model {
    std::string name;  // as written: a number in the benchmark itself, any word in its followers
    std::uint32_t label = 0;
  };
  // As written; a name that several classes bear has its parent before it (`parent/name`).
  std::vector<std::string> classes;
  std::vector<Model> models;  // in the order of the file
};

// `PSB 1`, then `classes models`, then per class: `name parent count` and `count` model names. Free white
// space. Throws UsageError with the place of the mistake.
Classification read_classification(const std::filesystem::path& file);

}  // namespace meander
