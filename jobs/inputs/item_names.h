// Finds the items that a name in a file of labels means.
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
  // Items are added in ascending order of their ids, which must outlive this object.
  void reserve(std::size_t items) { whole_.reserve(items); }
  // `path`: the path of the item, or the one that it would have if its archive were unpacked.
  void add(std::string_view id, const std::filesystem::path& path);
  // Called once, after the last item.
  void finish();

  struct Items {
    std::size_t begin = 0, end = 0;  // empty: none
    bool is_ambiguous = false;
  };
  // The item whose id, or the path that it stands for, is one of the line's names. O(log items).
  Items find_id(const LabelLine& line) const;
  // The items that the first known name of the line means. A name is
  //   1. an id, as in find_id;
  //   2. the end of a path: the name of a file with or without its extension, or the name of a folder, which
  //      means all items in it; `b/c` is a `c` in a folder `b`. The extension of a file of points (.txt,
  //      .npy, .pts ...) is ignored. Folders in front of the id may have other names here if two parts or
  //      more agree
  //      (`data/` of `data/chair/a.off`);
  //   3. the number that ABC (`00000002_...`) and ScanNet (`scene0000_00_...`) put in front of names of
  //   files.
  // A name of several files or folders is ambiguous, unless one of them holds the others. O(log items).
  Items find(const LabelLine& line) const;

 private:
  enum class Kind : std::uint8_t { folder, stem, number };
  struct Place {
    std::string_view last;    // last part of the path: a file without its extension, or its number
    std::string_view folder;  // the path in front of it in the id; ends with a slash, or is empty
    std::size_t begin = 0, end = 0;
    Kind kind = Kind::folder;
  };
  struct Wanted {
    std::string_view last, folder;
    std::size_t parts = 0;  // how many parts of `folder` must agree
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
  std::deque<std::string> owned_;        // the paths that are longer than the ids
  std::vector<std::string_view> whole_;  // the path of each item, escaped like its id
  std::vector<std::size_t> above_;       // how many bytes of it are in front of the id
  std::vector<Place> places_;
};

}  // namespace meander
