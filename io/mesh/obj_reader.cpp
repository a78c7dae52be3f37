// Wavefront OBJ: v, vn and f lines; everything else (lines, points, and unless they are asked for groups,
// materials and texture coordinates) is skipped, so that several objects become one mesh.
//
// The text is cut at line ends into blocks that are read on their own. An index counted backwards from the
// current line depends on how many vertices earlier blocks hold, so it is kept aside and resolved when blocks
// are joined.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "io/mesh/format_readers.h"
#include "io/mesh/line_blocks.h"
#include "io/mesh/mtl_reader.h"
#include "io/mesh/part_names.h"
#include "io/mesh/text_cursor.h"
#include "io/mesh/texture_images.h"
#include "kernels/core/parallel.h"

namespace meander {

namespace {

struct RelativeIndex {
  std::size_t position;  // in the index array of its part
  std::int64_t offset;   // added to the count of all earlier parts
};

// From this polygon of a part on: of a material, an object or groups.
struct NameUse {
  std::size_t polygon;
  std::string_view name;
};

// What is read beside positions, normals and faces.
struct ObjExtras {
  bool colors = false, textures = false;  // colours; textures of materials, which need coordinates
  bool keeps_coordinates = false;         // texture coordinates for their own sake
  bool groups = false, objects = false, materials = false;  // what faces belong to
  bool coordinates() const { return textures || keeps_coordinates; }
};

// Index numbers of one kind (vertices, normals or texture coordinates) that faces of a part name.
struct ObjPart {
  std::vector<double> x, y, z;
  std::vector<float> normals;
  std::vector<float> colors;       // three per vertex, where they are asked for
  std::vector<float> painted;      // the same, of comments `#MRGB`, for the vertices in their order
  std::vector<NameUse> materials;  // the same
  std::vector<NameUse> groups, objects;
  PolygonPart polygons;
  std::vector<std::uint32_t> corner_normals;      // for the first corners, as far as faces name normals
  std::vector<float> coordinates;                 // two per texture coordinate, where they are asked for
  std::vector<std::uint32_t> corner_coordinates;  // as corner_normals
  std::vector<RelativeIndex> relative_corners, relative_normals, relative_coordinates;
  std::uint64_t bad_faces = 0, free_forms = 0;
  const char* first_bad_face = nullptr;
  const char* bad_vertex = nullptr;  // the token that is not a number
  bool cut_vertex = false;           // the last line of the file ends in a vertex
  bool keywords = false;             // a line that only OBJ files have was seen
};

// In lower case, to be compared with letters alone: no other byte becomes one of them.
constexpr char folded(char c) { return static_cast<char>(c | 0x20); }

// A line end behind a backslash, and blanks, does not end the line.
bool is_continued(const char* line_end, const char* text_begin) {
  const char* p = line_end;
  while (p > text_begin && text::is_blank(p[-1])) --p;
  return p > text_begin && p[-1] == '\\';
}

class ObjBlockReader {
 public:
  ObjBlockReader(const char* begin, const char* end, ObjExtras extras, ObjPart& part)
      : at_(begin), end_(end), begin_(begin), extras_(extras), part_(part) {}

