#include "io/mesh/point_reader.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "io/file/file_bytes.h"
#include "io/mesh/format_readers.h"
#include "io/mesh/text_cursor.h"
#include "io/utf8.h"

namespace meander {

namespace {

enum class PointFile : std::uint8_t { ply, off, text, npy };

PointFile kind_of(const std::filesystem::path& path) {
  static constexpr std::array<std::pair<std::string_view, PointFile>, 7> extensions = {
      {{".ply", PointFile::ply},
       {".off", PointFile::off},
       {".xyz", PointFile::text},
       {".txt", PointFile::text},
       {".csv", PointFile::text},
       {".pts", PointFile::text},
       {".npy", PointFile::npy}}};
  const std::string extension = path.extension().string();
  for (const auto& [name, kind] : extensions)
    if (text::same_word(extension, name)) return kind;
  throw ItemError(Status::unsupported_format,
                  (extension.empty() ? "a name without extension"
                                     : "the extension " + text::quoted(extension, extension.data())) +
                      " is none of .ply .off .xyz .txt .csv .pts .npy");
}

PointCloud dispatch(std::string_view content, PointFile kind, const CancelToken& cancel,
                    const BlockRule& rule) {
  if (std::all_of(content.begin(), content.end(), text::is_separator))
    throw ItemError(Status::empty, "the file holds nothing but blanks");
  const std::string other = kind == PointFile::ply   ? foreign_content(content, MeshFormat::ply)
                            : kind == PointFile::off ? foreign_content(content, MeshFormat::off)
                                                     : foreign_content(content, std::nullopt);
  if (!other.empty())
    throw ItemError(Status::unreadable, std::string("by its name this is ") +
                                            (kind == PointFile::ply   ? "a PLY file"
                                             : kind == PointFile::off ? "an OFF file"
                                                                      : "a text of points") +
                                            ", by its content it is " + other);
  if (kind == PointFile::ply) return read_ply_points(content, cancel, rule);
  if (kind == PointFile::text) return read_text_points(content, cancel);
  PolygonMesh mesh = read_off_vertices(content, cancel, rule);
  return {std::move(mesh.x), std::move(mesh.y), std::move(mesh.z), std::move(mesh.normals), {}};
}

}  // namespace

std::string not_finite(std::uint64_t vertex, std::uint64_t count) {
  return "vertex " + std::to_string(vertex) + " of " + std::to_string(count) + " is not finite";
}

PointCloud read_points_in_blocks(std::string_view content, const std::filesystem::path& name,
                                 const CancelToken& cancel, const BlockRule& rule) {
  const PointFile kind = kind_of(name);
  if (content.empty()) throw ItemError(Status::empty, "the file is empty");
  if (kind == PointFile::npy) {
    if (const std::string other = foreign_content(content, std::nullopt); !other.empty())
      throw ItemError(Status::unreadable,
                      "by its name this is an array of numpy, by its content it is " + other);
    return read_npy_points(content, cancel);
  }
  content = without_byte_order_mark(content);
  if (const std::optional<std::string> copy = converted(content, kind == PointFile::ply))
    return dispatch(*copy, kind, cancel, rule);
  return dispatch(content, kind, cancel, rule);
}

PointCloud read_points(const std::filesystem::path& path, const CancelToken& cancel) {
  cancel.check();
  kind_of(path);  // before the file is opened
  const FileBytes file(path);
  const std::string_view content(reinterpret_cast<const char*>(file.bytes().data()), file.bytes().size());
  PointCloud cloud = read_points_in_blocks(content, path, cancel, BlockRule{});
  if (file.is_cut()) throw ItemError(Status::unreadable, "the file was shortened while it was read");
  return cloud;
}

}  // namespace meander
