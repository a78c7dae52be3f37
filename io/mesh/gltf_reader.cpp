// glTF 2.0, as JSON with buffers beside it and as one binary file (GLB): all meshes of the scene where it
// puts them, as one mesh.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <tuple>
#include <utility>

#include "io/image/color_image.h"
#include "io/mesh/format_readers.h"
#include "io/mesh/gltf_data.h"
#include "io/mesh/gltf_document.h"
#include "io/mesh/gltf_draco.h"
#include "io/mesh/text_cursor.h"
#include "io/mesh/texture_images.h"

namespace meander {

namespace {

constexpr std::uint32_t joints_per_set = 4;
constexpr std::size_t vertices_between_checks = 65536;
// Files may hold more inverse bind matrices than a skin has joints, but they are no place for data.
constexpr std::uint64_t most_spare_matrices = 65536;

// The vertices of a primitive before they are placed.
struct VertexValues {
  std::vector<double> positions;                     // three each
  std::vector<std::vector<double>> joints, weights;  // sets of four each
  std::size_t count() const { return positions.size() / 3; }
};

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

// The textures of materials, read when the first triangle has one.
class SceneTextures {
 public:
  SceneTextures(const GltfDocument& document, GltfData& data, std::span<const CompanionFile> companions,
                const CancelToken& cancel)
      : document_(document),
        data_(data),
        companions_(companions),
        cancel_(cancel),
        numbers_(document.materials.size(), no_index) {}

  static bool has_any(const GltfDocument& document) {
    return std::any_of(document.materials.begin(), document.materials.end(),
                       [](const GltfMaterial& material) { return material.has_texture; });
  }

  // What decoding those takes that are no files of their own, as their headers state.
  std::uint64_t embedded_bytes() {
    std::uint64_t bytes = 0, working = 0;
    std::vector<bool> counted(document_.images.size(), false);
    for (const GltfMaterial& material : document_.materials) {
      const std::uint32_t image = material.image;
      if (image >= counted.size() || counted[image]) continue;
      counted[image] = true;
      with_bytes(image, [&](std::string_view content) {
        const ImageMemory memory = memory_of_image(std::as_bytes(std::span(content)));
        bytes += memory.kept_bytes;
        working = std::max(working, memory.working_bytes + content.size());
      });
    }
    return bytes + working;
  }

  // The number of the material's texture; no_index where it has none.
  std::uint32_t of(std::uint32_t material) {
    if (material >= numbers_.size() || !document_.materials[material].has_texture) return no_index;
    std::uint32_t& number = numbers_[material];
    if (number != no_index) return number;
    number = static_cast<std::uint32_t>(textures_->textures.size());
    textures_->textures.push_back(document_.materials[material].texture);
    textures_->textures.back().image = image(document_.materials[material].image);
    return number;
  }

  SurfaceTextures& made() { return *textures_; }
  std::shared_ptr<const SurfaceTextures> take() { return std::move(textures_); }

 private:
  // Calls use(bytes) for an image inside the file, unless it cannot be found.
  template <class Use>
  void with_bytes(std::uint32_t number, Use use) {
    const GltfImage& image = document_.images[number];
    try {
      if (image.uri && is_data_uri(*image.uri))
        use(std::string_view(decode_data_uri(*image.uri)));
      else if (!image.uri && image.view != no_index)
        use(data_.view(image.view));
    } catch (const ItemError& error) {
      if (error.status() != Status::unreadable) throw;
    }
  }

  ColorImage read(std::uint32_t number) {
    ColorImage read;
    read.problem = "is not there";
    const std::optional<std::string_view>& uri = document_.images[number].uri;
    if (uri && !is_data_uri(*uri)) {
      std::string reason;
      return image_of_file(companions_, companion_path(*uri, reason), cancel_);
    }
    with_bytes(number, [&](std::string_view content) {
      read = decode_color_image(std::as_bytes(std::span(content)), cancel_);
    });
    return read;
  }

  std::uint32_t image(std::uint32_t number) {
    if (number >= document_.images.size()) return no_index;
    const auto [at, is_new] =
        images_.try_emplace(number, static_cast<std::uint32_t>(textures_->images.size()));
    if (is_new) textures_->images.push_back(read(number));
    return at->second;
  }

