#include "io/mesh/gltf_document.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <utility>

#include "io/mesh/byte_order.h"
#include "io/mesh/gltf_extensions.h"
#include "io/mesh/part_names.h"
#include "kernels/core/portable_angles.h"

namespace meander {

namespace {

constexpr std::uint64_t most_stride = 65535;
// The codecs of EXT_meshopt_compression keep at least a byte of 64 of vertices and of 12 of indices.
constexpr std::uint64_t most_ratio_of_codecs = 128;
constexpr std::string_view glb_magic = "glTF";
constexpr std::uint64_t glb_header = 12, chunk_header = 8;

// The members of one entry of a list of the file.
class Entry {
 public:
  Entry(JsonValue value, std::string_view list, std::uint64_t index)
      : value_(value), list_(list), index_(index) {
    if (!value.is_object()) fail("it is not an object");
  }

  [[noreturn]] void fail(const std::string& what) const { fail_in(list_, index_, what); }
  JsonValue member(std::string_view name) const { return value_.member(name); }

  // An entry inside this one, for messages under the same place.
  std::optional<Entry> inside(std::string_view name) const { return inside(value_.member(name), name); }
  std::optional<Entry> inside(JsonValue value, std::string_view name) const {
    if (!value) return std::nullopt;
    if (!value.is_object()) fail(fmt::format("`{}` is not an object", name));
    return Entry(value, list_, index_);
  }
  std::optional<Entry> extension(std::string_view name) const {
    const std::optional<Entry> all = inside("extensions");
    return all ? all->inside(name) : std::nullopt;
  }

  std::uint64_t count(std::string_view name) const {
    if (!member(name)) fail(fmt::format("`{}` is missing", name));
    return count(name, 0);
  }
  std::uint64_t count(std::string_view name, std::uint64_t otherwise) const {
    const JsonValue value = member(name);
    if (!value) return otherwise;
    const std::optional<std::uint64_t> whole = value.count();
    if (!whole) fail(fmt::format("`{}` is not a whole number of 0 or more", name));
    return *whole;
  }
  // The number of another entry; no_index where it is not given.
  std::uint32_t reference(std::string_view name) const { return reference(member(name), name); }
  std::uint32_t reference(JsonValue value, std::string_view name) const {
    if (!value) return no_index;
    const std::optional<std::uint64_t> whole = value.count();
    if (!whole || *whole >= no_index) fail(fmt::format("`{}` is not the number of an entry", name));
    return static_cast<std::uint32_t>(*whole);
  }
  std::vector<std::uint32_t> references(std::string_view name) const {
    std::vector<std::uint32_t> numbers;
    const JsonValue list = member(name);
    if (list && !list.is_array()) fail(fmt::format("`{}` is not a list", name));
    for (const JsonValue& value : list.items()) numbers.push_back(reference(value, name));
    return numbers;
  }
  std::optional<std::string_view> text(std::string_view name) const {
    const JsonValue value = member(name);
    if (value && !value.text()) fail(fmt::format("`{}` is not a text", name));
    return value.text();
  }
  template <std::size_t N>
  bool numbers(std::string_view name, std::array<double, N>& out) const {
    const JsonValue list = member(name);
    if (!list) return false;
    const std::vector<JsonValue> items = list.items();
    if (!list.is_array() || items.size() != N) fail(fmt::format("`{}` is not a list of {} numbers", name, N));
    for (std::size_t k = 0; k < N; ++k) {
      const std::optional<double> number = items[k].number();
      if (!number) fail(fmt::format("`{}` is not a list of {} numbers", name, N));
      out[k] = *number;
    }
    return true;
  }
  GltfComponent component(std::string_view name) const {
    const std::uint64_t number = count(name);
    const bool known = (number >= 5120 && number <= 5123) || number == 5125 || number == 5126;
    if (!known) fail(fmt::format("`{}` is {}, which is no type", name, number));
    return static_cast<GltfComponent>(number);
  }

