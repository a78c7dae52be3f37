// The mesh files below a folder.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace meander {

// A folder, or a link to something, whose content is not known.
struct UnreadFolder {
  std::filesystem::path path;
  std::string reason;
};

// What was found below one or more folders.
struct FolderSearch {
  std::vector<std::filesystem::path> files;      // with an extension of a known format; in no order
  std::map<std::string, std::uint64_t> skipped;  // other files, by extension
  std::uint64_t hidden = 0;                      // files and folders left out: .NAME and __MACOSX
  std::uint64_t links_back = 0;  // links to a folder that they stand in themselves: not followed
  std::vector<UnreadFolder> unread;
};

// Adds everything below `root`. Links to files and folders are followed; a folder that is reached on two ways
// is searched twice, but never inside itself (identified by device and inode). A folder that cannot be read,
// and a link that leads to nothing and has no extension of a known format, are in `unread`; a broken link
// with such an extension is a file. Cost: one look at every entry, one file descriptor.
void search_folder(const std::filesystem::path& root, FolderSearch& search);

}  // namespace meander
