// The class and the split of an item by the folders that it is in.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "kernels/data/samples.h"

namespace meander {

// automatic: one of the others, see recognize_layout.
enum class FolderLayout : std::uint8_t { automatic, flat, modelnet, shapenet };
std::string_view name_of(FolderLayout layout);  // "auto", "flat", "modelnet", "shapenet"

// The class and the split that the folders of an item give it; an empty class: none.
struct ItemPlace {
  std::string label;
  Split split = Split::none;
};

// The split that a word names in any case: train, training; test, testing; val, valid, validation.
// Split::none for any other word.
Split split_of_word(std::string_view word);

// Whether a folder is named like a synset of WordNet: eight digits.
bool is_synset(std::string_view name);

// The place of an item, by its id, in a layout other than automatic:
//   flat      no class, no split
//   modelnet  the last folder with the name of a split is the split; the class is the folder before it where
//             the file stands in it (chair/train/x.off), else the folder behind it (train/chair/x.off)
//   shapenet  the class is the folder of the synset (synset/id/models/x.obj, synset/id/x.obj)
// An item whose folders do not fit has no class and no split.
ItemPlace place_of(std::string_view id, FolderLayout layout);

// The layout that a set of ids has as a whole; never automatic:
//   modelnet  every id is CLASS/SPLIT/FILE, or every id is SPLIT/CLASS/FILE, with items for training and for
//             tests; not SPLIT/MODEL/FILE, whose folders are models: none is in two splits, and several have
//             files of the same name
//   shapenet  every id is SYNSET/ID/models/FILE or SYNSET/ID/model.EXTENSION, a synset having eight digits
//   flat      otherwise
FolderLayout recognize_layout(std::span<const std::string> ids);

}  // namespace meander
