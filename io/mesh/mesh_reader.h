// Reading OFF, OBJ, PLY and STL files: lenient about what files in the wild look like, exact about what they
// say.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>

#include "io/mesh/mapped_file.h"
#include "kernels/core/cancel.h"
#include "kernels/mesh/polygon_mesh.h"

namespace meander {

enum class MeshFormat : std::uint8_t { off, obj, ply, stl };

// By extension, case-insensitive; false for any other extension.
bool mesh_format_of(const std::filesystem::path& path, MeshFormat& format);

// What a mesh of this format probably holds, from the first (and a few middle) kilobytes: for the memory
// reservation.
struct MeshEstimate {
  std::uint64_t file_bytes = 0;
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
};
// Reads at most 256 KiB of the file. Headers are believed only as far as the file's size allows. Never throws
// for a malformed file (an upper bound from the size stands in); throws ItemError(unreadable) when it cannot
// be opened.
MeshEstimate peek_mesh(const std::filesystem::path& path, MeshFormat format);

// Parses the bytes of a file. Never trusts a count: every count is checked against the bytes that are there
// before memory is taken. Large files are parsed in parallel blocks (the result does not depend on it). Extra
// properties are skipped; vertex and corner normals and scalar vertex and face attributes are kept. Throws
// ItemError: unreadable or unsupported_format with a sentence that says what is wrong and where (line or
// byte); empty for a file without a face. Bad single faces are not errors: see PolygonMesh.
PolygonMesh read_mesh(std::span<const std::byte> bytes, MeshFormat format, const CancelToken& cancel = {});

}  // namespace meander
