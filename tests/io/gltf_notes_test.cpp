// What a glTF file asks for and does not get is noted by name.
#include <fmt/format.h>

#include "gltf_reading.h"
#include "kernels/mesh/surface_textures.h"
#include "support/catch.h"
#include "support/image_files.h"

using namespace meander;
using namespace meander::test;

namespace {

std::string example(const PolygonMesh& mesh, Note note) {
  return mesh.notes.examples[static_cast<std::size_t>(note)];
}

PolygonMesh read_colored(const std::string& content, std::span<const CompanionFile> beside = {}) {
  MeshSurroundings around;
  around.companions = beside;
  around.colors = true;
  return read_gltf_file(content, around);
}

const TestImage red(2, 2, [](std::uint32_t, std::uint32_t) { return std::vector<int>{200, 30, 40}; });

// The cube with a material that shows `texture`, and texture coordinates.
std::string textured(const std::string& textures, const std::string& images,
                     const std::string& attributes = R"(,"TEXCOORD_0":2)",
                     const std::string& info = R"("index":0)") {
  GltfFile file = cube_file();
  file.add_accessor(file.add_view(std::vector<float>(16, 0.5F)), 5126, 8, "VEC2");
  return file.with_data_uri(
      R"(,"meshes":[{"primitives":[{"attributes":{"POSITION":0)" + attributes +
      R"(},"indices":1,"material":0}]}],"materials":[{"pbrMetallicRoughness":{"baseColorTexture":{)" + info +
      R"(}}}],"textures":[)" + textures + R"(],"images":[)" + images + "]");
}

}  // namespace

TEST_CASE("glTF notes: unapplied extensions that change the shape are named, listed or not") {
  const auto read = [](const std::string& rest, bool colors) {
    const std::string content = cube_file().glb(plain_cube + rest);
    return colors ? read_colored(content) : read_gltf_file(content);
  };
  for (const bool colors : {false, true}) {
    const PolygonMesh listed =
        read(R"(,"extensionsUsed":["ACME_curves","KHR_lights_punctual","ACME_wheels\n"])", colors);
    CHECK(listed.notes[Note::feature_ignored] == 2);
    CHECK(example(listed, Note::feature_ignored) == "`ACME_curves`, `ACME_wheels?` are not applied");
    const PolygonMesh present = read(
        R"(,"extensions":{"ACME_bend":{}},"materials":[{"extensions":{"ACME_bend":{"extensions":{"ACME_inner":{}}}}}],)"
        R"("extras":{"extensions":{"ACME_extra":{}}})",
        colors);
    CHECK(present.notes[Note::feature_ignored] == 2);
    CHECK(example(present, Note::feature_ignored) == "`ACME_bend`, `ACME_inner` are not applied");
  }
  std::string many = R"("A0")";
  for (int k = 1; k < 500; ++k) many += fmt::format(",\"ACME_{}\"", k);
  const PolygonMesh mesh = read(",\"extensionsUsed\":[" + many + "]", false);
  CHECK(mesh.notes[Note::feature_ignored] == 500);
  CHECK(example(mesh, Note::feature_ignored).size() <= Notes::longest_note_example);
  CHECK(example(mesh, Note::feature_ignored).ends_with("are not applied"));
}

TEST_CASE("glTF notes: color extensions are noted only when colors are requested") {
  for (const char* name :
       {"KHR_texture_basisu", "MSFT_texture_dds", "EXT_texture_avif", "KHR_materials_variants",
        "KHR_techniques_webgl", "FB_materials_modmap", "KHR_materials_unheard_of"}) {
    INFO(name);
    const std::string content = cube_file().glb(plain_cube + R"(,"extensionsUsed":[")" + name + "\"]");
    CHECK_FALSE(read_gltf_file(content).notes.any());
    const PolygonMesh mesh = read_colored(content);
    CHECK(mesh.notes[Note::feature_ignored] == 1);
    CHECK(example(mesh, Note::feature_ignored) == "`" + std::string(name) + "` is not applied");
  }
  for (const char* name : {"KHR_mesh_quantization", "KHR_draco_mesh_compression", "EXT_meshopt_compression",
                           "EXT_mesh_gpu_instancing", "KHR_texture_transform", "EXT_texture_webp",
                           "KHR_materials_pbrSpecularGlossiness", "KHR_node_visibility",
                           "KHR_lights_punctual", "EXT_lights_image_based", "KHR_materials_unlit",
                           "KHR_materials_transmission", "KHR_animation_pointer", "KHR_xmp_json_ld",
                           "EXT_structural_metadata", "MSFT_lod", "VRMC_vrm", "OMI_collider"}) {
    INFO(name);
    const std::string list = std::string("[\"") + name + "\"]";
    CHECK_FALSE(read_colored(cube_file().glb(plain_cube + R"(,"extensionsUsed":)" + list)).notes.any());
    CHECK_FALSE(read_colored(cube_file().glb(plain_cube + R"(,"extensionsRequired":)" + list)).notes.any());
  }
  CHECK_THAT(
      gltf_outcome(cube_file().glb(plain_cube + R"(,"extensionsRequired":["KHR_meshopt_compression"])")),
      Catch::Matchers::ContainsSubstring(
          "unsupported_format: it requires an extension that is not read: KHR_meshopt_compression"));
}

