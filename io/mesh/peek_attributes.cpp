#include "io/mesh/peek_attributes.h"

#include <algorithm>
#include <map>
#include <utility>

#include "io/mesh/format_readers.h"
#include "io/mesh/gltf_document.h"
#include "io/mesh/ply_header.h"

namespace meander {

namespace {

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
      // Of properties of one name the first counts.
      const auto same = [&](const FileAttribute& a) { return a.name == own && a.of_faces == of_faces; };
      if (std::none_of(attributes.begin(), attributes.end(), same))
        attributes.push_back({own, 1, integers, of_faces});
    }
  }
  return attributes;
}

std::vector<FileAttribute> attributes_of_gltf(const ByteSource& file) {
  constexpr std::size_t most_chunk_header = 32;
  const GltfChunks chunks = gltf_chunks(file.read(0, most_chunk_header), file.bytes());
  std::vector<FileAttribute> attributes;
  std::map<std::pair<std::string, std::uint32_t>, std::size_t> places;  // in the list, by name and width
  if (chunks.json_bytes <= most_peeked_json) {
    const JsonTree json(file.read(chunks.json_begin, static_cast<std::size_t>(chunks.json_bytes)));
    const std::vector<JsonValue> accessors = json.root().member("accessors").items();
    for (const JsonValue& mesh : json.root().member("meshes").items())
      for (const JsonValue& primitive : mesh.member("primitives").items())
        for (const JsonValue& value : primitive.member("attributes").items()) {
          const std::optional<std::uint64_t> number = value.count();
          if (!value.name().starts_with('_') || !number || *number >= accessors.size()) continue;
          const JsonValue accessor = accessors[static_cast<std::size_t>(*number)];
          const std::string_view type = accessor.member("type").text().value_or("");
          const std::uint32_t width = type == "SCALAR" ? 1
                                      : type.starts_with("VEC")
                                          ? static_cast<std::uint32_t>(type.back() - '0')
                                          : 0;
          const bool is_float =
              accessor.member("componentType").count() == static_cast<std::uint64_t>(GltfComponent::float32);
          const bool is_fraction = accessor.member("normalized").truth().value_or(false);
          if (width < 1 || width > 4) continue;
          const bool integers = !is_float && !is_fraction;
          const auto [at, is_new] =
              places.try_emplace(std::pair(std::string(value.name()), width), attributes.size());
          if (is_new)
            attributes.push_back({std::string(value.name()), width, integers, false});
          else
            attributes[at->second].integers = attributes[at->second].integers && integers;
        }
  }
  for (const char* const name : {"material", "object", "part"}) attributes.push_back({name, 1, true, true});
  return attributes;
}

}  // namespace

std::vector<FileAttribute> peek_attributes(const ByteSource& file, MeshFormat format) {
  try {
    if (format == MeshFormat::ply) return attributes_of_ply(file);
    if (format == MeshFormat::gltf) return attributes_of_gltf(file);
    if (format == MeshFormat::obj)
      return {{"group", 1, true, true}, {"material", 1, true, true}, {"object", 1, true, true}};
  } catch (const ItemError&) {  // reading the mesh will say what is wrong
  }
  return {};
}

std::optional<bool> takes_integers(std::span<const FileAttribute> attributes, const AttributeColumn& column) {
  for (const bool of_faces : {false, true}) {
    const auto find = [&](const std::string& name, std::uint32_t width) -> std::optional<bool> {
      for (const FileAttribute& attribute : attributes)
        if (attribute.of_faces == of_faces && attribute.name == name && attribute.width == width)
          return attribute.integers;
      return std::nullopt;
    };
    if (const std::optional<bool> whole = find(column.name, column.width)) return whole;
    for (const auto& suffixes : attribute_suffixes) {
      if (column.width == 1) break;
      bool integers = true, has_all = true;
      for (std::uint32_t k = 0; k < column.width && has_all; ++k) {
        const std::optional<bool> one = find(column.name + suffixes[k], 1);
        has_all = one.has_value();
        integers = integers && one.value_or(false);
      }
      if (has_all) return integers;
    }
  }
  return std::nullopt;
}

}  // namespace meander
