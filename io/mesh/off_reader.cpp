// OFF as Geomview documents it and as files in the wild have it.
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "io/mesh/byte_order.h"
#include "io/mesh/format_readers.h"
#include "io/mesh/line_blocks.h"
#include "io/mesh/off_header.h"
#include "io/mesh/text_cursor.h"

namespace meander {

namespace {

using text::TextCursor;
using text::Token;

// points: faces are not read and need not be there; coordinates are finite, and where no face is promised
// nothing follows the vertices.
enum class Wanted : std::uint8_t { mesh, points };

// Whether the header promises what is wanted.
void check_promise(std::uint64_t vertices, std::uint64_t faces, Wanted wanted) {
  if (wanted == Wanted::points && vertices == 0)
    throw ItemError(Status::empty, "the header promises no vertex");
  if (wanted == Wanted::mesh && faces == 0)
    throw ItemError(Status::empty,
                    "the header promises " + std::to_string(vertices) + " vertices and no face");
}

void make_vertices(PolygonMesh& mesh, std::size_t count, bool normals) {
  mesh.x.resize(count);
  mesh.y.resize(count);
  mesh.z.resize(count);
  if (normals) mesh.normals.resize(3 * count);
}

// How the colors of the faces of a file are written. Rows may be read at the same time.
struct ColorTokens {
  std::atomic<bool> any_real{false};           // one has a point or an exponent
  std::atomic<std::uint64_t> of_color_map{0};  // faces with the number of an entry in a map of colors
  std::atomic<std::uint64_t> odd{0};           // faces with two numbers, or more than four
};

// The color at the end of a row: three numbers, or four with an opacity. Any other count is none, one number
// being an index into a map of colors. `behind`: numbers that follow the color.
void read_color(TextCursor& cursor, std::size_t behind, float* color, ColorTokens* tokens) {
  std::array<double, 6> values{};
  std::size_t count = 0;
  bool any_real = false;
  while (count < values.size() && cursor.token_on_line()) {
    const char* const first = cursor.at;
    if (cursor.number(values[count]) != Token::ok) break;
    any_real =
        any_real || std::any_of(first, cursor.at, [](char c) { return c == '.' || c == 'e' || c == 'E'; });
    ++count;
  }
  count -= std::min(count, behind);
  if (tokens != nullptr && count == 1) tokens->of_color_map.fetch_add(1, std::memory_order_relaxed);
  if (tokens != nullptr && (count == 2 || count > 4)) tokens->odd.fetch_add(1, std::memory_order_relaxed);
  if (count != 3 && count != 4) return;
  if (tokens != nullptr && any_real) tokens->any_real.store(true, std::memory_order_relaxed);
  for (std::size_t k = 0; k < 3; ++k) color[k] = static_cast<float>(values[k]);
}

// `faces`: what the numbers of the colors of faces are.
void finish_colors(PolygonMesh& mesh, ColorNumbers faces, std::uint64_t of_color_map) {
  mesh.colors.face.resize(3 * mesh.polygon_count(), no_color);
  for (std::vector<float>* const values : {&mesh.colors.vertex, &mesh.colors.face})
    if (std::all_of(values->begin(), values->end(), [](float value) { return std::isnan(value); }))
      *values = {};
  scale_colors(mesh.colors.vertex, ColorNumbers::real);
  scale_colors(mesh.colors.face, faces);
  mesh.notes.add(Note::color_map_ignored,
                 "colours of faces are entries of a colour map, which is no part of the file", of_color_map);
}

// A reader of the rows of one text file. Rows of different vertices may be read at the same time.
struct OffRows {
  OffVertexLayout layout;
  PolygonMesh& mesh;
  Wanted wanted;
  bool colors = false;            // into mesh.colors, which has room for all of them
  std::size_t behind_color = 0;   // numbers of a texture coordinate
  ColorTokens* tokens = nullptr;  // of faces, with colors
  int dimensions = 3;

