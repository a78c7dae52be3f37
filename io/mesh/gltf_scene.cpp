// The scene of a glTF file: what stands where, and how much it is, before any of it is read.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>
#include <optional>
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
// What places an instance, while its node is read.
constexpr std::uint64_t bytes_per_instance = (3 + 4 + 3) * sizeof(double);
// Larger counts of copies stay here: they are refused, whatever they are.
constexpr std::uint64_t most_copies = std::uint64_t{1} << 32;

// A node on the way down, and which of its children is next.
struct Step {
  std::uint32_t node = 0;
  std::size_t next = 0;
};

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

namespace {

// Where all nodes stand, of one with several parents below the first, and an order of them in which parents
// come before their children.
std::vector<std::uint32_t> place_nodes(const GltfDocument& document, const std::vector<std::uint32_t>& roots,
                                       std::vector<AffineMap>& world, const CancelToken& cancel) {
  enum : std::uint8_t { unseen, open, done };
  std::vector<std::uint8_t> state(document.nodes.size(), unseen);
  world.resize(document.nodes.size());
  std::vector<std::uint32_t> order;
  order.reserve(document.nodes.size());
  std::vector<Step> path;
  const auto enter = [&](std::uint32_t node) {
    state[node] = open;
    path.push_back({node, 0});
  };
  std::size_t steps = 0;
  for (const std::uint32_t root : roots) {
    world[root] = document.nodes[root].local;
    enter(root);
    while (!path.empty()) {
      if (++steps % nodes_between_checks == 0) cancel.check();
      Step& step = path.back();
      const GltfNode& node = document.nodes[step.node];
      if (step.next == node.children.size()) {
        state[step.node] = done;
        order.push_back(step.node);
        path.pop_back();
        continue;
      }
      const std::uint32_t child = node.children[step.next++];
      if (child >= document.nodes.size()) fail_in("nodes", child, "there is no such node");
      if (state[child] == open) fail_in("nodes", child, "it is below itself");
      if (state[child] == done) continue;
      world[child] = product(world[step.node], document.nodes[child].local);
      enter(child);
    }
  }
  const auto cyclic = std::find(state.begin(), state.end(), unseen);
  if (cyclic != state.end())
    fail_in("nodes", static_cast<std::uint64_t>(cyclic - state.begin()), "it is below itself");
  std::reverse(order.begin(), order.end());
  return order;
}

// Whether there is something to draw at each node or below it.
std::vector<bool> drawn_nodes(const GltfDocument& document, const std::vector<std::uint32_t>& order) {
  std::vector<bool> drawn(document.nodes.size(), false);
  for (auto number = order.rbegin(); number != order.rend(); ++number) {
    const GltfNode& node = document.nodes[*number];
    drawn[*number] = !node.is_hidden && (node.mesh != no_index ||
                                         std::any_of(node.children.begin(), node.children.end(),
                                                     [&](std::uint32_t child) { return drawn[child]; }));
  }
  return drawn;
}

// Finds which of the nodes that the scene names stand below no other of them, and how often each node stands.
void count_copies(const GltfDocument& document, const std::vector<std::uint32_t>& named,
                  const std::vector<std::uint32_t>& order, GltfScene& scene) {
  const std::vector<bool> drawn = drawn_nodes(document, order);
  std::vector<bool> reached(document.nodes.size(), false);
  std::vector<std::uint32_t> parents(document.nodes.size(), 0);
  for (const std::uint32_t node : named) reached[node] = true;
  for (const std::uint32_t node : order)
    if (reached[node] && drawn[node])
      for (const std::uint32_t child : document.nodes[node].children) {
        reached[child] = true;
        ++parents[child];
      }
  std::uint64_t repeats = document.repeated_scene_nodes;
  scene.copies.assign(document.nodes.size(), 0);
  for (const std::uint32_t node : named) {
    if (parents[node] == 0) {
      scene.roots.push_back(node);
      scene.copies[node] = drawn[node] ? 1 : 0;
    } else if (drawn[node]) {
      ++repeats;
      if (scene.first_repeated == no_index) scene.first_repeated = node;
    }
  }
  std::uint64_t steps = 0, all = most_parts;
  for (const std::uint32_t number : order) {
    const std::uint64_t copies = scene.copies[number];
    if (copies == 0) continue;
    const GltfNode& node = document.nodes[number];
    if (node.mesh != no_index && node.mesh >= document.meshes.size())
      fail_in("nodes", number, fmt::format("there is no mesh {}", node.mesh));
    for (const std::uint32_t child : node.children)
      if (drawn[child]) scene.copies[child] = std::min(most_copies, scene.copies[child] + copies);
    steps += copies * (1 + node.children.size());
    all += 1 + node.children.size();
    if (steps > all)
      throw ItemError(Status::unsupported_format,
                      fmt::format("more than {} copies of nodes in the scene", most_parts));
    repeats += node.repeated_children;
    if (parents[number] > 1) ++repeats;
    if ((parents[number] > 1 || node.repeated_children > 0) && scene.first_repeated == no_index)
      scene.first_repeated = number;
  }
  scene.repeated = repeats;
}

}  // namespace