  void read() {
    while (at_ < end_ && part_.bad_vertex == nullptr) {
      while (at_ < end_ && text::is_separator(*at_)) ++at_;
      if (at_ == end_) return;
      const char after = at_ + 1 < end_ ? at_[1] : '\n';
      const char first = folded(*at_), second = folded(after);
      if (first == 'v' && text::is_separator(after)) {
        ++at_;
        read_vertex();
      } else if (first == 'f' && text::is_separator(after)) {
        ++at_;
        read_face();
        skip_logical_line();
      } else if (first == 'f' && second == 'o' && at_ + 2 < end_ && text::is_separator(at_[2])) {
        at_ += 2;  // a face before version 3.0 of the format
        read_face();
        skip_logical_line();
      } else if (first == 'v' && second == 'n' && at_ + 2 < end_ && text::is_blank(at_[2])) {
        at_ += 2;
        read_normal();
        skip_logical_line();
      } else if (extras_.coordinates() && first == 'v' && second == 't' && at_ + 2 < end_ &&
                 text::is_blank(at_[2])) {
        part_.keywords = true;
        at_ += 2;
        read_coordinate();
        skip_logical_line();
      } else {
        if (!part_.keywords) part_.keywords = is_keyword();
        part_.free_forms += is_free_form() ? 1 : 0;
        if ((extras_.colors || extras_.materials) && first == 'u') read_material();
        if (extras_.colors && *at_ == '#') read_painted();
        if ((extras_.objects || extras_.groups) && text::is_separator(after)) {
          if (extras_.objects && first == 'o') read_name(part_.objects);
          if (extras_.groups && first == 'g') read_name(part_.groups);
        }
        // Never continued: a comment or a material path may well end in a backslash.
        at_ = text::find_line_end(at_, end_);
      }
    }
  }

 private:
  // Moves to the next token of the logical line; false at its end.
  bool next_on_line() {
    for (; at_ < end_; ++at_) {
      if (*at_ == '\\') {
        const char* p = at_ + 1;
        while (p < end_ && text::is_blank(*p)) ++p;
        if (p == end_ || *p != '\n') return true;
        at_ = p;
      } else if (*at_ == '\n' || !text::is_separator(*at_)) {
        return *at_ != '\n' && *at_ != '#';
      }
    }
    return false;
  }

  void skip_logical_line() {
    // After most vertices and faces the line ends here: cheaper than a search that finds it at once.
    if (at_ == end_ || *at_ != '\n') at_ = text::find_line_end(at_, end_);
    while (at_ < end_ && is_continued(at_, begin_)) at_ = text::find_line_end(at_ + 1, end_);
  }

  bool read_number(double& value) {
    if (!next_on_line()) return false;
    const char* const next = text::parse_number(at_, end_, value);
    if (next == nullptr) return false;
    at_ = next;
    return true;
  }

  void read_vertex() {
    double x = 0, y = 0, z = 0;
    if (!read_number(x) || !read_number(y) || !read_number(z)) {
      // Only the last line of the file has no line end.
      part_.cut_vertex = text::find_line_end(at_, end_) == end_;
      if (part_.cut_vertex)
        at_ = end_;
      else
        part_.bad_vertex = at_;
      return;
    }
    part_.x.push_back(x);
    part_.y.push_back(y);
    part_.z.push_back(z);
    if (extras_.colors) read_color();
    skip_logical_line();
  }

  // Three numbers behind the position, or four with an opacity; a single one is a weight.
  void read_color() {
    std::array<double, 4> values{};
    std::size_t count = 0;
    while (count < values.size() && read_number(values[count])) ++count;
    for (std::size_t k = 0; k < 3; ++k)
      part_.colors.push_back(count >= 3 ? static_cast<float>(values[k])
                                        : std::numeric_limits<float>::quiet_NaN());
  }

  void read_material() {
    const char* const line_end = text::find_line_end(at_, end_);
    const std::string_view line(at_, static_cast<std::size_t>(line_end - at_));
    if (text::same_word(line.substr(0, 6), "usemtl") && (line.size() == 6 || text::is_separator(line[6])))
      part_.materials.push_back({part_.polygons.count(), trimmed(line.substr(6))});
  }

  // ZBrush keeps colours of vertices in comments: `#MRGB` and up to 64 times eight digits, mask, red, green
  // and blue.
  void read_painted() {
    const char* const line_end = text::find_line_end(at_, end_);
    const std::string_view line(at_, static_cast<std::size_t>(line_end - at_));
    if (!line.starts_with("#MRGB ")) return;
    const std::string_view digits = trimmed(line.substr(6));
    for (std::size_t at = 0; at + 8 <= digits.size(); at += 8) {
      std::uint32_t value = 0;
      const auto [stop, error] = std::from_chars(digits.data() + at, digits.data() + at + 8, value, 16);
      if (error != std::errc{} || stop != digits.data() + at + 8) return;
      for (const int shift : {16, 8, 0})
        part_.painted.push_back(static_cast<float>(value >> shift & 255u) / 255.0f);
    }
  }

