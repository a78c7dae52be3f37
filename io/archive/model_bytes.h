// The bytes of a model, wherever they are: in a file of its own or in an archive, and in the files that it
// names (buffers, material libraries, images), which lie below the folder that was given as input, in the
// same archive if the model is in one.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "io/archive/archive.h"
#include "io/file/file_bytes.h"
#include "io/mesh/mesh_reader.h"

namespace meander {

inline constexpr std::size_t most_searched_names = 4096;

// Where a model is, and how far the names in it may lead.
struct ModelPlace {
  std::filesystem::path path;  // of a member of an archive: ARCHIVE/MEMBER
  PackedFile packed = {};      // where it is, if it is in an archive
  MeshFormat format = MeshFormat::off;
  // How many folders above its own the files that it names may lie in: up to the folder that was given as
  // input; of a file given by itself one. Members of an archive may name all of its members.
  std::uint32_t folders_above = 1;
};

// FileBytes where the model has a file of its own (`packed` is none), else unpacked into memory.
class ModelBytes {
 public:
  // Throws ItemError as FileBytes and Archive::unpack do, and too_large when all that has to be unpacked is
  // more than `most_unpacked`. A file that the model names and that cannot be read is kept with the reason:
  // reading the mesh fails where it is needed. With `colors`, the mesh has its colors, and the files that
  // hold them (MTL, images) are opened too; one that cannot be read costs its colors alone. Those are
  // also found under names that differ as folded_name allows, on disk in folders of up to
  // most_searched_names. A name that leads up (`..`) is followed as far as ModelPlace::folders_above, and not
  // where a link leads out of that folder.
  explicit ModelBytes(const ModelPlace& place, std::uint64_t most_unpacked = ~std::uint64_t{0},
                      bool colors = false);
  ModelBytes(const ModelBytes&) = delete;
  ModelBytes& operator=(const ModelBytes&) = delete;

  std::uint64_t file_bytes() const;  // of all files but those of colors alone
  // What the bytes took beside themselves while they were unpacked.
  std::uint64_t packed_bytes() const { return packed_bytes_; }
  // The size of the files that are read for colors alone, and the memory of decoding their images, as their
  // headers state.
  std::uint64_t color_bytes() const;
  // The content of the model: the SHA-256 of its file; of a model that names other files, of the digests of
  // its file and of these in the order in which it names them (zeros for one that cannot be read).
  std::array<std::uint8_t, 32> content_sha256() const;
  // The SHA-256 of the digests of the files that hold colors alone, in the order in which the model names
  // them (zeros for one that cannot be read): they are no part of content_sha256, on which the points
  // depend. Zeros where there are none.
  std::array<std::uint8_t, 32> color_sha256() const;
  // See read_mesh and MeshSurroundings::admit. This and the digests throw ItemError(unreadable) where another
  // program has shortened a file meanwhile.
  PolygonMesh mesh(const CancelToken& cancel = {}, const std::function<void(const MeshEstimate&)>& admit = {},
                   const MeshExtras& extras = {}) const;

 private:
  // The bytes of one file. Moved only before they are looked at.
  struct File {
    std::optional<FileBytes> on_disk;
    std::string unpacked;
    std::span<const std::byte> bytes() const;
    bool is_cut() const { return on_disk && on_disk->is_cut(); }
  };
  void fail_if_cut() const;
  File open(const std::filesystem::path& path, const PackedFile& packed, bool of_colors = false);
  std::span<const CompanionFile> surface_companions() const;
  void open_companion(const ModelPlace& place, CompanionFile& companion, bool any_case);

  MeshFormat format_;
  std::uint64_t packed_bytes_ = 0, may_unpack_ = 0;
  File own_;
  std::deque<File> beside_;
  std::vector<CompanionFile> companions_;  // of the surface, then those of its colors
  std::size_t color_companions_ = 0;
  bool colors_;
};

// See peek_mesh; file_bytes counts the other files too. Cost for a member of an archive: its unpacking.
MeshEstimate peek_model(const ModelPlace& place);
// The files on disk that a peeked model names; none for a member of an archive, which has them in its
// archive.
std::vector<std::filesystem::path> companion_files(const MeshEstimate& peeked, const ModelPlace& place);

// The archive member that a path names: MESH.gz, ARCHIVE/MEMBER for a member of an archive, or
// ARCHIVE/ARCHIVE/MEMBER for one of an archive in an archive; none for every other path, and where there is
// no such member. Throws ItemError when the archive cannot be read.
PackedFile find_packed(const std::filesystem::path& path);
// The archive in front of the member in such a path; empty where there is none.
std::filesystem::path archive_in_path(const std::filesystem::path& path);

}  // namespace meander
