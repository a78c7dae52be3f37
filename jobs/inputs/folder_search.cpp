#include "jobs/inputs/folder_search.h"

#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <numeric>
#include <system_error>
#include <utility>

#include "io/item_id.h"
#include "io/mesh/mesh_reader.h"
#include "io/mesh/point_writer.h"
#include "kernels/core/status.h"

namespace meander {

namespace {

namespace fs = std::filesystem;

bool is_hidden(const std::string& name) { return name.starts_with('.') || name == "__MACOSX"; }

// Bounds the memory of all indexes together: the largest ones lose every second access point.
void keep_indexes_small(FolderSearch& search) {
  constexpr std::uint64_t max_bytes = std::uint64_t{64} << 20;
  while (search.index_bytes() > max_bytes)
    (*std::max_element(search.indexed.begin(), search.indexed.end(), [](const auto& a, const auto& b) {
      return a->index_bytes() < b->index_bytes();
    }))->thin_index();
}

std::shared_ptr<const Archive> note_archive(std::shared_ptr<Archive> archive, FolderSearch& search) {
  if (!archive->problem().empty()) search.unread.push_back({archive->shown(), archive->problem(), true});
  if (archive->index_bytes() > 0) {
    search.indexed.push_back(archive);
    keep_indexes_small(search);
  }
  return archive;
}

void take_inner_archive(const std::shared_ptr<const Archive>& outer, std::size_t member,
                        const fs::path& folder, FolderSearch& search);

// Takes the members of an archive that stands for `folder`.
void take_members(const std::shared_ptr<const Archive>& archive, const fs::path& folder,
                  FolderSearch& search) {
  for (std::size_t i = 0; i < archive->members().size(); ++i) {
    const fs::path name = archive->members()[i].name;
    MeshFormat format;
    if (std::any_of(name.begin(), name.end(), [](const fs::path& part) { return is_hidden(part.string()); }))
      ++search.hidden;
    else if (mesh_format_of(name, format))
      search.files.push_back({folder / name, {archive, i}});
    else if (const auto kind = archive_kind_of(name); kind && kind != ArchiveKind::gzip)
      take_inner_archive(archive, i, folder / unpacked_path(name), search);
    else
      ++search.skipped[escape_id(name.extension().string())];
  }
}

void take_inner_archive(const std::shared_ptr<const Archive>& outer, std::size_t member,
                        const fs::path& folder, FolderSearch& search) {
  const fs::path shown = outer->shown() / outer->members()[member].name;
  if (outer->outer()) {
    search.unread.push_back(
        {shown, "it is in an archive inside an archive, and only one level is opened: unpack the outer one"});
    return;
  }
  std::shared_ptr<const Archive> archive;
  try {
    archive = open_inner_archive(outer, member, search);
  } catch (const ItemError& error) {
    search.unread.push_back({shown, error.what()});
    return;
  }
  take_members(archive, folder, search);
}

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
    // The folder is closed before those below are searched, so that one descriptor is enough for any depth.
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
      take_mesh(path, format);
    else if (const auto kind = archive_kind_of(path); kind && target != fs::file_type::not_found)
      take_archive(path, *kind);
    else if (target == fs::file_type::not_found)
      search_.unread.push_back({path, "the target of the link does not exist"});
    else if (target == fs::file_type::none || target == fs::file_type::unknown)
      leave_out(path, error);
    else
      ++search_.skipped[escape_id(path.extension().string())];
  }

  // Its row will say whether it is a mesh.
  void take_mesh(const fs::path& path, MeshFormat format) {
    const bool is_format_of_points = format == MeshFormat::ply || format == MeshFormat::off;
    if (is_format_of_points && is_written_points(path))
      ++search_.written_points;
    else
      search_.files.push_back({path, {}});
  }

  void take_archive(const fs::path& path, ArchiveKind kind) {
    if (kind == ArchiveKind::gzip)
      search_.files.push_back({unpacked_path(path), {std::make_shared<const Archive>(path), 0}});
    else
      search_archive(path, search_);
  }

  void leave_out(const fs::path& path, const std::error_code& error) {
    search_.unread.push_back({path, error.message()});
  }

  FolderSearch& search_;
  std::vector<std::pair<dev_t, ino_t>> way_;  // the folders from the root to the present one
};

}  // namespace

fs::path FoundFile::shown() const {
  if (!packed) return path;
  const Archive& archive = *packed.archive;
  return archive.kind() == ArchiveKind::gzip ? archive.path() : archive.shown() / packed.facts().name;
}

fs::path unpacked_path(const fs::path& archive) {
  return archive.parent_path() / name_without_packing(archive);
}

std::uint64_t FolderSearch::index_bytes() const {
  return std::accumulate(indexed.begin(), indexed.end(), std::uint64_t{0},
                         [](std::uint64_t sum, const auto& archive) { return sum + archive->index_bytes(); });
}

std::shared_ptr<const Archive> open_archive(const fs::path& path, FolderSearch& search) {
  return note_archive(std::make_shared<Archive>(path), search);
}

std::shared_ptr<const Archive> open_inner_archive(const std::shared_ptr<const Archive>& outer,
                                                  std::size_t member, FolderSearch& search) {
  return note_archive(std::make_shared<Archive>(outer, member), search);
}

std::shared_ptr<const Archive> search_archive(const fs::path& path, FolderSearch& search) {
  std::shared_ptr<const Archive> archive;
  try {
    archive = open_archive(path, search);
  } catch (const ItemError& error) {
    search.unread.push_back({path, error.what()});
    return nullptr;
  }
  take_members(archive, unpacked_path(path), search);
  return archive;
}

void search_folder(const fs::path& root, FolderSearch& search) { Walk(search).enter(root); }

}  // namespace meander
