// Names in folders: changed so that they are on disk when the call returns.
#pragma once

#include <filesystem>

#include "io/file/file_error.h"

namespace meander {

void make_folder(const std::filesystem::path& folder);  // one that is there already is no error
void sync_folder(const std::filesystem::path& folder, FullDisk full_disk = FullDisk::stops_run);
// Replaces `to` and syncs its folder.
void rename_file(const std::filesystem::path& from, const std::filesystem::path& to,
                 FullDisk full_disk = FullDisk::stops_run);
void remove_file(const std::filesystem::path& path);  // one that is not there is no error

}  // namespace meander