TEST_CASE("glTF notes: each visible image that is lost is noted once, with its kind") {
  struct Lost {
    const char* image;
    Note kind;
    const char* said;
  };
  const CompanionFile beside[] = {{.path = "open.png",
                                   .problem = "Permission denied",
                                   .is_image = true,
                                   .loss = CompanionFile::Loss::unreadable}};
  for (const Lost& lost :
       {Lost{R"({"uri":"images/a.png"})", Note::image_missing, "`images/a.png` is not there"},
        Lost{R"({"uri":"open.png"})", Note::image_unreadable, "`open.png` cannot be read"},
        Lost{R"({"uri":"http://x.org/a.png"})", Note::image_outside,
             "`http://x.org/a.png` is not a file of the model's folder"},
        Lost{R"({"bufferView":77})", Note::image_missing, "image 0 is not there"},
        Lost{"{}", Note::image_missing, "image 0 is not there"}}) {
    INFO(lost.image);
    const PolygonMesh mesh = read_colored(textured(R"({"source":0})", lost.image), beside);
    CHECK(mesh.notes[lost.kind] == 1);
    CHECK(example(mesh, lost.kind) == lost.said);
    std::uint64_t all = 0;
    for (const std::uint32_t count : mesh.notes.counts) all += count;
    CHECK(all == 1);
    CHECK_FALSE(read_gltf_file(textured(R"({"source":0})", lost.image)).notes.any());
  }
  const PolygonMesh none = read_colored(textured("{}", ""));
  CHECK(example(none, Note::image_missing) == "the texture of material 0 has no image");
  const PolygonMesh kept = read_colored(
      textured(R"({"source":0})", R"({"uri":"data:image/png;base64,)" + base64(png_bytes(red)) + "\"}"));
  CHECK_FALSE(kept.notes.any());
  REQUIRE(kept.colors.textures->images.size() == 1);
  CHECK_FALSE(kept.colors.textures->images[0].is_lost());
}

TEST_CASE("glTF notes: a lost image that no triangle shows is not noted") {
  GltfFile file = cube_file();
  const PolygonMesh mesh = read_colored(file.glb(
      plain_cube +
      R"(,"materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}],"textures":[{"source":0}],"images":[{"uri":"a.png"}])"));
  CHECK_FALSE(mesh.notes.any());
}

TEST_CASE(
    "glTF notes: EXT_texture_webp takes precedence over the source, and the source over unread formats") {
  const std::string png = R"({"uri":"data:image/png;base64,)" + base64(png_bytes(red)) + "\"}";
  const std::string other = R"({"uri":"data:image/ktx2;base64,)" + base64("\xABKTX 20\xBB\r\n\x1A\n") + "\"}";
  const auto source = [](const char* name, int image) {
    return fmt::format(R"("extensions":{{"{}":{{"source":{}}}}})", name, image);
  };
  // An image is known by its content: here it is a PNG by the name of WebP.
  const PolygonMesh webp = read_colored(
      textured("{" + source("EXT_texture_webp", 0) + R"(,"source":1})", png + R"(,{"uri":"not.png"})"));
  CHECK_FALSE(webp.notes.any());
  CHECK_FALSE(webp.colors.textures->images[webp.colors.textures->textures[0].image].is_lost());
  const PolygonMesh lost = read_colored(
      textured("{" + source("EXT_texture_webp", 1) + R"(,"source":0})", png + R"(,{"uri":"lost.webp"})"));
  CHECK(example(lost, Note::image_missing) == "`lost.webp` is not there");
  CHECK_FALSE(lost.colors.textures->images[lost.colors.textures->textures[0].image].is_lost());
  for (const char* name : {"KHR_texture_basisu", "EXT_texture_avif", "MSFT_texture_dds"}) {
    INFO(name);
    const PolygonMesh spare =
        read_colored(textured("{" + source(name, 1) + R"(,"source":0})", png + "," + other));
    CHECK(spare.notes[Note::feature_ignored] == 1);
    CHECK(spare.notes[Note::image_unsupported] == 0);
    CHECK_FALSE(spare.colors.textures->images[spare.colors.textures->textures[0].image].is_lost());
    const PolygonMesh without = read_colored(textured("{" + source(name, 1) + "}", png + "," + other));
    CHECK(without.notes[Note::feature_ignored] == 1);
    CHECK(without.notes[Note::image_unsupported] == 1);
    CHECK(example(without, Note::image_unsupported).starts_with("image 1"));
  }
}

