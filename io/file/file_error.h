// Errors of files that the program itself keeps or writes. Files of items have their own (input_file.h).
#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>
#include <system_error>

#include "io/run_error.h"

namespace meander {

// The consequence of a full disk (or of a quota, a limit on file sizes, an I/O error).
enum class FullDisk : std::uint8_t {
  stops_run,    // RunError::Kind::stopped: the same command continues where it stopped
  ends_command  // RunError::Kind::unusable: there is nothing to continue
};

// "cannot <action> <path>: <reason of the system>". Its kind is `unusable` for every reason but a full disk.
class FileError : public RunError {
 public:
  FileError(int error, std::string_view action, const std::filesystem::path& path, FullDisk full_disk);
  const std::error_code& code() const { return code_; }

 private:
  std::error_code code_;
};

[[noreturn]] void throw_file_error(int error, std::string_view action, const std::filesystem::path& path,
                                   FullDisk full_disk = FullDisk::stops_run);

}  // namespace meander
