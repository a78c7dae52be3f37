// STL, binary and ascii. The size decides which of the two: many binary files begin with "solid".
#include <algorithm>
#include <bit>
#include <limits>
#include <string>
#include <utility>

#include "io/mesh/byte_order.h"
#include "io/mesh/format_readers.h"
#include "io/mesh/text_cursor.h"
#include "kernels/core/parallel.h"

namespace meander {

namespace {

using text::TextCursor;
using text::Token;

constexpr std::size_t header_bytes = 84, facet_bytes = 50;
constexpr bool swap_bytes = std::endian::native == std::endian::big;  // STL is little-endian
constexpr std::size_t words_between_checks = std::size_t{1} << 18;

std::uint32_t stated_facets(std::string_view content) {
  return load<std::uint32_t>(content.data() + 80, swap_bytes);
}

// Programs that write while they compute leave 0 or -1 where the count belongs.
bool is_unknown(std::uint32_t count) { return count == 0 || count == 0xFFFFFFFFu; }

// Colors of facets in the two bytes that the format leaves for attributes: five bits a channel. Programs of
// Materialise (Magics) announce them by `COLOR=` and four bytes, red, green, blue and opacity of the whole,
// in the header; the top bit is clear where a facet has a color of its own, red in the lowest bits. VisCAM
// and SolidView set the top bit of facets with a color, blue in the lowest bits. Anything else is no color.
void read_colors(std::string_view content, PolygonMesh& mesh) {
  const std::size_t facets = mesh.polygon_count();
  const auto attribute = [&](std::size_t f) {
    return load<std::uint16_t>(content.data() + header_bytes + f * facet_bytes + 48, swap_bytes);
  };
  std::size_t marked = 0, unmarked = 0;
  for (std::size_t f = 0; f < facets; ++f) {
    marked += (attribute(f) & 0x8000) != 0;
    unmarked += attribute(f) != 0 && (attribute(f) & 0x8000) == 0;
  }
  constexpr std::string_view mark = "COLOR=";
  const std::size_t stated = content.substr(0, 80 - 4).find(mark);
  const bool is_magics = stated != std::string_view::npos;
  if (!is_magics)
    mesh.notes.add(Note::colors_ignored, "attributes of facets are no colours: the bit that says so is clear",
                   unmarked);
  if (!is_magics && marked == 0) return;
  std::vector<float>& colors = mesh.colors.face;
  colors.assign(3 * facets, no_color);
  for (std::size_t f = 0; f < facets; ++f) {
    const unsigned value = attribute(f);
    const bool is_marked = (value & 0x8000) != 0;
    for (unsigned k = 0; k < 3; ++k) {
      const unsigned shift = 5 * (is_magics ? k : 2 - k);
      const float own = static_cast<float>(value >> shift & 31) / 31;
      // Where no facet has any attribute, none has a color of its own.
      const bool has_own = is_magics ? !is_marked && (marked > 0 || unmarked > 0) : is_marked;
      if (has_own)
        colors[3 * f + k] = own;
      else if (is_magics)
        colors[3 * f + k] =
            static_cast<float>(static_cast<unsigned char>(content[stated + mark.size() + k])) / 255;
    }
  }
}

PolygonMesh read_binary(std::string_view content, const CancelToken& cancel, const BlockRule& rule,
                        bool colors) {
  const std::size_t there = (content.size() - header_bytes) / facet_bytes;
  const std::uint32_t stated = stated_facets(content);
  const std::size_t facets = is_unknown(stated) ? there : std::min<std::size_t>(there, stated);
  if (facets == 0 && stated == 0) throw ItemError(Status::empty, "the binary STL file states 0 facets");
  if (facets == 0)
    throw ItemError(Status::unreadable,
                    "the file ends before the first of " + std::to_string(stated) + " facets");
  PolygonMesh mesh;
  number_triangles(facets, mesh);
  for (std::vector<double>* const values : {&mesh.x, &mesh.y, &mesh.z}) values->resize(3 * facets);
  parallel_blocks(facets, std::max<std::size_t>(1, rule.block_bytes / facet_bytes),
                  [&](std::size_t begin, std::size_t end) {
                    cancel.check();
                    for (std::size_t f = begin; f < end; ++f) {
                      const char* const facet = content.data() + header_bytes + f * facet_bytes + 12;
                      for (std::size_t c = 0; c < 3; ++c) {
                        mesh.x[3 * f + c] = load<float>(facet + 12 * c, swap_bytes);
                        mesh.y[3 * f + c] = load<float>(facet + 12 * c + 4, swap_bytes);
                        mesh.z[3 * f + c] = load<float>(facet + 12 * c + 8, swap_bytes);
                      }
                    }
                  });
  if (!is_unknown(stated)) mesh.repairs[Repair::missing_faces] = saturated(stated - facets);
  mesh.repairs[Repair::extra_data] = saturated(content.size() - header_bytes - facets * facet_bytes);
  if (colors) read_colors(content, mesh);
  return mesh;
}

bool is_text(char c) { return (c >= ' ' && c <= '~') || c == '\n' || c == '\r' || c == '\t'; }

// Moves to the end of a line, whatever ends it: behind the # that a comment begins with.
void skip_comment(TextCursor& cursor) {
  while (cursor.at < cursor.end && *cursor.at != '\n' && *cursor.at != '\r') ++cursor.at;
}

// The facets of a text. A loop of more than three vertices (polygons do occur) becomes a fan; one of fewer
// keeps its number as a polygon without corners. Every facet has three vertices of its own, NaN where the
// file has none.
class AsciiReader {
 public:
  AsciiReader(std::string_view content, const CancelToken& cancel)
      : content_(content), cancel_(cancel), cursor_{content.data(), content.data() + content.size(), false} {
    // About 250 bytes a facet; vectors grow where a file is terser.
    const std::size_t facets = content.size() / 200;
    for (std::vector<double>* const values : {&mesh_.x, &mesh_.y, &mesh_.z}) values->reserve(3 * facets);
    part_.begin.reserve(facets + 1);
    part_.corners.reserve(3 * facets);
  }