TEST_CASE("glTF notes: textured triangles without the texture coordinates they need are noted") {
  const std::string png = R"({"uri":"data:image/png;base64,)" + base64(png_bytes(red)) + "\"}";
  const auto count = [&](const std::string& attributes, const std::string& info) {
    const PolygonMesh mesh = read_colored(textured(R"({"source":0})", png, attributes, info));
    CHECK((mesh.notes[Note::coordinates_missing] > 0) == mesh.notes.any());
    return mesh.notes[Note::coordinates_missing];
  };
  CHECK(count(R"(,"TEXCOORD_0":2)", R"("index":0)") == 0);
  CHECK(count("", R"("index":0)") == 1);
  CHECK(count(R"(,"TEXCOORD_0":2)", R"("index":0,"texCoord":1)") == 1);
  CHECK(count(R"(,"TEXCOORD_0":0)", R"("index":0)") == 1);
  CHECK(count(R"(,"TEXCOORD_0":2)",
              R"("index":0,"texCoord":1,"extensions":{"KHR_texture_transform":{"texCoord":0}})") == 0);
  CHECK(count(R"(,"TEXCOORD_0":2)",
              R"("index":0,"texCoord":0,"extensions":{"KHR_texture_transform":{"texCoord":1}})") == 1);
}

TEST_CASE("glTF notes: missing buffers that are not needed are not noted, missing colors and materials are") {
  const GltfFile file = cube_file();
  std::string content = file.with_data_uri(plain_cube);
  content.insert(content.find("}],\"bufferViews\"") + 1,
                 R"(,{"byteLength":4,"uri":"spare.bin"},{"byteLength":4})");
  const PolygonMesh spare = read_gltf_file(content);
  CHECK(spare.notes[Note::buffer_missing] == 1);
  CHECK(example(spare, Note::buffer_missing) == "`spare.bin` is not there");
  const std::string four(4, '\0');
  const CompanionFile there[] = {{"spare.bin", std::as_bytes(std::span(four)), {}}};
  MeshSurroundings around;
  around.companions = there;
  CHECK_FALSE(read_gltf_file(content, around).notes.any());
  const PolygonMesh lost = read_colored(file.glb(
      R"(,"meshes":[{"primitives":[{"attributes":{"POSITION":0,"COLOR_0":1},"indices":1,"material":3}]}])"));
  CHECK(example(lost, Note::colors_ignored) == "COLOR_0 in accessor 1 cannot be read");
  CHECK(example(lost, Note::material_missing) == "there is no material 3");
}

TEST_CASE("glTF: COLOR_0 is clamped to 0 to 1, and integers are divided by their max") {
  const auto first = [](const auto& values, int component, const std::string& extra) {
    GltfFile file = cube_file();
    file.add_accessor(file.add_view(values), component, 8, "VEC4", extra);
    const PolygonMesh mesh = read_colored(
        file.glb(R"(,"meshes":[{"primitives":[{"attributes":{"POSITION":0,"COLOR_0":2},"indices":1}]}])"));
    return std::vector<float>(mesh.colors.vertex.begin(), mesh.colors.vertex.begin() + 3);
  };
  std::vector<float> floats(32, 0.5F);
  floats[5] = 200;  // one highlight changes no other
  floats[0] = 1.0000001F;
  floats[1] = -3;
  CHECK(first(floats, 5126, "") == std::vector<float>{1, 0, 0.5F});
  for (const char* extra : {"", ",\"normalized\":true"}) {
    CHECK(first(std::vector<std::uint8_t>(32, 51), 5121, extra) == std::vector<float>(3, 0.2F));
    CHECK(first(std::vector<std::uint16_t>(32, 13107), 5123, extra) == std::vector<float>(3, 0.2F));
  }
}
