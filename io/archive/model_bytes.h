// The bytes of a model, wherever they are: in a file of its own or in an archive.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "io/archive/archive.h"
#include "io/file/mapped_file.h"
#include "io/mesh/mesh_reader.h"

namespace meander {

// Mapped where the model has a file of its own (`packed` is none), else unpacked into memory.
class ModelBytes {
 public:
  // Throws ItemError as MappedFile and Archive::unpack do.
  ModelBytes(const std::filesystem::path& path, const PackedFile& packed,
             std::uint64_t most_unpacked = ~std::uint64_t{0});
  std::span<const std::byte> bytes() const;
  // What the bytes took beside themselves while they were unpacked.
  std::uint64_t packed_bytes() const { return packed_bytes_; }

 private:
  std::optional<MappedFile> mapped_;
  std::string unpacked_;
  std::uint64_t packed_bytes_ = 0;
};

// See peek_mesh. Cost for a member of an archive: its unpacking.
MeshEstimate peek_model(const std::filesystem::path& path, const PackedFile& packed, MeshFormat format);

// The archive member that a path names: MESH.gz, or ARCHIVE/MEMBER for a member of an archive; none for every
// other path, and where there is no such member. Throws ItemError when the archive cannot be read.
PackedFile find_packed(const std::filesystem::path& path);
// The archive in front of the member in such a path; empty where there is none.
std::filesystem::path archive_in_path(const std::filesystem::path& path);

}  // namespace meander
