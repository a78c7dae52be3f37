// glTF 2.0, as JSON with buffers beside it and as one binary file (GLB): all meshes of the scene where it
// puts them, as one mesh.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <optional>
#include <tuple>
#include <utility>

#include "io/mesh/format_readers.h"
#include "io/mesh/gltf_data.h"
#include "io/mesh/gltf_document.h"
#include "io/mesh/gltf_draco.h"
#include "io/mesh/gltf_extensions.h"
#include "io/mesh/gltf_textures.h"
#include "io/mesh/part_names.h"
#include "io/mesh/text_cursor.h"

namespace meander {

namespace {

constexpr std::uint32_t joints_per_set = 4;
constexpr std::size_t vertices_between_checks = 65536;
// Files may hold more inverse bind matrices than a skin has joints, but they are no place for data.
constexpr std::uint64_t most_spare_matrices = 65536;

// The vertices of a primitive before they are placed.
struct VertexValues {
  std::span<const double> positions;                     // three each
  std::vector<std::span<const double>> joints, weights;  // sets of four each
  std::vector<std::vector<double>> kept;                 // what is not kept elsewhere
  std::size_t count() const { return positions.size() / 3; }
  std::span<const double> keep(std::vector<double> values) {
    kept.push_back(std::move(values));
    return kept.back();
  }
};

// Where a mesh stands: that of its node, and inside it that of an instance.
struct Placement {
  std::uint32_t node = no_index, mesh = 0;
  AffineMap world = identity_map, instance = identity_map;
  bool is_instance = false;
};

// Morph targets that are not at 0: the accessor of what they add to positions, and their weight.
using ActiveTargets = std::vector<std::pair<std::uint32_t, double>>;

// Vertices in the mesh. Of a skin, vertices whose joints turn space inside out are marked one by one.
struct VertexBlock {
  std::uint32_t first = 0, count = 0;
  bool is_mirrored = false;
  std::vector<bool> mirrored;

  bool mirrors(std::uint32_t vertex) const {
    return mirrored.empty() ? is_mirrored : vertex < count && mirrored[vertex];
  }
};

double determinant(const AffineMap& m) {
  return m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) +
         m[2] * (m[4] * m[9] - m[5] * m[8]);
}

// The corners of triangle t of a list, strip or fan, as positions in its list of corners.
std::array<std::size_t, 3> triangle_corners(std::uint32_t mode, std::size_t t) {
  if (mode == 4) return {3 * t, 3 * t + 1, 3 * t + 2};
  if (mode == 5) return {t, t + 1 + t % 2, t + 2 - t % 2};
  return {t + 1, t + 2, 0};
}

// Strips or fans as a list of triangles, where the largest number of the type of indices stands between them:
// the format forbids it, programs that draw begin anew behind it.
std::vector<std::uint32_t> listed_triangles(std::uint32_t mode, std::span<const std::uint32_t> indices,
                                            std::uint32_t restart) {
  std::vector<std::uint32_t> listed;
  for (std::size_t begin = 0; begin < indices.size();) {
    const auto end = static_cast<std::size_t>(
        std::find(indices.begin() + static_cast<std::ptrdiff_t>(begin), indices.end(), restart) -
        indices.begin());
    for (std::size_t t = 0; t + 2 < end - begin; ++t)
      for (const std::size_t place : triangle_corners(mode, t)) listed.push_back(indices[begin + place]);
    begin = end + 1;
  }
  return listed;
}

bool has_textures(const GltfDocument& document) {
  return std::any_of(document.materials.begin(), document.materials.end(),
                     [](const GltfMaterial& material) { return material.has_texture; });
}

// Whether one of numbered_attributes is asked for.
bool asks_for_numbers(const MeshExtras& extras) {
  return std::any_of(numbered_attributes.begin(), numbered_attributes.end(),
                     [&](std::string_view name) { return asks_for(extras.attributes, name); });
}

// The number of parts of a scene that count_scene has counted: below 2^24.
std::size_t count_parts(const GltfDocument& document, const GltfScene& scene) {
  std::uint64_t parts = 0;
  for (std::uint32_t node = 0; node < document.nodes.size(); ++node) {
    const std::uint32_t mesh = document.nodes[node].mesh;
    if (scene.copies[node] == 0 || mesh == no_index) continue;
    parts += scene.copies[node] * count_instances(document, node) * document.meshes[mesh].primitives.size();
  }
  if (document.nodes.empty())
    for (const GltfMesh& mesh : document.meshes) parts += mesh.primitives.size();
  return static_cast<std::size_t>(parts);
}

class SceneReader {
 public:
  SceneReader(const GltfDocument& document, const GltfScene& scene, GltfData& data, const MeshEstimate& total,
              const CancelToken& cancel, bool colors, const MeshExtras& extras, SceneTextures& textures,
              Notes& notes)
      : document_(document),
        scene_(scene),
        data_(data),
        cancel_(cancel),
        colors_(colors),
        textured_(colors && has_textures(document)),
        extras_(extras),
        names_parts_(asks_for_numbers(extras)),
        textures_(textures),
        notes_(notes),
        skins_(document.skins.size()) {
    for (std::vector<double>* const values : {&mesh_.x, &mesh_.y, &mesh_.z}) values->reserve(total.vertices);
    mesh_.corners.reserve(3 * total.triangles);
    part_.reserve(total.triangles);
    if (names_parts_) sources_.reserve(count_parts(document, scene));
  }

