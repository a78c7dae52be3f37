// The mesh files below a folder.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "io/archive/archive.h"

namespace meander {

// A folder, an archive or a link whose content could not be read.
struct UnreadFolder {
  std::filesystem::path path;
  std::string reason;
  bool partly = false;  // an archive whose members before the damage are known
};

// A mesh file, or a member of an archive.
struct FoundFile {
  std::filesystem::path path;  // a member's path is that in the archive unpacked beside itself
  PackedFile packed;

  // The path for messages: that of the file, ARCHIVE/MEMBER, ARCHIVE/ARCHIVE/MEMBER, or that of the .gz file.
  std::filesystem::path shown() const;
};

// What was found below one or more folders.
struct FolderSearch {
  std::vector<FoundFile> files;                  // with an extension of a known format; in no order
  std::map<std::string, std::uint64_t> skipped;  // counts of other files by extension
  std::uint64_t hidden = 0;                      // skipped files and folders: .NAME and __MACOSX
  std::uint64_t written_points = 0;              // skipped files of points that `export` made
  std::uint64_t links_back = 0;                  // links to a folder around them, which are not followed
  std::vector<UnreadFolder> unread;
  std::vector<std::shared_ptr<Archive>> indexed;  // archives whose access points take memory

  std::uint64_t index_bytes() const;  // the memory of the access points of all archives
};

// The path that an archive stands for: the folder (for .gz: the file) beside it with its name without the
// extension, to which it would be unpacked.
std::filesystem::path unpacked_path(const std::filesystem::path& archive);

// Lists an archive and notes its damage, and the memory of its access points, in `search`. Throws ItemError
// as Archive does.
std::shared_ptr<const Archive> open_archive(const std::filesystem::path& path, FolderSearch& search);
// The same for an archive that is a member of another one.
std::shared_ptr<const Archive> open_inner_archive(const std::shared_ptr<const Archive>& outer,
                                                  std::size_t member, FolderSearch& search);

// Adds the members of an archive (not .gz) as the files of the folder that it stands for; hidden members and
// those with other extensions are counted. An archive in an archive is opened; one inside that one goes to
// `unread`, as does an archive that cannot be read, or not to its end. Returns the archive, or null when it
// cannot be read. Cost: see Archive.
std::shared_ptr<const Archive> search_archive(const std::filesystem::path& archive, FolderSearch& search);

// Adds everything below `root`. Links to files and folders are followed; a folder that is reached in two ways
// is searched twice, but never inside itself (device and inode identify it). A folder that cannot be read
// goes to `unread`, as does a broken link, unless it has the extension of a known format and counts as a
// file. PLY and OFF files that `is_written_points` recognizes are counted, and are no meshes. Archives are
// searched as the folders that they stand for. Cost: every entry is looked at once, and the first 128 bytes
// of PLY and OFF files; two file descriptors.
void search_folder(const std::filesystem::path& root, FolderSearch& search);

}  // namespace meander