GltfScene arrange_scene(const GltfDocument& document, const CancelToken& cancel) {
  GltfScene scene;
  const std::vector<std::uint32_t> roots = roots_of(document);
  const std::vector<std::uint32_t> order = place_nodes(document, roots, scene.world, cancel);
  if (document.has_scenes)
    for (const std::uint32_t node : document.scene_nodes)
      if (node >= document.nodes.size()) fail_in("nodes", node, "there is no such node");
  count_copies(document, document.has_scenes ? document.scene_nodes : roots, order, scene);
  return scene;
}

void visit_parts(const GltfDocument& document, const GltfScene& scene, const CancelToken& cancel,
                 const std::function<void(const GltfPart&)>& visit) {
  if (document.nodes.empty())  // a file of meshes for others to place
    for (std::uint32_t mesh = 0; mesh < document.meshes.size(); ++mesh) visit({no_index, mesh});
  std::vector<Step> path;
  std::vector<AffineMap> worlds;  // of the nodes on the path
  const auto enter = [&](std::uint32_t number) {
    const GltfNode& node = document.nodes[number];
    worlds.push_back(path.empty() ? node.local : product(worlds.back(), node.local));
    path.push_back({number, 0});
    if (node.mesh != no_index) visit({number, node.mesh, worlds.back()});
  };
  std::size_t steps = 0;
  for (const std::uint32_t root : scene.roots) {
    if (scene.copies[root] > 0) enter(root);
    while (!path.empty()) {
      if (++steps % nodes_between_checks == 0) cancel.check();
      Step& step = path.back();
      const GltfNode& node = document.nodes[step.node];
      if (step.next == node.children.size()) {
        path.pop_back();
        worlds.pop_back();
        continue;
      }
      const std::uint32_t child = node.children[step.next++];
      if (scene.copies[child] > 0) enter(child);
    }
  }
}

std::uint64_t count_instances(const GltfDocument& document, std::uint32_t number) {
  if (document.nodes[number].instances == no_index) return 1;
  const GltfInstances& instances = document.instances[document.nodes[number].instances];
  std::optional<std::uint64_t> count;
  for (const auto& [accessor, width] :
       {std::pair{instances.moves, 3u}, {instances.turns, 4u}, {instances.scales, 3u}}) {
    if (accessor == no_index) continue;
    const GltfAccessor& values = accessor_of(document, accessor, "instances");
    if (values.width != width)
      fail_in("accessors", accessor, fmt::format("of instances {} numbers each are needed", width));
    check_fits(document, accessor);
    if (count && *count != values.count)
      fail_in("nodes", number,
              fmt::format("its instances are {} by one accessor and {} by another", *count, values.count));
    count = values.count;
  }
  return *count;
}

