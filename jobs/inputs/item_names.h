// Which items a name of a file of labels means.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "jobs/inputs/label_file.h"

namespace meander {

// The names of items: of their files and of the folders that they stand in, below the input and above it.
class ItemNames {
 public:
  // Items in ascending order of their ids, which outlive the names.
  void reserve(std::size_t items) { whole_.reserve(items); }
  // `path`: where the item lies, or would lie if its archive were unpacked.
  void add(std::string_view id, const std::filesystem::path& path);
  // Once, behind the last item.
  void finish();

  struct Items {
    std::size_t begin = 0, end = 0;  // a range of them; empty: none
    bool is_ambiguous = false;
  };
  // The item whose id, or the path that it stands for, is one of the line's names. O(log items).
  Items find_id(const LabelLine& line) const;
  // By the first of the line's names that means something:
  //   1. an id, as find_id;
  //   2. the end of a path: the name of a file, with its extension as it is or without it, or that of a
  //   folder,
  //      which means all items below it; `b/c` is a `c` in a folder `b`. Folders that the name has in front
  //      of the id may be called otherwise here, if two parts or more are right (`data/` of
  //      `data/chair/a.off`). The extension of a point file (.txt, .npy, .pts ...) does not count;
  //   3. the number that ABC (`00000002_...`) and ScanNet (`scene0000_00_...`) put in front of names of
  //   files.
  // What several files or folders have, none of which holds the others, is ambiguous. O(log items).
  Items find(const LabelLine& line) const;

 private:
  enum class Kind : std::uint8_t { folder, stem, number };
  struct Place {
    std::string_view last;    // part of the path: of a file without extension, or its number
    std::string_view folder;  // the path in front of it in the id, which ends with a slash or is empty
    std::size_t begin = 0, end = 0;
    Kind kind = Kind::folder;
  };
  struct Wanted {
    std::string_view last, folder;
    std::size_t parts = 0;  // of `folder` that must be the same
    bool is_number = false;
  };

  void add_folders(std::size_t item);
  std::string_view above(std::size_t item) const { return whole_[item].substr(0, above_[item]); }
  static int compare(const Place& place, const Wanted& wanted);
  Items find_exactly(const std::string& id) const;
  Items find_end(const std::string& name, const std::string& synset) const;
  template <class IsRight>
  Items find_places(const Wanted& wanted, const IsRight& is_right) const;
  template <class IsRight>
  Items find_from_top(Wanted wanted, const IsRight& is_right) const;
  bool may_be_above(const Place& place, const Wanted& wanted) const;
  bool is_below_other_synset(std::size_t item, const std::string& synset) const;

  std::vector<std::string_view> ids_;
  std::deque<std::string> owned_;        // paths that are longer than the ids
  std::vector<std::string_view> whole_;  // the path of each item, like its id, as far up as it is known
  std::vector<std::size_t> above_;       // bytes of it in front of the id
  std::vector<Place> places_;
};

}  // namespace meander
