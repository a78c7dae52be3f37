// Internal to io/mesh: what the JSON of a glTF 2.0 file says of its geometry, as plain structs.
//
// Types are checked when the JSON is read; what names what (an accessor its buffer view) when it is used, so
// that a broken texture does not cost a model.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/json/json_tree.h"
#include "io/mesh/mesh_reader.h"
#include "io/mesh/polygon_parts.h"
#include "kernels/mesh/count_limit.h"
#include "kernels/mesh/surface_textures.h"

namespace meander {

// Row-major 3 x 4: a linear map and a translation.
using AffineMap = std::array<double, 12>;
// b first, then a.
AffineMap product(const AffineMap& a, const AffineMap& b);
// Scaled, turned by a quaternion x, y, z, w of any length, moved.
AffineMap map_of(const std::array<double, 3>& move, std::array<double, 4> turn,
                 const std::array<double, 3>& scale);
inline constexpr AffineMap identity_map = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

// As the format numbers them.
enum class GltfComponent : std::uint16_t {
  int8 = 5120,
  uint8 = 5121,
  int16 = 5122,
  uint16 = 5123,
  uint32 = 5125,
  float32 = 5126
};
constexpr std::uint64_t bytes_of(GltfComponent component) {
  return component <= GltfComponent::uint8 ? 1 : component <= GltfComponent::uint16 ? 2 : 4;
}
// What normalized integers are divided by.
constexpr double largest_of(GltfComponent component) {
  switch (component) {
    case GltfComponent::int8:
      return 127;
    case GltfComponent::uint8:
      return 255;
    case GltfComponent::int16:
      return 32767;
    case GltfComponent::uint16:
      return 65535;
    case GltfComponent::uint32:
      return 4294967295;
    case GltfComponent::float32:
      break;
  }
  return 1;
}
constexpr bool is_index(GltfComponent component) {
  return component == GltfComponent::uint8 || component == GltfComponent::uint16 ||
         component == GltfComponent::uint32;
}

// A part of a buffer; of a compressed view where the stream is, and what it unpacks to.
struct GltfView {
  enum class Packing : std::uint8_t { none, attributes, triangles, indices };
  enum class Filter : std::uint8_t { none, octahedral, quaternion, exponential };
  std::uint32_t buffer = no_index;
  std::uint64_t offset = 0, bytes = 0, stride = 0;  // stride 0: elements follow each other
  Packing packing = Packing::none;
  Filter filter = Filter::none;
  std::uint64_t count = 0;  // unpacked elements of `stride` bytes
};

struct GltfAccessor {
  std::uint32_t view = no_index;  // none: zeros
  std::uint64_t offset = 0, count = 0;
  GltfComponent component = GltfComponent::float32;
  std::uint32_t width = 0;  // components of an element; 0: a matrix of 2 or 3, which no geometry has
  bool normalized = false;
  std::uint64_t sparse_count = 0;
  std::uint32_t sparse_numbers = no_index, sparse_values = no_index;  // views
  std::uint64_t sparse_numbers_offset = 0, sparse_values_offset = 0;
  GltfComponent sparse_component = GltfComponent::uint32;
};

// The attributes are accessors or, in a Draco stream, ids.
struct GltfAttributes {
  std::uint32_t positions = no_index;
  std::vector<std::uint32_t> joints, weights;  // sets of four
  auto operator<=>(const GltfAttributes&) const = default;
};

struct GltfPrimitive {
  GltfAttributes attributes;
  std::uint32_t indices = no_index;
  std::uint32_t mode = 4;                 // 0 points, 1 to 3 lines, 4 triangles, 5 strip, 6 fan
  std::uint32_t colors = no_index;        // an accessor,
  std::uint32_t draco_colors = no_index;  // and an id in its Draco stream
  std::uint32_t material = no_index;
  // Sets of texture coordinates, accessors; in a Draco stream ids. The three above only if colors are asked
  // for, these also if coordinates are, and the material if its number is.
  std::vector<std::uint32_t> coordinates, draco_coordinates;
  // Accessors of what morph targets add to the positions; no_index of a target that moves none.
  std::vector<std::uint32_t> targets;
  // Accessors, and ids in a Draco stream, of the attributes that are asked for, in their order.
  std::vector<std::uint32_t> asked, draco_asked;
  std::uint32_t draco_view = no_index;
  GltfAttributes draco_ids;
};

struct GltfMesh {
  std::vector<GltfPrimitive> primitives;
  std::vector<double> weights;  // of the targets at rest; those that are not there are 0
};

// A file, a data URI or a part of a buffer.
struct GltfImage {
  std::optional<std::string_view> uri;
  std::uint32_t view = no_index;
};

// An invalid one loses the colors, not the model.
struct GltfMaterial {
  std::array<float, 3> color = {1, 1, 1};  // base color in linear light
  bool has_texture = false;
  std::uint32_t image = no_index;        // no_index although it has a texture: one that is not there
  std::uint32_t other_image = no_index;  // the one to be taken where that cannot be read
  bool is_foreign = false;               // the image is of a format that is not read
  std::uint32_t coordinate_set = 0;      // the number of the texture coordinates
  Texture texture;                       // without the number of the image
};

// Accessors of what places the copies of a mesh (EXT_mesh_gpu_instancing); at least one of the three.
struct GltfInstances {
  std::uint32_t moves = no_index, turns = no_index, scales = no_index;
};

struct GltfNode {
  AffineMap local = identity_map;
  std::uint32_t mesh = no_index, skin = no_index;
  std::uint32_t instances = no_index;   // in GltfDocument::instances
  bool is_hidden = false;               // with all below it
  std::uint32_t repeated_children = 0;  // named more than once
  std::vector<std::uint32_t> children;  // each once
  std::vector<double> weights;          // before those of the mesh, if there are any
};

struct GltfSkin {
  std::uint32_t inverse_binds = no_index;
  std::vector<std::uint32_t> joints;
};

struct GltfDocument {
  std::vector<std::optional<std::string_view>> buffer_uris;  // none: the binary chunk, if it is the first
  std::vector<GltfView> views;
  std::vector<GltfAccessor> accessors;
  std::vector<GltfMesh> meshes;
  std::vector<GltfMaterial> materials;  // this and the next if colors are asked for
  std::vector<GltfImage> images;
  std::vector<GltfNode> nodes;
  std::vector<GltfInstances> instances;
  std::vector<GltfSkin> skins;
  bool has_scenes = false;
  std::vector<std::uint32_t> scene_nodes;  // of the scene to be shown, each once
  std::uint32_t repeated_scene_nodes = 0;  // named more than once
};

// The texts in a file: JSON and the binary chunk of a GLB file.
struct GltfChunks {
  std::uint64_t json_begin = 0, json_bytes = 0;
  std::uint64_t binary_begin = 0, binary_bytes = 0;
  bool has_binary = false;
  std::uint64_t extra_bytes = 0;  // behind the end that the file states
};

// Where they are, of a file of which `head` is the beginning (all of it, or at least the first 20 bytes).
// Throws ItemError(unreadable, or unsupported_format for other versions) when the container is damaged or
// cut. A head that is shorter than the file finds no binary chunk.
GltfChunks gltf_chunks(std::string_view head, std::uint64_t file_bytes);

// Throws ItemError: unsupported_format for glTF 1.0 and for required extensions that are unknown, which it
// names; unreadable when a value has another type than the format says. What colors need is read with
// `colors` alone, and what is wrong there costs the colors; so it is with the extras. O(values).
GltfDocument parse_gltf(const JsonTree& json, bool colors = false, const MeshExtras& extras = {});

// "accessors[3]: `what`".
[[noreturn]] void fail_in(std::string_view list, std::uint64_t index, const std::string& what);

// The path of an external buffer relative to the model's folder, percent-decoded; empty with the reason set
// where it is none that may be opened: absolute, leading upwards, a URL.
std::string companion_path(std::string_view uri, std::string& reason);
bool is_data_uri(std::string_view uri);  // in any case

// Mesh `mesh` of node `node` (no_index: without a node, in a file without nodes) where the node stands.
struct GltfPart {
  std::uint32_t node = no_index, mesh = 0;
  AffineMap world = identity_map;
};

// What stands in the scene. A node below several parents stands below each of them; one that a list names
// twice stands there once, and so does one that the scene names beside a parent of it.
struct GltfScene {
  std::vector<AffineMap> world;      // of all nodes; of one with several parents that below the first
  std::vector<std::uint32_t> roots;  // in the order of the scene
  // How often each node stands in it; 0: not, or it has nothing to show.
  std::vector<std::uint64_t> copies;
  std::uint64_t repeated = 0;  // nodes that are named more than once
  std::uint32_t first_repeated = no_index;
};
// Throws ItemError: unreadable when a node is below itself, unsupported_format when copies of nodes are more
// than 2^24. O(nodes), whatever the number of copies.
GltfScene arrange_scene(const GltfDocument& document, const CancelToken& cancel);

// Calls visit for what has a mesh, in the order of the scene: nodes before their children.
void visit_parts(const GltfDocument& document, const GltfScene& scene, const CancelToken& cancel,
                 const std::function<void(const GltfPart&)>& visit);

// How often the mesh of this node stands at it; 1 without instances. Throws ItemError(unreadable) where
// their accessors are not there, are of other types, or differ in their counts.
std::uint64_t count_instances(const GltfDocument& document, std::uint32_t node);

// The weights of the morph targets of this mesh at this node (or without one).
const std::vector<double>& weights_of(const GltfDocument& document, std::uint32_t node, std::uint32_t mesh);

// Faces and the like that a primitive has.
struct GltfCounts {
  std::uint64_t vertices = 0, corners = 0, triangles = 0, left_out = 0;
};
// Throws ItemError(unreadable) when it names accessors that are not there or of another kind.
GltfCounts count_primitive(const GltfDocument& document, const GltfPrimitive& primitive);

// The external buffers, see FormatRow::companions. Throws ItemError(unsupported_format) for more than 1,024.
std::vector<std::string> companions_of(const GltfDocument& document);

// The files of images that materials show, the same way; of more than 1,024 the first.
std::vector<std::string> image_companions_of(const GltfDocument& document);

// What reading takes: vertices, triangles, the memory beside them; not the files. Throws as count_primitive,
// and ItemError(unsupported_format) when there is more than 32 bits can number.
MeshEstimate count_scene(const GltfDocument& document, const GltfScene& scene, const CancelToken& cancel);

// The JSON of a file.
std::string_view json_of(std::string_view content, const GltfChunks& chunks);

// See FormatRow::read. The file is not read in blocks.
PolygonMesh read_gltf(std::string_view content, const CancelToken& cancel, const BlockRule& rule,
                      const MeshSurroundings& around);

}  // namespace meander
