#include "io/mesh/ply_header.h"

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include "io/mesh/format_readers.h"
#include "io/mesh/mtl_reader.h"
#include "io/mesh/text_cursor.h"

namespace meander {

namespace {

// The words of one header line and where it is, for sentences about it.
struct Line {
  std::string_view content;
  const char* begin;
  text::TextCursor words;

  std::string_view next() { return words.word(); }
  [[noreturn]] void fail(const std::string& what) const { text::fail_at(content, begin, what); }
};

PlyType type_named(std::string_view word, const Line& line) {
  static constexpr std::array<std::pair<std::string_view, PlyType>, 18> names = {
      {{"char", PlyType::int8},
       {"int8", PlyType::int8},
       {"uchar", PlyType::uint8},
       {"uint8", PlyType::uint8},
       {"short", PlyType::int16},
       {"int16", PlyType::int16},
       {"ushort", PlyType::uint16},
       {"uint16", PlyType::uint16},
       {"int", PlyType::int32},
       {"int32", PlyType::int32},
       {"uint", PlyType::uint32},
       {"uint32", PlyType::uint32},
       {"int64", PlyType::int64},
       {"uint64", PlyType::uint64},
       {"float", PlyType::float32},
       {"float32", PlyType::float32},
       {"double", PlyType::float64},
       {"float64", PlyType::float64}}};
  for (const auto& [name, type] : names)
    if (text::same_word(word, name)) return type;
  line.fail("unknown type " + text::quoted(line.content, word.data()));
}

PlyEncoding parse_format(Line& line) {
  const std::string_view word = line.next();
  if (word == "ascii") return PlyEncoding::ascii;
  if (word == "binary_little_endian") return PlyEncoding::little_endian;
  if (word == "binary_big_endian") return PlyEncoding::big_endian;
  line.fail("unknown PLY format " + text::quoted(line.content, word.data()));
}

PlyElement parse_element(Line& line) {
  PlyElement element;
  element.name = line.next();
  std::int64_t count = 0;
  if (line.words.integer(count) != text::Token::ok || count < 0) line.fail("an element has no count");
  element.count = static_cast<std::uint64_t>(count);
  return element;
}

PlyProperty parse_property(Line& line) {
  PlyProperty property;
  std::string_view word = line.next();
  property.is_list = word == "list";
  if (property.is_list) {
    property.count_type = type_named(line.next(), line);
    word = line.next();
  }
  property.type = type_named(word, line);
  property.name = line.next();
  if (property.name.empty()) line.fail("a property has no name");
  return property;
}

constexpr std::size_t max_texture_files = 4096;

void take_texture_file(Line& line, PlyHeader& header) {
  if (!text::same_word(line.next(), "texturefile")) return;
  std::string_view name(line.words.at, static_cast<std::size_t>(line.words.end - line.words.at));
  name = trimmed(name);
  if (!name.empty() && header.texture_files.size() < max_texture_files)
    header.texture_files.emplace_back(name);
}

}  // namespace

bool PlyElement::has_lists() const {
  return std::any_of(properties.begin(), properties.end(), [](const PlyProperty& p) { return p.is_list; });
}

std::size_t PlyElement::fixed_bytes() const {
  std::size_t bytes = 0;
  for (const PlyProperty& p : properties) bytes += bytes_of(p.is_list ? p.count_type : p.type);
  return bytes;
}

int PlyElement::index_list() const {
  if (name != "face" && name != "tristrips") return -1;
  for (std::size_t p = 0; p < properties.size(); ++p)
    if (properties[p].is_list &&
        (properties[p].name == "vertex_indices" || properties[p].name == "vertex_index"))
      return static_cast<int>(p);
  return -1;
}

int PlyElement::scalar_named(std::string_view lower_case) const {
  int found = -1;
  for (std::size_t p = 0; p < properties.size(); ++p) {
    if (properties[p].is_list) continue;
    if (properties[p].name == lower_case) return static_cast<int>(p);
    if (found < 0 && text::same_word(properties[p].name, lower_case)) found = static_cast<int>(p);
  }
  return found;
}

const PlyElement* PlyHeader::find(std::string_view name) const {
  for (const PlyElement& element : elements)
    if (element.name == name) return &element;
  return nullptr;
}

PlyHeader parse_ply_header(std::string_view content) {
  PlyHeader header;
  const char* const end = content.data() + content.size();
  const char* at = content.data();
  const char* first_end = at;
  while (first_end < end && *first_end != '\n' && *first_end != '\r') ++first_end;
  if (text::TextCursor first{at, first_end, false}; first.word() != "ply")
    text::fail_at(content, at, "not a PLY file: it does not begin with `ply`");
  // Files of old Macintosh programs end lines in CR alone; behind the header they may be binary.
  const bool only_cr = first_end + 1 < end && *first_end == '\r' && first_end[1] != '\n';
  // Where every line ends in LF CR, the last CR is not the first byte of the rows.
  const bool lf_cr = first_end + 1 < end && *first_end == '\n' && first_end[1] == '\r';
  at = std::min(first_end + (only_cr || first_end == end || *first_end == '\n' ? 1 : 2), end);
  bool format = false;
  while (at < end) {
    const char* line_end = only_cr ? std::find(at, end, '\r') : text::find_line_end(at, end);
    Line line{content, at, {at, line_end, false}};
    at = line_end < end ? line_end + 1 : end;
    const std::string_view keyword = line.next();
    if (keyword == "format") {
      header.encoding = parse_format(line);
      format = true;
    } else if (keyword == "element") {
      header.elements.push_back(parse_element(line));
    } else if (keyword == "property") {
      if (header.elements.empty()) line.fail("a property before any element");
      header.elements.back().properties.push_back(parse_property(line));
    } else if (keyword == "comment") {
      take_texture_file(line, header);
    } else if (keyword == "end_header") {
      if (!format) line.fail("the header states no format");
      if (lf_cr && at < end && *at == '\r') ++at;
      header.body = static_cast<std::size_t>(at - content.data());
      return header;
    } else if (!keyword.empty() && keyword != "obj_info" && !header.elements.empty()) {
      // Before the first element nothing can be misread: an exporter of Blender puts its name there as it is.
      // Behind one, a line not understood may be a property whose loss would shift every row.
      line.fail("unknown keyword " + text::quoted(content, keyword.data()) + " in the header");
    }
  }
  text::fail_at(content, end, "the header has no end_header");
}

std::vector<std::string> ply_image_paths(std::span<const std::byte> bytes) {
  std::vector<std::string> paths;
  const DecodedText text(bytes);
  try {
    for (const std::string& name : parse_ply_header(text.text()).texture_files) {
      const std::string path = meant_path({}, name);
      if (!path.empty() && std::find(paths.begin(), paths.end(), path) == paths.end()) paths.push_back(path);
    }
  } catch (const ItemError&) {  // reading it says why
  }
  return paths;
}

}  // namespace meander