  // What stands behind a keyword of one letter.
  void read_name(std::vector<NameUse>& uses) {
    const char* const line_end = text::find_line_end(at_ + 1, end_);
    const std::string_view name(at_ + 1, static_cast<std::size_t>(line_end - at_ - 1));
    uses.push_back({part_.polygons.count(), trimmed(name)});
  }

  // A normal that cannot be read stays in its place as zero: what uses it falls back to the geometric one.
  void read_normal() {
    double n[3] = {0, 0, 0};
    if (!read_number(n[0]) || !read_number(n[1]) || !read_number(n[2])) n[0] = n[1] = n[2] = 0;
    for (const double value : n) part_.normals.push_back(static_cast<float>(value));
  }

  // Of one to three numbers, of which the second is 0 where it is not given.
  void read_coordinate() {
    double u = 0, v = 0;
    if (!read_number(u)) u = std::numeric_limits<double>::quiet_NaN();
    if (!read_number(v)) v = 0;
    part_.coordinates.push_back(static_cast<float>(u));
    part_.coordinates.push_back(static_cast<float>(v));
  }

  static std::uint32_t resolve(std::int64_t number, std::size_t count, std::size_t position,
                               std::vector<RelativeIndex>& relative) {
    if (number > 0) return text::to_index(number - 1);
    if (number < 0) relative.push_back({position, static_cast<std::int64_t>(count) + number});
    return no_index;
  }

  // a, a/b, a//c or a/b/c, where b may be missing.
  bool read_corner() {
    std::int64_t vertex = 0, texture = 0, normal = 0;
    const char* p = text::parse_digits(at_, end_, vertex);
    if (p == nullptr) return false;
    if (p < end_ && *p == '/') {
      ++p;
      const bool is_given = p < end_ && *p != '/';
      if (const char* const q = is_given ? text::parse_digits(p, end_, texture) : nullptr) p = q;
      if (p < end_ && *p == '/') {
        ++p;
        if (const char* const q = text::parse_digits(p, end_, normal)) p = q;
      }
    }
    if (p < end_ && !text::is_separator(*p)) {
      if (*p == '.' || text::lower(*p) == 'e') p = text::parse_whole_number(at_, end_, vertex);
      if (p == nullptr) return false;
      if (p < end_ && !text::is_separator(*p) && *p != '#' && *p != '\\') return false;
    }
    at_ = p;
    std::vector<std::uint32_t>& corners = part_.polygons.corners;
    if (normal != 0) {
      part_.corner_normals.resize(corners.size(), no_index);
      part_.corner_normals.push_back(
          resolve(normal, part_.normals.size() / 3, corners.size(), part_.relative_normals));
    }
    if (texture != 0 && extras_.coordinates()) {
      part_.corner_coordinates.resize(corners.size(), no_index);
      part_.corner_coordinates.push_back(
          resolve(texture, part_.coordinates.size() / 2, corners.size(), part_.relative_coordinates));
    }
    corners.push_back(resolve(vertex, part_.x.size(), corners.size(), part_.relative_corners));
    return true;
  }

  void read_face() {
    const char* const start = at_;
    const std::size_t normals = part_.corner_normals.size();
    const std::size_t coordinates = part_.corner_coordinates.size();
    while (next_on_line()) {
      if (read_corner()) continue;
      part_.polygons.give_up_polygon();
      const std::size_t kept = part_.polygons.corners.size();
      part_.corner_normals.resize(normals);  // a face that cannot be read names none
      part_.corner_coordinates.resize(coordinates);
      for (std::vector<RelativeIndex>* const list :
           {&part_.relative_corners, &part_.relative_normals, &part_.relative_coordinates})
        while (!list->empty() && list->back().position >= kept) list->pop_back();
      if (part_.bad_faces++ == 0) part_.first_bad_face = start;
      return;
    }
    part_.polygons.close_polygon();
  }