  const GltfDocument& document_;
  GltfData& data_;
  std::span<const CompanionFile> companions_;
  const CancelToken& cancel_;
  std::vector<std::uint32_t> numbers_;             // of textures, by material
  std::map<std::uint32_t, std::uint32_t> images_;  // of those that were read
  std::shared_ptr<SurfaceTextures> textures_ = std::make_shared<SurfaceTextures>();
};

class SceneReader {
 public:
  SceneReader(const GltfDocument& document, const GltfScene& scene, GltfData& data, const MeshEstimate& total,
              const CancelToken& cancel, bool colors, const MeshExtras& extras, SceneTextures& textures)
      : document_(document),
        scene_(scene),
        data_(data),
        cancel_(cancel),
        colors_(colors),
        textured_(colors && SceneTextures::has_any(document)),
        extras_(extras),
        textures_(textures),
        skins_(document.skins.size()) {
    for (std::vector<double>* const values : {&mesh_.x, &mesh_.y, &mesh_.z}) values->reserve(total.vertices);
    mesh_.corners.reserve(3 * total.triangles);
    part_.reserve(total.triangles);
  }

  PolygonMesh read() {
    for (const GltfPart& part : scene_.parts) {
      cancel_.check();
      blocks_.clear();
      for (const GltfPrimitive& primitive : document_.meshes[part.mesh]) read_primitive(part, primitive);
    }
    if (part_.empty())
      throw ItemError(Status::empty,
                      left_out_ == 0
                          ? std::string("the scene holds no triangles")
                          : fmt::format("the scene holds no triangles, but {} points and lines", left_out_));
    mesh_.repairs[Repair::short_faces] = saturated(left_out_);
    std::vector<std::uint32_t> corners = std::move(mesh_.corners);
    number_triangles(part_.size(), mesh_);
    mesh_.corners = std::move(corners);
    mesh_.face_attributes.push_back({"part", std::move(part_)});
    for (auto& [name, values] : asked_) {
      values.resize(mesh_.vertex_count(), std::numeric_limits<double>::quiet_NaN());
      mesh_.asked_attributes.push_back({name, std::move(values)});
    }
    if (mesh_.coordinates.values.empty()) mesh_.coordinates = {};
    mesh_.colors.linear = mesh_.colors.of_materials = colors_;
    if (!textures_.made().textures.empty()) mesh_.colors.textures = textures_.take();
    return std::move(mesh_);
  }

