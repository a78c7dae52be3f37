// Estimates of mesh sizes from 256 KiB of a file.
//
// Headers are believed where the size of the file agrees. Text is sampled: a file of up to 256 KiB is looked
// at whole, a larger one at its beginning and at one spot in each of equal strata, so that the share of the
// file that vertices and faces take is known to about one stratum.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "io/file/input_file.h"
#include "io/mesh/format_readers.h"
#include "io/mesh/off_header.h"
#include "io/mesh/ply_header.h"
#include "io/mesh/text_cursor.h"
#include "kernels/core/vector_instructions.h"

namespace meander {

namespace {

using text::TextCursor;
using text::Token;

constexpr std::uint64_t most_bytes = 256 << 10;
constexpr std::uint64_t head_bytes = 64 << 10;
constexpr std::uint64_t header_bytes = 4 << 10;  // enough for nearly every PLY header
constexpr std::size_t spots = 48;
constexpr std::size_t spot_bytes = (most_bytes - head_bytes) / spots;
// A section of a file may begin anywhere in a stratum, and objects may come in turns: sampled counts are
// raised so that they are rarely too small.
constexpr double sampling_margin = 1.2;

// Whole lines of a part of the file, and how many bytes of the file they stand for.
struct Stratum {
  std::string lines;
  double bytes = 0;
};

struct Peek {
  const ByteSource& file;
  std::string head;
  bool whole;  // the head is the file

  explicit Peek(const ByteSource& opened)
      : file(opened),
        head(opened.read(0, opened.bytes() <= most_bytes ? most_bytes : head_bytes)),
        whole(opened.bytes() <= most_bytes) {}

  std::vector<Stratum> strata() const {
    std::vector<Stratum> result;
    if (whole) return {{head, static_cast<double>(head.size())}};
    const std::size_t last = head.rfind('\n');
    if (last != std::string::npos)
      result.push_back({head.substr(0, last + 1), static_cast<double>(head.size())});
    const double width = static_cast<double>(file.bytes() - head_bytes) / spots;
    for (std::size_t s = 0; s < spots; ++s) {
      // Golden-ratio steps keep the spots out of step with anything periodic in the file.
      const double within = std::fmod(0.5 + 0.6180339887498949 * static_cast<double>(s), 1.0);
      const double room = std::max(0.0, width - static_cast<double>(spot_bytes));
      const auto offset =
          head_bytes + static_cast<std::uint64_t>(static_cast<double>(s) * width + within * room);
      const std::string bytes = file.read(offset, spot_bytes);
      const std::size_t first = bytes.find('\n'), end = bytes.rfind('\n');
      if (first != end) result.push_back({bytes.substr(first + 1, end - first), width});
    }
    return result;
  }
};

// Rows per kind as counted, raised to the whole file.
struct Rows {
  double vertices = 0, faces = 0, triangles = 0;

