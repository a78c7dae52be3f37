// A file system of a few kilobytes, in memory. Only root can mount one.
#pragma once

#include <sys/mount.h>

#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>

namespace meander::test {

class SmallDisk {
 public:
  SmallDisk(const std::filesystem::path& folder, std::uint64_t kilobytes) : folder_(folder) {
    std::filesystem::create_directories(folder);
    mounted_ = ::mount("tmpfs", folder.c_str(), "tmpfs", 0, size_of(kilobytes).c_str()) == 0;
  }
  ~SmallDisk() {
    if (mounted_) ::umount2(folder_.c_str(), MNT_DETACH);
  }
  bool mounted() const { return mounted_; }
  void resize(std::uint64_t kilobytes) {
    if (::mount("tmpfs", folder_.c_str(), "tmpfs", MS_REMOUNT, size_of(kilobytes).c_str()) != 0)
      throw std::runtime_error("cannot resize the small disk");
  }

 private:
  static std::string size_of(std::uint64_t kilobytes) { return "size=" + std::to_string(kilobytes) + "k"; }
  std::filesystem::path folder_;
  bool mounted_ = false;
};

}  // namespace meander::test
