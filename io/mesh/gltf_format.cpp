// glTF: what is known of a file without reading its scene.
#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "io/mesh/format_readers.h"
#include "io/mesh/gltf_document.h"
#include "io/utf8.h"

namespace meander {

namespace {

// JSON up to this size is read for the estimate; for larger JSON the size of the file stands in.
constexpr std::uint64_t most_peeked_json = std::uint64_t{16} << 20;
constexpr std::size_t most_chunk_header = 32;

// Some programs fill the chunk with zeros instead of blanks.
std::string_view without_zeros(std::string_view chunk) {
  while (chunk.ends_with('\0')) chunk.remove_suffix(1);
  return chunk;
}

bool is_any_file(std::string_view) { return true; }

// A binary file, or an object of JSON with members of glTF, which programs write in any order.
LooksLike looks_like_gltf(std::string_view head) {
  if (head.starts_with("glTF")) return LooksLike::mesh;
  head = without_byte_order_mark(head);
  head.remove_prefix(std::min(head.find_first_not_of(" \t\r\n\f"), head.size()));
  if (!head.starts_with('{')) return LooksLike::other;
  constexpr std::array<std::string_view, 4> names = {R"("asset")", R"("accessors")", R"("bufferViews")",
                                                     R"("scenes")"};
  const auto members = std::count_if(names.begin(), names.end(), [&](std::string_view name) {
    return head.find(name) != std::string_view::npos;
  });
  return members >= 2 ? LooksLike::mesh : LooksLike::other;
}

// The paths that `paths` finds in the JSON; none where it names no file or cannot be read. Most binary files
// need no other file, and are not parsed twice.
template <class Paths>
std::vector<std::string> paths_in(std::span<const std::byte> bytes, const Paths& paths) try {
  const std::string_view content = text_of(bytes);
  if (content.empty()) return {};
  const std::string_view text = json_of(content, gltf_chunks(content, content.size()));
  if (text.find("\"uri\"") == std::string_view::npos) return {};
  return paths(JsonTree(text));
} catch (const ItemError&) {
  return {};
}

std::vector<std::string> buffer_paths(std::span<const std::byte> bytes) {
  return paths_in(bytes, [](const JsonTree& json) { return companions_of(parse_gltf(json)); });
}

std::vector<std::string> image_paths(std::span<const std::byte> bytes) {
  return paths_in(bytes, [](const JsonTree& json) { return image_companions_of(parse_gltf(json, true)); });
}

std::optional<MeshEstimate> peek_gltf(const ByteSource& file) try {
  const GltfChunks chunks = gltf_chunks(file.read(0, most_chunk_header), file.bytes());
  // In base64 a vertex takes 16 characters.
  MeshEstimate estimate{file.bytes(), file.bytes() / 16 + 1, file.bytes() / 16 + 1};
  if (chunks.json_bytes > most_peeked_json) {
    estimate.decoding_bytes = chunks.json_bytes * JsonTree::most_bytes_per_character;
    return estimate;
  }
  const std::string text = file.read(chunks.json_begin, static_cast<std::size_t>(chunks.json_bytes));
  const JsonTree json(without_zeros(text));
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

std::vector<FileAttribute> attributes_of_gltf(const ByteSource& file) {
  const GltfChunks chunks = gltf_chunks(file.read(0, most_chunk_header), file.bytes());
  std::vector<FileAttribute> attributes;
  std::map<std::pair<std::string, std::uint32_t>, std::size_t> places;  // in the list, by name and width
  if (chunks.json_bytes <= most_peeked_json) {
    const JsonTree json(file.read(chunks.json_begin, static_cast<std::size_t>(chunks.json_bytes)));
    const GltfDocument document = parse_gltf(json);
    for (const JsonValue& mesh : json.root().member("meshes").items())
      for (const JsonValue& primitive : mesh.member("primitives").items())
        for (const JsonValue& value : primitive.member("attributes").items()) {
          const std::optional<std::uint64_t> number = value.count();
          if (!value.name().starts_with('_') || !number || *number >= document.accessors.size()) continue;
          const GltfAccessor& accessor = document.accessors[static_cast<std::size_t>(*number)];
          const std::uint32_t width = accessor.width;
          if (width < 1 || width > 4) continue;
          const bool integers = accessor.component != GltfComponent::float32 && !accessor.normalized;
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

std::string_view json_of(std::string_view content, const GltfChunks& chunks) {
  return without_zeros(content.substr(static_cast<std::size_t>(chunks.json_begin),
                                      static_cast<std::size_t>(chunks.json_bytes)));
}

extern const FormatRow gltf_format = {
    .called = "a glTF",
    .extensions = {".gltf", ".glb"},
    .read = read_gltf,
    .is_raw = is_any_file,
    .looks_like = looks_like_gltf,
    .peek_file = peek_gltf,
    .companions = buffer_paths,
    .color_companions = image_paths,
    .attributes = attributes_of_gltf,
};

}  // namespace meander