  PolygonMesh read() {
    for (std::size_t words = 1; !cut_; ++words) {
      if (words % words_between_checks == 0) cancel_.check();
      const std::string_view word = cursor_.word();
      if (word.empty()) break;
      if (word.front() == '#') {
        skip_comment(cursor_);
      } else if (text::same_word(word, "vertex")) {
        read_vertex();
      } else if (text::same_word(word, "facet")) {
        end_facet(false);
        in_facet_ = true;
      } else if (text::same_word(word, "endfacet")) {
        end_facet(true);
      } else if (text::same_word(word, "endsolid")) {
        end_facet(true);
        skip_name();
      } else if (begins_solid(word)) {
        end_facet(true);
        skip_name();
        skip_header();
      }
      // Normals, outer, loop and endloop: nothing in them is needed.
    }
    cut_ = cut_ || in_facet_;
    if (in_facet_) drop_facet();
    return finish();
  }

 private:
  static bool begins_solid(std::string_view word) {
    return word.size() >= 5 && text::same_word(word.substr(0, 5), "solid");  // also "solidname"
  }

  // The name of a solid is any text up to the line's end, or up to a facet that begins on the same line.
  void skip_name() {
    // Kept: a file may have all its solids on one line.
    if (line_end_ < cursor_.at) line_end_ = text::find_line_end(cursor_.at, cursor_.end);
    const std::string_view name(cursor_.at, static_cast<std::size_t>(line_end_ - cursor_.at));
    const std::size_t facet = name.find("facet normal");
    cursor_.at = facet == std::string_view::npos ? line_end_ : cursor_.at + facet;
  }

  // Lines between a solid and its first facet: colors of CAE programs, comments.
  void skip_header() {
    for (;;) {
      TextCursor ahead = cursor_;
      const std::string_view word = ahead.word();
      if (word.empty() || is_body(word, ahead)) return;
      cursor_.skip_to_token();
      cursor_.skip_line();
    }
  }
  // Whether a line that begins with this word is of the facets.
  static bool is_body(std::string_view word, TextCursor behind) {
    double x = 0;
    if (text::same_word(word, "vertex")) return behind.token_on_line() && behind.number(x) == Token::ok;
    return text::same_word(word, "facet") || text::same_word(word, "outer") ||
           text::same_word(word, "endsolid") || begins_solid(word);
  }