  // Where a part, as its number counts them, comes from.
  struct PartSource {
    std::uint32_t node, mesh, material;
  };
  // The sources of all parts, where one of numbered_attributes is asked for.
  std::vector<PartSource> take_sources() { return std::move(sources_); }

  PolygonMesh read() {
    visit_parts(document_, scene_, cancel_, [&](const GltfPart& part) { read_part(part); });
    if (part_.empty())
      throw ItemError(Status::empty,
                      left_out_ == 0
                          ? std::string("the scene holds no triangles")
                          : fmt::format("the scene holds no triangles, but {} points and lines", left_out_));
    mesh_.repairs[Repair::short_faces] = saturated(left_out_);
    std::vector<std::uint32_t> corners = std::move(mesh_.corners);
    number_triangles(part_.size(), mesh_);
    mesh_.corners = std::move(corners);
    mesh_.face_attributes.push_back({"part", std::move(part_), true});
    for (auto& [name, asked] : asked_) {
      asked.values.resize(mesh_.vertex_count(), std::numeric_limits<double>::quiet_NaN());
      mesh_.asked_attributes.push_back({name, std::move(asked.values), asked.integers});
    }
    if (mesh_.coordinates.values.empty()) mesh_.coordinates = {};
    mesh_.colors.linear = mesh_.colors.of_materials = colors_;
    if (!textures_.made().textures.empty()) mesh_.colors.textures = textures_.take();
    return std::move(mesh_);
  }

 private:
  void read_part(const GltfPart& part) {
    Placement place{part.node, part.mesh, part.world};
    if (part.node == no_index || document_.nodes[part.node].instances == no_index) return read_mesh_at(place);
    const GltfInstances& instances = document_.instances[document_.nodes[part.node].instances];
    const auto values = [&](std::uint32_t accessor, std::uint32_t width) {
      return accessor == no_index ? std::vector<double>() : data_.numbers(accessor, width, cancel_);
    };
    const std::vector<double> moves = values(instances.moves, 3), turns = values(instances.turns, 4),
                              scales = values(instances.scales, 3);
    place.is_instance = true;
    const std::uint64_t count = count_instances(document_, part.node);
    for (std::size_t i = 0; i < count; ++i) {
      std::array<double, 3> move{}, scale = {1, 1, 1};
      std::array<double, 4> turn = {0, 0, 0, 1};
      if (!moves.empty()) std::copy_n(moves.data() + 3 * i, 3, move.begin());
      if (!turns.empty()) std::copy_n(turns.data() + 4 * i, 4, turn.begin());
      if (!scales.empty()) std::copy_n(scales.data() + 3 * i, 3, scale.begin());
      place.instance = map_of(move, turn, scale);
      read_mesh_at(place);
    }
  }

  void read_mesh_at(const Placement& part) {
    cancel_.check();
    blocks_.clear();
    for (const GltfPrimitive& primitive : document_.meshes[part.mesh].primitives)
      read_primitive(part, primitive);
  }

  void read_primitive(const Placement& part, const GltfPrimitive& primitive) {
    const auto number = static_cast<double>(next_part_++);
    if (names_parts_) sources_.push_back({part.node, part.mesh, primitive.material});
    const GltfCounts counts = count_primitive(document_, primitive);
    left_out_ += counts.left_out;
    if (counts.triangles == 0) return;
    if (colors_ && primitive.material != no_index && primitive.material >= document_.materials.size())
      notes_.add(Note::material_missing, fmt::format("there is no material {}", primitive.material));
    if (primitive.draco_view != no_index) return read_draco(part, primitive, counts, number);
    forget_decoded();
    const ActiveTargets targets = targets_of(part, primitive);
    const std::tuple key(primitive.attributes, primitive.colors, primitive.asked, targets);
    auto block = blocks_.find(key);
    if (block == blocks_.end()) {
      VertexValues values = values_of(primitive.attributes);
      add_targets(targets, values);
      block = blocks_.emplace(key, place(part, values)).first;
      if (colors_) add_vertex_colors(primitive.colors, block->second.count);
      for (std::size_t i = 0; i < primitive.asked.size(); ++i)
        add_asked(extras_.attributes[i], primitive.asked[i], block->second);
    }
    std::vector<std::uint32_t> indices;
    if (primitive.indices != no_index) indices = data_.indices(primitive.indices, cancel_);
    std::uint32_t mode = primitive.mode;
    std::uint64_t triangles = counts.triangles;
    if (mode > 4 && !indices.empty()) {
      const auto restart =
          static_cast<std::uint32_t>(largest_of(document_.accessors[primitive.indices].component));
      if (std::find(indices.begin(), indices.end(), restart) != indices.end()) {
        indices = listed_triangles(mode, indices, restart);
        mode = 4;
        triangles = indices.size() / 3;
        if (triangles == 0) return;
      }
    }
    const FirstCoordinates first = {coordinates_of(primitive, block->second.count),
                                    own_coordinates_of(primitive, block->second.count)};
    note_coordinates(primitive, first.texture);
    add_triangles(mode, triangles, indices, block->second, number, first);
    if (colors_) add_face_colors(primitive.material, triangles);
  }