 private:
  void read_primitive(const GltfPart& part, const GltfPrimitive& primitive) {
    const auto number = static_cast<double>(next_part_++);
    const GltfCounts counts = count_primitive(document_, primitive);
    left_out_ += counts.left_out;
    if (counts.triangles == 0) return;
    if (primitive.draco_view != no_index) return read_draco(part, primitive, counts, number);
    const std::tuple key(primitive.attributes, primitive.colors, primitive.asked);
    auto block = blocks_.find(key);
    if (block == blocks_.end()) {
      block = blocks_.emplace(key, place(part, values_of(primitive.attributes))).first;
      if (colors_) add_vertex_colors(primitive.colors, block->second.count);
      add_asked(primitive, block->second);
    }
    std::vector<std::uint32_t> indices;
    if (primitive.indices != no_index) indices = data_.indices(primitive.indices, cancel_);
    const FirstCoordinates first = {coordinates_of(primitive, block->second.count),
                                    own_coordinates_of(primitive, block->second.count)};
    add_triangles(primitive.mode, counts.triangles, indices, block->second, number, first);
    if (colors_) add_face_colors(primitive.material, counts.triangles);
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

  // COLOR_0, of three numbers or four with an opacity; what is wrong with it costs the colours alone.
  void add_vertex_colors(std::uint32_t accessor, std::size_t count) {
    std::vector<double> values;
    const std::uint32_t width = color_width(accessor);
    try {
      if (width > 0 && document_.accessors[accessor].count == count)
        values = data_.numbers(accessor, width, cancel_);
    } catch (const ItemError& error) {
      if (error.status() != Status::unreadable) throw;
    }
    add_vertex_colors(values, width, count);
  }
  // values: `width` for each vertex; other counts are no colours.
  void add_vertex_colors(std::span<const double> values, std::uint32_t width, std::size_t count) {
    std::vector<float>& colors = mesh_.colors.vertex;
    const std::size_t begin = colors.size();
    colors.resize(begin + 3 * count, no_color);
    if (values.size() != width * count) return;
    for (std::size_t v = 0; width > 0 && v < count; ++v)
      for (std::size_t k = 0; k < 3; ++k)
        colors[begin + 3 * v + k] = static_cast<float>(values[width * v + k]);
  }
  // Numbers of a colour; 0: the accessor has none.
  std::uint32_t color_width(std::uint32_t accessor) const {
    if (accessor >= document_.accessors.size()) return 0;
    const std::uint32_t width = document_.accessors[accessor].width;
    return width == 3 || width == 4 ? width : 0;
  }

  // Values of the vertices of a block; of vertices before it that have none NaN. A vector is one attribute
  // for each of its numbers.
  void add_asked_values(const AttributeColumn& column, const std::vector<double>& values,
                        const VertexBlock& block) {
    for (std::uint32_t k = 0; k < column.width; ++k) {
      std::vector<double>& all =
          asked_[column.width == 1 ? column.name : fmt::format("{}_{}", column.name, k)];
      all.resize(block.first, std::numeric_limits<double>::quiet_NaN());
      for (std::size_t v = 0; v < block.count; ++v) all.push_back(values[column.width * v + k]);
    }
  }

  // Of accessors of the width that is asked for; what is wrong with one costs its values alone.
  void add_asked(const GltfPrimitive& primitive, const VertexBlock& block) {
    for (std::size_t i = 0; i < primitive.asked.size(); ++i) {
      const AttributeColumn& column = extras_.attributes[i];
      const std::uint32_t accessor = primitive.asked[i];
      if (accessor >= document_.accessors.size() || document_.accessors[accessor].count != block.count ||
          document_.accessors[accessor].width != column.width)
        continue;
      try {
        add_asked_values(column, data_.numbers(accessor, column.width, cancel_), block);
      } catch (const ItemError& error) {
        if (error.status() != Status::unreadable) throw;
      }
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

  void read_draco(const GltfPart& part, const GltfPrimitive& primitive, const GltfCounts& counts,
                  double number) {
    const GltfAttributes& ids = primitive.draco_ids;
    if (ids.positions == no_index)
      fail_in("bufferViews", primitive.draco_view, "its Draco stream has no positions");
    const std::size_t sets = is_skinned(part) ? std::min(ids.joints.size(), ids.weights.size()) : 0;
    std::vector<DracoAttribute> wanted = {{ids.positions, 3}};
    for (std::size_t s = 0; s < sets; ++s) {
      wanted.push_back({ids.joints[s], joints_per_set});
      wanted.push_back({ids.weights[s], joints_per_set});
    }
    const auto set = coordinate_set_of(primitive.material);
    const bool has_coordinates =
        set && *set < primitive.draco_coordinates.size() && primitive.draco_coordinates[*set] != no_index;
    if (has_coordinates) wanted.push_back({primitive.draco_coordinates[*set], 2, true});
    const bool has_own = extras_.coordinates && !primitive.draco_coordinates.empty() &&
                         primitive.draco_coordinates[0] != no_index;
    const std::size_t own_at = wanted.size();
    if (has_own) wanted.push_back({primitive.draco_coordinates[0], 2, true});
    const std::size_t asked_at = wanted.size();
    for (std::size_t i = 0; i < primitive.draco_asked.size(); ++i)
      wanted.push_back({primitive.draco_asked[i], extras_.attributes[i].width, true});
    const std::uint32_t color_numbers =
        primitive.draco_colors == no_index ? 0 : color_width(primitive.colors);
    if (color_numbers > 0) wanted.push_back({primitive.draco_colors, color_numbers, true, true});
    DracoMesh decoded =
        decode_draco(data_.view(primitive.draco_view), wanted, counts.vertices, counts.triangles);
    VertexValues values;
    values.positions = std::move(decoded.values[0]);
    for (std::size_t s = 0; s < sets; ++s) {
      values.joints.push_back(std::move(decoded.values[1 + 2 * s]));
      values.weights.push_back(std::move(decoded.values[2 + 2 * s]));
    }
    const VertexBlock block = place(part, values);
    if (colors_)
      add_vertex_colors(color_numbers > 0 ? decoded.values.back() : std::vector<double>(), color_numbers,
                        block.count);
    for (std::size_t i = 0; i < primitive.draco_asked.size(); ++i)
      if (const std::vector<double>& found = decoded.values[asked_at + i]; !found.empty())
        add_asked_values(extras_.attributes[i], found, block);
    if (decoded.corners.empty()) return;
    const auto added = [&](bool there, std::size_t at, std::vector<float>& all) {
      return there && !decoded.values[at].empty() ? add_coordinates(decoded.values[at], all) : no_index;
    };
    const FirstCoordinates first = {added(has_coordinates, own_at - 1, textures_.made().coordinates),
                                    added(has_own, own_at, mesh_.coordinates.values)};
    add_triangles(4, decoded.corners.size() / 3, decoded.corners, block, number, first);
    if (colors_) add_face_colors(primitive.material, decoded.corners.size() / 3);
  }

  bool is_skinned(const GltfPart& part) const {
    return part.node != no_index && document_.nodes[part.node].skin != no_index;
  }

  VertexValues values_of(const GltfAttributes& attributes) {
    VertexValues values;
    const std::uint64_t count = document_.accessors[attributes.positions].count;
    values.positions = data_.numbers(attributes.positions, 3, cancel_);
    const auto read_sets = [&](const std::vector<std::uint32_t>& accessors,
                               std::vector<std::vector<double>>& sets) {
      for (const std::uint32_t accessor : accessors) {
        if (accessor >= document_.accessors.size() || document_.accessors[accessor].count != count)
          fail_in("accessors", accessor, fmt::format("joints or weights of other than {} vertices", count));
        sets.push_back(data_.numbers(accessor, joints_per_set, cancel_));
      }
    };
    read_sets(attributes.joints, values.joints);
    read_sets(attributes.weights, values.weights);
    return values;
  }

  VertexBlock place(const GltfPart& part, const VertexValues& values) {
    VertexBlock block;
    check_count(mesh_.vertex_count() + values.count(), "vertices");
    block.first = static_cast<std::uint32_t>(mesh_.vertex_count());
    block.count = static_cast<std::uint32_t>(values.count());
    const bool bends = is_skinned(part) && !values.joints.empty();
    const AffineMap& own = part.node == no_index ? identity_map : scene_.world[part.node];
    const std::vector<AffineMap>* const joints =
        bends ? &joints_of(document_.nodes[part.node].skin) : nullptr;
    block.is_mirrored = determinant(own) < 0;
    if (bends) block.mirrored.resize(block.count);
    for (std::size_t v = 0; v < values.count(); ++v) {
      if (v % vertices_between_checks == 0) cancel_.check();
      const AffineMap blended = bends ? blend(values, v, *joints) : own;
      if (bends) block.mirrored[v] = determinant(blended) < 0;
      add_vertex(blended, values.positions.data() + 3 * v);
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
  SceneTextures& textures_;
  std::map<std::uint32_t, std::uint32_t> coordinates_, own_coordinates_;  // where those of an accessor begin
  std::map<std::string, std::vector<double>> asked_;  // attributes by name, of the vertices so far
  std::vector<std::vector<AffineMap>> skins_;         // of joints, once they are asked for
  // Of the mesh that is being placed, with the accessors of its colours and of what else is asked for.
  std::map<std::tuple<GltfAttributes, std::uint32_t, std::vector<std::uint32_t>>, VertexBlock> blocks_;
  PolygonMesh mesh_;
  std::vector<double> part_;  // of every triangle
  std::uint64_t next_part_ = 0, left_out_ = 0;
};

void check_content(std::string_view content) {
  const std::size_t first = content.find_first_not_of(" \t\r\n\0");
  if (first == std::string_view::npos) throw ItemError(Status::empty, "the file holds nothing but blanks");
  if (content.starts_with("glTF") || content[first] == '{') return;
  const std::string other = foreign_content(content, MeshFormat::gltf);
  throw ItemError(Status::unreadable, "by its name this is a glTF file, by its content it is " +
                                          (other.empty() ? "neither binary glTF nor JSON" : other));
}

std::string_view part_of(std::string_view content, std::uint64_t begin, std::uint64_t bytes) {
  return content.substr(static_cast<std::size_t>(begin), static_cast<std::size_t>(bytes));
}

}  // namespace

PolygonMesh read_gltf(std::string_view content, const CancelToken& cancel, const MeshSurroundings& around) {
  const bool is_marked = content.starts_with("\xEF\xBB\xBF");
  check_content(is_marked ? content.substr(3) : content);
  const GltfChunks chunks = gltf_chunks(content, content.size());
  const JsonTree json(part_of(content, chunks.json_begin, chunks.json_bytes));
  const GltfDocument document = parse_gltf(json, around.colors, around.extras);
  const GltfScene scene = arrange_scene(document, cancel);
  MeshEstimate total = count_scene(document, scene, cancel);
  total.companions = companions_of(document);
  total.decoding_bytes += json.memory_bytes();
  if (around.admit) around.admit(total);
  std::optional<std::string_view> binary;
  if (chunks.has_binary) binary = part_of(content, chunks.binary_begin, chunks.binary_bytes);
  GltfData data(document, binary, around.companions);
  SceneTextures textures(document, data, around.companions, cancel);
  if (const std::uint64_t bytes = textures.embedded_bytes(); bytes > 0 && around.admit) {
    total.decoding_bytes += bytes;
    around.admit(total);
  }
  PolygonMesh mesh =
      SceneReader(document, scene, data, total, cancel, around.colors, around.extras, textures).read();
  mesh.repairs[Repair::extra_data] = saturated(chunks.extra_bytes);
  return mesh;
}

std::vector<std::string> companion_paths(std::span<const std::byte> bytes, MeshFormat format) {
  const std::string_view content(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (format != MeshFormat::gltf || content.empty()) return {};
  try {
    const GltfChunks chunks = gltf_chunks(content, content.size());
    const std::string_view text = part_of(content, chunks.json_begin, chunks.json_bytes);
    // Most binary files hold all that they need, and need not be parsed twice.
    if (text.find("\"uri\"") == std::string_view::npos) return {};
    return companions_of(parse_gltf(JsonTree(text)));
  } catch (const ItemError&) {
    return {};
  }
}

std::vector<std::string> gltf_image_paths(std::string_view content) try {
  if (content.empty()) return {};
  const GltfChunks chunks = gltf_chunks(content, content.size());
  const std::string_view text = part_of(content, chunks.json_begin, chunks.json_bytes);
  if (text.find("\"uri\"") == std::string_view::npos) return {};
  return image_companions_of(parse_gltf(JsonTree(text), true));
} catch (const ItemError&) {
  return {};
}

MeshEstimate peek_gltf(const ByteSource& file) try {
  constexpr std::size_t most_header = 32;
  const GltfChunks chunks = gltf_chunks(file.read(0, most_header), file.bytes());
  // In base64 a vertex takes 16 characters.
  MeshEstimate estimate{file.bytes(), file.bytes() / 16 + 1, file.bytes() / 16 + 1};
  if (chunks.json_bytes > most_peeked_json) {
    estimate.decoding_bytes = chunks.json_bytes * JsonTree::most_bytes_per_character;
    return estimate;
  }
  const JsonTree json(file.read(chunks.json_begin, static_cast<std::size_t>(chunks.json_bytes)));
  const GltfDocument document = parse_gltf(json);
  estimate = count_scene(document, arrange_scene(document, {}), {});
  estimate.companions = companions_of(document);
  estimate.file_bytes = file.bytes();
  estimate.decoding_bytes += json.memory_bytes();
  return estimate;
} catch (const ItemError&) {  // reading it ends in the same way, before there is a mesh
  MeshEstimate estimate{file.bytes(), 0, 0};
  estimate.decoding_bytes = std::min(file.bytes(), most_peeked_json) * JsonTree::most_bytes_per_character;
  return estimate;
}

}  // namespace meander