const std::vector<double>& weights_of(const GltfDocument& document, std::uint32_t node, std::uint32_t mesh) {
  const bool has_own = node != no_index && !document.nodes[node].weights.empty();
  return has_own ? document.nodes[node].weights : document.meshes[mesh].weights;
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

namespace {

struct MeshCounts {
  std::uint64_t vertices = 0, triangles = 0, morphed = 0;
  std::uint64_t most_at_once = 0;  // bytes beside the mesh while a primitive is read
  bool counted = false;
};

// The counts of a mesh at one place. `morphs`: some of its morph targets are not at 0.
MeshCounts count_mesh(const GltfDocument& document, std::uint32_t number, bool morphs) {
  MeshCounts mesh;
  mesh.counted = true;
  // Primitives of one mesh may share their vertices, unless they have colors, targets or attributes of their
  // own that are asked for. Texture coordinates of their own would take memory too: they count as vertices.
  std::set<std::tuple<GltfAttributes, std::uint32_t, std::vector<std::uint32_t>, std::vector<std::uint32_t>,
                      std::vector<std::uint32_t>>>
      blocks;
  for (const GltfPrimitive& primitive : document.meshes[number].primitives) {
    const GltfCounts counts = count_primitive(document, primitive);
    const bool is_draco = primitive.draco_view != no_index, bends = morphs && !primitive.targets.empty();
    const std::tuple block(primitive.attributes, primitive.colors, primitive.asked, primitive.coordinates,
                           morphs ? primitive.targets : std::vector<std::uint32_t>());
    if (is_draco || blocks.insert(block).second) mesh.vertices += counts.vertices;
    mesh.triangles += counts.triangles;
    if (bends) {
      const auto moving = std::count_if(primitive.targets.begin(), primitive.targets.end(),
                                        [](std::uint32_t target) { return target != no_index; });
      mesh.morphed += static_cast<std::uint64_t>(moving) * counts.vertices;
    }
    const std::uint64_t sets = primitive.attributes.joints.size();
    // The triangles of strips are listed where they are cut.
    mesh.most_at_once =
        std::max(mesh.most_at_once, (is_draco ? draco_bytes_per_triangle : 0) * counts.triangles +
                                        (is_draco ? draco_bytes_per_vertex : 0) * counts.vertices +
                                        sizeof(double) * (3 + 8 * sets + (bends ? 6 : 0)) * counts.vertices +
                                        (primitive.mode > 4 ? 16 : 4) * counts.corners);
  }
  check_count(mesh.vertices, "vertices");
  check_count(3 * mesh.triangles, "corners");
  return mesh;
}

}  // namespace

MeshEstimate count_scene(const GltfDocument& document, const GltfScene& scene, const CancelToken& cancel) {
  // The counts of each mesh, with morph targets and without: a mesh that stands in the scene a million times
  // is looked at once.
  std::vector<std::array<MeshCounts, 2>> of_mesh(document.meshes.size());
  MeshEstimate total;
  std::uint64_t parts = 0, morphed = 0, most_at_once = 0, instance_bytes = 0;
  const auto add = [&](std::uint32_t node, std::uint32_t number, std::uint64_t copies) {
    const std::vector<double>& weights = weights_of(document, node, number);
    const bool morphs = std::any_of(weights.begin(), weights.end(), [](double w) { return w != 0; });
    MeshCounts& mesh = of_mesh[number][morphs ? 1 : 0];
    if (!mesh.counted) mesh = count_mesh(document, number, morphs);
    parts += copies * std::max<std::uint64_t>(1, document.meshes[number].primitives.size());
    // Below 2^24 parts the products below are far from 2^64.
    if (copies > most_parts || parts > most_parts)
      throw ItemError(Status::unsupported_format, fmt::format("more than {} parts in the scene", most_parts));
    total.vertices += copies * mesh.vertices;
    total.triangles += copies * mesh.triangles;
    morphed += copies * std::min<std::uint64_t>(mesh.morphed, no_index);
    check_count(total.vertices, "vertices");
    check_count(3 * total.triangles, "corners");
    check_count(morphed, "vertices of morph targets");
    if (copies > 0) most_at_once = std::max(most_at_once, mesh.most_at_once);
  };
  for (std::uint32_t node = 0; node < document.nodes.size(); ++node) {
    if (node % nodes_between_checks == 0) cancel.check();
    if (scene.copies[node] == 0 || document.nodes[node].mesh == no_index) continue;
    const std::uint64_t instances = count_instances(document, node);
    add(node, document.nodes[node].mesh, scene.copies[node] * instances);
    if (document.nodes[node].instances != no_index)
      instance_bytes = std::max(instance_bytes, instances * bytes_per_instance);
  }
  if (document.nodes.empty())
    for (std::uint32_t mesh = 0; mesh < document.meshes.size(); ++mesh) add(no_index, mesh, 1);
  total.decoding_bytes = most_at_once + instance_bytes;
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
  const auto add = [&](std::uint32_t image) {
    if (image >= document.images.size()) return;
    const auto& uri = document.images[image].uri;
    if (!uri || is_data_uri(*uri)) return;
    const std::string path = companion_path(*uri, reason);
    if (path.empty() || paths.size() == most_companions) return;
    if (named.insert(path).second) paths.push_back(path);
  };
  for (const GltfMaterial& material : document.materials) {
    add(material.image);
    add(material.other_image);
  }
  return paths;
}

}  // namespace meander
