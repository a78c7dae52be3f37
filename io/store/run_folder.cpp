#include "io/store/run_folder.h"

#include <fmt/format.h>
#include <unistd.h>

#include <string>
#include <vector>

#include "io/file/directory.h"

namespace meander::store {

namespace fs = std::filesystem;

fs::path with_suffix(const fs::path& store, std::string_view suffix) {
  fs::path path = store;
  path += suffix;
  return path;
}

fs::path part_of_store(const fs::path& store) {
  return with_suffix(store, fmt::format(".part-{}", ::getpid()));
}

void remove_leftovers(const fs::path& store) {
  const fs::path folder = store.parent_path().empty() ? fs::path(".") : store.parent_path();
  const std::string name = store.filename().string();
  std::error_code ignored;
  std::vector<fs::path> leftovers;
  for (fs::directory_iterator entry(folder, ignored), end; !ignored && entry != end;
       entry.increment(ignored)) {
    const std::string other = entry->path().filename().string();
    // A process number and nothing behind it: NAME.part-1.off is a user's mesh.
    for (const std::string& prefix :
         {name + ".part-", name + ".run.removed-", name + ".run.json.tmp", name + ".failed.txt.tmp"})
      if (other.starts_with(prefix) &&
          other.find_first_not_of("0123456789", prefix.size()) == std::string::npos)
        leftovers.push_back(entry->path());
  }
  for (const fs::path& path : leftovers) fs::remove_all(path, ignored);
}

void remove_run_folder(const fs::path& store) {
  const fs::path removed = with_suffix(store, fmt::format(".run.removed-{}", ::getpid()));
  std::error_code ignored;
  fs::remove_all(removed, ignored);
  rename_file(with_suffix(store, ".run"), removed);
  fs::remove_all(removed, ignored);
}

}  // namespace meander::store