  void read_vertex() {
    double x = 0, y = 0, z = 0;
    for (double* const value : {&x, &y, &z}) {
      const Token token = cursor_.number(*value);
      if (token == Token::ok) continue;
      // A number cut by the end of the file is not an error of the number.
      cut_ = token == Token::ended || text::find_line_end(cursor_.at, cursor_.end) == cursor_.end;
      if (cut_) {
        in_facet_ = true;
        return;
      }
      text::fail_at(content_, cursor_.at,
                    "a vertex needs three numbers, but there is " + text::quoted(content_, cursor_.at));
    }
    in_facet_ = true;
    if (loop_ >= 3) {
      const std::size_t first = mesh_.x.size() - 3, last = mesh_.x.size() - 1;
      close_triangle();
      copy_vertex(first);
      copy_vertex(last);
      loop_ = 2;
    }
    add_vertex(x, y, z);
    ++loop_;
    vertex_end_ = cursor_.at;
  }

  void add_vertex(double x, double y, double z) {
    mesh_.x.push_back(x);
    mesh_.y.push_back(y);
    mesh_.z.push_back(z);
  }
  void copy_vertex(std::size_t v) { add_vertex(mesh_.x[v], mesh_.y[v], mesh_.z[v]); }

  void close_triangle() {
    const std::size_t end = mesh_.x.size();
    for (std::size_t v = end - 3; v < end; ++v) part_.corners.push_back(static_cast<std::uint32_t>(v));
    part_.close_polygon();
  }

  // `ended`: by its own end word, not by the beginning of the next.
  void end_facet(bool ended) {
    if (!in_facet_) return;
    if (loop_ == 3) {
      close_triangle();
    } else if (loop_ > 0 || ended) {
      constexpr double nan_value = std::numeric_limits<double>::quiet_NaN();
      for (; loop_ < 3; ++loop_) add_vertex(nan_value, nan_value, nan_value);
      part_.close_polygon();
    }
    in_facet_ = false;
    loop_ = 0;
  }

  // The last facet of a file that is cut.
  void drop_facet() {
    if (loop_ == 3 && vertex_end_ != cursor_.end) {
      end_facet(true);  // nothing but its end words is missing
      return;
    }
    for (std::vector<double>* const values : {&mesh_.x, &mesh_.y, &mesh_.z})
      values->resize(values->size() - loop_);
    mesh_.repairs[Repair::missing_faces] = 1;
  }

  PolygonMesh finish() {
    if (part_.count() == 0 && cut_)
      text::fail_at(content_, cursor_.end, "the file ends before its first facet is complete");
    if (part_.count() == 0) throw ItemError(Status::empty, "the ascii STL file holds no facet");
    check_count(mesh_.x.size(), "vertices");
    std::vector<PolygonPart> parts;
    parts.push_back(std::move(part_));
    join_polygons(parts, mesh_);
    return std::move(mesh_);
  }

