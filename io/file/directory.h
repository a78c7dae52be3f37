// Changes of names in folders, which are on disk when the call returns.
#pragma once

#include <filesystem>

#include "io/file/file_error.h"

namespace meander {

void make_folder(const std::filesystem::path& folder);  // an existing folder is no error
void sync_folder(const std::filesystem::path& folder, FullDisk full_disk = FullDisk::stops_run);
// Replaces `to` and syncs its folder.
void rename_file(const std::filesystem::path& from, const std::filesystem::path& to,
                 FullDisk full_disk = FullDisk::stops_run);
void remove_file(const std::filesystem::path& path);  // a missing file is no error

}  // namespace meander
