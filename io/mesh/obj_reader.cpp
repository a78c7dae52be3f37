// Wavefront OBJ: v, vn and f lines; everything else (lines, points, and unless they are asked for groups,
// materials and texture coordinates) is skipped, so that several objects become one mesh.
//
// The text is cut at line ends into blocks that are read on their own. An index counted backwards from the
// current line depends on how many vertices earlier blocks hold, so it is kept aside and resolved when blocks
// are joined.
#include <fmt/format.h>

#include <algorithm>
#include <array>
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
#include "io/mesh/obj_blocks.h"
#include "io/mesh/part_names.h"
#include "io/mesh/text_cursor.h"
#include "io/mesh/texture_images.h"
#include "kernels/core/parallel.h"

namespace meander {

namespace {

using text::TextCursor;

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
      : textures_(textures), images_(companions, cancel, textures, notes) {}

  // no_index for a material without an image.
  std::uint32_t of(const MtlMaterial& material) {
    if (!material.has_image) return no_index;
    const auto [at, is_new] = numbers_.try_emplace(&material, 0);
    if (!is_new) return at->second;
    at->second = static_cast<std::uint32_t>(textures_.textures.size());
    textures_.textures.push_back(material.texture);
    textures_.textures.back().image = images_.number_of(material.image, material.image);
    return at->second;
  }

 private:
  SurfaceTextures& textures_;
  FileImages images_;
  std::map<const MtlMaterial*, std::uint32_t> numbers_;
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
    // If a library is lost, its materials are not counted as missing too.
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

// Calls use(name) for the names that hold from a face on, as far as no other follows before the next face,
// and face() for each face.
template <class Use, class Face>
void for_each_face(const std::vector<ObjPart>& parts, const std::vector<std::size_t>& polygons,
                   std::vector<NameUse> ObjPart::*member, const Use& use, const Face& face) {
  for (std::size_t b = 0; b < parts.size(); ++b) {
    const std::vector<NameUse>& uses = parts[b].*member;
    std::size_t next = 0;
    for (std::size_t p = 0; p <= polygons[b]; ++p) {
      const std::size_t before = next;
      while (next < uses.size() && uses[next].polygon <= p) ++next;
      if (next > before) use(uses[next - 1].name);
      if (p < polygons[b]) face();
    }
  }
}

// Colors of vertices, polygons and blocks: a material holds until the next one is named.
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
  for_each_face(
      parts, polygons, &ObjPart::materials, [&](std::string_view name) { current.use(name); },
      [&] {
        colors.face.insert(colors.face.end(), current.color.begin(), current.color.end());
        if (extras.textures) textures->face.push_back(current.texture);
      });
  if (!textures->textures.empty()) colors.textures = std::move(textures);
  return colors;
}

// The colors of comments, where there is one for each vertex and no other.
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
  TextCursor cursor{line.data(), line.data() + line.size(), false};
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
  for_each_face(
      parts, polygons, member, [&](std::string_view use) { name = name_of(use); },
      [&] {
        if (name) {
          const auto [at, is_new] = numbers.try_emplace(*name, numbers.size());
          if (is_new) made.names.push_back(*name);
          number = static_cast<double>(at->second);
          name.reset();
        }
        made.values.push_back(number);
      });
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
  TextCursor cursor{content.data(), content.data() + content.size()};
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
    read_obj_block(starts[b], starts[b + 1], extras, parts[b]);
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
    if (mesh.colors.textures != nullptr)
      mesh.notes.add(Note::coordinates_missing, untextured_faces,
                     count_lacking_coordinates(mesh, *mesh.colors.textures));
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
