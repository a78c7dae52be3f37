// Archives as the tests need them: whole ones and odd ones.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace meander::test {

// One member of an archive to be written. What is left as it is makes an ordinary one.
struct ArchiveEntry {
  std::string name, content;
  bool deflate = true;                  // zip: else stored
  std::uint16_t flags = 0, method = 8;  // zip: general flags; the method stated, where it is neither 0 nor 8
  bool dos = false;                     // zip: made by a program of DOS
  std::uint32_t mode = 0100644;         // zip: of Unix
  char type = '0';                      // tar
  std::string link;                     // tar: what it links to
  std::optional<std::uint64_t> stated_bytes;   // instead of the length of the content
  std::optional<std::uint32_t> stated_crc;     // zip
  std::optional<std::uint64_t> stated_offset;  // zip
};

enum class LongNames { ustar, gnu, pax };  // how tar writes names of more than 100 bytes

std::string zip_bytes(const std::vector<ArchiveEntry>& entries, bool zip64 = false,
                      std::string_view comment = {});
std::string tar_bytes(const std::vector<ArchiveEntry>& entries, LongNames names = LongNames::gnu);
std::string gzip_bytes(std::string_view content, int level = 6);

// The files below a folder, named relative to it behind `prefix`, ascending.
std::vector<ArchiveEntry> entries_of(const std::filesystem::path& folder, const std::string& prefix = {});

}  // namespace meander::test
