// The scene of a glTF file: what stands where, and how much it is, before any of it is read.
#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <tuple>
#include <utility>

#include "io/mesh/gltf_document.h"

namespace meander {

namespace {

constexpr std::uint64_t most_parts = std::uint64_t{1} << 24;
constexpr std::size_t most_companions = 1024;
constexpr std::size_t nodes_between_checks = 4096;
// A decoder of Draco streams keeps tables of corners and attributes beside what it makes.
constexpr std::uint64_t draco_bytes_per_triangle = 200, draco_bytes_per_vertex = 640;
// Flat regular grids take least: entropy coding gives their corners and positions next to nothing.
constexpr std::uint64_t draco_free_elements = 1 << 16, draco_elements_per_byte = 4096;

// Calls visit(node, parent) for the trees below the roots, parents first, children in their order. `seen`
// holds the nodes that were met before; meeting one again is an error.
template <class Visit>
void walk(const GltfDocument& document, const std::vector<std::uint32_t>& roots, std::vector<bool>& seen,
          const CancelToken& cancel, Visit visit) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> open;
  for (auto root = roots.rbegin(); root != roots.rend(); ++root) open.emplace_back(*root, no_index);
  for (std::size_t steps = 1; !open.empty(); ++steps) {
    if (steps % nodes_between_checks == 0) cancel.check();
    const auto [node, parent] = open.back();
    open.pop_back();
    if (node >= document.nodes.size()) fail_in("nodes", node, "there is no such node");
    if (seen[node]) fail_in("nodes", node, "it is reached twice, but nodes have one parent at most");
    seen[node] = true;
    visit(node, parent);
    const std::vector<std::uint32_t>& children = document.nodes[node].children;
    for (auto child = children.rbegin(); child != children.rend(); ++child) open.emplace_back(*child, node);
  }
}

std::vector<std::uint32_t> roots_of(const GltfDocument& document) {
  std::vector<bool> is_child(document.nodes.size(), false);
  for (const GltfNode& node : document.nodes)
    for (const std::uint32_t child : node.children)
      if (child < is_child.size()) is_child[child] = true;
  std::vector<std::uint32_t> roots;
  for (std::uint32_t node = 0; node < document.nodes.size(); ++node)
    if (!is_child[node]) roots.push_back(node);
  return roots;
}

const GltfAccessor& accessor_of(const GltfDocument& document, std::uint32_t number, const char* of_what) {
  if (number >= document.accessors.size())
    throw ItemError(Status::unreadable, fmt::format("the accessor {} of {} is not there (there are {})",
                                                    number, of_what, document.accessors.size()));
  return document.accessors[number];
}

// By the sizes that the file states, so that a false count is found before memory is asked for.
void check_fits(const GltfDocument& document, std::uint32_t number) {
  const GltfAccessor& accessor = document.accessors[number];
  if (accessor.view >= document.views.size() || accessor.count == 0) return;
  const GltfView& view = document.views[accessor.view];
  const std::uint64_t bytes = bytes_of(accessor.component) * accessor.width;
  const std::uint64_t stride = view.stride == 0 ? bytes : view.stride;
  const std::uint64_t there = view.packing == GltfView::Packing::none ? view.bytes : view.count * view.stride;
  if (accessor.offset > there || (accessor.count - 1) * stride + bytes > there - accessor.offset)
    fail_in("accessors", number,
            fmt::format(
                "{} elements of {} bytes, {} apart, from byte {}, do not fit into the {} bytes of their view",
                accessor.count, bytes, stride, accessor.offset, there));
}

void check_draco_fits(const GltfDocument& document, const GltfPrimitive& primitive,
                      const GltfCounts& counts) {
  if (primitive.draco_view >= document.views.size())
    throw ItemError(Status::unreadable, fmt::format("there is no buffer view {}", primitive.draco_view));
  const std::uint64_t bytes = document.views[primitive.draco_view].bytes;
  if (std::max(counts.vertices, counts.triangles) > draco_free_elements + draco_elements_per_byte * bytes)
    fail_in("bufferViews", primitive.draco_view,
            fmt::format("{} bytes of Draco cannot hold {} vertices and {} triangles", bytes, counts.vertices,
                        counts.triangles));
}

std::uint64_t elements_of(const GltfPrimitive& primitive, std::uint64_t corners) {
  switch (primitive.mode) {
    case 1:
      return corners / 2;
    case 3:
      return corners < 2 ? 0 : corners - 1;
    case 4:
      return corners / 3;
    case 5:
    case 6:
      return corners < 3 ? 0 : corners - 2;
    default:
      return corners;
  }
}

}  // namespace

