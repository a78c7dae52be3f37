// What goes wrong with a file that the program itself keeps or writes. Files of items have errors of their
// own (input_file.h).
#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>
#include <system_error>

#include "io/run_error.h"

namespace meander {

// What follows from a full disk (also from a quota, a limit on file sizes, an I/O error).
enum class FullDisk : std::uint8_t {
  stops_run,    // nothing is lost: the same command continues where it stopped. RunError::Kind::stopped
  ends_command  // nothing was begun that could be continued. RunError::Kind::unusable
};

// "cannot <action> <path>: <what the system says>". Unusable for every other reason than a full disk.
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
