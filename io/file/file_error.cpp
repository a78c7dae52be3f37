#include "io/file/file_error.h"

#include <fmt/format.h>

#include <cerrno>

namespace meander {

namespace {

RunError::Kind kind_of(int error, FullDisk full_disk) {
  const bool is_full = error == ENOSPC || error == EDQUOT || error == EFBIG || error == EIO;
  return is_full && full_disk == FullDisk::stops_run ? RunError::Kind::stopped : RunError::Kind::unusable;
}

}  // namespace

FileError::FileError(int error, std::string_view action, const std::filesystem::path& path,
                     FullDisk full_disk)
    : RunError(kind_of(error, full_disk), fmt::format("cannot {} {}: {}", action, path.string(),
                                                      std::generic_category().message(error))),
      code_(error, std::generic_category()) {}

void throw_file_error(int error, std::string_view action, const std::filesystem::path& path,
                      FullDisk full_disk) {
  throw FileError(error, action, path, full_disk);
}

}  // namespace meander