  ActiveTargets targets_of(const Placement& part, const GltfPrimitive& primitive) const {
    const std::vector<double>& weights = weights_of(document_, part.node, part.mesh);
    ActiveTargets targets;
    for (std::size_t k = 0; k < std::min(weights.size(), primitive.targets.size()); ++k)
      if (weights[k] != 0 && primitive.targets[k] != no_index)
        targets.emplace_back(primitive.targets[k], weights[k]);
    return targets;
  }

  void add_targets(const ActiveTargets& targets, VertexValues& values) {
    if (targets.empty()) return;
    std::vector<double> moved(values.positions.begin(), values.positions.end());
    for (const auto& [accessor, weight] : targets) {
      const std::vector<double> target = numbers_of(accessor, 3, values.count(), "a morph target");
      for (std::size_t k = 0; k < moved.size(); ++k) moved[k] += weight * target[k];
    }
    values.positions = values.keep(std::move(moved));
  }

  // The values of an accessor that has to have this count.
  std::vector<double> numbers_of(std::uint32_t accessor, std::uint32_t width, std::uint64_t count,
                                 const char* what) {
    if (accessor >= document_.accessors.size() || document_.accessors[accessor].count != count)
      fail_in("accessors", accessor, fmt::format("{} of other than {} vertices", what, count));
    return data_.numbers(accessor, width, cancel_);
  }

  // Textured triangles without coordinates show no image.
  void note_coordinates(const GltfPrimitive& primitive, std::uint32_t first) {
    const auto set = coordinate_set_of(primitive.material);
    if (set && first == no_index)
      notes_.add(Note::coordinates_missing,
                 fmt::format("a primitive of material {} has no TEXCOORD_{} that can be read",
                             primitive.material, *set));
  }

  // Which set of coordinates the texture of this material is laid by; none: it has no texture.
  std::optional<std::uint32_t> coordinate_set_of(std::uint32_t material) const {
    if (!textured_ || material >= document_.materials.size()) return std::nullopt;
    if (!document_.materials[material].has_texture) return std::nullopt;
    return document_.materials[material].coordinate_set;
  }

  // The first of `count` texture coordinates of the vertices of a primitive; no_index where it has none that
  // can be read.
  std::uint32_t coordinates_of(const GltfPrimitive& primitive, std::uint32_t count) {
    const auto set = coordinate_set_of(primitive.material);
    if (!set) return no_index;
    return coordinates_of_set(primitive, *set, count, coordinates_, textures_.made().coordinates);
  }

  // The same of those that are kept for their own sake: of the first set.
  std::uint32_t own_coordinates_of(const GltfPrimitive& primitive, std::uint32_t count) {
    if (!extras_.coordinates) return no_index;
    return coordinates_of_set(primitive, 0, count, own_coordinates_, mesh_.coordinates.values);
  }

  std::uint32_t coordinates_of_set(const GltfPrimitive& primitive, std::uint32_t set, std::uint32_t count,
                                   std::map<std::uint32_t, std::uint32_t>& known, std::vector<float>& all) {
    if (set >= primitive.coordinates.size()) return no_index;
    const std::uint32_t accessor = primitive.coordinates[set];
    if (accessor >= document_.accessors.size() || document_.accessors[accessor].count != count)
      return no_index;
    const auto [at, is_new] = known.try_emplace(accessor, no_index);
    if (!is_new) return at->second;
    try {
      at->second = add_coordinates(data_.numbers(accessor, 2, cancel_), all);
    } catch (const ItemError& error) {
      if (error.status() != Status::unreadable) throw;
    }
    return at->second;
  }

  static std::uint32_t add_coordinates(const std::vector<double>& values, std::vector<float>& all) {
    const std::uint64_t first = all.size() / 2;
    check_count(first + values.size() / 2, "texture coordinates");
    for (const double value : values) all.push_back(static_cast<float>(value));
    return static_cast<std::uint32_t>(first);
  }