  std::string_view content_;
  const CancelToken& cancel_;
  TextCursor cursor_;
  PolygonMesh mesh_;
  PolygonPart part_;
  std::size_t loop_ = 0;              // vertices of the current triangle so far
  const char* line_end_ = nullptr;    // of the line that a solid was named on
  const char* vertex_end_ = nullptr;  // behind the last number read
  bool in_facet_ = false, cut_ = false;
};

bool is_binary(std::string_view content) { return is_exact_binary_stl(content, content.size()); }

// `solid`, then a facet or the end.
bool looks_like_ascii_stl(std::string_view content) {
  TextCursor cursor{content.data(), content.data() + content.size(), false};
  std::string_view first = cursor.word();
  for (; first.starts_with('#'); first = cursor.word()) skip_comment(cursor);
  if (text::same_word(first, "facet")) return true;
  if (first.size() < 5 || !text::same_word(first.substr(0, 5), "solid")) return false;
  // The name may be several words, and some programs put the first facet on its line.
  const std::string_view name(
      cursor.at, static_cast<std::size_t>(text::find_line_end(cursor.at, cursor.end) - cursor.at));
  const bool printable = name.find('\0') == std::string_view::npos;
  if (printable && name.find("facet normal") != std::string_view::npos) return true;
  // Other lines may stand before the first facet; binary files have NUL bytes there.
  bool any_line = false;
  for (cursor.skip_line(); cursor.skip_to_token(); cursor.skip_line()) {
    TextCursor ahead = cursor;
    const std::string_view word = ahead.word();
    if (text::same_word(word, "facet") || text::same_word(word, "endsolid")) return true;
    const std::string_view line(
        cursor.at, static_cast<std::size_t>(text::find_line_end(cursor.at, cursor.end) - cursor.at));
    if (!printable || line.find('\0') != std::string_view::npos) return false;
    any_line = true;
  }
  return !any_line && printable && name.size() < 256;
}

PolygonMesh read_stl(std::string_view content, const CancelToken& cancel, const BlockRule& rule,
                     const MeshSurroundings& around) {
  if (is_binary(content)) return read_binary(content, cancel, rule, around.colors);
  if (looks_like_ascii_stl(content)) return AsciiReader(content, cancel).read();
  const std::string_view head = content.substr(0, 512);
  if (std::all_of(head.begin(), head.end(), is_text))
    text::fail_at(content, content.data(), "neither a binary nor an ascii STL file");
  if (content.size() < header_bytes)
    throw ItemError(Status::unreadable, "byte " + std::to_string(content.size()) +
                                            ": the file ends in the header of a binary STL file");
  return read_binary(content, cancel, rule, around.colors);
}

LooksLike looks_like_stl(std::string_view head) {
  return head.size() > 5 && looks_like_ascii_stl(head) && head.find("vertex") != std::string_view::npos
             ? LooksLike::mesh
             : LooksLike::other;
}

ElementCounts count_stl_lines(std::string_view lines) {
  ElementCounts counts;
  TextCursor cursor{lines.data(), lines.data() + lines.size(), false};
  for (std::string_view word = cursor.word(); !word.empty(); word = cursor.word())
    if (text::same_word(word, "vertex")) ++counts.vertices;
  counts.triangles = counts.faces = counts.vertices / 3;
  return counts;
}

MeshEstimate peek_stl(const MeshPeek& peek) {
  const std::uint64_t bytes = peek.file.bytes();
  const auto of_facets = [&](std::uint64_t facets) { return MeshEstimate{bytes, 3 * facets, facets}; };
  if (bytes >= header_bytes) {
    const std::uint64_t stated = stated_facets(peek.head), there = (bytes - header_bytes) / facet_bytes;
    if (is_exact_binary_stl(peek.head, bytes) || !looks_like_ascii_stl(peek.head))
      return of_facets(stated == 0 ? there : std::min(stated, there));
  }
  const std::optional<ElementCounts> rows = sampled(peek, count_stl_lines);
  if (!rows) return of_facets(bytes / 30);
  // One kind of line throughout: only the lengths of numbers vary.
  return of_facets(rounded_up((peek.whole ? 1.0 : 1.05) * rows->triangles));
}

// Three vertices a facet, of a text that is as terse as can be.
MeshEstimate most_in_stl(std::uint64_t bytes) { return {bytes, 3 * (bytes / 30), bytes / 30}; }

}  // namespace

bool is_exact_binary_stl(std::string_view head, std::uint64_t bytes) {
  return head.size() >= header_bytes &&
         bytes == header_bytes + facet_bytes * std::uint64_t{stated_facets(head)};
}

extern const FormatRow stl_format = {
    .called = "an STL",
    .extensions = {".stl"},
    .read = read_stl,
    .is_raw = is_binary,
    .looks_like = looks_like_stl,
    .peek = peek_stl,
    .most = most_in_stl,
};

}  // namespace meander