  std::string_view word() const {
    const char* p = at_;
    while (p < end_ && !text::is_separator(*p)) ++p;
    return {at_, static_cast<std::size_t>(p - at_)};
  }

  // A surface that is no polygon: of version 3.0 of the format, or a patch of those before.
  bool is_free_form() const {
    if (*at_ != 's' && *at_ != 'b' && *at_ != 'c') return false;
    const std::string_view word = this->word();
    for (const std::string_view known : {"surf", "bzp", "bsp", "cdc", "cdp"})
      if (word == known) return true;
    return false;
  }

  bool is_keyword() const {
    if (*at_ == '#') return true;
    const std::string_view word = this->word();
    for (const std::string_view known : {"vt", "vp", "l", "p", "o", "g", "s", "mtllib", "usemtl", "v", "vn"})
      if (text::same_word(word, known)) return true;
    return false;
  }

  const char* at_;
  const char* end_;
  const char* begin_;
  ObjExtras extras_;
  ObjPart& part_;
};

// Where the vertices, normals, corners and texture coordinates of each part begin in the mesh.
struct Offsets {
  std::uint64_t vertices = 0, normals = 0, corners = 0, coordinates = 0;
};

std::vector<Offsets> offsets_of(const std::vector<ObjPart>& parts) {
  std::vector<Offsets> offsets(parts.size() + 1);
  for (std::size_t b = 0; b < parts.size(); ++b)
    offsets[b + 1] = {offsets[b].vertices + parts[b].x.size(),
                      offsets[b].normals + parts[b].normals.size() / 3,
                      offsets[b].corners + parts[b].polygons.corners.size(),
                      offsets[b].coordinates + parts[b].coordinates.size() / 2};
  check_count(offsets.back().vertices, "vertices");
  check_count(offsets.back().normals, "normals");
  check_count(offsets.back().corners, "corners");
  check_count(offsets.back().coordinates, "texture coordinates");
  return offsets;
}

void resolve_relative(std::vector<RelativeIndex>& list, std::uint64_t base, std::uint32_t* indices) {
  for (const RelativeIndex& index : list)
    indices[index.position] = text::to_index(static_cast<std::int64_t>(base) + index.offset);
  list = {};
}

template <class T>
void move_part(std::vector<T>& part, std::size_t parts, std::uint64_t at, std::vector<T>& whole) {
  if (parts == 1)
    whole = std::move(part);
  else
    std::copy(part.begin(), part.end(), whole.begin() + static_cast<std::ptrdiff_t>(at));
  part = {};
}

void drop_out_of_range(std::uint32_t* begin, std::uint32_t* end, std::uint64_t count) {
  for (std::uint32_t* index = begin; index != end; ++index)
    if (*index >= count) *index = no_index;
}

PolygonMesh join_parts(std::vector<ObjPart>& parts, const std::vector<Offsets>& offsets, std::size_t bytes,
                       std::size_t block) {
  const Offsets total = offsets.back();
  const bool normals =
      std::any_of(parts.begin(), parts.end(), [](const ObjPart& p) { return !p.corner_normals.empty(); });
  PolygonMesh mesh;
  std::vector<PolygonPart> polygons;
  for (ObjPart& part : parts) polygons.push_back(std::move(part.polygons));
  join_polygons(polygons, mesh);
  if (parts.size() > 1)
    for (std::vector<double>* const values : {&mesh.x, &mesh.y, &mesh.z}) values->resize(total.vertices);
  if (normals && parts.size() > 1) mesh.normals.resize(3 * total.normals);
  if (normals) mesh.corner_normals.resize(total.corners, no_index);
  parallel_blocks(bytes, block, [&](std::size_t begin, std::size_t) {
    const std::size_t b = begin / block;
    ObjPart& part = parts[b];
    move_part(part.x, parts.size(), offsets[b].vertices, mesh.x);
    move_part(part.y, parts.size(), offsets[b].vertices, mesh.y);
    move_part(part.z, parts.size(), offsets[b].vertices, mesh.z);
    std::uint32_t* const corners = mesh.corners.data() + offsets[b].corners;
    resolve_relative(part.relative_corners, offsets[b].vertices, corners);
    drop_out_of_range(corners, mesh.corners.data() + offsets[b + 1].corners, total.vertices);
    if (!normals) return;
    move_part(part.normals, parts.size(), 3 * offsets[b].normals, mesh.normals);
    std::uint32_t* const corner_normals = mesh.corner_normals.data() + offsets[b].corners;
    std::copy(part.corner_normals.begin(), part.corner_normals.end(), corner_normals);
    resolve_relative(part.relative_normals, offsets[b].normals, corner_normals);
    drop_out_of_range(corner_normals, mesh.corner_normals.data() + offsets[b + 1].corners, total.normals);
  });
  return mesh;
}

// Coordinates of all corners, as far as faces name them.
CornerCoordinates join_coordinates(std::vector<ObjPart>& parts, const std::vector<Offsets>& offsets) {
  CornerCoordinates joined;
  joined.corner.resize(offsets.back().corners, no_index);
  joined.values.reserve(2 * offsets.back().coordinates);
  for (std::size_t b = 0; b < parts.size(); ++b) {
    ObjPart& part = parts[b];
    joined.values.insert(joined.values.end(), part.coordinates.begin(), part.coordinates.end());
    std::uint32_t* const corners = joined.corner.data() + offsets[b].corners;
    std::copy(part.corner_coordinates.begin(), part.corner_coordinates.end(), corners);
    resolve_relative(part.relative_coordinates, offsets[b].coordinates, corners);
    part.coordinates = {};
    part.corner_coordinates = {};
  }
  // Others would be found to be none when they are looked up; a file may name those that follow.
  drop_out_of_range(joined.corner.data(), joined.corner.data() + joined.corner.size(),
                    offsets.back().coordinates);
  return joined;
}

// The textures of materials, each once; their images are read when the first polygon has one.
class MaterialTextures {
 public:
  MaterialTextures(std::span<const CompanionFile> companions, const CancelToken& cancel,
                   SurfaceTextures& textures, Notes& notes)
      : companions_(companions), cancel_(cancel), textures_(textures), notes_(notes) {}

