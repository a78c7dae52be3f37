// The table of mesh formats: all that the program knows of a format stands in its row.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace meander {

class ByteSource;
struct CancelToken;
struct BlockRule;
struct CompanionFile;
struct FileAttribute;
struct MeshEstimate;
struct MeshPeek;
struct MeshSurroundings;
struct PolygonMesh;

// Plans of arrays have the numbers: append.
enum class MeshFormat : std::uint8_t { off, obj, ply, stl, gltf };

// Whether the beginning of a file is of a format; `points`: it is, and the file has no faces.
enum class LooksLike : std::uint8_t { other, mesh, points };

// Each reader defines its own row, and mesh_formats.cpp lists them. A function that is null stands for a
// format without that feature.
struct FormatRow {
  std::string_view called;                       // with its article: "an OFF"
  std::array<std::string_view, 2> extensions{};  // in lower case, the usual one first
  // Throws ItemError as read_mesh does. `content` is the whole file: text in UTF-8 with LF line ends and
  // without a byte-order mark, or what the next two leave alone.
  PolygonMesh (*read)(std::string_view content, const CancelToken& cancel, const BlockRule& rule,
                      const MeshSurroundings& around);
  // Whether the file is read as it stands: no text, and not looked at for other formats.
  bool (*is_raw)(std::string_view content) = nullptr;
  // Whether a file that is not UTF-16 keeps its line ends.
  bool (*keeps_line_ends)(std::string_view content) = nullptr;
  // Judges the first 64 KiB; `other` when in doubt.
  LooksLike (*looks_like)(std::string_view head) = nullptr;
  // The estimate of peek_mesh, from the beginning of the file and what it samples. Throws ItemError where the
  // header cannot be read.
  MeshEstimate (*peek)(const MeshPeek& peek) = nullptr;
  // The same without taking the beginning into memory first; nothing: `peek` does it.
  std::optional<MeshEstimate> (*peek_file)(const ByteSource& file) = nullptr;
  // The most that a file of this size can hold, whatever is in it; null: counts do not depend on the size.
  MeshEstimate (*most)(std::uint64_t bytes) = nullptr;
  // The paths of the files that the surface of a model is in beside its own (CompanionFile::path), in the
  // order in which the file names them, each once; none for a file that cannot be read. O(bytes).
  std::vector<std::string> (*companions)(std::span<const std::byte> bytes) = nullptr;
  // The same of the files that hold colors alone: images (CompanionFile::is_image), or libraries of
  // materials where the format has the next.
  std::vector<std::string> (*color_companions)(std::span<const std::byte> bytes) = nullptr;
  // The images of the materials that the file uses, from these libraries. A name counts from the folder of
  // its library, and of an absolute path the file's name alone is taken.
  std::vector<std::string> (*library_images)(std::span<const std::byte> bytes,
                                             std::span<const CompanionFile> libraries) = nullptr;
  // See peek_attributes. Throws ItemError where the header cannot be read.
  std::vector<FileAttribute> (*attributes)(const ByteSource& file) = nullptr;
};

// In the order of MeshFormat.
std::span<const FormatRow* const> mesh_formats();
inline const FormatRow& row_of(MeshFormat format) {
  return *mesh_formats()[static_cast<std::size_t>(format)];
}

// By extension, case-insensitive; false for any other extension.
bool mesh_format_of(const std::filesystem::path& path, MeshFormat& format);
// The extensions that are read, for messages: ".off, .obj, .ply, .stl, .gltf, .glb", the last one behind
// `conjunction` where there is one ("or").
std::string mesh_extensions(std::string_view conjunction = {});
// The names, for documents: "OFF, OBJ, PLY, STL, glTF".
std::string mesh_format_names();

// The format, other than `except`, that the first 64 KiB of a file are clearly of, and whether they are of a
// mesh; nothing when in doubt.
struct RecognizedMesh {
  MeshFormat format;
  LooksLike content;
};
std::optional<RecognizedMesh> recognize_mesh(std::string_view head, std::optional<MeshFormat> except = {});

// Whether the size is that of a binary STL file with the facet count it states; `head` is its beginning.
bool is_exact_binary_stl(std::string_view head, std::uint64_t bytes);

}  // namespace meander