  // COLOR_0, of three numbers or four with an opacity; what is wrong with it costs the colors alone. Its
  // integers are shares of the largest, also where they are not marked so.
  void add_vertex_colors(std::uint32_t accessor, std::size_t count) {
    std::vector<double> values;
    const std::uint32_t width = color_width(accessor);
    try {
      if (width > 0 && document_.accessors[accessor].count == count) {
        values = data_.numbers(accessor, width, cancel_);
        if (!document_.accessors[accessor].normalized)
          for (double& value : values) value /= largest_of(document_.accessors[accessor].component);
      }
    } catch (const ItemError& error) {
      if (error.status() != Status::unreadable) throw;
    }
    note_colors(accessor, !values.empty() || count == 0);
    add_vertex_colors(values, width, count);
  }
  void note_colors(std::uint32_t accessor, bool found) {
    if (accessor != no_index && !found)
      notes_.add(Note::colors_ignored, fmt::format("COLOR_0 in accessor {} cannot be read", accessor));
  }
  // values: `width` for each vertex; other counts are no colors.
  void add_vertex_colors(std::span<const double> values, std::uint32_t width, std::size_t count) {
    std::vector<float>& colors = mesh_.colors.vertex;
    const std::size_t begin = colors.size();
    colors.resize(begin + 3 * count, no_color);
    if (values.size() != width * count) return;
    for (std::size_t v = 0; width > 0 && v < count; ++v)
      for (std::size_t k = 0; k < 3; ++k)
        colors[begin + 3 * v + k] = static_cast<float>(values[width * v + k]);
  }
  // Numbers of a color; 0: the accessor has none.
  std::uint32_t color_width(std::uint32_t accessor) const {
    if (accessor >= document_.accessors.size()) return 0;
    const std::uint32_t width = document_.accessors[accessor].width;
    return width == 3 || width == 4 ? width : 0;
  }

  // Values of the vertices of a block; of vertices before it that have none NaN. A vector is one attribute
  // for each of its numbers.
  void add_asked_values(const AttributeColumn& column, const std::vector<double>& values,
                        const VertexBlock& block, std::uint32_t accessor) {
    for (std::uint32_t k = 0; k < column.width; ++k) {
      AskedValues& asked = asked_[column.width == 1 ? column.name : fmt::format("{}_{}", column.name, k)];
      asked.integers = asked.integers && declares_integers(accessor);
      std::vector<double>& all = asked.values;
      all.resize(block.first, std::numeric_limits<double>::quiet_NaN());
      for (std::size_t v = 0; v < block.count; ++v) all.push_back(values[column.width * v + k]);
    }
  }

  // Those that are normalized stand for fractions.
  bool declares_integers(std::uint32_t accessor) const {
    if (accessor >= document_.accessors.size()) return false;
    const GltfAccessor& facts = document_.accessors[accessor];
    return facts.component != GltfComponent::float32 && !facts.normalized;
  }

  // Adds the values of an accessor of the width that is asked for; an invalid one loses its values alone.
  void add_asked(const AttributeColumn& column, std::uint32_t accessor, const VertexBlock& block) {
    if (accessor >= document_.accessors.size() || document_.accessors[accessor].count != block.count ||
        document_.accessors[accessor].width != column.width)
      return;
    try {
      add_asked_values(column, data_.numbers(accessor, column.width, cancel_), block, accessor);
    } catch (const ItemError& error) {
      if (error.status() != Status::unreadable) throw;
    }
  }

  void add_face_colors(std::uint32_t material, std::size_t triangles) {
    std::array<float, 3> color = {no_color, no_color, no_color};
    if (material < document_.materials.size()) color = document_.materials[material].color;
    for (std::size_t t = 0; t < triangles; ++t)
      mesh_.colors.face.insert(mesh_.colors.face.end(), color.begin(), color.end());
    if (!textured_) return;
    std::vector<std::uint32_t>& faces = textures_.made().face;
    faces.insert(faces.end(), triangles, textures_.of(material));
  }

  // What a primitive keeps beside its Draco stream is read as usual.
  bool is_beside(std::uint32_t accessor) const {
    return accessor < document_.accessors.size() &&
           (document_.accessors[accessor].view != no_index || document_.accessors[accessor].sparse_count > 0);
  }

  // An attribute of the stream under this id, which stands for the accessor.
  DracoAttribute draco_attribute(std::uint32_t id, std::uint32_t width, std::uint32_t accessor,
                                 bool optional = false) const {
    DracoAttribute wanted{id, width, optional};
    if (accessor < document_.accessors.size()) {
      wanted.component = document_.accessors[accessor].component;
      wanted.normalized = document_.accessors[accessor].normalized;
    }
    return wanted;
  }

  static std::uint32_t entry_of(const std::vector<std::uint32_t>& list, std::size_t number) {
    return number < list.size() ? list[number] : no_index;
  }

