// docs/FORMATS.md against the readers: a file for every line of its table.
#include <algorithm>
#include <functional>
#include <map>
#include <sstream>

#include "io/archive/archive.h"
#include "io/reading.h"
#include "support/catch.h"
#include "support/gltf_files.h"
#include "support/scratch_files.h"

using namespace meander;
using namespace meander::test;

namespace {

std::string document(const std::string& name) {
  return read_file(std::string(MEANDER_SOURCE_DIR) + "/" + name);
}
std::string page() { return document("docs/FORMATS.md"); }

// The cells of the table below a heading, without the lines of its head.
std::vector<std::vector<std::string>> table_below(const std::string& heading) {
  std::istringstream text(page().substr(page().find("\n## " + heading + "\n")));
  std::vector<std::vector<std::string>> rows;
  std::string line;
  while (std::getline(text, line) && !line.starts_with("|")) {
  }
  for (std::getline(text, line); std::getline(text, line) && line.starts_with("|");) {
    std::vector<std::string> cells;
    std::istringstream rest(line.substr(1));
    for (std::string cell; std::getline(rest, cell, '|');) cells.push_back(cell.substr(1, cell.size() - 2));
    rows.push_back(cells);
  }
  return rows;
}

std::span<const std::byte> bytes_of(std::string_view text) { return std::as_bytes(std::span(text)); }

CompanionFile there(const char* name, std::string_view text) {
  return {.path = name, .bytes = bytes_of(text)};
}
CompanionFile not_there(const char* name, bool is_image = false) {
  return {
      .path = name, .problem = "no such file", .is_image = is_image, .loss = CompanionFile::Loss::missing};
}

PolygonMesh read_all(std::string_view content, MeshFormat format,
                     const std::vector<CompanionFile>& companions = {}) {
  MeshSurroundings around;
  around.colors = true;
  around.companions = companions;
  return read_mesh(bytes_of(content), format, {}, around);
}

// The kinds of notes, "none", or the status of the failure.
std::string happens(std::string_view content, MeshFormat format,
                    const std::vector<CompanionFile>& companions = {}) {
  try {
    const PolygonMesh mesh = read_all(content, format, companions);
    std::string kinds;
    for (std::size_t n = 0; n < note_count; ++n)
      if (mesh.notes.counts[n] > 0) kinds += (kinds.empty() ? "" : " ") + std::string(note_names[n]);
    return kinds.empty() ? "none" : kinds;
  } catch (const ItemError& error) {
    return std::string(name_of(error.status()));
  }
}

const std::string off_body = "3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2";
const std::string obj_body = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\n";
const std::string library = "newmtl a\nKd 1 0 0\nnewmtl b\nKd 0 1 0\nmap_Ks x.png\nbump y.png\nd .5\nNs 3\n";
const std::string textured = "newmtl a\nmap_Kd -s 1 1 1 t.png\n";
const std::string ply_head = "ply\nformat ascii 1.0\n";
const std::string ply_vertices =
    "element vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\nproperty "
    "uchar "
    "green\nproperty uchar blue\nproperty float s\nproperty float t\n";
const std::string ply_rows = "0 0 0 9 9 9 0 0\n1 0 0 9 9 9 1 0\n0 1 0 9 9 9 0 1\n";

std::string ply_text(const std::string& comment, const std::string& more_elements,
                     const std::string& more_rows) {
  return ply_head + comment + ply_vertices + "element face 1\nproperty list uchar int vertex_indices\n" +
         more_elements + "end_header\n" + ply_rows + "3 0 1 2\n" + more_rows;
}

std::string binary_stl(std::uint16_t attribute) {
  std::string bytes(80, ' ');
  bytes += std::string("\1\0\0\0", 4) + std::string(12, '\0');
  for (const float value : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f})
    bytes.append(reinterpret_cast<const char*>(&value), 4);
  return bytes.append(reinterpret_cast<const char*>(&attribute), 2);
}
const std::string ascii_facet =
    "facet normal 9 9 9\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n";

