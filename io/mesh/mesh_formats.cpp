#include <algorithm>
#include <utility>

#include "io/mesh/format_readers.h"
#include "io/mesh/text_cursor.h"
#include "io/word_list.h"

namespace meander {

// Each beside its reader.
extern const FormatRow off_format, obj_format, ply_format, stl_format, gltf_format;

std::span<const FormatRow* const> mesh_formats() {
  static constexpr std::array rows = {&off_format, &obj_format, &ply_format, &stl_format, &gltf_format};
  return rows;
}

std::string mesh_extensions(std::string_view conjunction) {
  std::vector<std::string_view> extensions;
  for (const FormatRow* const row : mesh_formats())
    for (const std::string_view extension : row->extensions)
      if (!extension.empty()) extensions.push_back(extension);
  return word_list(extensions, conjunction);
}

std::string mesh_format_names() {
  std::vector<std::string_view> names;
  for (const FormatRow* const row : mesh_formats())
    names.push_back(row->called.substr(row->called.find(' ') + 1));
  return word_list(names);
}

bool mesh_format_of(const std::filesystem::path& path, MeshFormat& format) {
  const std::string extension = path.extension().string();
  const auto rows = mesh_formats();
  for (std::size_t f = 0; f < rows.size() && !extension.empty(); ++f)
    for (const std::string_view own : rows[f]->extensions)
      if (text::same_word(extension, own)) {
        format = static_cast<MeshFormat>(f);
        return true;
      }
  return false;
}

std::optional<RecognizedMesh> recognize_mesh(std::string_view head, std::optional<MeshFormat> except) {
  for (std::size_t f = 0; f < mesh_formats().size(); ++f) {
    const auto format = static_cast<MeshFormat>(f);
    const auto looks_like = row_of(format).looks_like;
    if (format == except || looks_like == nullptr) continue;
    if (const LooksLike found = looks_like(head); found != LooksLike::other)
      return RecognizedMesh{format, found};
  }
  return std::nullopt;
}

std::string foreign_content(std::string_view content, std::optional<MeshFormat> format) {
  // Programs and servers leave these under any name.
  static constexpr std::array<std::pair<std::string_view, const char*>, 8> marks = {
      {{"\x1F\x8B", "a gzip archive"},
       {"PK\x03\x04", "a zip archive"},
       {"glTF", "a binary glTF file"},
       {"\x89HDF\r\n\x1A\n", "an HDF5 file"},
       {"version https://git-lfs", "a Git LFS pointer; the file itself was not fetched"},
       {"<!DOCTYPE", "a web page"},
       {"<html", "a web page"},
       {"<?xml", "an XML file"}}};
  const std::string_view head = content.substr(0, 65536);
  for (const auto& [mark, name] : marks)
    if (head.starts_with(mark)) return name;
  // JSON may be of anything; what reads it says so.
  const std::optional<RecognizedMesh> found = recognize_mesh(head, format);
  if (!found || found->format == MeshFormat::gltf) return {};
  return std::string(row_of(found->format).called) + " file";
}

}  // namespace meander
