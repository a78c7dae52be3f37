#include "io/mesh/mesh_reader.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "io/mesh/format_readers.h"
#include "io/mesh/text_cursor.h"
#include "io/utf8.h"

namespace meander {

namespace {

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

std::optional<std::string> converted(std::string_view content, bool (*keeps_line_ends)(std::string_view)) {
  if (content.starts_with("\xFF\xFE")) return with_lf(from_utf16(content, false));
  if (content.starts_with("\xFE\xFF")) return with_lf(from_utf16(content, true));
  if (keeps_line_ends != nullptr && keeps_line_ends(content)) return std::nullopt;
  if (!has_lone_cr(content)) return std::nullopt;
  // The bytes of a damaged binary STL file are not line ends.
  if (content.substr(0, 512).find('\0') != std::string_view::npos) return std::nullopt;
  return with_lf(std::string(content));
}

}  // namespace

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

DecodedText::DecodedText(std::string_view content, bool (*keeps_line_ends)(std::string_view))
    : text_(without_byte_order_mark(content)), converted_(converted(text_, keeps_line_ends)) {}

void check_text(std::string_view text, std::string_view called, std::optional<MeshFormat> format) {
  if (std::all_of(text.begin(), text.end(), text::is_separator))
    throw ItemError(Status::empty, "the file holds nothing but blanks");
  if (const std::string other = foreign_content(text, format); !other.empty())
    throw ItemError(Status::unreadable,
                    "by its name this is " + std::string(called) + ", by its content it is " + other);
}

PolygonMesh read_mesh_in_blocks(std::span<const std::byte> bytes, MeshFormat format,
                                const CancelToken& cancel, const BlockRule& rule,
                                const MeshSurroundings& around) {
  cancel.check();
  if (bytes.empty()) throw ItemError(Status::empty, "the file is empty");
  const FormatRow& row = row_of(format);
  if (row.is_raw != nullptr && row.is_raw(text_of(bytes)))
    return with_colors_in_range(row.read(text_of(bytes), cancel, rule, around));
  const DecodedText content(text_of(bytes), row.keeps_line_ends);
  check_text(content.text(), std::string(row.called) + " file", format);
  return with_colors_in_range(row.read(content.text(), cancel, rule, around));
}

PolygonMesh read_mesh(std::span<const std::byte> bytes, MeshFormat format, const CancelToken& cancel,
                      const MeshSurroundings& around) {
  return read_mesh_in_blocks(bytes, format, cancel, BlockRule{}, around);
}

}  // namespace meander
