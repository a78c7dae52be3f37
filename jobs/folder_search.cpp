#include "jobs/folder_search.h"

#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

#include "io/item_id.h"
#include "io/mesh/mesh_reader.h"

namespace meander {

namespace {

namespace fs = std::filesystem;

bool is_hidden(const std::string& name) { return name.starts_with('.') || name == "__MACOSX"; }

class Walk {
 public:
  explicit Walk(FolderSearch& search) : search_(search) {}

  void enter(const fs::path& folder) {
    struct stat facts {};
    if (::stat(folder.c_str(), &facts) != 0)
      return leave_out(folder, std::error_code(errno, std::generic_category()));
    const std::pair<dev_t, ino_t> identity(facts.st_dev, facts.st_ino);
    if (std::find(way_.begin(), way_.end(), identity) != way_.end()) {
      ++search_.links_back;
      return;
    }
    way_.push_back(identity);
    // Searched once the folder is closed: one descriptor is open, however deep the tree.
    for (const fs::path& below : take_entries(folder)) enter(below);
    way_.pop_back();
  }

 private:
  // Returns the folders among the entries.
  std::vector<fs::path> take_entries(const fs::path& folder) {
    std::vector<fs::path> folders;
    std::error_code error;
    fs::directory_iterator at(folder, error);
    for (; !error && at != fs::directory_iterator(); at.increment(error)) take(*at, folders);
    if (error) leave_out(folder, error);
    return folders;
  }

  void take(const fs::directory_entry& entry, std::vector<fs::path>& folders) {
    const fs::path& path = entry.path();
    if (is_hidden(path.filename().string())) {
      ++search_.hidden;
      return;
    }
    std::error_code error;
    const bool is_link = entry.is_symlink(error);
    const fs::file_type target = is_link ? fs::status(path, error).type() : fs::file_type::regular;
    MeshFormat format;
    if (is_link ? target == fs::file_type::directory : entry.is_directory(error))
      folders.push_back(path);
    else if (mesh_format_of(path, format))
      search_.files.push_back(path);  // whatever it is: its row will say so
    else if (target == fs::file_type::not_found)
      search_.unread.push_back({path, "the target of the link does not exist"});
    else if (target == fs::file_type::none || target == fs::file_type::unknown)
      leave_out(path, error);
    else
      ++search_.skipped[escape_id(path.extension().string())];
  }

  void leave_out(const fs::path& path, const std::error_code& error) {
    search_.unread.push_back({path, error.message()});
  }

  FolderSearch& search_;
  std::vector<std::pair<dev_t, ino_t>> way_;  // the folders from the root to here
};

}  // namespace

void search_folder(const fs::path& root, FolderSearch& search) { Walk(search).enter(root); }

}  // namespace meander