AffineMap product(const AffineMap& a, const AffineMap& b) {
  AffineMap c;
  for (std::size_t row = 0; row < 12; row += 4)
    for (std::size_t column = 0; column < 4; ++column)
      c[row + column] = a[row] * b[column] + a[row + 1] * b[4 + column] + a[row + 2] * b[8 + column] +
                        (column == 3 ? a[row + 3] : 0.0);
  return c;
}

GltfScene arrange_scene(const GltfDocument& document, const CancelToken& cancel) {
  GltfScene scene;
  const std::vector<std::uint32_t> roots = roots_of(document);
  scene.world.resize(document.nodes.size());
  std::vector<bool> seen(document.nodes.size(), false);
  walk(document, roots, seen, cancel, [&](std::uint32_t node, std::uint32_t parent) {
    const AffineMap& local = document.nodes[node].local;
    scene.world[node] = parent == no_index ? local : product(scene.world[parent], local);
  });
  const auto cyclic = std::find(seen.begin(), seen.end(), false);
  if (cyclic != seen.end())
    fail_in("nodes", static_cast<std::uint64_t>(cyclic - seen.begin()), "it is below itself");
  std::fill(seen.begin(), seen.end(), false);
  walk(document, document.has_scenes ? document.scene_nodes : roots, seen, cancel,
       [&](std::uint32_t node, std::uint32_t) {
         const std::uint32_t mesh = document.nodes[node].mesh;
         if (mesh == no_index) return;
         if (mesh >= document.meshes.size()) fail_in("nodes", node, fmt::format("there is no mesh {}", mesh));
         scene.parts.push_back({node, mesh});
       });
  if (document.nodes.empty())  // a file of meshes for others to place
    for (std::uint32_t mesh = 0; mesh < document.meshes.size(); ++mesh)
      scene.parts.push_back({no_index, mesh});
  return scene;
}

GltfCounts count_primitive(const GltfDocument& document, const GltfPrimitive& primitive) {
  GltfCounts counts;
  if (primitive.attributes.positions == no_index)
    return counts;  // to be made by an extension or by a program
  const GltfAccessor& positions = accessor_of(document, primitive.attributes.positions, "positions");
  if (positions.width != 3 || positions.component == GltfComponent::uint32)
    fail_in("accessors", primitive.attributes.positions,
            "positions are three numbers of 8, 16 bits or float");
  counts.corners = positions.count;
  const bool is_draco = primitive.draco_view != no_index;
  if (!is_draco) check_fits(document, primitive.attributes.positions);
  if (primitive.indices != no_index) {
    const GltfAccessor& indices = accessor_of(document, primitive.indices, "indices");
    if (indices.width != 1 || !is_index(indices.component))
      fail_in("accessors", primitive.indices, "indices are single numbers of 8, 16 or 32 bits");
    if (!is_draco) check_fits(document, primitive.indices);
    counts.corners = indices.count;
  }
  const std::uint64_t elements = elements_of(primitive, counts.corners);
  if (primitive.mode < 4) {
    counts.left_out = elements;
    return counts;
  }
  counts.vertices = positions.count;
  counts.triangles = elements;
  counts.left_out = primitive.mode == 4 && counts.corners % 3 != 0 ? 1 : 0;
  if (is_draco) check_draco_fits(document, primitive, counts);
  return counts;
}

