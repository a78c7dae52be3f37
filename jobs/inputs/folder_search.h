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

// A folder, an archive, or a link to something, whose content is not known.
struct UnreadFolder {
  std::filesystem::path path;
  std::string reason;
  bool partly = false;  // an archive of which the members in front of the damage are known
};

// A mesh file, or a member of an archive.
struct FoundFile {
  std::filesystem::path path;  // of a member: where it would be if the archive were unpacked where it lies
  PackedFile packed;

  // The file; ARCHIVE/MEMBER, ARCHIVE/ARCHIVE/MEMBER, or ARCHIVE for the one in a .gz file.
  std::filesystem::path shown() const;
};

// What was found below one or more folders.
struct FolderSearch {
  std::vector<FoundFile> files;                  // with an extension of a known format; in no order
  std::map<std::string, std::uint64_t> skipped;  // other files, by extension
  std::uint64_t hidden = 0;                      // files and folders left out: .NAME and __MACOSX
  std::uint64_t links_back = 0;  // links to a folder that they stand in themselves: not followed
  std::vector<UnreadFolder> unread;
  std::vector<std::shared_ptr<Archive>> indexed;  // archives whose access points take memory

  std::uint64_t index_bytes() const;  // of all of them
};

// What an archive stands for: the folder (of .gz the file) that it would be unpacked to, of its name without
// the extension, beside it.
std::filesystem::path unpacked_path(const std::filesystem::path& archive);

// Lists an archive; notes what is damaged in it, and the memory of its access points, in `search`. Throws
// ItemError as Archive does.
std::shared_ptr<const Archive> open_archive(const std::filesystem::path& path, FolderSearch& search);
// The same with an archive that is a member of another one.
std::shared_ptr<const Archive> open_inner_archive(const std::shared_ptr<const Archive>& outer,
                                                  std::size_t member, FolderSearch& search);

// Adds the members of an archive (not .gz) as the files of that folder: hidden ones are counted, others
// skipped by extension. An archive in an archive is opened as in a folder, one that is in an archive of an
// archive is in `unread`, as is an archive that cannot be read, or not to its end. Cost: see Archive.
// Returns it, null where it cannot be read.
std::shared_ptr<const Archive> search_archive(const std::filesystem::path& archive, FolderSearch& search);

// Adds everything below `root`. Links to files and folders are followed; a folder that is reached on two ways
// is searched twice, but never inside itself (identified by device and inode). A folder that cannot be read,
// and a link that leads to nothing and has no extension of a known format, are in `unread`; a broken link
// with such an extension is a file. Archives are searched as the folders that they stand for. Cost: one look
// at every entry, one file descriptor.
void search_folder(const std::filesystem::path& root, FolderSearch& search);

}  // namespace meander