  // no_index for a material without an image.
  std::uint32_t of(const MtlMaterial& material) {
    if (!material.has_image) return no_index;
    const auto [at, is_new] = numbers_.try_emplace(&material, 0);
    if (!is_new) return at->second;
    at->second = static_cast<std::uint32_t>(textures_.textures.size());
    textures_.textures.push_back(material.texture);
    textures_.textures.back().image = image(material.image);
    return at->second;
  }

 private:
  std::uint32_t image(const std::string& path) {
    const auto [at, is_new] = images_.try_emplace(path, static_cast<std::uint32_t>(textures_.images.size()));
    if (is_new) {
      textures_.images.push_back(image_of_file(companions_, path, cancel_));
      note_lost_image(textures_.images.back(), path, notes_);
    }
    return at->second;
  }

  std::span<const CompanionFile> companions_;
  const CancelToken& cancel_;
  SurfaceTextures& textures_;
  Notes& notes_;
  std::map<const MtlMaterial*, std::uint32_t> numbers_;
  std::map<std::string, std::uint32_t> images_;
};

// What a polygon of this material has; where it has an image, the factor of the image. By the format the two
// are multiplied, but programs write black where the image is all that they mean.
std::array<float, 3> face_color(const MtlMaterial& material) {
  const bool is_black = material.color == std::array<float, 3>{0, 0, 0};
  return material.has_image && is_black ? no_material_color : material.color;
}

// What stands in front of the faces of an OBJ file: the material of the faces that follow.
class CurrentMaterial {
 public:
  CurrentMaterial(const MtlMaterials& materials, MaterialTextures& images, Notes& notes)
      : materials_(materials), images_(images), notes_(notes) {}