std::string gltf_text(const std::string& rest) {
  GltfFile file;
  file.add_points(gltf_cube_points);
  file.add_indices(gltf_cube_indices);
  file.add_points({2, 0, 0, 4, 0, 0});           // 2
  file.add_points(std::vector<float>(24, 1.f));  // 3
  return file.with_data_uri(rest);
}
const std::string one_mesh = R"(,"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}])";

std::size_t faces_of_gltf(const std::string& rest) {
  return read_all(gltf_text(rest), MeshFormat::gltf).polygon_count();
}

using Check = std::function<std::string()>;

// By format and feature: what happens to a file with it, as the page begins to say it.
std::map<std::string, Check> checks() {
  using enum MeshFormat;
  std::map<std::string, Check> all;
  const auto add = [&](const std::string& line, Check check) { all.emplace(line, std::move(check)); };
  add("OFF keyword left out, or glued to the counts",
      [] { return happens(off_body, off) + happens("OFF" + off_body, off); });
  add("OFF `C`, `N`, `ST`, `4` in front of the keyword", [] {
    return happens(
        "STCNOFF\n3 1 0\n0 0 0 0 0 1 9 9 9 255 0 0\n1 0 0 0 0 1 9 9 9 255 0 0\n"
        "0 1 0 0 0 1 9 9 9 255 0 0\n3 0 1 2\n",
        off);
  });
  add("OFF `BINARY`", [] {
    std::string file = "OFF BINARY\n";
    const auto word = [&](std::uint32_t value) {
      for (int k = 3; k >= 0; --k) file += static_cast<char>(value >> (8 * k) & 0xFF);
    };
    for (const std::uint32_t value :
         {3u, 1u, 0u, 0u, 0u, 0u, 0x3F800000u, 0u, 0u, 0u, 0x3F800000u, 0u, 3u, 0u, 1u, 2u, 0u})
      word(value);
    return happens(file, off);
  });
  add("OFF `nOFF` of two and three dimensions", [] { return happens("nOFF\n3\n" + off_body, off); });
  add("OFF `nOFF` of more dimensions", [] { return happens("nOFF\n5\n" + off_body, off); });
  add("OFF colors of vertices and of faces", [] {
    const PolygonMesh mesh =
        read_all("COFF\n3 1 0\n0 0 0 1 0 0\n1 0 0 1 0 0\n0 1 0 1 0 0\n3 0 1 2 9 9 9\n", off);
    return std::string(mesh.colors.vertex.size() == 9 && mesh.colors.face.size() == 3 ? "none" : "lost");
  });
  add("OFF a color that is one number, an entry of a color map",
      [] { return happens("OFF\n" + off_body + " 7\n", off); });
  add("OBJ polygons, `a/b/c`, negative numbers, continued lines, capitals", [] {
    return happens("V 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nVN 0 0 1\nF 1/1/1 -3/1/-1 \\\n 3//1 4\n",
                   obj);
  });
  add("OBJ `v x y z r g b`", [] {
    return std::string(
        read_all("v 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 0 1 0 1 0 0\nf 1 2 3\n", obj).colors.vertex.size() == 9
            ? "none"
            : "lost");
  });
  add("OBJ `mtllib`, `usemtl`, `Kd`, `map_Kd` with `-s`, `-o`, `-clamp`, `-mm`", [] {
    return happens("mtllib m.mtl\n" + obj_body + "usemtl a\nf 1/1 2/1 3/1\n", obj, {there("m.mtl", library)});
  });
  add("OBJ no `usemtl`, and one material in its library", [] {
    return happens("mtllib m.mtl\n" + obj_body + "f 1 2 3\n", obj, {there("m.mtl", "newmtl a\nKd 1 0 0\n")});
  });
  add("OBJ a library that is not there",
      [] { return happens("mtllib m.mtl\n" + obj_body + "usemtl a\nf 1 2 3\n", obj, {not_there("m.mtl")}); });
  add("OBJ a material that no library has", [] {
    return happens("mtllib m.mtl\n" + obj_body + "usemtl c\nf 1 2 3\n", obj, {there("m.mtl", library)});
  });
  add("OBJ an image that is not there", [] {
    return happens("mtllib m.mtl\n" + obj_body + "usemtl a\nf 1/1 2/1 3/1\n", obj,
                   {there("m.mtl", textured), not_there("t.png", true)});
  });
  add("OBJ textured faces without `vt`", [] {
    const std::string found =
        happens("mtllib m.mtl\n" + obj_body + "usemtl a\nf 1 2 3\n", obj, {there("m.mtl", textured)});
    return found == "image_missing coordinates_missing" ? "coordinates_missing" : found;
  });
  add("OBJ `map_Ks`, `bump`, `d`, `Ns` and other lines of materials", [] {
    return happens("mtllib m.mtl\n" + obj_body + "usemtl b\nf 1 2 3\n", obj, {there("m.mtl", library)});
  });
  add("OBJ points, lines, curves, smoothing groups",
      [] { return happens(obj_body + "p 1\nl 1 2\ns 1\ncurv 0 1 1 2\nf 1 2 3\n", obj); });
  add("PLY any elements and properties, in text and binary of either byte order",
      [] { return happens(ply_text("", "", ""), MeshFormat::ply); });
  add("PLY `tristrips`", [] {
    return happens(ply_head + ply_vertices +
                       "element tristrips 1\nproperty list int int vertex_indices\nend_header\n" + ply_rows +
                       "3 0 1 2\n",
                   MeshFormat::ply);
  });
  add("PLY colors of vertices and of faces", [] {
    return std::string(read_all(ply_text("", "", ""), MeshFormat::ply).colors.vertex.size() == 9 ? "none"
                                                                                                 : "lost");
  });
  add("PLY `comment TextureFile` with `texcoord` of faces or coordinates of vertices", [] {
    const PolygonMesh mesh = read_all(ply_text("comment TextureFile t.png\n", "", ""), MeshFormat::ply);
    return std::string(mesh.colors.textures != nullptr ? "none" : "lost");
  });
  add("PLY an image of the header that is not there",
      [] { return happens(ply_text("comment TextureFile t.png\n", "", ""), MeshFormat::ply); });
  add("PLY edges and other elements", [] {
    return happens(ply_text("", "element edge 1\nproperty int vertex1\nproperty int vertex2\n", "0 1\n"),
                   MeshFormat::ply);
  });
  add("STL binary and text, told by the size",
      [] { return happens(binary_stl(0), stl) + happens("solid\n" + ascii_facet, stl); });
  add("STL lines between `solid` and the first facet",
      [] { return happens("solid\ncolor 1 0 0\n" + ascii_facet, stl); });
  add("STL colors of facets (VisCAM, SolidView, Magics)", [] {
    return std::string(read_all(binary_stl(0xFC00), stl).colors.face.size() == 3 ? "none" : "lost");
  });
  add("STL attributes of facets that are no colors by those rules",
      [] { return happens(binary_stl(7), stl); });
  add("STL normals of facets", [] { return happens("solid\n" + ascii_facet, stl); });
  add("glTF scenes, nodes, skins in rest pose, strips and fans", [] {
    return happens(gltf_text(one_mesh + R"(,"nodes":[{"mesh":0}],"scenes":[{"nodes":[0]}])"),
                   MeshFormat::gltf);
  });
  add("glTF `EXT_mesh_gpu_instancing`", [] {
    const std::size_t faces = faces_of_gltf(
        one_mesh +
        R"(,"nodes":[{"mesh":0,"extensions":{"EXT_mesh_gpu_instancing":{"attributes":{"TRANSLATION":2}}}}])");
    return std::string(faces == 24 ? "none" : "lost");
  });
  add("glTF default weights of morph targets", [] {
    const PolygonMesh mesh = read_all(
        gltf_text(
            R"(,"meshes":[{"weights":[1],"primitives":[{"attributes":{"POSITION":0},"indices":1,"targets":[{"POSITION":3}]}]}],"nodes":[{"mesh":0}])"),
        MeshFormat::gltf);
    return std::string(*std::min_element(mesh.x.begin(), mesh.x.end()) == 1 ? "none" : "lost");
  });
  add("glTF a node below two parents", [] {
    return happens(gltf_text(one_mesh + R"(,"nodes":[{"children":[2]},{"children":[2]},{"mesh":0}])"),
                   MeshFormat::gltf);
  });
  add("glTF `KHR_materials_variants`", [] {
    return happens(
        gltf_text(one_mesh + R"(,"nodes":[{"mesh":0}],"extensionsUsed":["KHR_materials_variants"])"),
        MeshFormat::gltf);
  });
  add("glTF an extension that is not known", [] {
    return happens(gltf_text(one_mesh + R"(,"nodes":[{"mesh":0}],"extensionsUsed":["EXT_any_shape"])"),
                   MeshFormat::gltf);
  });
  add("glTF an extension that is not known and required", [] {
    return happens(gltf_text(one_mesh + R"(,"nodes":[{"mesh":0}],"extensionsRequired":["EXT_any_shape"])"),
                   MeshFormat::gltf);
  });
  add("glTF lights, animations, cameras, metadata", [] {
    return happens(
        gltf_text(
            one_mesh +
            R"(,"nodes":[{"mesh":0,"camera":0}],"extensionsUsed":["KHR_lights_punctual"],"animations":[])"),
        MeshFormat::gltf);
  });
  add("glTF points and lines", [] {
    return happens(
        gltf_text(
            R"(,"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1},{"attributes":{"POSITION":0},"mode":0}]}],"nodes":[{"mesh":0}])"),
        MeshFormat::gltf);
  });
  return all;
}

}  // namespace