  void add(const Rows& other, double factor) {
    vertices += factor * other.vertices;
    faces += factor * other.faces;
    triangles += factor * other.triangles;
  }
};

// Sums count_lines over the strata; nothing when no line could be seen.
template <class CountLines>
std::optional<Rows> sampled(const Peek& peek, const CountLines& count_lines) {
  Rows total;
  double covered = 0;
  for (const Stratum& stratum : peek.strata()) {
    if (stratum.lines.empty()) continue;
    total.add(count_lines(std::string_view(stratum.lines)),
              stratum.bytes / static_cast<double>(stratum.lines.size()));
    covered += stratum.bytes;
  }
  if (covered == 0) return std::nullopt;
  const double scale = static_cast<double>(peek.file.bytes()) / covered;
  if (peek.whole) return total;
  Rows raised;
  raised.add(total, scale);
  return raised;
}

std::uint64_t rounded_up(double count) { return static_cast<std::uint64_t>(std::ceil(std::max(0.0, count))); }

double triangles_of(double corners) { return std::max(0.0, corners - 2); }

// Counts the tokens from the one that the cursor stands at to the end of its line or a comment, and moves
// there. Sixteen bytes at a time: faces are most of many files.
std::size_t tokens_on_line(TextCursor& cursor) {
  std::size_t tokens = 0;
  std::uint32_t after_separator = 1;
  const auto mask = [](__m128i bytes) { return static_cast<std::uint32_t>(_mm_movemask_epi8(bytes)); };
  for (; cursor.end - cursor.at >= 16; cursor.at += 16) {
    const __m128i bytes = _mm_loadu_si128(reinterpret_cast<const __m128i*>(cursor.at));
    const std::uint32_t separators = mask(_mm_cmpeq_epi8(_mm_min_epu8(bytes, _mm_set1_epi8(' ')), bytes));
    const std::uint32_t starts = ~separators & (separators << 1 | after_separator);
    std::uint32_t stops = mask(_mm_cmpeq_epi8(bytes, _mm_set1_epi8('\n')));
    if (cursor.hash_comments) stops |= mask(_mm_cmpeq_epi8(bytes, _mm_set1_epi8('#'))) & starts;
    // Bit 16 of the starts belongs to the next bytes.
    const int length = std::min(std::countr_zero(stops), 16);
    tokens += static_cast<std::size_t>(std::popcount(starts & ((1u << length) - 1)));
    if (stops != 0) {
      cursor.at += length;
      return tokens;
    }
    after_separator = separators >> 15;
  }
  if (after_separator == 0)
    while (cursor.at < cursor.end && !text::is_separator(*cursor.at)) ++cursor.at;
  for (; cursor.token_on_line(); ++tokens) cursor.word();
  return tokens;
}

Rows count_obj_lines(std::string_view lines) {
  Rows rows;
  TextCursor cursor{lines.data(), lines.data() + lines.size()};
  while (cursor.skip_to_token()) {
    const char first = *cursor.at;
    const bool single = cursor.at + 1 < cursor.end && text::is_separator(cursor.at[1]);
    if (first == 'v' && single) ++rows.vertices;
    if (first == 'f' && single) {
      ++rows.faces;
      // The keyword is a token too; a continued line is closed by its backslash.
      rows.triangles += triangles_of(static_cast<double>(tokens_on_line(cursor)) - 1);
    }
    cursor.skip_line();
  }
  return rows;
}

Rows count_stl_lines(std::string_view lines) {
  Rows rows;
  TextCursor cursor{lines.data(), lines.data() + lines.size(), false};
  for (std::string_view word = cursor.word(); !word.empty(); word = cursor.word())
    if (text::same_word(word, "vertex")) ++rows.vertices;
  rows.triangles = rows.faces = rows.vertices / 3;
  return rows;
}

// Faces of an OFF or PLY text: `before` numbers, then n >= 3 and n vertex numbers.
Rows count_polygon_lines(std::string_view lines, std::size_t before, bool hash_comments) {
  Rows rows;
  TextCursor cursor{lines.data(), lines.data() + lines.size(), hash_comments};
  while (cursor.skip_to_token()) {
    const char* const line_end = text::find_line_end(cursor.at, cursor.end);
    TextCursor line{cursor.at, line_end, hash_comments};
    cursor.at = line_end;
    for (std::size_t k = 0; k < before; ++k) line.word();
    std::int64_t corners = 0, number = 0;
    if (line.integer(corners) != Token::ok || corners < 3) continue;
    std::int64_t k = 0;
    while (k < corners && line.integer(number) == Token::ok) ++k;
    if (k < corners) continue;
    ++rows.faces;
    rows.triangles += static_cast<double>(corners - 2);
  }
  return rows;
}

MeshEstimate from_size(std::uint64_t bytes) { return {bytes, bytes / 6 + 1, bytes / 6 + 1}; }

// What the reader makes of a small file that is not laid out as expected.
MeshEstimate from_reader(const Peek& peek, MeshFormat format) {
  try {
    const PolygonMesh mesh = read_mesh(std::as_bytes(std::span(peek.head)), format);
    std::uint64_t triangles = 0;
    for (std::size_t p = 0; p < mesh.polygon_count(); ++p) {
      const std::uint32_t corners = mesh.polygon_begin[p + 1] - mesh.polygon_begin[p];
      triangles += corners < 3 ? 0 : corners - 2;
    }
    return {peek.file.bytes(), mesh.vertex_count(), triangles};
  } catch (const ItemError&) {
    return from_size(peek.file.bytes());
  }
}

// Vertex and face counts of a header, against faces seen in the text.
MeshEstimate from_counts(const Peek& peek, MeshFormat format, std::uint64_t vertices, std::uint64_t faces,
                         std::size_t before, bool hash_comments) {
  const std::uint64_t bytes = peek.file.bytes();
  vertices = std::min(vertices, bytes / 6 + 1);
  const std::optional<Rows> rows = sampled(
      peek, [&](std::string_view lines) { return count_polygon_lines(lines, before, hash_comments); });
  const bool seen = rows.has_value() && rows->faces > 0;
  if (peek.whole) {
    if (seen && static_cast<std::uint64_t>(rows->faces) == faces)
      return {bytes, vertices, static_cast<std::uint64_t>(rows->triangles)};
    return from_reader(peek, format);
  }
  if (!seen) return {bytes, vertices, std::min(2 * std::min(faces, bytes), bytes / 6 + 1)};
  const double there = std::min(static_cast<double>(faces), sampling_margin * rows->faces);
  const double each = rows->triangles / rows->faces;
  return {bytes, vertices, rounded_up(there * (each == 1 ? 1 : 1.1 * each))};
}

MeshEstimate peek_off(const Peek& peek) {
  const OffHeader header = parse_off_header(peek.head);
  if (!header.binary) return from_counts(peek, MeshFormat::off, header.vertices, header.faces, 0, true);
  const std::uint64_t front = header.body + 12;  // the counts are three words
  if (peek.file.bytes() < front) return from_size(peek.file.bytes());
  const std::uint64_t words = (peek.file.bytes() - front) / 4;
  const std::uint64_t words_per_vertex =
      3 + header.homogeneous + (header.normals ? 3 : 0) + (header.colours ? 4 : 0) + (header.texture ? 2 : 0);
  const auto big_endian = [&](std::size_t at) {
    std::uint64_t value = 0;
    for (std::size_t k = 0; k < 4; ++k)
      value = value << 8 | static_cast<unsigned char>(peek.head.at(header.body + at + k));
    return value;
  };
  const auto little_endian = [&](std::size_t at) {
    return std::uint64_t{__builtin_bswap32(static_cast<std::uint32_t>(big_endian(at)))};
  };
  const bool swapped = big_endian(0) > words / words_per_vertex;
  const std::uint64_t vertices =
      std::min(swapped ? little_endian(0) : big_endian(0), words / words_per_vertex);
  const std::uint64_t faces = swapped ? little_endian(4) : big_endian(4);
  const std::uint64_t left = words - vertices * words_per_vertex;  // words of faces
  // A face is its length, its corners and the number of its colour components.
  const std::uint64_t corners = left > 2 * faces ? left - 2 * faces : 0;
  // Less than triangles take: the file is cut, and polygons may be larger.
  return {peek.file.bytes(), vertices, left < 5 * faces ? left / 3 + 1 : corners - 2 * faces};
}

// Of the values of properties that are no coordinates, which the reader keeps beside the mesh.
std::uint64_t ply_attribute_bytes(std::uint64_t bytes, const PlyHeader& header) {
  std::uint64_t total = 0;
  for (const PlyElement& element : header.elements) {
    if (element.name != "vertex" && element.name != "face") continue;
    // A row has a byte a property at least, of text two.
    const std::uint64_t least = header.encoding == PlyEncoding::ascii ? 2 * element.properties.size()
                                                                      : std::uint64_t{element.fixed_bytes()};
    const std::uint64_t rows = least == 0 ? 0 : std::min(element.count, bytes / least);
    for (const PlyProperty& property : element.properties)
      if (property.is_list && property.name == "texcoord")
        // While the vector grows, and where both textures and coordinates want it; of text two bytes a
        // number.
        total += 3 * sizeof(float) *
                 (bytes / (header.encoding == PlyEncoding::ascii ? 2 : bytes_of(property.type)));
      else if (!property.is_list && property.name != "x" && property.name != "y" && property.name != "z")
        total += rows * sizeof(double);
  }
  return total;
}

// Binary: every size is known but the lists' lengths, and what the file holds beyond the rest is theirs.
MeshEstimate peek_binary_ply(std::uint64_t bytes, const PlyHeader& header) {
  std::uint64_t fixed = header.body, vertices = 0, faces = 0, lists = 0;
  const PlyElement* polygons = nullptr;
  for (const PlyElement& element : header.elements) {
    const std::uint64_t row = element.fixed_bytes();
    const std::uint64_t rows = row == 0 ? 0 : std::min(element.count, bytes / row);
    if (element.name == "vertex") vertices = rows;
    if (element.index_list() >= 0 && rows > 0) {
      polygons = &element;
      faces = rows;
    }
    if (rows > 0)
      lists += static_cast<std::uint64_t>(std::count_if(element.properties.begin(), element.properties.end(),
                                                        [](const PlyProperty& p) { return p.is_list; }));
    fixed += rows * row;
  }
  if (polygons == nullptr) return {bytes, vertices, 0};
  const std::size_t entry =
      bytes_of(polygons->properties[static_cast<std::size_t>(polygons->index_list())].type);
  if (lists == 1 && fixed < bytes) {
    const std::uint64_t corners = (bytes - fixed) / entry;
    if (polygons->name == "tristrips") return {bytes, vertices, corners};
    if (corners >= 3 * faces) return {bytes, vertices, corners - 2 * faces};
  }
  // Cut short, or with lists of texture coordinates beside: faces of three or four corners as far as there is
  // room.
  const std::uint64_t before = fixed - faces * polygons->fixed_bytes();
  const std::uint64_t room = bytes > before ? bytes - before : 0;
  return {bytes, vertices,
          std::min(lists == 1 ? faces : 2 * faces, room / (polygons->fixed_bytes() + 3 * entry) + 1)};
}

MeshEstimate peek_ply_mesh(const Peek& peek, const PlyHeader& header) {
  if (header.encoding != PlyEncoding::ascii) return peek_binary_ply(peek.file.bytes(), header);
  const PlyElement* const vertices = header.find("vertex");
  const PlyElement* const faces = header.find("face");
  const PlyElement* const strips = header.find("tristrips");
  const std::uint64_t count = vertices == nullptr ? 0 : vertices->count;
  if (strips != nullptr && strips->count > 0)
    return peek.whole ? from_reader(peek, MeshFormat::ply) : from_size(peek.file.bytes());
  const int list = faces == nullptr ? -1 : faces->index_list();
  if (list < 0 || faces->count == 0)
    return {peek.file.bytes(), std::min(count, peek.file.bytes() / 6 + 1), 0};
  return from_counts(peek, MeshFormat::ply, count, faces->count, static_cast<std::size_t>(list), false);
}

MeshEstimate with_attributes(MeshEstimate estimate, const PlyHeader& header) {
  estimate.decoding_bytes = ply_attribute_bytes(estimate.file_bytes, header);
  return estimate;
}

MeshEstimate peek_ply(const Peek& peek) {
  const PlyHeader header = parse_ply_header(peek.head);
  return with_attributes(peek_ply_mesh(peek, header), header);
}

MeshEstimate peek_stl(const Peek& peek) {
  const std::uint64_t bytes = peek.file.bytes();
  const auto of_facets = [&](std::uint64_t facets) { return MeshEstimate{bytes, 3 * facets, facets}; };
  if (bytes >= 84) {
    std::uint64_t stated = 0;
    for (std::size_t k = 4; k-- > 0;) stated = stated << 8 | static_cast<unsigned char>(peek.head[80 + k]);
    const std::uint64_t there = (bytes - 84) / 50;
    const bool exact = bytes == 84 + 50 * stated;
    if (exact || !looks_like_ascii_stl(peek.head))
      return of_facets(stated == 0 ? there : std::min(stated, there));
  }
  const std::optional<Rows> rows = sampled(peek, count_stl_lines);
  if (!rows) return of_facets(bytes / 30);
  // One kind of line throughout: only the lengths of numbers vary.
  return of_facets(rounded_up((peek.whole ? 1.0 : 1.05) * rows->triangles));
}

MeshEstimate peek_obj(const Peek& peek) {
  const std::optional<Rows> rows = sampled(peek, count_obj_lines);
  const std::uint64_t bytes = peek.file.bytes();
  if (peek.whole && rows && (rows->vertices == 0 || peek.head.find('\\') != std::string::npos))
    return from_reader(peek, MeshFormat::obj);
  if (!rows || rows->vertices == 0) return from_size(bytes);
  const double margin = peek.whole ? 1 : sampling_margin;
  return {bytes, rounded_up(margin * rows->vertices), rounded_up(margin * rows->triangles)};
}

// Binary PLY files are known by their header alone: most of a bulk run's bytes need not be looked at twice.
std::optional<PlyHeader> short_binary_header(const ByteSource& file) {
  try {
    PlyHeader header = parse_ply_header(file.read(0, header_bytes));
    if (header.encoding != PlyEncoding::ascii) return header;
  } catch (const ItemError&) {  // text, a longer header, or none at all
  }
  return std::nullopt;
}

}  // namespace

std::optional<MeshEstimate> most_in_file(std::uint64_t bytes, MeshFormat format) {
  if (format == MeshFormat::gltf) return std::nullopt;
  if (format == MeshFormat::stl)
    return MeshEstimate{bytes, 3 * (bytes / 30), bytes / 30};  // three vertices a facet
  // A polygon has fewer triangles than corners, and a corner or a coordinate takes a digit and a separator;
  // in binary PLY a byte.
  // There the values of all properties are kept, as doubles.
  if (format == MeshFormat::ply) return MeshEstimate{bytes, bytes, bytes, 0, sizeof(double) * bytes};
  return MeshEstimate{bytes, bytes / 2, bytes / 2};
}

MeshEstimate peek_mesh(const std::filesystem::path& path, MeshFormat format) {
  return peek_mesh(InputFile(path), format);
}

MeshEstimate peek_mesh(const ByteSource& file, MeshFormat format) {
  if (file.bytes() == 0) return {};
  if (format == MeshFormat::ply)
    if (const auto header = short_binary_header(file))
      return with_attributes(peek_binary_ply(file.bytes(), *header), *header);
  if (format == MeshFormat::gltf) return peek_gltf(file);
  Peek peek(file);
  const bool utf16 = peek.head.starts_with("\xFF\xFE") || peek.head.starts_with("\xFE\xFF");
  if (utf16) return peek.whole ? from_reader(peek, format) : from_size(file.bytes() / 2);
  if (format != MeshFormat::stl && peek.head.starts_with("\xEF\xBB\xBF")) peek.head.erase(0, 3);
  try {
    switch (format) {
      case MeshFormat::off:
        return peek_off(peek);
      case MeshFormat::obj:
        return peek_obj(peek);
      case MeshFormat::ply:
        return peek_ply(peek);
      case MeshFormat::stl:
        return peek_stl(peek);
      case MeshFormat::gltf:
        break;
    }
  } catch (const ItemError&) {
    // The header cannot be read: neither will the mesh be.
  }
  return from_size(file.bytes());
}

}  // namespace meander