  void read_draco(const Placement& part, const GltfPrimitive& primitive, const GltfCounts& counts,
                  double number) {
    const GltfAttributes &ids = primitive.draco_ids, &plain = primitive.attributes;
    if (ids.positions == no_index && !is_beside(plain.positions))
      fail_in("bufferViews", primitive.draco_view, "its Draco stream has no positions");
    std::vector<DracoAttribute> wanted;
    const auto ask = [&](const DracoAttribute& attribute) {
      wanted.push_back(attribute);
      return wanted.size() - 1;
    };
    constexpr std::size_t none = ~std::size_t{0};
    const std::size_t positions_at =
        ids.positions == no_index ? none : ask(draco_attribute(ids.positions, 3, plain.positions));
    const std::size_t sets = is_skinned(part) ? ids.joints.size() : 0, joints_at = wanted.size();
    for (std::size_t s = 0; s < sets; ++s) {
      ask(draco_attribute(ids.joints[s], joints_per_set, no_index));
      wanted.back().component = GltfComponent::uint32;  // numbers, whatever the stream says of them
      // Weights are shares of their sum, so that their unit counts only beside those of other sets.
      ask(draco_attribute(ids.weights[s], joints_per_set,
                          sets < plain.joints.size() ? entry_of(plain.weights, s) : no_index));
    }
    const auto set = coordinate_set_of(primitive.material);
    const auto ask_coordinates = [&](std::size_t which) {
      const std::uint32_t id = entry_of(primitive.draco_coordinates, which);
      return id == no_index ? none
                            : ask(draco_attribute(id, 2, entry_of(primitive.coordinates, which), true));
    };
    const std::size_t coordinates_at = set ? ask_coordinates(*set) : none,
                      own_at = extras_.coordinates ? ask_coordinates(0) : none;
    const std::size_t asked_at = wanted.size();
    for (std::size_t i = 0; i < primitive.draco_asked.size(); ++i)
      ask(draco_attribute(primitive.draco_asked[i], extras_.attributes[i].width, primitive.asked[i], true));
    const std::uint32_t color_numbers =
        primitive.draco_colors == no_index ? 0 : color_width(primitive.colors);
    const std::size_t colors_at =
        color_numbers == 0
            ? none
            : ask(draco_attribute(primitive.draco_colors, color_numbers, primitive.colors, true));
    if (color_numbers > 0) wanted.back().normalized = true;  // see add_vertex_colors
    const DracoMesh& decoded = decoded_of(primitive, wanted, counts);
    VertexValues values;
    values.positions = positions_at == none
                           ? values.keep(numbers_of(plain.positions, 3, decoded.vertices, "positions"))
                           : std::span<const double>(decoded.values[positions_at]);
    for (std::size_t s = 0; s < sets; ++s) {
      values.joints.push_back(decoded.values[joints_at + 2 * s]);
      values.weights.push_back(decoded.values[joints_at + 2 * s + 1]);
    }
    for (std::size_t s = sets; is_skinned(part) && s < plain.joints.size(); ++s) {
      if (!is_beside(plain.joints[s]) || !is_beside(plain.weights[s])) break;
      values.joints.push_back(
          values.keep(numbers_of(plain.joints[s], joints_per_set, decoded.vertices, "joints")));
      values.weights.push_back(
          values.keep(numbers_of(plain.weights[s], joints_per_set, decoded.vertices, "weights")));
    }
    add_targets(targets_of(part, primitive), values);
    const VertexBlock block = place(part, values);
    if (colors_ && colors_at == none) {
      add_vertex_colors(is_beside(primitive.colors) ? primitive.colors : no_index, block.count);
    } else if (colors_) {
      note_colors(primitive.colors, !decoded.values[colors_at].empty());
      add_vertex_colors(decoded.values[colors_at], color_numbers, block.count);
    }
    for (std::size_t i = 0; i < primitive.draco_asked.size(); ++i)
      if (const std::vector<double>& found = decoded.values[asked_at + i]; !found.empty())
        add_asked_values(extras_.attributes[i], found, block, primitive.asked[i]);
      else if (primitive.draco_asked[i] == no_index && is_beside(primitive.asked[i]))
        add_asked(extras_.attributes[i], primitive.asked[i], block);
    if (decoded.corners.empty()) return;
    const auto added = [&](std::size_t at, std::vector<float>& all) {
      return decoded.values[at].empty() ? no_index : add_coordinates(decoded.values[at], all);
    };
    const auto is_plain = [&](std::size_t which) {
      return is_beside(entry_of(primitive.coordinates, which));
    };
    const FirstCoordinates first = {coordinates_at != none
                                        ? added(coordinates_at, textures_.made().coordinates)
                                    : set && is_plain(*set) ? coordinates_of(primitive, block.count)
                                                            : no_index,
                                    own_at != none ? added(own_at, mesh_.coordinates.values)
                                    : is_plain(0)  ? own_coordinates_of(primitive, block.count)
                                                   : no_index};
    note_coordinates(primitive, first.texture);
    add_triangles(4, decoded.corners.size() / 3, decoded.corners, block, number, first);
    if (colors_) add_face_colors(primitive.material, decoded.corners.size() / 3);
  }

