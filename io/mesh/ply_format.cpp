// PLY: what is known of a file without reading its rows.
#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "io/mesh/format_readers.h"
#include "io/mesh/ply_rows.h"

namespace meander {

namespace {

constexpr std::uint64_t short_header_bytes = 4 << 10;  // enough for nearly every PLY header
constexpr std::size_t most_header = 64 << 10;

std::vector<FileAttribute> attributes_of_ply(const ByteSource& file) {
  std::string head = file.read(0, most_header);
  if (head.starts_with("\xEF\xBB\xBF")) head.erase(0, 3);
  const PlyHeader header = parse_ply_header(head);
  std::vector<FileAttribute> attributes;
  for (const char* const name : {"vertex", "face"}) {
    const PlyElement* const element = header.find(name);
    if (element == nullptr) continue;
    const bool of_faces = element->name == "face";
    const auto has = [&](std::string_view wanted) {
      return std::any_of(element->properties.begin(), element->properties.end(),
                         [&](const PlyProperty& p) { return !p.is_list && p.name == wanted; });
    };
    const bool normals = has("nx") && has("ny") && has("nz");
    for (const PlyProperty& property : element->properties) {
      const std::string& own = property.name;
      const bool is_place =
          own == "x" || own == "y" || own == "z" || (normals && (own == "nx" || own == "ny" || own == "nz"));
      if (property.is_list || (!of_faces && is_place)) continue;
      const bool integers = property.type != PlyType::float32 && property.type != PlyType::float64;
      // The first of several properties of one name counts.
      const auto same = [&](const FileAttribute& a) { return a.name == own && a.of_faces == of_faces; };
      if (std::none_of(attributes.begin(), attributes.end(), same))
        attributes.push_back({own, 1, integers, of_faces});
    }
  }
  return attributes;
}

LooksLike looks_like_ply(std::string_view head) {
  if (!(head.starts_with("ply\n") || head.starts_with("ply\r")) ||
      head.find("format ") == std::string_view::npos)
    return LooksLike::other;
  try {
    const PlyHeader header = parse_ply_header(head);
    const PlyElement* const faces = header.find("face");
    return faces == nullptr || faces->count == 0 ? LooksLike::points : LooksLike::mesh;
  } catch (const ItemError&) {
    return LooksLike::mesh;
  }
}

// The header of a binary PLY file is read with its CR line ends: a copy would damage the data behind it. A
// comment of a header may have one: what stands behind it is no line of the header.
bool keeps_cr(std::string_view content) {
  return content.substr(0, 64).find("ascii") == std::string_view::npos ||
         content.find('\n') != std::string_view::npos;
}

// The bytes of the properties, other than coordinates, that the reader keeps beside the mesh.
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

MeshEstimate peek_ply_mesh(const MeshPeek& peek, const PlyHeader& header) {
  if (header.encoding != PlyEncoding::ascii) return peek_binary_ply(peek.file.bytes(), header);
  const PlyElement* const vertices = header.find("vertex");
  const PlyElement* const faces = header.find("face");
  const PlyElement* const strips = header.find("tristrips");
  const std::uint64_t count = vertices == nullptr ? 0 : vertices->count;
  if (strips != nullptr && strips->count > 0)
    return peek.whole ? estimate_from_reader(peek) : estimate_from_size(peek.file.bytes());
  const int list = faces == nullptr ? -1 : faces->index_list();
  if (list < 0 || faces->count == 0)
    return {peek.file.bytes(), std::min(count, peek.file.bytes() / 6 + 1), 0};
  return estimate_from_counts(peek, count, faces->count, static_cast<std::size_t>(list), false);
}

MeshEstimate with_attributes(MeshEstimate estimate, const PlyHeader& header) {
  estimate.decoding_bytes = ply_attribute_bytes(estimate.file_bytes, header);
  return estimate;
}

MeshEstimate peek_ply(const MeshPeek& peek) {
  const PlyHeader header = parse_ply_header(peek.head);
  return with_attributes(peek_ply_mesh(peek, header), header);
}

// Binary PLY files are known by their header alone: most of a bulk run's bytes need not be looked at twice.
std::optional<PlyHeader> short_binary_header(const ByteSource& file) {
  try {
    PlyHeader header = parse_ply_header(file.read(0, short_header_bytes));
    if (header.encoding != PlyEncoding::ascii) return header;
  } catch (const ItemError&) {  // text, a longer header, or none at all
  }
  return std::nullopt;
}

std::optional<MeshEstimate> peek_short_header(const ByteSource& file) {
  const std::optional<PlyHeader> header = short_binary_header(file);
  if (!header) return std::nullopt;
  return with_attributes(peek_binary_ply(file.bytes(), *header), *header);
}

// In binary files a corner or a coordinate takes a byte, and the values of all properties are kept, as
// doubles.
MeshEstimate most_in_ply(std::uint64_t bytes) { return {bytes, bytes, bytes, 0, sizeof(double) * bytes}; }

}  // namespace

extern const FormatRow ply_format = {
    .called = "a PLY",
    .extensions = {".ply"},
    .read = read_ply,
    .keeps_line_ends = keeps_cr,
    .looks_like = looks_like_ply,
    .peek = peek_ply,
    .peek_file = peek_short_header,
    .most = most_in_ply,
    .color_companions = ply_image_paths,
    .attributes = attributes_of_ply,
};

}  // namespace meander
