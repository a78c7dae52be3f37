#include "io/mesh/mesh_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <optional>
#include <string>
#include <utility>

#include "io/mesh/format_readers.h"
#include "io/mesh/off_header.h"
#include "io/mesh/text_cursor.h"
#include "io/utf8.h"

namespace meander {

namespace {

constexpr std::array<std::string_view, 5> format_names = {"an OFF file", "an OBJ file", "a PLY file",
                                                          "an STL file", "a glTF file"};
std::string_view name_of(MeshFormat format) { return format_names[static_cast<std::size_t>(format)]; }

void append_utf8(std::string& out, std::uint32_t code) {
  const auto put = [&](std::uint32_t byte) { out += static_cast<char>(byte); };
  if (code < 0x80) {
    put(code);
  } else if (code < 0x800) {
    put(0xC0 | code >> 6);
    put(0x80 | (code & 0x3F));
  } else if (code < 0x10000) {
    put(0xE0 | code >> 12);
    put(0x80 | (code >> 6 & 0x3F));
    put(0x80 | (code & 0x3F));
  } else {
    put(0xF0 | code >> 18);
    put(0x80 | (code >> 12 & 0x3F));
    put(0x80 | (code >> 6 & 0x3F));
    put(0x80 | (code & 0x3F));
  }
}

// UTF-16 behind its byte-order mark; a half surrogate becomes U+FFFD, a half unit at the end is dropped.
std::string from_utf16(std::string_view bytes, bool big_endian) {
  const auto unit = [&](std::size_t at) {
    const auto first = static_cast<unsigned char>(bytes[at]),
               second = static_cast<unsigned char>(bytes[at + 1]);
    return static_cast<std::uint32_t>(big_endian ? first << 8 | second : second << 8 | first);
  };
  std::string out;
  out.reserve(bytes.size() / 2);
  for (std::size_t at = 2; at + 1 < bytes.size(); at += 2) {
    std::uint32_t code = unit(at);
    if (code >= 0xD800 && code < 0xE000) {
      const std::uint32_t next = at + 3 < bytes.size() ? unit(at + 2) : 0;
      if (code < 0xDC00 && next >= 0xDC00 && next < 0xE000) {
        code = 0x10000 + ((code - 0xD800) << 10) + (next - 0xDC00);
        at += 2;
      } else {
        code = 0xFFFD;
      }
    }
    append_utf8(out, code);
  }
  return out;
}

bool looks_like_obj(std::string_view head) {
  text::TextCursor cursor{head.data(), head.data() + head.size()};
  std::size_t vertices = 0;
  while (cursor.skip_to_token()) {
    const std::string_view word = cursor.word();
    double number = 0;
    if (word == "v") {
      for (int k = 0; k < 3; ++k)
        if (!cursor.token_on_line() || cursor.number(number) != text::Token::ok) return false;
      if (++vertices == 3) return true;
    } else if (word != "vn" && word != "vt" && word != "o" && word != "g" && word != "s" &&
               word != "mtllib" && word != "usemtl") {
      return false;
    }
    cursor.skip_line();
  }
  return false;
}

bool looks_like_off(std::string_view head) {
  try {
    text::TextCursor cursor{head.data(), head.data() + head.size()};
    return cursor.skip_to_token() && !text::is_digit(*cursor.at) && parse_off_header(head).body > 0;
  } catch (const ItemError&) {
    return false;
  }
}

PolygonMesh dispatch(std::string_view content, MeshFormat format, const CancelToken& cancel,
                     const BlockRule& rule, const MeshSurroundings& around) {
  if (std::all_of(content.begin(), content.end(), text::is_separator))
    throw ItemError(Status::empty, "the file holds nothing but blanks");
  if (const std::string other = foreign_content(content, format); !other.empty())
    throw ItemError(Status::unreadable, "by its name this is " + std::string(name_of(format)) +
                                            ", by its content it is " + other);
  switch (format) {
    case MeshFormat::off:
      return read_off(content, cancel, rule, around);
    case MeshFormat::obj:
      return read_obj(content, cancel, rule, around);
    case MeshFormat::ply:
      return read_ply(content, cancel, rule, around);
    case MeshFormat::stl:
    case MeshFormat::gltf:
      break;
  }
  return read_stl(content, cancel, rule, around);
}

// Whatever numbers the file has: see read_mesh.
PolygonMesh with_colors_in_range(PolygonMesh mesh) {
  for (std::vector<float>* const values : {&mesh.colors.vertex, &mesh.colors.face})
    for (float& value : *values) value = std::isfinite(value) ? std::clamp(value, 0.0F, 1.0F) : no_color;
  return mesh;
}

}  // namespace

namespace {

// Whether a CR is there that no LF follows. All bytes are looked at, many at once.
bool has_lone_cr(std::string_view text) {
  const std::size_t first = text.find('\r');  // most files have none
  if (first == std::string_view::npos) return false;
  bool found = text.back() == '\r';
  constexpr std::size_t at_once = 65536;
  for (std::size_t begin = first; begin + 1 < text.size() && !found; begin += at_once) {
    const std::size_t end = std::min(begin + at_once, text.size() - 1);
    unsigned lone = 0;
    for (std::size_t at = begin; at < end; ++at)
      lone |= static_cast<unsigned>(text[at] == '\r') & static_cast<unsigned>(text[at + 1] != '\n');
    found = lone != 0;
  }
  return found;
}

// Every CR that no LF follows becomes one.
std::string with_lf(std::string text) {
  for (std::size_t at = 0; at < text.size(); ++at)
    if (text[at] == '\r' && (at + 1 == text.size() || text[at + 1] != '\n')) text[at] = '\n';
  return text;
}

}  // namespace

std::optional<std::string> converted(std::string_view content, bool is_ply) {
  if (content.starts_with("\xFF\xFE")) return with_lf(from_utf16(content, false));
  if (content.starts_with("\xFE\xFF")) return with_lf(from_utf16(content, true));
  // The header of a binary PLY file is read with its CR line ends: a copy would damage the data behind it.
  if (is_ply && content.substr(0, 64).find("ascii") == std::string_view::npos) return std::nullopt;
  // A comment of a PLY header may have one: what stands behind it is no line of the header.
  if (is_ply && content.find('\n') != std::string_view::npos) return std::nullopt;
  if (!has_lone_cr(content)) return std::nullopt;
  // The bytes of a damaged binary STL file are not line ends.
  if (content.substr(0, 512).find('\0') != std::string_view::npos) return std::nullopt;
  return with_lf(std::string(content));
}

void scale_colors(std::vector<float>& values, ColorNumbers numbers) {
  std::size_t above = 0, others = 0;
  const float limit = numbers == ColorNumbers::whole ? 255 : 1;
  for (const float value : values) {
    above += value > limit;
    others += value <= limit && value != 0;
  }
  const double largest = numbers == ColorNumbers::whole ? (above > 0 ? 65535 : 255)
                         : above > others               ? 255
                                                        : 1;
  for (float& value : values) value = static_cast<float>(value / largest);
}

DecodedText::DecodedText(std::span<const std::byte> bytes)
    : text_(reinterpret_cast<const char*>(bytes.data()), bytes.size()) {
  text_ = without_byte_order_mark(text_);
  converted_ = converted(text_, false);
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
  if (format != MeshFormat::ply && (head.starts_with("ply\n") || head.starts_with("ply\r")) &&
      head.find("format ") != std::string_view::npos)
    return std::string(name_of(MeshFormat::ply));
  if (format != MeshFormat::stl && head.size() > 5 && looks_like_ascii_stl(head) &&
      head.find("vertex") != std::string_view::npos)
    return std::string(name_of(MeshFormat::stl));
  if (format != MeshFormat::off && looks_like_off(head)) return std::string(name_of(MeshFormat::off));
  if (format != MeshFormat::obj && looks_like_obj(head)) return std::string(name_of(MeshFormat::obj));
  return {};
}

namespace {

constexpr std::array<std::pair<std::string_view, MeshFormat>, 6> extensions = {{{".off", MeshFormat::off},
                                                                                {".obj", MeshFormat::obj},
                                                                                {".ply", MeshFormat::ply},
                                                                                {".stl", MeshFormat::stl},
                                                                                {".gltf", MeshFormat::gltf},
                                                                                {".glb", MeshFormat::gltf}}};

}  // namespace

std::string mesh_extensions(std::string_view conjunction) {
  std::string list;
  for (const auto& [extension, format] : extensions) {
    const bool is_last = extension == extensions.back().first;
    if (!list.empty()) list += is_last && !conjunction.empty() ? " " + std::string(conjunction) + " " : ", ";
    list += extension;
  }
  return list;
}

bool mesh_format_of(const std::filesystem::path& path, MeshFormat& format) {
  const std::string extension = path.extension().string();
  for (const auto& [name, value] : extensions) {
    if (!text::same_word(extension, name)) continue;
    format = value;
    return true;
  }
  return false;
}

PolygonMesh read_mesh_in_blocks(std::span<const std::byte> bytes, MeshFormat format,
                                const CancelToken& cancel, const BlockRule& rule,
                                const MeshSurroundings& around) {
  cancel.check();
  if (bytes.empty()) throw ItemError(Status::empty, "the file is empty");
  std::string_view content(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (format == MeshFormat::gltf) return with_colors_in_range(read_gltf(content, cancel, around));
  if (format == MeshFormat::stl && is_exact_binary_stl(content))
    return with_colors_in_range(read_stl(content, cancel, rule, around));
  content = without_byte_order_mark(content);
  if (const std::optional<std::string> copy = converted(content, format == MeshFormat::ply))
    return with_colors_in_range(dispatch(*copy, format, cancel, rule, around));
  return with_colors_in_range(dispatch(content, format, cancel, rule, around));
}

PolygonMesh read_mesh(std::span<const std::byte> bytes, MeshFormat format, const CancelToken& cancel,
                      const MeshSurroundings& around) {
  return read_mesh_in_blocks(bytes, format, cancel, BlockRule{}, around);
}

}  // namespace meander