  bool acceptable(std::size_t v) const {
    return wanted == Wanted::mesh ||
           (std::isfinite(mesh.x[v]) && std::isfinite(mesh.y[v]) && std::isfinite(mesh.z[v]));
  }

  Token vertex(TextCursor& cursor, std::size_t v) const {
    std::array<double, 3> position{};
    auto& [x, y, z] = position;
    for (int k = 0; k < dimensions; ++k)
      if (const Token token = cursor.number(position[static_cast<std::size_t>(k)]); token != Token::ok)
        return token;
    if (layout.positions > dimensions) {
      double w = 1;
      if (const Token token = cursor.number(w); token != Token::ok) return token;
      x /= w;
      y /= w;
      z /= w;
    }
    mesh.x[v] = x;
    mesh.y[v] = y;
    mesh.z[v] = z;
    if (layout.normals) {
      double value = 0;
      for (int k = 0; k < layout.before_normal; ++k) {
        if (const Token token = cursor.number(value); token != Token::ok) return token;
        if (colors && k < 3 && layout.before_normal >= 3)
          mesh.colors.vertex[3 * v + static_cast<std::size_t>(k)] = static_cast<float>(value);
      }
      for (std::size_t k = 0; k < 3; ++k) {
        if (const Token token = cursor.number(value); token != Token::ok) return token;
        mesh.normals[3 * v + k] = static_cast<float>(value);
      }
    }
    if (colors && layout.rest_of_line && layout.before_normal == 0)
      read_color(cursor, behind_color, mesh.colors.vertex.data() + 3 * v, nullptr);
    if (layout.rest_of_line) cursor.skip_line();
    return Token::ok;
  }

  // A face whose numbers are written with points and exponents, as by programs that have one format for all.
  // Its line has to hold three corners or more: a vertex too many is no face. Moves behind the last corner.
  static bool real_face(TextCursor& cursor, PolygonPart& part) {
    const std::size_t before = part.corners.size();
    TextCursor line = cursor;
    const auto read = [&](std::int64_t& value) {
      const char* const next =
          line.token_on_line() ? text::parse_whole_number(line.at, line.end, value) : nullptr;
      if (next != nullptr) line.at = next;
      return next != nullptr;
    };
    std::int64_t count = 0, number = 0;
    bool is_face = read(count) && count >= 3;
    for (std::int64_t c = 0; is_face && c < count; ++c) {
      is_face = read(number);
      if (is_face) part.corners.push_back(text::to_index(number));
    }
    if (is_face)
      cursor = line;
    else
      part.corners.resize(before);
    return is_face;
  }