TEST_CASE("formats: every row of the feature table holds for a file with that feature") {
  const std::map<std::string, Check> all = checks();
  std::size_t lines = 0;
  for (const std::vector<std::string>& row : table_below("By format")) {
    REQUIRE(row.size() == 3);
    const std::string line = row[0] + " " + row[1];
    INFO(line);
    const auto check = all.find(line);
    REQUIRE(check != all.end());
    const std::string found = check->second();
    ++lines;
    const auto named = row[2].find(row[2].starts_with("refused") ? "refused: `" : "noted: `");
    if (named == std::string::npos) {
      CHECK(found.find_first_not_of("none") == std::string::npos);
      continue;
    }
    const std::size_t begin = row[2].find('`', named) + 1;
    CHECK(found == row[2].substr(begin, row[2].find('`', begin) - begin));
  }
  CHECK(lines == all.size());
}

TEST_CASE("formats: the page lists the note kinds and extensions of the code, in the same order") {
  std::vector<std::string> kinds;
  for (const std::vector<std::string>& row : table_below("Notes")) kinds.push_back(row[0]);
  std::vector<std::string> known;
  for (const std::string_view name : note_names) known.push_back("`" + std::string(name) + "`");
  CHECK(kinds == known);
  const auto has = [](const char* name, const std::string& text) {
    return document(name).find(text) != std::string::npos;
  };
  CHECK(has("docs/FORMATS.md", "Extensions, in any case: " + mesh_extensions() + ";"));
  CHECK(has("docs/DATASETS.md", "with the extension " + mesh_extensions("or") + ", in any case"));
  CHECK(has("docs/DATASETS.md", "| an archive: " + archive_extensions() + " |"));
  CHECK(has("README.md", "Formats: " + mesh_format_names() + ";"));
}