 private:
  JsonValue value_;
  std::string_view list_;
  std::uint64_t index_;
};

// Calls read(Entry) for each of the list.
template <class Read>
void read_list(JsonValue root, std::string_view name, Read read) {
  const JsonValue list = root.member(name);
  if (list && !list.is_array()) throw ItemError(Status::unreadable, fmt::format("`{}` is not a list", name));
  std::uint64_t index = 0;
  for (const JsonValue& value : list.items()) read(Entry(value, name, index++));
}

GltfView read_view(const Entry& entry) {
  using Packing = GltfView::Packing;
  using Filter = GltfView::Filter;
  GltfView view;
  const std::optional<Entry> packed = entry.extension("EXT_meshopt_compression");
  const Entry& from = packed ? *packed : entry;
  view.buffer = from.reference("buffer");
  view.offset = from.count("byteOffset", 0);
  view.bytes = from.count("byteLength");
  view.stride = from.count("byteStride", 0);
  if (view.stride > most_stride) entry.fail(fmt::format("a `byteStride` of {} is none", view.stride));
  if (!packed) return view;
  view.count = from.count("count");
  const std::string_view mode = from.text("mode").value_or(""), filter = from.text("filter").value_or("NONE");
  view.packing = mode == "ATTRIBUTES"  ? Packing::attributes
                 : mode == "TRIANGLES" ? Packing::triangles
                 : mode == "INDICES"   ? Packing::indices
                                       : Packing::none;
  view.filter = filter == "OCTAHEDRAL"    ? Filter::octahedral
                : filter == "QUATERNION"  ? Filter::quaternion
                : filter == "EXPONENTIAL" ? Filter::exponential
                                          : Filter::none;
  if (view.packing == Packing::none) entry.fail(fmt::format("the compression mode `{}` is unknown", mode));
  if (view.filter == Filter::none && filter != "NONE")
    entry.fail(fmt::format("the filter `{}` is unknown", filter));
  const bool is_indices = view.packing != Packing::attributes;
  const std::uint64_t step = view.filter == Filter::quaternion ? 8 : 4;
  if (is_indices
          ? view.stride != 2 && view.stride != 4
          : view.stride == 0 || view.stride > 256 || view.stride % step != 0 ||
                (view.filter >= Filter::octahedral && view.filter <= Filter::quaternion && view.stride > 8))
    entry.fail(fmt::format("a compressed view cannot have elements of {} bytes", view.stride));
  if (view.packing == Packing::triangles && view.count % 3 != 0)
    entry.fail(fmt::format("{} compressed indices are no triangles", view.count));
  check_count(view.count, "elements of a buffer view");
  if (view.count * view.stride / most_ratio_of_codecs > view.bytes)
    entry.fail(fmt::format("{} bytes cannot unpack to {}", view.bytes, view.count * view.stride));
  return view;
}

GltfAccessor read_accessor(const Entry& entry) {
  static constexpr std::array<std::pair<std::string_view, std::uint32_t>, 7> widths = {
      {{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT2", 0}, {"MAT3", 0}, {"MAT4", 16}}};
  GltfAccessor accessor;
  accessor.view = entry.reference("bufferView");
  accessor.offset = entry.count("byteOffset", 0);
  accessor.count = entry.count("count");
  check_count(accessor.count, "elements of an accessor");
  accessor.component = entry.component("componentType");
  const std::string_view type = entry.text("type").value_or("");
  const auto found =
      std::find_if(widths.begin(), widths.end(), [&](const auto& w) { return w.first == type; });
  if (found == widths.end()) entry.fail(fmt::format("the type `{}` is none", type));
  accessor.width = found->second;
  if (const JsonValue normalized = entry.member("normalized")) {
    if (!normalized.truth()) entry.fail("`normalized` is neither true nor false");
    accessor.normalized = *normalized.truth();
  }
  const std::optional<Entry> sparse = entry.inside("sparse");
  if (!sparse) return accessor;
  const std::optional<Entry> numbers = sparse->inside("indices"), values = sparse->inside("values");
  if (!numbers || !values) entry.fail("`sparse` lacks its indices or values");
  accessor.sparse_count = sparse->count("count");
  if (accessor.sparse_count > accessor.count)
    entry.fail(fmt::format("{} of {} elements are said to be sparse", accessor.sparse_count, accessor.count));
  accessor.sparse_numbers = numbers->reference("bufferView");
  accessor.sparse_numbers_offset = numbers->count("byteOffset", 0);
  accessor.sparse_component = numbers->component("componentType");
  if (!is_index(accessor.sparse_component))
    entry.fail("the indices of `sparse` are of a type that numbers nothing");
  accessor.sparse_values = values->reference("bufferView");
  accessor.sparse_values_offset = values->count("byteOffset", 0);
  return accessor;
}

// The number of sets of joints, and of texture coordinates: each is looked up among all attributes.
constexpr std::size_t most_sets = 64;

GltfAttributes read_attributes(const Entry& entry) {
  GltfAttributes attributes;
  const std::optional<Entry> list = entry.inside("attributes");
  if (!list) return attributes;
  attributes.positions = list->reference("POSITION");
  for (std::size_t set = 0;; ++set) {
    const std::string joints = fmt::format("JOINTS_{}", set), weights = fmt::format("WEIGHTS_{}", set);
    if (!list->member(joints) || !list->member(weights)) return attributes;
    if (set == most_sets) entry.fail(fmt::format("more than {} sets of joints", most_sets));
    attributes.joints.push_back(list->reference(joints));
    attributes.weights.push_back(list->reference(weights));
  }
}

// The number of another entry, or none where it is no number.
std::uint32_t lenient_reference(JsonValue value) {
  const std::optional<std::uint64_t> number = value ? value.count() : std::nullopt;
  return number && *number < no_index ? static_cast<std::uint32_t>(*number) : no_index;
}

double lenient_number(JsonValue value, double otherwise) {
  const std::optional<double> number = value ? value.number() : std::nullopt;
  return number && std::isfinite(*number) ? *number : otherwise;
}

// The lists that materials lead into.
struct TextureLists {
  std::vector<JsonValue> textures, samplers;

  explicit TextureLists(JsonValue root)
      : textures(root.member("textures").items()), samplers(root.member("samplers").items()) {}
  static JsonValue entry(const std::vector<JsonValue>& list, std::uint32_t number) {
    return number < list.size() ? list[number] : JsonValue();
  }
};

TextureWrap wrap_of(JsonValue sampler, std::string_view name) {
  switch (lenient_reference(sampler.member(name))) {
    case 33071:
      return TextureWrap::clamp;
    case 33648:
      return TextureWrap::mirror;
    default:
      return TextureWrap::repeat;
  }
}

// KHR_texture_transform: scaled, turned counter-clockwise as one sees the image, moved. v points down.
std::array<double, 6> placement_of(JsonValue transform) {
  const std::vector<JsonValue> scales = transform.member("scale").items(),
                               moves = transform.member("offset").items();
  const auto pair = [](const std::vector<JsonValue>& values, std::size_t k, double otherwise) {
    return values.size() == 2 ? lenient_number(values[k], otherwise) : otherwise;
  };
  const Direction turn =
      direction_of(std::fmod(lenient_number(transform.member("rotation"), 0), 2 * std::numbers::pi));
  const double x = pair(scales, 0, 1), y = pair(scales, 1, 1);
  return {turn.cosine * x, turn.sine * y,   pair(moves, 0, 0),
          -turn.sine * x,  turn.cosine * y, pair(moves, 1, 0)};
}

// Which image a texture shows: that of an extension whose format is read, or else that of the format itself,
// or else one that is not read, which is then lost by its name.
void choose_image(JsonValue texture, GltfMaterial& material) {
  const auto of_extension = [&](const char* name) {
    return lenient_reference(texture.member("extensions").member(name).member("source"));
  };
  material.image = lenient_reference(texture.member("source"));
  if (const std::uint32_t webp = of_extension("EXT_texture_webp"); webp != no_index)
    material.other_image = std::exchange(material.image, webp);
  for (const char* const name : {"KHR_texture_basisu", "EXT_texture_avif", "MSFT_texture_dds"})
    if (material.image == no_index) {
      material.image = of_extension(name);
      material.is_foreign = material.image != no_index;
    }
}

void read_texture(const TextureLists& lists, JsonValue info, GltfMaterial& material) {
  constexpr std::uint32_t nearest_filter = 9728;
  material.has_texture = true;
  const JsonValue transform = info.member("extensions").member("KHR_texture_transform");
  const std::uint32_t set = lenient_reference(info.member("texCoord")),
                      other = lenient_reference(transform.member("texCoord"));
  material.coordinate_set = other != no_index ? other : set != no_index ? set : 0;
  if (transform) material.texture.placement = placement_of(transform);
  const JsonValue texture = TextureLists::entry(lists.textures, lenient_reference(info.member("index")));
  choose_image(texture, material);
  const JsonValue sampler = TextureLists::entry(lists.samplers, lenient_reference(texture.member("sampler")));
  material.texture.wrap_u = wrap_of(sampler, "wrapS");
  material.texture.wrap_v = wrap_of(sampler, "wrapT");
  material.texture.nearest = lenient_reference(sampler.member("magFilter")) == nearest_filter;
}

// White, where there is no factor, is what the format says.
GltfMaterial read_material(const TextureLists& lists, JsonValue value) {
  GltfMaterial material;
  const JsonValue rough = value.member("pbrMetallicRoughness"),
                  glossy = value.member("extensions").member("KHR_materials_pbrSpecularGlossiness");
  const bool is_glossy = glossy && (glossy.member("diffuseFactor") || glossy.member("diffuseTexture"));
  const JsonValue factor = is_glossy ? glossy.member("diffuseFactor") : rough.member("baseColorFactor"),
                  texture = is_glossy ? glossy.member("diffuseTexture") : rough.member("baseColorTexture");
  const std::vector<JsonValue> values = factor.items();
  for (std::size_t k = 0; k < 3 && values.size() >= 3; ++k)
    material.color[k] = static_cast<float>(values[k].number().value_or(1));
  if (texture) read_texture(lists, texture, material);
  return material;
}

std::vector<std::uint32_t> read_coordinates(JsonValue attributes) {
  std::vector<std::uint32_t> sets;
  while (sets.size() < most_sets) {
    const JsonValue coordinates = attributes.member(fmt::format("TEXCOORD_{}", sets.size()));
    if (!coordinates) break;
    sets.push_back(lenient_reference(coordinates));
  }
  return sets;
}

std::vector<std::uint32_t> read_asked(JsonValue attributes, std::span<const AttributeColumn> columns) {
  std::vector<std::uint32_t> asked;
  // Other names are those of the format itself, whose values are no user's.
  for (const AttributeColumn& column : columns)
    asked.push_back(column.name.starts_with('_') ? lenient_reference(attributes.member(column.name))
                                                 : no_index);
  return asked;
}

std::vector<std::uint32_t> read_targets(const Entry& primitive) {
  std::vector<std::uint32_t> targets;
  const JsonValue list = primitive.member("targets");
  if (list && !list.is_array()) primitive.fail("`targets` is not a list");
  for (const JsonValue& value : list.items())
    targets.push_back(primitive.inside(value, "targets")->reference("POSITION"));
  return targets;
}

std::vector<double> read_weights(const Entry& entry) {
  std::vector<double> weights;
  const JsonValue list = entry.member("weights");
  if (list && !list.is_array()) entry.fail("`weights` is not a list of numbers");
  for (const JsonValue& value : list.items()) {
    if (!value.number()) entry.fail("`weights` is not a list of numbers");
    weights.push_back(*value.number());
  }
  return weights;
}

GltfMesh read_mesh_entry(const Entry& entry, bool colors, const MeshExtras& extras) {
  GltfMesh mesh;
  mesh.weights = read_weights(entry);
  std::vector<GltfPrimitive>& primitives = mesh.primitives;
  const JsonValue list = entry.member("primitives");
  if (!list.is_array()) entry.fail("`primitives` is not a list");
  for (const JsonValue& value : list.items()) {
    const std::optional<Entry> from = entry.inside(value, "primitives");
    GltfPrimitive& primitive = primitives.emplace_back();
    primitive.attributes = read_attributes(*from);
    primitive.indices = from->reference("indices");
    primitive.targets = read_targets(*from);
    if (colors) {
      primitive.colors = lenient_reference(from->member("attributes").member("COLOR_0"));
    }
    if (colors || asks_for(extras.attributes, "material"))
      primitive.material = lenient_reference(from->member("material"));
    const bool coordinates = colors || extras.coordinates;
    if (coordinates) primitive.coordinates = read_coordinates(from->member("attributes"));
    primitive.asked = read_asked(from->member("attributes"), extras.attributes);
    const std::uint64_t mode = from->count("mode", 4);
    if (mode > 6) entry.fail(fmt::format("the mode {} of a primitive is none", mode));
    primitive.mode = static_cast<std::uint32_t>(mode);
    const std::optional<Entry> draco = from->extension("KHR_draco_mesh_compression");
    if (!draco) continue;
    primitive.draco_view = draco->reference("bufferView");
    primitive.draco_ids = read_attributes(*draco);
    if (coordinates) primitive.draco_coordinates = read_coordinates(draco->member("attributes"));
    primitive.draco_asked = read_asked(draco->member("attributes"), extras.attributes);
    if (colors) primitive.draco_colors = lenient_reference(draco->member("attributes").member("COLOR_0"));
    if (primitive.draco_view == no_index) entry.fail("its Draco stream has no buffer view");
    if (primitive.mode < 4) entry.fail("a Draco stream holds triangles only");
  }
  return mesh;
}

}  // namespace

AffineMap map_of(const std::array<double, 3>& move, std::array<double, 4> turn,
                 const std::array<double, 3>& scale) {
  const double norm =
      std::sqrt(turn[0] * turn[0] + turn[1] * turn[1] + turn[2] * turn[2] + turn[3] * turn[3]);
  if (norm > 0)
    for (double& q : turn) q /= norm;
  const auto [x, y, z, w] = turn;
  const std::array<double, 9> rotation = {
      1 - 2 * (y * y + z * z), 2 * (x * y - z * w),     2 * (x * z + y * w),
      2 * (x * y + z * w),     1 - 2 * (x * x + z * z), 2 * (y * z - x * w),
      2 * (x * z - y * w),     2 * (y * z + x * w),     1 - 2 * (x * x + y * y)};
  AffineMap map;
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column)
      map[4 * row + column] = rotation[3 * row + column] * scale[column];
    map[4 * row + 3] = move[row];
  }
  return map;
}

namespace {

// Keeps the first of equal numbers, in their order; how many are gone.
std::uint32_t keep_first(std::vector<std::uint32_t>& numbers) {
  std::vector<std::uint32_t> sorted = numbers;
  std::sort(sorted.begin(), sorted.end());
  if (std::adjacent_find(sorted.begin(), sorted.end()) == sorted.end()) return 0;
  std::set<std::uint32_t> seen;
  const auto end = std::remove_if(numbers.begin(), numbers.end(),
                                  [&](std::uint32_t number) { return !seen.insert(number).second; });
  const auto gone = static_cast<std::uint32_t>(numbers.end() - end);
  numbers.erase(end, numbers.end());
  return gone;
}

// Custom attributes of instances, whose names begin with `_`, place nothing.
std::optional<GltfInstances> read_instances(const Entry& entry) {
  const JsonValue attributes =
      entry.member("extensions").member("EXT_mesh_gpu_instancing").member("attributes");
  GltfInstances instances;
  instances.moves = entry.reference(attributes.member("TRANSLATION"), "TRANSLATION");
  instances.turns = entry.reference(attributes.member("ROTATION"), "ROTATION");
  instances.scales = entry.reference(attributes.member("SCALE"), "SCALE");
  if (instances.moves == no_index && instances.turns == no_index && instances.scales == no_index)
    return std::nullopt;
  return instances;
}

GltfNode read_node(const Entry& entry, GltfDocument& document) {
  GltfNode node;
  node.mesh = entry.reference("mesh");
  node.skin = entry.reference("skin");
  node.children = entry.references("children");
  node.repeated_children = keep_first(node.children);
  node.weights = read_weights(entry);
  const JsonValue visible = entry.member("extensions").member("KHR_node_visibility").member("visible");
  node.is_hidden = !visible.truth().value_or(true);
  if (const std::optional<GltfInstances> instances = read_instances(entry)) {
    node.instances = static_cast<std::uint32_t>(document.instances.size());
    document.instances.push_back(*instances);
  }
  std::array<double, 16> matrix{};
  if (entry.numbers("matrix", matrix)) {
    for (std::size_t row = 0; row < 3; ++row)
      for (std::size_t column = 0; column < 4; ++column)
        node.local[4 * row + column] = matrix[4 * column + row];
    return node;
  }
  std::array<double, 3> move{}, scale = {1, 1, 1};
  std::array<double, 4> turn = {0, 0, 0, 1};
  const bool moves = entry.numbers("translation", move), turns = entry.numbers("rotation", turn),
             scales = entry.numbers("scale", scale);
  if (moves || turns || scales) node.local = map_of(move, turn, scale);
  return node;
}

void check_version(JsonValue root) {
  const JsonValue asset = root.member("asset");
  const std::string_view version = asset.member("version").text().value_or("");
  // In glTF 1.0 these are objects, and the version may be missing.
  const bool is_first = version.starts_with("1.") || asset.member("version").number() ||
                        root.member("accessors").is_object() || root.member("meshes").is_object();
  if (is_first) throw ItemError(Status::unsupported_format, "glTF 1.0: only glTF 2.0 is read");
  if (version.empty())
    throw ItemError(Status::unreadable, "not a glTF file: it lacks `asset` with a version");
  const std::string_view least = asset.member("minVersion").text().value_or(version);
  if (!version.starts_with("2.") || (least != version && least != "2.0"))
    throw ItemError(Status::unsupported_format, fmt::format("glTF {}: only glTF 2.0 is read", least));
}

void check_extensions(JsonValue root) {
  const JsonValue required = root.member("extensionsRequired");
  if (required && !required.is_array())
    throw ItemError(Status::unreadable, "`extensionsRequired` is not a list");
  constexpr std::size_t most_named = 8;
  std::string unknown;
  std::size_t count = 0;
  for (const JsonValue& value : required.items()) {
    const std::string_view name = value.text().value_or("?").substr(0, 64);
    if (is_known_extension(name)) continue;
    if (++count <= most_named) unknown += (count == 1 ? "" : ", ") + std::string(name);
  }
  if (count > most_named) unknown += ", ...";
  if (count > 0)
    throw ItemError(Status::unsupported_format, fmt::format("it requires {} that {} not read: {}",
                                                            count == 1 ? "an extension" : "extensions",
                                                            count == 1 ? "is" : "are", unknown));
}

void choose_scene(JsonValue root, GltfDocument& document) {
  const JsonValue chosen = root.member("scene");
  if (chosen && !chosen.count()) throw ItemError(Status::unreadable, "`scene` is not the number of a scene");
  const std::uint64_t scene = chosen.count().value_or(0);
  std::uint64_t scenes = 0;
  read_list(root, "scenes", [&](const Entry& entry) {
    if (scenes++ == scene) document.scene_nodes = entry.references("nodes");
  });
  document.repeated_scene_nodes = keep_first(document.scene_nodes);
  document.has_scenes = scenes > 0;
  if (chosen && scene >= scenes)
    throw ItemError(Status::unreadable, fmt::format("`scene` is {}, and there are {} scenes", scene, scenes));
}

}  // namespace

void fail_in(std::string_view list, std::uint64_t index, const std::string& what) {
  throw ItemError(Status::unreadable, fmt::format("{}[{}]: {}", list, index, what));
}

GltfChunks gltf_chunks(std::string_view head, std::uint64_t file_bytes) {
  GltfChunks chunks;
  if (!head.starts_with(glb_magic)) {
    chunks.json_begin = head.starts_with("\xEF\xBB\xBF") ? 3 : 0;
    chunks.json_bytes = file_bytes - chunks.json_begin;
    return chunks;
  }
  const auto word = [&](std::uint64_t at) {
    return std::uint64_t{load<std::uint32_t>(head.data() + at, std::endian::native == std::endian::big)};
  };
  const auto fail = [](const std::string& what) { throw ItemError(Status::unreadable, what); };
  if (head.size() < glb_header + chunk_header) fail("the file ends in the header of a binary glTF file");
  if (word(4) != 2)
    throw ItemError(Status::unsupported_format,
                    fmt::format("binary glTF of version {}: only version 2 is read", word(4)));
  const std::uint64_t stated = word(8);
  if (stated > file_bytes)
    fail(fmt::format("cut: the file has {} bytes, and by its header {}", file_bytes, stated));
  chunks.extra_bytes = file_bytes - stated;
  for (std::uint64_t at = glb_header; at + chunk_header <= stated && at + chunk_header <= head.size();) {
    const std::uint64_t bytes = word(at), kind = word(at + 4), begin = at + chunk_header;
    if (bytes > stated - begin)
      fail(fmt::format("byte {}: a chunk of {} bytes leads beyond the end of the file", at, bytes));
    if (at == glb_header) {
      if (kind != 0x4E4F534A) fail("the first chunk of the binary glTF file is not JSON");
      chunks.json_begin = begin;
      chunks.json_bytes = bytes;
    } else if (kind == 0x004E4942 && !chunks.has_binary) {
      chunks.has_binary = true;
      chunks.binary_begin = begin;
      chunks.binary_bytes = bytes;
    }
    at = begin + bytes;
  }
  if (chunks.json_begin == 0) fail("the binary glTF file has no chunk");
  return chunks;
}

GltfDocument parse_gltf(const JsonTree& json, bool colors, const MeshExtras& extras) {
  const JsonValue root = json.root();
  if (!root.is_object()) throw ItemError(Status::unreadable, "not a glTF file: its JSON is not an object");
  check_version(root);
  check_extensions(root);
  GltfDocument document;
  read_list(root, "buffers", [&](const Entry& e) { document.buffer_uris.push_back(e.text("uri")); });
  read_list(root, "bufferViews", [&](const Entry& e) { document.views.push_back(read_view(e)); });
  read_list(root, "accessors", [&](const Entry& e) { document.accessors.push_back(read_accessor(e)); });
  read_list(root, "meshes",
            [&](const Entry& e) { document.meshes.push_back(read_mesh_entry(e, colors, extras)); });
  read_list(root, "nodes", [&](const Entry& e) { document.nodes.push_back(read_node(e, document)); });
  read_list(root, "skins", [&](const Entry& e) {
    document.skins.push_back({e.reference("inverseBindMatrices"), e.references("joints")});
  });
  if (colors) {
    const TextureLists lists(root);
    for (const JsonValue& material : root.member("materials").items())
      document.materials.push_back(read_material(lists, material));
    for (const JsonValue& image : root.member("images").items())
      document.images.push_back({image.member("uri").text(), lenient_reference(image.member("bufferView"))});
  }
  choose_scene(root, document);
  return document;
}

}  // namespace meander