  // bad: the polygon is there without corners, and its line is skipped. ended: nothing was added.
  // color: three numbers that stay as they are without one, or null.
  Token face(TextCursor& cursor, PolygonPart& part, float* color) const {
    std::int64_t count = 0, number = 0;
    TextCursor start = cursor;
    const std::size_t before = part.corners.size();
    Token token = cursor.length(count);
    for (std::int64_t c = 0; token == Token::ok && c < count; ++c) {
      token = cursor.integer(number);
      if (token == Token::ok) part.corners.push_back(text::to_index(number));
    }
    if (token == Token::bad) {
      part.corners.resize(before);
      if (real_face(start, part)) {
        cursor = start;
        token = Token::ok;
      }
    }
    if (token == Token::ok) part.close_polygon();
    if (token == Token::bad) part.give_up_polygon();
    if (token == Token::ended) part.corners.resize(part.begin.back());
    if (color != nullptr && token == Token::ok) read_color(cursor, 0, color, tokens);
    cursor.skip_line();
    return token;
  }
};

// Every vertex and every face on a line of its own and none missing: the usual large file. False: read in
// order.
bool read_lines(std::string_view body, const OffHeader& header, const OffRows& rows, std::size_t block_bytes,
                const CancelToken& cancel) {
  std::vector<PolygonPart> parts;
  const auto row = [&](std::size_t block, std::uint64_t ordinal, TextCursor line) {
    if (ordinal >= header.vertices)
      return rows.wanted == Wanted::points ||
             rows.face(line, parts[block],
                       rows.colors ? rows.mesh.colors.face.data() + 3 * (ordinal - header.vertices)
                                   : nullptr) == Token::ok;
    return rows.vertex(line, ordinal) == Token::ok && !line.token_on_line() && rows.acceptable(ordinal);
  };
  if (!text::for_each_line(
          body, header.vertices + header.faces, true, block_bytes, cancel,
          [&](std::size_t blocks) { parts.resize(blocks); }, row))
    return false;
  join_polygons(parts, rows.mesh);
  return true;
}

void read_vertices(std::string_view content, TextCursor& cursor, const OffHeader& header, const OffRows& rows,
                   const CancelToken& cancel) {
  // A number too many or too few would shift all that follows. Numbers may stand on any lines, but where each
  // vertex ended its line, the next one does, too.
  bool end_lines = true;
  for (std::size_t v = 0; v < header.vertices; ++v) {
    if (v % rows_between_checks == 0) cancel.check();
    cursor.skip_to_token();
    const char* const start = cursor.at;
    const Token token = rows.vertex(cursor, v);
    if (token == Token::ok && !rows.acceptable(v))
      throw ItemError(Status::non_finite, "line " + std::to_string(text::line_of(content, start)) + ": " +
                                              not_finite(v, header.vertices));
    if (token == Token::ok && (rows.layout.rest_of_line || !end_lines || !cursor.token_on_line())) continue;
    if (token == Token::ok && v == 0) {
      end_lines = false;
      continue;
    }
    const std::string which = "vertex " + std::to_string(v) + " of " + std::to_string(header.vertices);
    if (token == Token::ended) text::fail_at(content, cursor.end, "the file ends in " + which);
    if (token == Token::ok)
      text::fail_at(
          content, cursor.at,
          text::quoted(content, cursor.at) + " follows " + which +
              " on its line, where all before it end theirs: a number or a vertex too many or too few");
    text::fail_at(content, cursor.at, which + ": " + text::quoted(content, cursor.at) + " is not a number");
  }
}

void read_faces(std::string_view content, TextCursor& cursor, const OffHeader& header, const OffRows& rows,
                const CancelToken& cancel) {
  PolygonMesh& mesh = rows.mesh;
  std::vector<PolygonPart> parts(1);
  PolygonPart& part = parts[0];
  const auto bytes = static_cast<std::uint64_t>(cursor.end - cursor.at);
  part.begin.reserve(std::min(header.faces, bytes / 2) + 1);
  part.corners.reserve(std::min(3 * std::min(header.faces, bytes), bytes / 2));
  cursor.skip_to_token();
  const char* const first = cursor.at;
  const char* first_bad = nullptr;
  std::uint64_t bad = 0;
  bool cut = false;  // in a face that is not there then
  while (part.count() < header.faces) {
    if (part.count() % rows_between_checks == 0) cancel.check();
    if (!cursor.skip_to_token()) break;
    const char* const start = cursor.at;
    float* const color = rows.colors ? mesh.colors.face.data() + 3 * part.count() : nullptr;
    const Token token = rows.face(cursor, part, color);
    cut = token == Token::ended;
    if (cut) break;
    if (token == Token::bad && bad++ == 0) first_bad = start;
  }
  // Without a line end behind it and with faces missing, the last face was probably cut in the middle of a
  // number.
  if (!cut && part.count() < header.faces && part.count() > 0 && cursor.at == cursor.end &&
      !text::is_separator(content.back())) {
    part.begin.pop_back();
    part.corners.resize(part.begin.back());
  }
  if (part.count() == 0)
    text::fail_at(content, cursor.end,
                  "the file ends before the first of " + std::to_string(header.faces) + " faces");
  if (bad >= part.count())
    text::fail_at(content, first_bad, text::quoted(content, first_bad) + " does not begin a face");
  mesh.repairs[Repair::missing_faces] = saturated(header.faces - part.count());
  if (cursor.skip_to_token()) {
    if (first_bad == first)
      text::fail_at(content, first_bad,
                    text::quoted(content, first_bad) +
                        " does not begin a face, and more lines than the header promises follow: the file "
                        "has more than " +
                        std::to_string(header.vertices) + " vertices");
    mesh.repairs[Repair::extra_data] = saturated(static_cast<std::uint64_t>(cursor.end - cursor.at));
  }
  join_polygons(parts, mesh);
}

PolygonMesh read_text(std::string_view content, const OffHeader& header, Wanted wanted,
                      const CancelToken& cancel, const BlockRule& rule, bool colors = false) {
  const std::string_view body = content.substr(header.body);
  PolygonMesh mesh;
  ColorTokens tokens;
  OffRows rows{off_vertex_layout(content, header), mesh,    wanted,           colors,
               header.texture ? 2u : 0u,           &tokens, header.dimensions};
  // A number and a separator take two bytes.
  const auto numbers = static_cast<std::uint64_t>(rows.layout.positions + (rows.layout.normals ? 3 : 0));
  if (header.vertices > (body.size() + 1) / 2 / numbers)
    throw ItemError(Status::unreadable, "the header promises " + std::to_string(header.vertices) +
                                            " vertices, but only " + std::to_string(body.size()) +
                                            " bytes follow it");
  check_count(header.vertices, "vertices");
  check_promise(header.vertices, header.faces, wanted);
  make_vertices(mesh, header.vertices, rows.layout.normals);
  const auto make_room = [&] {
    // A face takes two bytes.
    mesh.colors.vertex.assign(3 * header.vertices, no_color);
    mesh.colors.face.assign(3 * (std::min<std::uint64_t>(header.faces, body.size()) + 1), no_color);
    tokens.any_real = false;
    tokens.of_color_map = 0;
    tokens.odd = 0;
  };
  const auto finish = [&] {
    if (colors)
      finish_colors(mesh, tokens.any_real ? ColorNumbers::real : ColorNumbers::whole, tokens.of_color_map);
    mesh.notes.add(Note::colors_ignored, "colours of faces are not three or four numbers", tokens.odd);
  };
  if (colors) make_room();
  if (body.size() >= rule.parallel_from && header.faces <= body.size() &&
      read_lines(body, header, rows, rule.block_bytes, cancel)) {
    finish();
    return mesh;
  }
  if (colors) make_room();
  TextCursor cursor{body.data(), body.data() + body.size()};
  read_vertices(content, cursor, header, rows, cancel);
  if (wanted == Wanted::points) {
    // With faces, a vertex too few would take numbers of the first face.
    if (header.faces == 0 ? cursor.skip_to_token() : !rows.layout.rest_of_line && cursor.token_on_line())
      text::fail_at(content, cursor.at,
                    text::quoted(content, cursor.at) + " follows the " + std::to_string(header.vertices) +
                        " vertices that the header promises");
    return mesh;
  }
  read_faces(content, cursor, header, rows, cancel);
  finish();
  return mesh;
}

constexpr bool is_little_endian = std::endian::native == std::endian::little;

std::size_t words_per_vertex(const OffHeader& header) {
  return (header.homogeneous ? 4u : 3u) + (header.normals ? 3u : 0u) + (header.colors ? 4u : 0u) +
         (header.texture ? 2u : 0u);
}

// Binary: 32-bit words, big-endian as documented; some programs write little-endian. The counts decide which.
struct BinaryOff {
  std::string_view content;
  std::size_t at;
  bool swap;

