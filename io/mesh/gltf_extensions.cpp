#include "io/mesh/gltf_extensions.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <set>

#include "io/utf8.h"

namespace meander {

namespace {

// What an extension does to what is drawn at rest. `fallback`: nothing, as long as it is not required.
enum class Use : std::uint8_t { applied, harmless, fallback, color, shape };

constexpr std::array<std::string_view, 8> applied_names = {
    "KHR_mesh_quantization",   "KHR_draco_mesh_compression",
    "EXT_meshopt_compression", "EXT_mesh_gpu_instancing",
    "KHR_node_visibility",     "KHR_texture_transform",
    "EXT_texture_webp",        "KHR_materials_pbrSpecularGlossiness"};

// Light and shading, animation, sound, physics, cameras, and data about the model. Where a material lets
// light through or shines, its base color is still the color of its points.
constexpr std::array<std::string_view, 55> harmless_names = {"KHR_environment_map",
                                                             "KHR_materials_anisotropy",
                                                             "KHR_materials_clearcoat",
                                                             "KHR_materials_coat",
                                                             "KHR_materials_diffuse_roughness",
                                                             "KHR_materials_diffuse_transmission",
                                                             "KHR_materials_dispersion",
                                                             "KHR_materials_emissive_strength",
                                                             "KHR_materials_fuzz",
                                                             "KHR_materials_ior",
                                                             "KHR_materials_iridescence",
                                                             "KHR_materials_sheen",
                                                             "KHR_materials_specular",
                                                             "KHR_materials_subsurface",
                                                             "KHR_materials_transmission",
                                                             "KHR_materials_unlit",
                                                             "KHR_materials_volume",
                                                             "KHR_materials_volume_scatter",
                                                             "ADOBE_materials_clearcoat_specular",
                                                             "ADOBE_materials_clearcoat_tint",
                                                             "ADOBE_materials_thin_transparency",
                                                             "MSFT_packing_normalRoughnessMetallic",
                                                             "MSFT_packing_occlusionRoughnessMetallic",
                                                             "MOZ_lightmap",
                                                             "FB_materials_lightmap",
                                                             "KHR_interactivity",
                                                             "KHR_node_hoverability",
                                                             "KHR_node_selectability",
                                                             "KHR_audio",
                                                             "KHR_physics_rigid_bodies",
                                                             "KHR_implicit_shapes",
                                                             "KHR_collision_shapes",
                                                             "KHR_rigid_bodies",
                                                             "MSFT_physics",
                                                             "MSFT_lod",
                                                             "KHR_xmp",
                                                             "KHR_XMP",
                                                             "KHR_xmp_json_ld",
                                                             "EXT_mesh_features",
                                                             "EXT_instance_features",
                                                             "EXT_structural_metadata",
                                                             "EXT_feature_metadata",
                                                             "EXT_mesh_manifold",
                                                             "EXT_mesh_primitive_restart",
                                                             "KHR_mesh_primitive_restart",
                                                             "EXT_mesh_primitive_edge_visibility",
                                                             "CESIUM_primitive_outline",
                                                             "FB_ngon_encoding",
                                                             "FB_geometry_metadata",
                                                             "AGI_articulations",
                                                             "AGI_stk_metadata",
                                                             "CVTOOLS_unity_metadata",
                                                             "GODOT_single_root",
                                                             "VRM",
                                                             "KHR_camera_physical"};
constexpr std::array<std::string_view, 2> harmless_beginnings = {"OMI_", "VRMC_"};

bool is_any(std::string_view name, auto names) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

Use use_of(std::string_view name) {
  if (is_any(name, applied_names)) return Use::applied;
  if (is_any(name, harmless_names)) return Use::harmless;
  for (const std::string_view begin : harmless_beginnings)
    if (name.starts_with(begin)) return Use::harmless;
  for (const std::string_view part : {"_lights_", "_animation_", "_audio_"})
    if (name.find(part) != std::string_view::npos) return Use::harmless;
  // Its streams may be of a later version of the codec; what they replace has to be there too.
  if (name == "KHR_meshopt_compression") return Use::fallback;
  // Formats of images, other base colors, shaders, and variants of the materials.
  for (const std::string_view part :
       {"_materials_", "_material_", "_texture_", "_techniques_", "_technique_"})
    if (name.find(part) != std::string_view::npos) return Use::color;
  return Use::shape;
}

}  // namespace

bool is_known_extension(std::string_view name) {
  static constexpr std::array<std::string_view, 5> of_colors = {"KHR_texture_basisu", "EXT_texture_avif",
                                                                "MSFT_texture_dds", "KHR_techniques_webgl",
                                                                "KHR_technique_webgl"};
  const Use use = use_of(name);
  return use == Use::applied || use == Use::harmless || name.starts_with("KHR_materials_") ||
         is_any(name, of_colors);
}

std::string shown_text(std::string_view text, std::size_t most) {
  std::string shown;
  while (!text.empty()) {
    const std::size_t bytes = utf8_sequence_length(text);
    if (shown.size() + std::max<std::size_t>(bytes, 1) > most) break;
    const auto first = static_cast<unsigned char>(text[0]);
    // The first characters of two bytes are control characters too.
    const bool is_control = first < 0x20 || first == 0x7F ||
                            (first == 0xC2 && bytes == 2 && static_cast<unsigned char>(text[1]) < 0xA0);
    if (bytes == 0 || is_control)
      shown += '?';
    else
      shown += text.substr(0, bytes);
    text.remove_prefix(std::max<std::size_t>(bytes, 1));
  }
  return shown;
}

void note_ignored_extensions(const JsonTree& json, bool colors, Notes& notes) {
  std::vector<std::string_view> names;
  for (const JsonValue& value : json.root().member("extensionsUsed").items())
    if (const std::optional<std::string_view> name = value.text()) names.push_back(*name);
  for (const std::string_view name : json.members_of_all("extensions", "extras")) names.push_back(name);
  std::set<std::string_view> known;
  std::string example;
  std::uint64_t count = 0;
  for (const std::string_view name : names) {
    const Use use = use_of(name);
    const bool is_ignored = use == Use::shape || (use == Use::color && colors);
    if (!is_ignored || !known.insert(name).second) continue;
    ++count;
    const std::string shown = "`" + shown_text(name) + "`";
    if (example.size() + shown.size() + 22 <= Notes::longest_note_example)
      example += (count == 1 ? "" : ", ") + shown;
  }
  notes.add(Note::feature_ignored, example + (count == 1 ? " is not applied" : " are not applied"), count);
}

}  // namespace meander
