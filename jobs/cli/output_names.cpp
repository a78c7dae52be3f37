#include "jobs/cli/output_names.h"

#include <algorithm>
#include <map>
#include <span>
#include <string>
#include <system_error>
#include <vector>

#include "io/digest.h"

namespace meander {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t longest_part = 230, longest_extension = 16;

}  // namespace

fs::path shortened_parts(const fs::path& path) {
  fs::path result;
  for (const fs::path& part : path) {
    std::string name = part.string();
    if (name.size() > longest_part) {
      const auto digest = sha256(std::as_bytes(std::span(name)));
      // What follows the first dot of a name may be nearly all of it.
      const std::string extension = part.extension().string();
      const std::string ending = "~" + hex_text(std::span(digest).first(8)) +
                                 (extension.size() <= longest_extension ? extension : std::string());
      std::size_t kept = longest_part - std::min(longest_part, ending.size());
      while (kept > 0 && (static_cast<unsigned char>(name[kept]) & 0xC0) == 0x80) --kept;  // whole characters
      name = name.substr(0, kept) + ending;
    }
    result /= name;
  }
  return result;
}

void remove_temporaries(const fs::path& folder, const std::function<bool(const std::string&)>& is_own) {
  std::error_code none;
  std::vector<fs::path> leftovers;
  for (fs::directory_iterator entry(folder, none), end; !none && entry != end; entry.increment(none)) {
    const std::string name = entry->path().filename().string();
    const std::size_t mark = name.rfind(".tmp");
    if (mark == std::string::npos || mark + 4 == name.size() ||
        name.find_first_not_of("0123456789", mark + 4) != std::string::npos)
      continue;
    if (is_own(name.substr(0, mark))) leftovers.push_back(entry->path());
  }
  for (const fs::path& path : leftovers) fs::remove(path, none);
}

void remove_temporaries(const fs::path& folder, const std::set<std::string>& names) {
  std::map<fs::path, std::set<std::string>> by_folder;
  for (const std::string& name : names) {
    const fs::path path = folder / name;
    by_folder[path.parent_path()].insert(path.filename().string());
  }
  for (const auto& folder_of_files : by_folder)
    remove_temporaries(folder_of_files.first,
                       [&](const std::string& name) { return folder_of_files.second.contains(name); });
}

}  // namespace meander