  std::size_t words_left() const { return (content.size() - at) / 4; }
  template <class T>
  T word() {
    const T value = load<T>(content.data() + at, swap);
    at += 4;
    return value;
  }
};

bool plausible_counts(BinaryOff file, std::size_t words) {
  const auto vertices = file.word<std::int32_t>(), faces = file.word<std::int32_t>();
  file.word<std::int32_t>();
  return vertices >= 0 && faces >= 0 && static_cast<std::size_t>(vertices) <= file.words_left() / words;
}

// colors: three numbers for each face that stay as they are without a color, or null. Returns the number of
// faces whose color is an entry of a map.
std::uint64_t read_binary_faces(BinaryOff& file, std::size_t faces, PolygonMesh& mesh, float* colors,
                                const CancelToken& cancel) {
  std::vector<PolygonPart> parts(1);
  PolygonPart& part = parts[0];
  part.begin.reserve(std::min(faces, file.words_left() / 2) + 1);
  part.corners.reserve(std::min(3 * faces, file.words_left()));
  std::uint64_t of_color_map = 0;
  while (part.count() < faces && file.words_left() >= 2) {
    if (part.count() % rows_between_checks == 0) cancel.check();
    const auto count = file.word<std::int32_t>();
    if (count < 0 || static_cast<std::size_t>(count) + 1 > file.words_left()) break;
    for (std::int32_t c = 0; c < count; ++c)
      part.corners.push_back(text::to_index(file.word<std::int32_t>()));
    part.close_polygon();
    const auto numbers = file.word<std::int32_t>();
    if (numbers < 0 || static_cast<std::size_t>(numbers) > file.words_left()) {
      file.at = file.content.size();
      break;
    }
    of_color_map += numbers == 1;
    const std::size_t next = file.at + 4 * static_cast<std::size_t>(numbers);
    if (colors != nullptr && (numbers == 3 || numbers == 4))
      for (std::size_t k = 0; k < 3; ++k) colors[3 * (part.count() - 1) + k] = file.word<float>();
    file.at = next;
  }
  if (part.count() == 0)
    throw ItemError(Status::unreadable, "byte " + std::to_string(file.at) + ": none of " +
                                            std::to_string(faces) + " faces can be read");
  mesh.repairs[Repair::missing_faces] = saturated(faces - part.count());
  if (part.count() == faces) mesh.repairs[Repair::extra_data] = saturated(file.content.size() - file.at);
  join_polygons(parts, mesh);
  return of_color_map;
}

PolygonMesh read_binary(std::string_view content, const OffHeader& header, Wanted wanted,
                        const CancelToken& cancel, bool colors = false) {
  const std::size_t words = words_per_vertex(header);
  BinaryOff file{content, header.body, is_little_endian};
  if (file.words_left() < 3)
    throw ItemError(Status::unreadable,
                    "byte " + std::to_string(content.size()) + ": the file ends in the counts");
  if (!plausible_counts(file, words)) file.swap = !file.swap;
  if (!plausible_counts(file, words))
    throw ItemError(Status::unreadable, "byte " + std::to_string(file.at) +
                                            ": the counts of the binary file do not fit its size");
  const auto vertices = static_cast<std::size_t>(file.word<std::int32_t>());
  const auto faces = static_cast<std::size_t>(file.word<std::int32_t>());
  file.word<std::int32_t>();
  check_promise(vertices, faces, wanted);
  PolygonMesh mesh;
  make_vertices(mesh, vertices, header.normals);
  if (colors) {
    mesh.colors.vertex.assign(header.colors ? 3 * vertices : 0, no_color);
    // A face takes two words.
    mesh.colors.face.assign(3 * (std::min(faces, file.words_left() / 2) + 1), no_color);
  }
  for (std::size_t v = 0; v < vertices; ++v) {
    if (v % rows_between_checks == 0) cancel.check();
    mesh.x[v] = file.word<float>();
    mesh.y[v] = file.word<float>();
    mesh.z[v] = file.word<float>();
    if (header.homogeneous) {
      const double w = file.word<float>();
      mesh.x[v] /= w;
      mesh.y[v] /= w;
      mesh.z[v] /= w;
    }
    for (std::size_t k = 0; header.normals && k < 3; ++k) mesh.normals[3 * v + k] = file.word<float>();
    const std::size_t next = file.at + 4 * ((header.colors ? 4 : 0) + (header.texture ? 2 : 0));
    for (std::size_t k = 0; colors && header.colors && k < 3; ++k)
      mesh.colors.vertex[3 * v + k] = file.word<float>();
    file.at = next;
  }
  if (wanted == Wanted::points) {
    for (std::size_t v = 0; v < vertices; ++v)
      if (!std::isfinite(mesh.x[v]) || !std::isfinite(mesh.y[v]) || !std::isfinite(mesh.z[v]))
        throw ItemError(Status::non_finite, not_finite(v, vertices));
    const std::string_view rest = content.substr(file.at);
    if (faces == 0 && !std::all_of(rest.begin(), rest.end(), text::is_separator))
      throw ItemError(Status::unreadable, "byte " + std::to_string(file.at) + ": data follow the " +
                                              std::to_string(vertices) +
                                              " vertices that the header promises");
    return mesh;
  }
  const std::uint64_t of_color_map =
      read_binary_faces(file, faces, mesh, colors ? mesh.colors.face.data() : nullptr, cancel);
  if (colors) finish_colors(mesh, ColorNumbers::real, of_color_map);
  return mesh;
}

PolygonMesh read_off(std::string_view content, const CancelToken& cancel, const BlockRule& rule,
                     const MeshSurroundings& around) {
  const OffHeader header = parse_off_header(content);
  return header.binary ? read_binary(content, header, Wanted::mesh, cancel, around.colors)
                       : read_text(content, header, Wanted::mesh, cancel, rule, around.colors);
}

// A file without keyword is of numbers, which are of anything.
LooksLike looks_like_off(std::string_view head) try {
  TextCursor cursor{head.data(), head.data() + head.size()};
  if (!cursor.skip_to_token() || text::is_digit(*cursor.at)) return LooksLike::other;
  const OffHeader header = parse_off_header(head);
  if (header.body == 0) return LooksLike::other;
  return header.binary || header.faces > 0 ? LooksLike::mesh : LooksLike::points;
} catch (const ItemError&) {
  return LooksLike::other;
}

MeshEstimate peek_off(const MeshPeek& peek) {
  const OffHeader header = parse_off_header(peek.head);
  if (!header.binary) return estimate_from_counts(peek, header.vertices, header.faces, 0, true);
  const std::uint64_t front = header.body + 12;  // the counts are three words
  if (std::min<std::uint64_t>(peek.file.bytes(), peek.head.size()) < front)
    return estimate_from_size(peek.file.bytes());
  const std::uint64_t words = (peek.file.bytes() - front) / 4,
                      most_vertices = words / words_per_vertex(header);
  const auto count = [&](std::size_t at, bool swap) {
    return std::uint64_t{load<std::uint32_t>(peek.head.data() + header.body + at, swap)};
  };
  const bool swap = (count(0, is_little_endian) > most_vertices) != is_little_endian;
  const std::uint64_t vertices = std::min(count(0, swap), most_vertices), faces = count(4, swap);
  const std::uint64_t left = words - vertices * words_per_vertex(header);  // words of faces
  // A face is its length, its corners and the number of its color components.
  const std::uint64_t corners = left > 2 * faces ? left - 2 * faces : 0;
  // Less than triangles take: the file is cut, and polygons may be larger.
  return {peek.file.bytes(), vertices, left < 5 * faces ? left / 3 + 1 : corners - 2 * faces};
}

}  // namespace

PolygonMesh read_off_vertices(std::string_view content, const CancelToken& cancel, const BlockRule& rule) {
  const OffHeader header = parse_off_header(content);
  return header.binary ? read_binary(content, header, Wanted::points, cancel)
                       : read_text(content, header, Wanted::points, cancel, rule);
}

extern const FormatRow off_format = {
    .called = "an OFF",
    .extensions = {".off"},
    .read = read_off,
    .looks_like = looks_like_off,
    .peek = peek_off,
    .most = most_in_text,
};

}  // namespace meander