  void use(std::string_view name) {
    const MtlMaterial* const material = materials_.find(name);
    // Of a library that is lost, the materials are not missed beside it.
    const bool is_missed = materials_.any_read || !materials_.notes.any();
    if (material == nullptr && is_missed && missing_.insert(name).second)
      notes_.add(Note::material_missing, fmt::format("no library has the material `{}`", name));
    take(material);
  }
  // Where a file names no material at all.
  void assume(const std::pair<const std::string, MtlMaterial>& only) {
    notes_.add(Note::material_assumed,
               fmt::format("faces name no material and take `{}`, the only one of the library", only.first));
    take(&only.second);
  }

  std::array<float, 3> color = no_material_color;
  std::uint32_t texture = no_index;

 private:
  void take(const MtlMaterial* material) {
    color = material == nullptr ? no_material_color : face_color(*material);
    texture = material == nullptr ? no_index : images_.of(*material);
  }

  const MtlMaterials& materials_;
  MaterialTextures& images_;
  Notes& notes_;
  std::set<std::string_view> missing_;
};

// Colours of vertices, polygons and blocks: a material holds until the next one is named.
SurfaceColors join_colors(std::vector<ObjPart>& parts, const std::vector<std::size_t>& polygons,
                          const MtlMaterials& materials, ObjExtras extras, CornerCoordinates coordinates,
                          std::span<const CompanionFile> companions, const CancelToken& cancel,
                          Notes& notes) {
  SurfaceColors colors;
  for (ObjPart& part : parts) {
    colors.vertex.insert(colors.vertex.end(), part.colors.begin(), part.colors.end());
    part.colors = {};
  }
  if (std::none_of(colors.vertex.begin(), colors.vertex.end(), [](float v) { return v == v; }))
    colors.vertex = {};
  scale_colors(colors.vertex, ColorNumbers::real);
  const bool names_any =
      std::any_of(parts.begin(), parts.end(), [](const ObjPart& p) { return !p.materials.empty(); });
  if (companions.empty() && !names_any) return colors;
  colors.of_materials = true;
  auto textures = std::make_shared<SurfaceTextures>();
  textures->coordinates = std::move(coordinates.values);
  textures->corner = std::move(coordinates.corner);
  MaterialTextures images(companions, cancel, *textures, notes);
  CurrentMaterial current(materials, images, notes);
  if (!names_any && materials.only() != nullptr) current.assume(*materials.only());
  if (!names_any && materials.by_name.size() > 1)
    notes.add(Note::material_missing,
              fmt::format("faces name no material, and the libraries have {}", materials.by_name.size()));
  for (std::size_t b = 0; b < parts.size(); ++b) {
    const std::vector<NameUse>& uses = parts[b].materials;
    std::size_t next = 0;
    for (std::size_t p = 0; p < polygons[b]; ++p) {
      for (; next < uses.size() && uses[next].polygon <= p; ++next) {
        const bool is_last = next + 1 == uses.size() || uses[next + 1].polygon > p;
        if (is_last) current.use(uses[next].name);
      }
      colors.face.insert(colors.face.end(), current.color.begin(), current.color.end());
      if (extras.textures) textures->face.push_back(current.texture);
    }
    if (next < uses.size()) current.use(uses.back().name);
  }
  if (!textures->textures.empty()) colors.textures = std::move(textures);
  return colors;
}

// Textured faces of which a corner has no texture coordinates.
void note_lacking_coordinates(const PolygonMesh& mesh, Notes& notes) {
  const SurfaceTextures* const textures = mesh.colors.textures.get();
  if (textures == nullptr) return;
  std::uint64_t lacking = 0;
  for (std::size_t p = 0; p < textures->face.size(); ++p) {
    if (textures->face[p] == no_index) continue;
    for (std::uint32_t c = mesh.polygon_begin[p]; c < mesh.polygon_begin[p + 1]; ++c)
      if (textures->corner[c] == no_index) {
        ++lacking;
        break;
      }
  }
  notes.add(Note::coordinates_missing, "textured faces without texture coordinates", lacking);
}

// The colours of comments, where there is one for each vertex and no other.
void add_painted_colors(std::vector<ObjPart>& parts, PolygonMesh& mesh) {
  std::vector<float> painted;
  for (ObjPart& part : parts) {
    painted.insert(painted.end(), part.painted.begin(), part.painted.end());
    part.painted = {};
  }
  if (painted.empty() || !mesh.colors.vertex.empty()) return;
  if (painted.size() == 3 * mesh.vertex_count())
    mesh.colors.vertex = std::move(painted);
  else
    mesh.notes.add(Note::colors_ignored, "`#MRGB` has " + std::to_string(painted.size() / 3) +
                                             " colours for " + std::to_string(mesh.vertex_count()) +
                                             " vertices");
}

// All names of a line, apart by one blank.
std::string group_names(std::string_view line) {
  std::string names;
  text::TextCursor cursor{line.data(), line.data() + line.size(), false};
  while (cursor.skip_to_token()) {
    if (!names.empty()) names += ' ';
    names += cursor.word();
  }
  return names.empty() ? "default" : names;
}

// Faces by the names that hold until the next one does. `before` is the name of those before the first.
NumberedFaces number_faces(const std::vector<ObjPart>& parts, const std::vector<std::size_t>& polygons,
                           std::vector<NameUse> ObjPart::*member, std::string (*name_of)(std::string_view),
                           std::optional<std::string> before) {
  NumberedFaces made;
  if (std::all_of(parts.begin(), parts.end(), [&](const ObjPart& part) { return (part.*member).empty(); }))
    return made;
  std::map<std::string, std::size_t> numbers;
  std::optional<std::string> name = std::move(before);  // until a face has asked for its number
  double number = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t b = 0; b < parts.size(); ++b) {
    const std::vector<NameUse>& uses = parts[b].*member;
    std::size_t next = 0;
    for (std::size_t p = 0; p < polygons[b]; ++p) {
      for (; next < uses.size() && uses[next].polygon <= p; ++next) name = name_of(uses[next].name);
      if (name) {
        const auto [at, is_new] = numbers.try_emplace(*name, numbers.size());
        if (is_new) made.names.push_back(*name);
        number = static_cast<double>(at->second);
        name.reset();
      }
      made.values.push_back(number);
    }
    if (next < uses.size()) name = name_of(uses.back().name);
  }
  return made;
}

void add_numbers(const std::vector<ObjPart>& parts, const std::vector<std::size_t>& polygons,
                 const ObjExtras& extras, PolygonMesh& mesh) {
  const auto whole_line = [](std::string_view line) { return std::string(line); };
  NumberedAttributes numbered(mesh);
  if (extras.groups)
    numbered.add("group", number_faces(parts, polygons, &ObjPart::groups, group_names, "default"));
  if (extras.materials)
    numbered.add("material", number_faces(parts, polygons, &ObjPart::materials, whole_line, std::nullopt));
  if (extras.objects)
    numbered.add("object", number_faces(parts, polygons, &ObjPart::objects, whole_line, std::nullopt));
  numbered.finish();
}

// Errors of the file as a whole, reported at the earliest place whatever the blocks.
void check_parts(std::string_view content, const std::vector<ObjPart>& parts) {
  std::uint64_t faces = 0, bad_faces = 0, vertices = 0;
  bool keywords = false;
  const char* first_bad_face = nullptr;
  for (const ObjPart& part : parts) {
    if (part.bad_vertex != nullptr)
      text::fail_at(content, part.bad_vertex,
                    "a vertex needs three numbers, but there is " + text::quoted(content, part.bad_vertex));
    faces += part.polygons.count();
    bad_faces += part.bad_faces;
    vertices += part.x.size();
    keywords = keywords || part.keywords;
    if (first_bad_face == nullptr) first_bad_face = part.first_bad_face;
  }
  if (faces > 0 && bad_faces == faces)
    text::fail_at(content, first_bad_face, "this face cannot be read, nor any other");
  if (faces > 0) return;
  if (vertices > 0)
    throw ItemError(Status::empty, "the file holds " + std::to_string(vertices) + " vertices and no face");
  text::TextCursor cursor{content.data(), content.data() + content.size()};
  if (!keywords && cursor.skip_to_token())
    text::fail_at(content, cursor.at, "not a line of an OBJ file: " + text::quoted(content, cursor.at));
  throw ItemError(Status::empty, "the file holds no vertex and no face");
}

}  // namespace

