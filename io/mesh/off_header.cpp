#include "io/mesh/off_header.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "io/mesh/text_cursor.h"
#include "kernels/core/portable_functions.h"

namespace meander {

namespace {

using text::TextCursor;
using text::Token;

// Reads the keyword at the cursor, if there is one: the counts of a file without one may begin as it does.
// `dimensions`: whether their number follows it.
bool read_keyword(TextCursor& cursor, OffHeader& result, bool& dimensions) {
  OffHeader header;
  const char* p = cursor.at;
  const auto starts_with = [&](std::string_view lower_case) {
    return static_cast<std::size_t>(cursor.end - p) >= lower_case.size() &&
           text::same_word({p, lower_case.size()}, lower_case);
  };
  while (!starts_with("off")) {
    if (starts_with("st")) {
      header.texture = true;
      p += 2;
      continue;
    }
    if (p == cursor.end) return false;
    switch (*p) {
      case 'C':
        header.colors = true;
        break;
      case 'N':
        header.normals = true;
        break;
      case '4':
        header.homogeneous = true;
        break;
      case 'n':
        dimensions = true;
        break;
      default:
        return false;
    }
    ++p;
  }
  cursor.at = p + 3;
  result = header;
  return true;
}

std::uint64_t read_count(std::string_view content, TextCursor& cursor, const char* of_what) {
  std::int64_t count = 0;
  if (!cursor.skip_to_token())
    text::fail_at(content, cursor.end, std::string("the file ends before the number of ") + of_what);
  const char* const at = cursor.at;
  if (cursor.integer(count) != Token::ok || count < 0)
    text::fail_at(content, at, text::quoted(content, at) + " is not a number of " + of_what);
  return static_cast<std::uint64_t>(count);
}

void read_dimensions(std::string_view content, TextCursor& cursor, OffHeader& header) {
  const std::uint64_t dimensions = read_count(content, cursor, "dimensions");
  if (dimensions < 2 || dimensions > 3)
    throw ItemError(Status::unsupported_format,
                    "nOFF: vertices of " + std::to_string(dimensions) + " dimensions are not supported");
  header.dimensions = static_cast<int>(dimensions);
}

// The number of edges is useless and often left out: a third count belongs to the header when it is on
// the line of the second, or when every count has a line of its own.
void skip_edge_count(TextCursor& cursor, bool counts_on_one_line) {
  if (!cursor.token_on_line()) {
    if (counts_on_one_line) return;
    if (!cursor.skip_to_token()) return;
  }
  TextCursor ahead = cursor;
  std::int64_t edges = 0;
  if (ahead.integer(edges) != Token::ok) return;
  if (!counts_on_one_line && ahead.token_on_line()) return;  // three numbers on a line: a vertex
  cursor.at = ahead.at;
}

}  // namespace

OffHeader parse_off_header(std::string_view content) {
  OffHeader header;
  TextCursor cursor{content.data(), content.data() + content.size()};
  if (!cursor.skip_to_token()) throw ItemError(Status::empty, "the file holds no data");
  const char* const first = cursor.at;
  bool dimensions = false;
  const bool keyword = read_keyword(cursor, header, dimensions);
  if (keyword && cursor.token_on_line()) {
    TextCursor ahead = cursor;
    if (text::same_word(ahead.word(), "binary")) {
      if (dimensions)
        throw ItemError(Status::unsupported_format, "nOFF: binary files of it are not supported");
      cursor.skip_line();
      header.binary = true;
      header.body = static_cast<std::size_t>(cursor.at - content.data());
      return header;
    }
  }
  if (!keyword && !text::is_digit(*first))
    text::fail_at(content, first, "neither OFF nor counts, but " + text::quoted(content, first));
  if (keyword && dimensions) read_dimensions(content, cursor, header);
  header.vertices = read_count(content, cursor, "vertices");
  const bool counts_on_one_line = cursor.token_on_line();
  header.faces = read_count(content, cursor, "faces");
  skip_edge_count(cursor, counts_on_one_line);
  header.body = static_cast<std::size_t>(cursor.at - content.data());
  return header;
}

OffVertexLayout off_vertex_layout(std::string_view content, const OffHeader& header) {
  OffVertexLayout layout;
  layout.positions = header.dimensions + (header.homogeneous ? 1 : 0);
  layout.normals = header.normals;
  layout.rest_of_line = header.colors || header.texture;
  TextCursor cursor{content.data() + header.body, content.data() + content.size()};
  if (header.vertices == 0 || !cursor.skip_to_token()) return layout;
  std::vector<double> line;
  double value = 0;
  while (cursor.token_on_line() && cursor.number(value) == Token::ok) line.push_back(value);
  const auto needed = static_cast<std::size_t>(layout.positions + (layout.normals ? 3 : 0));
  if (line.size() <= needed) return layout;
  if (layout.normals && header.colors) {
    const auto is_unit = [&](std::size_t at) {
      return std::abs(portable::hypot(line[at], line[at + 1], line[at + 2]) - 1) < 0.01;
    };
    const std::size_t last = line.size() - 3 - (header.texture && line.size() >= needed + 2 ? 2 : 0);
    const auto usual = static_cast<std::size_t>(layout.positions);
    if (!is_unit(usual) && is_unit(last)) layout.before_normal = static_cast<int>(last - usual);
  }
  if (!layout.rest_of_line) {
    // Colors that are not announced, or vertices that run over line ends: with colors every vertex has a
    // line of its own, so the next vertex lines are whole and there are enough lines.
    std::uint64_t lines = 1;
    bool whole_lines = true;
    while (cursor.skip_line(), cursor.skip_to_token()) {
      if (++lines > std::min<std::uint64_t>(header.vertices, 16)) continue;
      std::size_t numbers = 0;
      while (cursor.token_on_line() && cursor.number(value) == Token::ok) ++numbers;
      whole_lines = whole_lines && numbers >= needed;
    }
    layout.rest_of_line =
        whole_lines && (line.size() % needed != 0 || lines >= header.vertices + header.faces);
  }
  return layout;
}

}  // namespace meander
