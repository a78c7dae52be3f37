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

PointCloud read_off_points(std::string_view content, const CancelToken& cancel, const BlockRule& rule) {
  PolygonMesh mesh = read_off_vertices(content, cancel, rule);
  return {std::move(mesh.x), std::move(mesh.y), std::move(mesh.z), std::move(mesh.normals), {}};
}

// What is known of a format of points.
struct PointFileRow {
  std::string_view extensions;       // in lower case, apart by blanks
  std::string_view called;           // with its article
  std::optional<MeshFormat> format;  // of meshes, where they have one
  PointCloud (*read)(std::string_view content, const CancelToken& cancel, const BlockRule& rule);
  enum class Content : std::uint8_t { text, binary, zip } content = Content::text;
};

constexpr std::array<PointFileRow, 5> point_files = {
    {{".ply", "a PLY file", MeshFormat::ply, read_ply_points},
     {".off", "an OFF file", MeshFormat::off, read_off_points},
     {".xyz .txt .csv .pts", "a text of points", {}, read_text_points},
     {".npy", "an array of numpy", {}, read_npy_points, PointFileRow::Content::binary},
     {".npz", "arrays of numpy", {}, read_npz_points, PointFileRow::Content::zip}}};

const PointFileRow& row_of_points(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  for (const PointFileRow& row : point_files) {
    text::TextCursor own{row.extensions.data(), row.extensions.data() + row.extensions.size()};
    for (std::string_view name = own.word(); !name.empty(); name = own.word())
      if (text::same_word(extension, name)) return row;
  }
  throw ItemError(Status::unsupported_format,
                  (extension.empty() ? "a name without extension"
                                     : "the extension " + text::quoted(extension, extension.data())) +
                      " is none of " + point_extensions());
}

}  // namespace

std::string not_finite(std::uint64_t vertex, std::uint64_t count) {
  return "vertex " + std::to_string(vertex) + " of " + std::to_string(count) + " is not finite";
}

std::string point_extensions() {
  std::string list;
  for (const PointFileRow& row : point_files) list += (list.empty() ? "" : " ") + std::string(row.extensions);
  return list;
}

PointCloud read_points_in_blocks(std::string_view content, const std::filesystem::path& name,
                                 const CancelToken& cancel, const BlockRule& rule) {
  const PointFileRow& row = row_of_points(name);
  if (content.empty()) throw ItemError(Status::empty, "the file is empty");
  if (row.content == PointFileRow::Content::text) {
    const DecodedText text(content, row.format ? row_of(*row.format).keeps_line_ends : nullptr);
    check_text(text.text(), row.called, row.format);
    return row.read(text.text(), cancel, rule);
  }
  if (row.content == PointFileRow::Content::binary) check_text(content, row.called, row.format);
  return row.read(content, cancel, rule);
}

PointCloud read_points(const std::filesystem::path& path, const CancelToken& cancel) {
  cancel.check();
  row_of_points(path);  // before the file is opened
  const FileBytes file(path);
  PointCloud cloud = read_points_in_blocks(text_of(file.bytes()), path, cancel, BlockRule{});
  if (file.is_cut()) throw ItemError(Status::unreadable, "the file was shortened while it was read");
  return cloud;
}

}  // namespace meander