PolygonMesh read_obj(std::string_view content, const CancelToken& cancel, const BlockRule& rule,
                     const MeshSurroundings& around) {
  if (content.empty()) throw ItemError(Status::empty, "the file holds no data");
  const std::size_t block = rule.block_of(content.size());
  const std::vector<const char*> starts = text::split_lines(
      content, block, [&](const char* line_end) { return is_continued(line_end, content.data()); });
  std::vector<ObjPart> parts(starts.size() - 1);
  const MtlMaterials materials = around.colors ? read_materials(around.companions) : MtlMaterials();
  const ObjExtras extras = {around.colors,
                            std::any_of(materials.by_name.begin(), materials.by_name.end(),
                                        [](const auto& material) { return material.second.has_image; }),
                            around.extras.coordinates,
                            asks_for(around.extras.attributes, "group"),
                            asks_for(around.extras.attributes, "object"),
                            asks_for(around.extras.attributes, "material")};
  parallel_blocks(content.size(), block, [&](std::size_t begin, std::size_t) {
    cancel.check();
    const std::size_t b = begin / block;
    ObjBlockReader(starts[b], starts[b + 1], extras, parts[b]).read();
  });
  check_parts(content, parts);
  // The last line is in the last part that has one: those behind it are empty where it is longer than they
  // are.
  const bool cut = std::any_of(parts.begin(), parts.end(), [](const ObjPart& p) { return p.cut_vertex; });
  std::vector<std::size_t> polygons;
  for (const ObjPart& part : parts) polygons.push_back(part.polygons.count());
  const std::vector<Offsets> offsets = offsets_of(parts);
  PolygonMesh mesh = join_parts(parts, offsets, content.size(), block);
  CornerCoordinates coordinates;
  if (extras.coordinates()) coordinates = join_coordinates(parts, offsets);
  if (extras.keeps_coordinates && !coordinates.values.empty()) mesh.coordinates = coordinates;
  if (!extras.textures) coordinates = {};
  if (around.colors) {
    mesh.notes = materials.notes;
    mesh.colors = join_colors(parts, polygons, materials, extras, std::move(coordinates), around.companions,
                              cancel, mesh.notes);
    note_lacking_coordinates(mesh, mesh.notes);
    add_painted_colors(parts, mesh);
  }
  add_numbers(parts, polygons, extras, mesh);
  if (cut) mesh.repairs[Repair::missing_vertices] = 1;
  std::uint64_t free_forms = 0;
  for (const ObjPart& part : parts) free_forms += part.free_forms;
  mesh.notes.add(Note::feature_ignored, "free-form surfaces (`surf`) are not read", free_forms);
  return mesh;
}

}  // namespace meander