  // The last stream is kept: the same mesh often stands at many places in a row.
  const DracoMesh& decoded_of(const GltfPrimitive& primitive, const std::vector<DracoAttribute>& wanted,
                              const GltfCounts& counts) {
    if (decoded_primitive_ == &primitive && decoded_.values.size() == wanted.size()) return decoded_;
    forget_decoded();
    decoded_ = decode_draco(data_.view(primitive.draco_view), wanted, counts.vertices, counts.triangles);
    decoded_primitive_ = &primitive;
    return decoded_;
  }

  void forget_decoded() {
    if (decoded_primitive_ == nullptr) return;
    decoded_primitive_ = nullptr;
    decoded_ = {};
  }

  bool is_skinned(const Placement& part) const {
    return part.node != no_index && document_.nodes[part.node].skin != no_index;
  }

  VertexValues values_of(const GltfAttributes& attributes) {
    VertexValues values;
    const std::uint64_t count = document_.accessors[attributes.positions].count;
    values.positions = values.keep(data_.numbers(attributes.positions, 3, cancel_));
    const auto read_sets = [&](const std::vector<std::uint32_t>& accessors,
                               std::vector<std::span<const double>>& sets) {
      for (const std::uint32_t accessor : accessors)
        sets.push_back(values.keep(numbers_of(accessor, joints_per_set, count, "joints or weights")));
    };
    read_sets(attributes.joints, values.joints);
    read_sets(attributes.weights, values.weights);
    return values;
  }

  VertexBlock place(const Placement& part, const VertexValues& values) {
    VertexBlock block;
    check_count(mesh_.vertex_count() + values.count(), "vertices");
    block.first = static_cast<std::uint32_t>(mesh_.vertex_count());
    block.count = static_cast<std::uint32_t>(values.count());
    const bool bends = is_skinned(part) && !values.joints.empty();
    const AffineMap own = part.is_instance ? product(part.world, part.instance) : part.world;
    const std::vector<AffineMap>* const joints =
        bends ? &joints_of(document_.nodes[part.node].skin) : nullptr;
    block.is_mirrored = determinant(own) < 0;
    if (bends) block.mirrored.resize(block.count);
    for (std::size_t v = 0; v < values.count(); ++v) {
      if (v % vertices_between_checks == 0) cancel_.check();
      AffineMap map = own;
      if (bends) {  // instead of the place of the node
        map = blend(values, v, *joints);
        if (part.is_instance) map = product(map, part.instance);
        block.mirrored[v] = determinant(map) < 0;
      }
      add_vertex(map, values.positions.data() + 3 * v);
    }
    return block;
  }

  void add_vertex(const AffineMap& m, const double* p) {
    mesh_.x.push_back(m[0] * p[0] + m[1] * p[1] + m[2] * p[2] + m[3]);
    mesh_.y.push_back(m[4] * p[0] + m[5] * p[1] + m[6] * p[2] + m[7]);
    mesh_.z.push_back(m[8] * p[0] + m[9] * p[1] + m[10] * p[2] + m[11]);
  }

  // From the space of the mesh to that of the scene, for every joint of a skin where it stands.
  const std::vector<AffineMap>& joints_of(std::uint32_t number) {
    if (number >= document_.skins.size())
      throw ItemError(Status::unreadable, fmt::format("there is no skin {}", number));
    const GltfSkin& skin = document_.skins[number];
    std::vector<AffineMap>& maps = skins_[number];
    if (!maps.empty() || skin.joints.empty()) return maps;
    std::vector<double> binds;
    if (skin.inverse_binds != no_index) {
      const std::uint64_t count =
          skin.inverse_binds < document_.accessors.size() ? document_.accessors[skin.inverse_binds].count : 0;
      if (count < skin.joints.size() || count > skin.joints.size() + most_spare_matrices)
        fail_in("skins", number, fmt::format("{} matrices for {} joints", count, skin.joints.size()));
      binds = data_.numbers(skin.inverse_binds, 16, cancel_);
    }
    for (std::size_t j = 0; j < skin.joints.size(); ++j) {
      if (skin.joints[j] >= scene_.world.size())
        fail_in("skins", number, fmt::format("there is no node {}", skin.joints[j]));
      AffineMap bind = identity_map;
      if (!binds.empty())
        for (std::size_t k = 0; k < 12; ++k) bind[k] = binds[16 * j + 4 * (k % 4) + k / 4];
      maps.push_back(product(scene_.world[skin.joints[j]], bind));
    }
    return maps;
  }