MeshEstimate count_scene(const GltfDocument& document, const GltfScene& scene, const CancelToken& cancel) {
  // Of each mesh once: what stands in the scene a million times is looked at once.
  std::vector<GltfCounts> of_mesh(document.meshes.size());
  std::vector<bool> counted(document.meshes.size(), false);
  MeshEstimate total;
  std::uint64_t parts = 0, most_at_once = 0;
  for (std::size_t i = 0; i < scene.parts.size(); ++i) {
    if (i % nodes_between_checks == 0) cancel.check();
    const std::uint32_t number = scene.parts[i].mesh;
    GltfCounts& mesh = of_mesh[number];
    if (!counted[number]) {
      counted[number] = true;
      // Primitives of one mesh may share their vertices, unless they have colours or attributes of their own
      // that are asked for. Texture coordinates of their own would take memory too: they count as vertices.
      std::set<
          std::tuple<GltfAttributes, std::uint32_t, std::vector<std::uint32_t>, std::vector<std::uint32_t>>>
          blocks;
      for (const GltfPrimitive& primitive : document.meshes[number]) {
        const GltfCounts counts = count_primitive(document, primitive);
        const bool is_draco = primitive.draco_view != no_index;
        const std::tuple block(primitive.attributes, primitive.colors, primitive.asked,
                               primitive.coordinates);
        if (is_draco || blocks.insert(block).second) mesh.vertices += counts.vertices;
        mesh.triangles += counts.triangles;
        const std::uint64_t sets = primitive.attributes.joints.size();
        most_at_once = std::max(most_at_once, (is_draco ? draco_bytes_per_triangle : 0) * counts.triangles +
                                                  (is_draco ? draco_bytes_per_vertex : 0) * counts.vertices +
                                                  sizeof(double) * (3 + 8 * sets) * counts.vertices +
                                                  4 * counts.corners);
      }
    }
    total.vertices += mesh.vertices;
    total.triangles += mesh.triangles;
    parts += document.meshes[number].size();
    check_count(total.vertices, "vertices");
    check_count(3 * total.triangles, "corners");
    if (parts > most_parts)
      throw ItemError(Status::unsupported_format, fmt::format("more than {} parts in the scene", most_parts));
  }
  total.decoding_bytes = most_at_once;
  for (const GltfView& view : document.views)
    if (view.packing != GltfView::Packing::none) total.decoding_bytes += view.count * view.stride;
  for (const auto& uri : document.buffer_uris)
    if (uri && is_data_uri(*uri)) total.decoding_bytes += uri->size();
  return total;
}

std::vector<std::string> companions_of(const GltfDocument& document) {
  std::vector<std::string> paths;
  std::set<std::string> named;
  std::string reason;
  for (const auto& uri : document.buffer_uris) {
    if (!uri || is_data_uri(*uri)) continue;
    const std::string path = companion_path(*uri, reason);
    if (path.empty() || !named.insert(path).second) continue;
    if (paths.size() == most_companions)
      throw ItemError(Status::unsupported_format,
                      fmt::format("it names more than {} files", most_companions));
    paths.push_back(path);
  }
  return paths;
}

std::vector<std::string> image_companions_of(const GltfDocument& document) {
  std::vector<std::string> paths;
  std::set<std::string> named;
  std::string reason;
  for (const GltfMaterial& material : document.materials) {
    if (material.image >= document.images.size()) continue;
    const auto& uri = document.images[material.image].uri;
    if (!uri || is_data_uri(*uri)) continue;
    const std::string path = companion_path(*uri, reason);
    if (path.empty() || paths.size() == most_companions) continue;
    if (named.insert(path).second) paths.push_back(path);
  }
  return paths;
}

}  // namespace meander
