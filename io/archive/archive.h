// Archives as inputs: .zip, .tar, .tar.gz (.tgz), and a single mesh in a .gz file.
#pragma once

#include <cstdint>
#include <ctime>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "io/archive/archive_member.h"
#include "io/archive/gzip_source.h"

namespace meander {

class InputFile;

enum class ArchiveKind : std::uint8_t { zip, tar, tar_gzip, gzip };

// By extension, case-insensitive; gzip only for the name of a mesh with .gz behind it.
std::optional<ArchiveKind> archive_kind_of(const std::filesystem::path& path);
// The extensions of archives of many files, for documents: ".zip, .tar, .tar.gz, .tgz".
std::string archive_extensions();
// The name without the extensions of archives: "set" of "set.tar.gz", "a.off" of "a.off.gz".
std::string name_without_packing(const std::filesystem::path& path);

// The directory of one archive. It is read once and then shared by threads; the file is open only while
// something is read from it. An archive stands for a folder of its name without extension: a folder of this
// name at its top that holds all its members counts once, as programs unpack it that make no folder in a
// folder of the same name.
//
// A .tar.gz file is unpacked once when it is listed, and nothing of it is kept but access points, 32 KiB each
// for every half MiB at first and at most 32 MiB in all: a member is then unpacked from the point before it.
// So no disk is needed, and nothing is left behind by a process that dies; a scratch file would be faster for
// archives beyond a few GiB, whose points are far apart.
//
// A member may be an archive itself, and is opened as one where it lies: in place where it is stored, from
// access points of its own where it is packed (a member of up to 1 MiB is unpacked instead). One level:
// members of such an archive are no archives.
class Archive {
 public:
  // Throws ItemError(unreadable) when the file cannot be read, or is no archive of its kind. Cost: the
  // directory of a zip file, one look at every header of a tar file, the unpacking of a .tar.gz file (about
  // 0.3 GB/s), nothing for a .gz file, which has one member.
  explicit Archive(std::filesystem::path path);
  // The archive (zip, tar or tar_gzip by its name) that a member of `outer` is. Throws as above, the status
  // of a refused member, and too_large where the directory of a zip has more than 256 MiB. Cost: besides, the
  // unpacking of a packed member.
  Archive(std::shared_ptr<const Archive> outer, std::size_t member);
  Archive(const Archive&) = delete;
  Archive& operator=(const Archive&) = delete;

  const std::filesystem::path& path() const { return path_; }  // of the file on disk
  // The archive that this one is a member of, and the name it has there; null and empty: of none.
  const std::shared_ptr<const Archive>& outer() const { return outer_; }
  std::string_view name_in_outer() const;
  std::filesystem::path shown() const;  // path(), or path()/name_in_outer()
  ArchiveKind kind() const { return kind_; }
  // Names are unique; those of which there are several are refused.
  const std::vector<ArchiveMember>& members() const { return listing_.members; }
  const std::string& problem() const { return listing_.problem; }
  // A member by its path below the folder that the archive stands for, or as it is stored.
  std::optional<std::size_t> find(std::string_view name) const;
  // The same, or where there is none the member whose path is the same once folded (folded_name): many
  // collections were made where that makes no difference. Of several, part by part of the path, the one that
  // is exact, then the first by bytes; of more than 4,096, which no collection has, none. O(log members);
  // once O(members log members).
  std::optional<std::size_t> find_in_any_case(std::string_view name) const;

  // The unpacked bytes, checked against their size and checksum where the archive has one. Throws ItemError:
  // the status of a refused member; unreadable when they are damaged or cut, are more than the archive states
  // or than is_bomb allows, or when the archive was changed since it was listed; too_large when they are more
  // than `most`. Memory: packed and unpacked.
  std::string unpack(std::size_t member, std::uint64_t most = ~std::uint64_t{0}) const;
  // Reads parts of a member, best in ascending order, with little memory: calls `look` with them. Throws as
  // unpack() does, as far as is read.
  void look_at(std::size_t member, const std::function<void(const ByteSource&)>& look) const;

  // The access points, of the archive and of the member that it is.
  std::uint64_t index_bytes() const { return points_.memory_bytes() + outer_points_.memory_bytes(); }
  void thin_index();

 private:
  using Look = std::function<void(const ByteSource&)>;

  void list(const ByteSource& file);
  void list_tar_gzip(const ByteSource& file);
  void unpack_once();
  // In the file; of a .tar.gz file at most, as its access points tell.
  std::uint64_t packed_bytes_of(std::size_t member) const;
  void enter_top_folder(const std::string& own_name);
  void enter_positions();
  // The file, if it is the one that was listed.
  InputFile open() const;
  // Calls `look` with the bytes of the archive, if it is the one that was listed.
  void look_at_archive(const Look& look) const;
  // See look_at; `points` are those of the packed member, or null.
  void look_at(std::size_t member, const Look& look, const AccessPoints* points) const;
  const ArchiveMember& readable(std::size_t member) const;
  std::string unpack_from(const ByteSource& file, std::size_t member, std::uint64_t most) const;
  std::string gunzip(const ByteSource& file, std::uint64_t most) const;

  std::filesystem::path path_;
  std::shared_ptr<const Archive> outer_;
  std::size_t member_in_outer_ = 0;
  ArchiveKind kind_;
  ArchiveListing listing_;
  std::unordered_map<std::string_view, std::size_t> position_;  // of members, by name
  mutable std::once_flag folding_;
  // Members by the hash of their folded name; see find_in_any_case.
  mutable std::vector<std::pair<std::uint64_t, std::uint32_t>> by_folded_name_;
  std::string top_;  // the folder that counts once, with a slash; empty: none
  AccessPoints points_;
  AccessPoints outer_points_;  // of the packed member of `outer_`
  std::uint64_t file_bytes_ = 0;
  std::timespec modified_{};
};

// A member of an archive as the place of a file; without an archive it is none.
struct PackedFile {
  std::shared_ptr<const Archive> archive;
  std::size_t member = 0;

  explicit operator bool() const { return archive != nullptr; }
  const ArchiveMember& facts() const { return archive->members()[member]; }
};

// Where a path below an archive leads into a member that is an archive itself (not .gz).
struct InnerPath {
  std::size_t member = 0;      // `a/set.zip` of `a/set.zip/x.off`
  std::filesystem::path rest;  // `x.off`
};
std::optional<InnerPath> inner_archive_in_path(const Archive& archive, const std::filesystem::path& name);

}  // namespace meander