  // Weights are taken as shares of their sum; without any the first joint has all.
  AffineMap blend(const VertexValues& values, std::size_t v, const std::vector<AffineMap>& joints) const {
    AffineMap sum{};
    double total = 0;
    const auto add = [&](double joint, double weight) {
      if (!(joint >= 0 && joint < static_cast<double>(joints.size())))
        throw ItemError(Status::unreadable, fmt::format("vertex {}: its skin has no joint {}", v, joint));
      const AffineMap& map = joints[static_cast<std::size_t>(joint)];
      for (std::size_t k = 0; k < 12; ++k) sum[k] += weight * map[k];
      total += weight;
    };
    for (std::size_t s = 0; s < values.joints.size(); ++s)
      for (std::size_t k = joints_per_set * v; k < joints_per_set * (v + 1); ++k)
        if (values.weights[s][k] != 0) add(values.joints[s][k], values.weights[s][k]);
    if (total == 0) {
      sum = {};
      add(values.joints[0][joints_per_set * v], 1);
      return sum;
    }
    for (double& value : sum) value /= total;
    return sum;
  }

  // The first of the texture coordinates of the vertices of a block: in the textures, and in those that are
  // kept for their own sake; no_index: none.
  struct FirstCoordinates {
    std::uint32_t texture = no_index, own = no_index;
  };

  // Without indices the corners are the vertices in order.
  void add_triangles(std::uint32_t mode, std::size_t triangles, const std::vector<std::uint32_t>& indices,
                     const VertexBlock& block, double number, FirstCoordinates first) {
    check_count(mesh_.corners.size() + 3 * std::uint64_t{triangles}, "corners");
    std::vector<std::uint32_t>& of_corners = textures_.made().corner;
    for (std::size_t t = 0; t < triangles; ++t) {
      std::array<std::uint32_t, 3> corners{};
      const std::array<std::size_t, 3> places = triangle_corners(mode, t);
      for (std::size_t k = 0; k < 3; ++k)
        corners[k] = indices.empty() ? static_cast<std::uint32_t>(places[k]) : indices[places[k]];
      if (block.mirrors(corners[0])) std::swap(corners[1], corners[2]);
      for (const std::uint32_t corner : corners)
        mesh_.corners.push_back(corner < block.count ? block.first + corner : no_index);
      const auto add_corners = [&](std::uint32_t begin, std::vector<std::uint32_t>& all) {
        for (const std::uint32_t corner : corners)
          all.push_back(corner < block.count && begin != no_index ? begin + corner : no_index);
      };
      if (textured_) add_corners(first.texture, of_corners);
      if (extras_.coordinates) add_corners(first.own, mesh_.coordinates.corner);
    }
    part_.insert(part_.end(), triangles, number);
  }

  const GltfDocument& document_;
  const GltfScene& scene_;
  GltfData& data_;
  const CancelToken& cancel_;
  bool colors_, textured_;
  const MeshExtras& extras_;
  const bool names_parts_;
  std::vector<PartSource> sources_;
  SceneTextures& textures_;
  Notes& notes_;
  DracoMesh decoded_;  // of the last primitive that is compressed so
  const GltfPrimitive* decoded_primitive_ = nullptr;
  std::map<std::uint32_t, std::uint32_t> coordinates_, own_coordinates_;  // where those of an accessor begin
  struct AskedValues {
    std::vector<double> values;  // of the vertices so far
    bool integers = true;        // wherever a primitive has some
  };
  std::map<std::string, AskedValues> asked_;   // attributes by name
  std::vector<std::vector<AffineMap>> skins_;  // of joints, once they are asked for
  // The blocks of the mesh that is being placed, by its accessors (colors and asked columns too) and morph
  // targets.
  std::map<std::tuple<GltfAttributes, std::uint32_t, std::vector<std::uint32_t>, ActiveTargets>, VertexBlock>
      blocks_;
  PolygonMesh mesh_;
  std::vector<double> part_;  // of every triangle
  std::uint64_t next_part_ = 0, left_out_ = 0;
};

// Names of the entries of a list of the file; empty for one that has none, or is not there.
class EntryNames {
 public:
  EntryNames(JsonValue root, std::string_view list) : entries_(root.member(list).items()) {}
  std::string_view of(std::uint32_t entry) const {
    if (entry >= entries_.size()) return {};
    return entries_[entry].member("name").text().value_or("");
  }

