#include "jobs/output_names.h"

#include <algorithm>
#include <span>
#include <string>

#include "io/digest.h"

namespace meander {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t longest_part = 230;

}  // namespace

fs::path shortened_parts(const fs::path& path) {
  fs::path result;
  for (const fs::path& part : path) {
    std::string name = part.string();
    if (name.size() > longest_part) {
      const auto digest = sha256(std::as_bytes(std::span(name)));
      const std::string ending = "~" + hex_text(std::span(digest).first(8)) + part.extension().string();
      std::size_t kept = longest_part - std::min(longest_part, ending.size());
      while (kept > 0 && (static_cast<unsigned char>(name[kept]) & 0xC0) == 0x80) --kept;  // whole characters
      name = name.substr(0, kept) + ending;
    }
    result /= name;
  }
  return result;
}

}  // namespace meander