 private:
  std::vector<JsonValue> entries_;
};

using PartSource = SceneReader::PartSource;

// Numbers of faces by what their parts come from, and by number one of these.
struct SceneNumbers {
  std::vector<double> values;
  std::vector<PartSource> sources;
};

// By the entry `key` of a list, no_index for none.
SceneNumbers number_scene_faces(const std::vector<double>& part_of_face, std::span<const PartSource> sources,
                                std::uint32_t PartSource::*key) {
  SceneNumbers made;
  std::map<std::uint32_t, std::size_t> numbers;
  made.values.reserve(part_of_face.size());
  for (const double part : part_of_face) {
    const PartSource& source = sources[static_cast<std::size_t>(part)];
    if (source.*key == no_index) {
      made.values.push_back(std::numeric_limits<double>::quiet_NaN());
      continue;
    }
    const auto [at, is_new] = numbers.try_emplace(source.*key, numbers.size());
    if (is_new) made.sources.push_back(source);
    made.values.push_back(static_cast<double>(at->second));
  }
  return made;
}

// The numbers of materials and nodes, and the names behind these and behind those of parts. A name may stand
// for any number of them: it stays where the file has it.
void add_scene_numbers(JsonValue root, std::span<const PartSource> sources,
                       std::span<const AttributeColumn> asked, PolygonMesh& mesh) {
  if (sources.empty()) return;
  const EntryNames nodes(root, "nodes"), meshes(root, "meshes"), materials(root, "materials");
  const auto material_name = [&](const PartSource& source) { return materials.of(source.material); };
  const auto node_name = [&](const PartSource& source) {
    const std::string_view name = nodes.of(source.node);
    return name.empty() ? meshes.of(source.mesh) : name;
  };
  const std::vector<double>& part_of_face = mesh.face_attributes.back().values;
  NumberedAttributes numbered(mesh);
  const auto add = [&](const std::string& attribute, std::uint32_t PartSource::*key, const auto& name_of) {
    SceneNumbers made = number_scene_faces(part_of_face, sources, key);
    numbered.add(attribute, std::move(made.values), made.sources.size(),
                 [&](std::size_t number) { return name_of(made.sources[number]); });
  };
  if (asks_for(asked, "material")) add("material", &PartSource::material, material_name);
  if (asks_for(asked, "object")) add("object", &PartSource::node, node_name);
  if (asks_for(asked, "part"))
    numbered.add_names("part", sources.size(), [&](std::size_t part) { return node_name(sources[part]); });
  numbered.finish();
}

void check_content(std::string_view content) {
  const std::size_t first = content.find_first_not_of(" \t\r\n\0");
  if (first == std::string_view::npos) throw ItemError(Status::empty, "the file holds nothing but blanks");
  if (content.starts_with("glTF") || content[first] == '{') return;
  const std::string other = foreign_content(content, MeshFormat::gltf);
  throw ItemError(Status::unreadable, "by its name this is a glTF file, by its content it is " +
                                          (other.empty() ? "neither binary glTF nor JSON" : other));
}

}  // namespace

PolygonMesh read_gltf(std::string_view content, const CancelToken& cancel, const BlockRule&,
                      const MeshSurroundings& around) {
  const bool is_marked = content.starts_with("\xEF\xBB\xBF");
  check_content(is_marked ? content.substr(3) : content);
  const GltfChunks chunks = gltf_chunks(content, content.size());
  const JsonTree json(json_of(content, chunks));
  const GltfDocument document = parse_gltf(json, around.colors, around.extras);
  const GltfScene scene = arrange_scene(document, cancel);
  MeshEstimate total = count_scene(document, scene, cancel);
  total.companions = companions_of(document);
  total.decoding_bytes += json.memory_bytes();
  if (asks_for_numbers(around.extras))
    total.decoding_bytes += count_parts(document, scene) * sizeof(PartSource);
  if (around.admit) around.admit(total);
  std::optional<std::string_view> binary;
  if (chunks.has_binary)
    binary = content.substr(static_cast<std::size_t>(chunks.binary_begin),
                            static_cast<std::size_t>(chunks.binary_bytes));
  GltfData data(document, binary, around.companions);
  Notes notes;
  note_ignored_extensions(json, around.colors, notes);
  if (scene.repeated > 0)
    notes.add(Note::node_repeated,
              scene.first_repeated == no_index
                  ? std::string("the scene names a node twice")
                  : fmt::format("node {} is named more than once", scene.first_repeated),
              scene.repeated);
  SceneTextures textures(document, data, around.companions, cancel, notes);
  if (const std::uint64_t bytes = textures.embedded_bytes(); bytes > 0 && around.admit) {
    total.decoding_bytes += bytes;
    around.admit(total);
  }
  SceneReader reader(document, scene, data, total, cancel, around.colors, around.extras, textures, notes);
  PolygonMesh mesh = reader.read();
  data.note_missing_buffers(notes);
  mesh.notes = std::move(notes);
  add_scene_numbers(json.root(), reader.take_sources(), around.extras.attributes, mesh);
  mesh.repairs[Repair::extra_data] = saturated(chunks.extra_bytes);
  return mesh;
}

}  // namespace meander
