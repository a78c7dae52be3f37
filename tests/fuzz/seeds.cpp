#include "seeds.h"

#include <fmt/format.h>
#include <png.h>

#include <array>
#include <cstring>
#include <filesystem>
#include <stdexcept>

#include "io/store/row_codec.h"
#include "io/store/run_plan.h"
#include "io/table/npy_header.h"
#include "support/archive_files.h"
#include "support/gltf_streams.h"
#include "support/image_encoders.h"
#include "support/mesh_files.h"
#include "support/test_meshes.h"

namespace meander::fuzz {

namespace {

using namespace test;
using namespace std::string_literals;

std::vector<std::string> off_seeds() {
  return {mesh_bytes(mesh_with_attributes(), MeshFile::off),
          mesh_bytes(mesh_with_attributes(), MeshFile::off_binary),
          "OFF 3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
          "COFF\n3 1 0 # colors\n0 0 0 255 0 0 255\n1 0 0 0 1 0 1\n0 1 0 0 0 1\n3 0 1 2 0.5 0.5 0.5\n",
          "ST4NOFF\n3 1 0\n0 0 0 1 0 0 1 0 0\n1 0 0 1 0 0 1 0 0\n0 1 0 1 0 0 1 1 1\n3 0 1 2\n",
          "nOFF 3\n3 1 0\n0 0 0\r\n1 0 0\r\n0 1 nan\r\n3 0 1 2 7\r\n"};
}

std::vector<std::string> obj_seeds() {
  return {mesh_bytes(mesh_with_attributes(), MeshFile::obj),
          "mtllib a.mtl b.mtl\no one\nv 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 255\nvt 0 0\nvn 0 0 1\n"
          "g a\ns off\nusemtl red\nf 1/1/1 2/1/1 3/1/1\nf -1//-1 -2//-1 \\\n -3//-1\nl 1 2\np 1\n",
          "v 1e400 -nan(ind) 1.#INF 2\r\nv 0 0 0\r\nv 1 0 0\r\nf 1 2 3 1\r\nf 4294967296 1 2\r\n"};
}

std::vector<std::string> ply_seeds() {
  return {
      mesh_bytes(mesh_with_attributes(), MeshFile::ply_ascii),
      mesh_bytes(mesh_with_attributes(), MeshFile::ply_little_endian),
      mesh_bytes(mesh_with_attributes(), MeshFile::ply_big_endian),
      "ply\nformat ascii 1.0\ncomment c\nobj_info o\nelement vertex 4\nproperty float x\nproperty float y\n"
      "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
      "property float density\nelement tristrips 1\nproperty list int int vertex_indices\n"
      "element material 1\nproperty list uchar double d\nend_header\n0 0 0 255 0 0 1\n1 0 0 0 255 0 1\n"
      "0 1 0 0 0 255 1\n1 1 0 9 9 9 2\n5 0 1 2 -1 3\n2 1 2\n",
      "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty char x\nproperty short y\n"
      "property uint z\nelement face 1\nproperty list uchar ushort vertex_index\nproperty uchar red\n"
      "property uchar green\nproperty uchar blue\nend_header\n"s +
          "\0\0\0\0\0\0\0\1\0\0\0\0\0\0\0\1\0\0\0\0\0\3\0\0\1\0\2\0\1\2\3"s};
}

std::vector<std::string> stl_seeds() {
  return {
      mesh_bytes(tetrahedron(), MeshFile::stl_ascii), mesh_bytes(tetrahedron(), MeshFile::stl_binary),
      "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
      "endsolid a\nsolid b\nfacet normal nan 0 0\nouter loop\nvertex 0 0 1\nvertex 1 0 1\nvertex 0 1 1\n"
      "endloop\nendfacet\nendsolid\n"};
}

std::vector<std::string> gltf_seeds() {
  GltfFile cube_file;
  cube_file.add_points(gltf_cube_points);
  cube_file.add_indices(gltf_cube_indices);
  const std::string scene =
      R"(,"meshes":[{"primitives":[{"attributes":{"POSITION":0,"COLOR_0":0},"indices":1,"material":0},)"
      R"({"attributes":{"POSITION":0},"mode":5},{"attributes":{"POSITION":0},"indices":1,"mode":6}]}],)"
      R"("materials":[{"pbrMetallicRoughness":{"baseColorFactor":[1,0.5,0,1]}}],)"
      R"("nodes":[{"mesh":0,"scale":[1,-1,2],"rotation":[0,0,0,1],"translation":[1,2,3],"children":[1]},)"
      R"({"mesh":0,"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,5,0,0,1]}],"scenes":[{"nodes":[0]}],"scene":0)";
  // Quantized, interleaved and sparse accessors, and a skin.
  GltfFile odd;
  odd.add_view(std::vector<std::int16_t>{0, 0, 0, 0, 9, 0, 0, 0, 0, 9, 0, 0, 9, 9, 9, 0},
               R"(,"byteStride":8)");
  odd.add_accessor(0, 5122, 4, "VEC3", R"(,"normalized":true)");
  odd.add_indices(std::vector<std::uint8_t>{0, 1, 2, 1, 3, 2});
  odd.add_view(std::vector<std::uint8_t>{1, 3});
  odd.add_view(std::vector<float>{5, 5, 5, 6, 6, 6});
  odd.add_accessor(
      -1, 5126, 4, "VEC3",
      R"(,"sparse":{"count":2,"indices":{"bufferView":2,"componentType":5121},"values":{"bufferView":3}})");
  odd.add_view(std::vector<std::uint8_t>(16, 0));
  odd.add_accessor(4, 5121, 4, "VEC4");
  odd.add_view(std::vector<float>{1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0});
  odd.add_accessor(5, 5126, 4, "VEC4");
  const std::string skinned =
      R"(,"meshes":[{"primitives":[{"attributes":{"POSITION":0,"JOINTS_0":3,"WEIGHTS_0":4},"indices":1},)"
      R"({"attributes":{"POSITION":2},"indices":1}]}],"skins":[{"joints":[1]}],)"
      R"("nodes":[{"mesh":0,"skin":0},{"translation":[1,0,0]}])";
  // Instances, morph targets, a node with two parents, a hidden one, and strips that begin anew.
  GltfFile rest;
  rest.add_points(gltf_cube_points);
  rest.add_indices(std::vector<std::uint8_t>{0, 1, 2, 255, 4, 5, 6, 7});
  rest.add_points({0, 0, 0, 1, 2, 3});
  rest.add_accessor(rest.add_view(std::vector<std::int8_t>{0, 0, 0, 127, 90, 0, 0, 90}), 5120, 2, "VEC4",
                    R"(,"normalized":true)");
  const std::string at_rest =
      R"(,"meshes":[{"weights":[0.5,0],"primitives":[{"attributes":{"POSITION":0},"indices":1,"mode":5,)"
      R"("targets":[{"POSITION":0},{"NORMAL":0}]},{"attributes":{"POSITION":0},"indices":1,"mode":6}]}],)"
      R"("nodes":[{"children":[2,3,3]},{"children":[2],"scale":[-1,1,1]},{"mesh":0,"weights":[1,-1],"extensions":)"
      R"({"EXT_mesh_gpu_instancing":{"attributes":{"TRANSLATION":2,"ROTATION":3,"SCALE":2,"_ID":2}}}},)"
      R"({"mesh":0,"extensions":{"KHR_node_visibility":{"visible":false}}}],"extensionsUsed":["ACME_curves"])";
  // An image of another format, and coordinates, in a textured material.
  const std::string textured =
      R"(,"meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_1":0},"indices":1,"material":0}]}],)"
      R"("materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0,"texCoord":1}}}],)"
      R"("textures":[{"source":0,"extensions":{"EXT_texture_webp":{"source":1}}}],)"
      R"("images":[{"bufferView":0},{"uri":"sub\\..\\image.webp"}],"nodes":[{"mesh":0}])";
  const BentGrid grid(5);
  return {rest.glb(at_rest),
          rest.with_data_uri(at_rest),
          cube_file.glb(textured),
          cube_file.glb(scene),
          cube_file.json(scene, "cube.bin"),
          cube_file.with_data_uri(scene),
          odd.glb(skinned),
          odd.with_data_uri(skinned),
          draco_file(draco_stream(grid, draco::MESH_SEQUENTIAL_ENCODING), 25, 96),
          draco_file(draco_stream(grid, draco::MESH_EDGEBREAKER_ENCODING), 25, 96),
          meshopt_file(grid),
          meshopt_file(grid, true),
          meshopt_file(grid, true, true)};
}

std::vector<std::string> mtl_seeds() {
  return {
      "# materials\nnewmtl red\nKa 0 0 0\nKd 1 0 0\nKs 0 0 0\nNs 10\nd 1\nillum 2\nmap_Kd -s 1 1 1 red.png\n"
      "newmtl blue\nKd 0.5\nnewmtl red\nKd 0 1 0\n",
      "newmtl blue\r\nKd spectral a.rfl 1\r\nnewmtl\r\nKd xyz 1 1 1\r\nnewmtl red\r\nKd 255 nan -1\r\n"};
}

std::vector<std::string> point_seeds() {
  return {"x,y,z,nx,ny,nz\n0,0,0,0,0,1\n1,2,3,1,0,0\n", "3\n0 0 0\n1 2 3\n4 5 6\n",
          "# points\n0 0 0 0 0 1 7\r\n1e3\t-2 3.5 1 0 0 8\r\n", "0 1\n2 3\n",
          "\xEF\xBB\xBF"
          "0, 0, 0\n1, 1, 1"};
}

std::vector<std::string> npy_seeds() {
  const std::uint64_t rows = 2, columns = 3;
  const std::string values(rows * columns * sizeof(double), '\0');
  const std::string text = "{\"shape\":(1L,2L),\"descr\":\">f4\",\"fortran_order\":True}\n";
  return {npy_header("<f8", std::array{rows, columns}) + values,
          npy_header("<f4", std::array{rows, 2 * columns}) + values,
          "\x93NUMPY\x02"s + '\0' + static_cast<char>(text.size()) + std::string(3, '\0') + text +
              std::string(8, '\0'),
          npy_header("|O", std::array{rows, columns}) + values};
}

ArchiveEntry entry(const std::string& name, const std::string& content) {
  ArchiveEntry made;
  made.name = name;
  made.content = content;
  return made;
}

ArchiveEntry link_entry(const std::string& name, char type) {
  ArchiveEntry made = entry(name, "");
  made.type = type;
  made.link = "set/a.off";
  return made;
}

std::vector<ArchiveEntry> archive_entries() {
  std::vector<ArchiveEntry> entries = {entry("set/a.off", mesh_bytes(tetrahedron(), MeshFile::off)),
                                       entry("set/b/b.stl", mesh_bytes(tetrahedron(), MeshFile::stl_binary)),
                                       entry("../out.off", "OFF"), entry("set/a.off", ""),
                                       entry(std::string(120, 'n') + "/long.obj", std::string(3000, 'v'))};
  entries[1].deflate = false;
  return entries;
}

std::vector<std::string> zip_seeds() {
  std::vector<ArchiveEntry> odd = archive_entries();
  odd[0].flags = 1;
  odd[1].dos = true;
  odd[1].name = "b\\b.stl";
  odd[2].method = 14;
  odd[3].mode = 0120777;
  odd[4].stated_bytes = 5;
  std::vector<ArchiveEntry> inner(2);
  inner[0].name = "in.zip";
  inner[0].content = zip_bytes(archive_entries());
  inner[1].name = "stored.tgz";
  inner[1].content = gzip_bytes(tar_bytes(archive_entries()));
  inner[1].deflate = false;
  return {zip_bytes(archive_entries()),
          zip_bytes(archive_entries(), true),
          zip_bytes(odd, false, "a comment"),
          "#!/bin/sh\nexit\n" + zip_bytes(archive_entries()),
          zip_bytes({}),
          zip_bytes(inner)};
}

std::vector<std::string> tar_seeds() {
  std::vector<ArchiveEntry> odd = archive_entries();
  odd[1].type = '5';
  odd[2] = link_entry("link.off", '1');
  odd[3] = link_entry("soft.off", '2');
  return {tar_bytes(archive_entries(), LongNames::gnu), tar_bytes(archive_entries(), LongNames::pax),
          tar_bytes(odd, LongNames::ustar), tar_bytes({})};
}

std::vector<std::string> npz_seeds() {
  const std::vector<std::string> arrays = npy_seeds();
  const std::uint64_t three = 3;
  const std::string loc = npy_header("<f8", std::array{three}) + std::string(3 * sizeof(double), '\0'),
                    scale = npy_header("<f8", {}) + std::string(sizeof(double), '\1'),
                    frame = npy_header("<U6", {}) + "s\0\0\0t\0\0\0o\0\0\0r\0\0\0e\0\0\0d\0\0\0"s;
  return {zip_bytes({entry("points.npy", arrays[0]), entry("normals.npy", arrays[0]),
                     entry("frame.npy", frame), entry("loc.npy", loc), entry("scale.npy", scale)}),
          zip_bytes({entry("arr_0.npy", arrays[1])})};
}

std::vector<std::string> gz_seeds() {
  const std::string mesh = mesh_bytes(mesh_with_attributes(), MeshFile::off);
  return {gzip_bytes(mesh),
          gzip_bytes(mesh, 0),
          gzip_bytes(mesh) + gzip_bytes("second\n"),
          gzip_bytes(""),
          gzip_bytes(tar_bytes(archive_entries())),
          gzip_bytes(std::string(200000, 'a'), 9)};
}

StoreHeader header_of(const StoreColumns& columns) {
  StoreHeader header;
  header.columns = columns;
  header.samples = 3;
  header.parameters_json = R"({"method":"direct"})";
  header.label_names = {"chair"};
  header.descriptors = {{"d2", 4, {{"bins", "4 equal bins"}}}};
  header.ids = {"a.off", "b.off"};
  header.labels = {0, -1};
  return header;
}

std::vector<std::string> plan_seeds() {
  std::vector<std::string> seeds;
  const ScratchFolder folder;
  StoreColumns chosen{.asked = ColumnSet(&Samples::rgb, &Samples::texcoord),
                      .left_out = ColumnSet(&Samples::normals)};
  chosen.attributes = {{"flow", 3}, {"quality", 1}};
  for (const StoreColumns& columns : {StoreColumns{}, StoreColumns{.rows = RowKind::surfaces}, chosen}) {
    RunPlan plan{header_of(columns)};
    if (columns.rows == RowKind::surfaces) plan.header.splits = {Split::train, Split::test};
    store::write_plan(folder.path(), plan);
    const std::string text = read_file(folder / "plan.bin");
    seeds.push_back(text.substr(0, text.size() - 4));
  }
  return seeds;
}

// Records as the store writes them, a payload behind the byte that chooses its store, and begun rows.
std::vector<std::string> journal_seeds() {
  const auto text_of = [](const std::vector<std::byte>& bytes) {
    return std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  };
  const auto record = [](std::uint32_t samples, Compression compression) {
    StoreHeader header = header_of({});
    header.samples = samples;
    header.compression = compression;
    Row row;
    row.report.status = Status::ok;
    row.descriptors = {{"d2", {1, 2, 3, 4}}};
    row.samples.points.assign(3 * std::size_t{samples}, 0.5F);
    row.samples.normals.assign(3 * std::size_t{samples}, 0.0F);
    row.samples.face.assign(samples, 0);
    row.samples.corners.assign(3 * std::size_t{samples}, 2);
    row.samples.barycentric.assign(2 * std::size_t{samples}, 0.25F);
    row.samples.curve_rank.assign(samples, 1);
    row.samples.density.assign(samples, 1);
    return encode_row(header, 1, row).bytes;
  };
  std::vector<std::string> seeds;
  for (const std::uint32_t samples : {3u, 5000u})
    for (const Compression compression : {Compression::standard, Compression::none}) {
      const std::string bytes = text_of(record(samples, compression));
      const char choice =
          static_cast<char>((samples == 3 ? 1 : 0) | (compression == Compression::standard ? 2 : 0));
      if (compression == Compression::standard || samples == 3)
        seeds.push_back(choice + bytes.substr(store::record_header_bytes));
      if (samples == 3 && compression == Compression::standard) seeds.push_back(bytes + bytes);
    }
  Row failed;
  failed.report.status = Status::unreadable;
  failed.report.reason = "line 3: a number is missing";
  seeds.push_back(text_of(encode_row(header_of({}), 1, failed).bytes));
  return seeds;
}

std::vector<std::string> json_seeds() {
  return {
      R"({"density":"uniform","describe":["d2",{"bins":64}],"n":1e3,"seed":1,"x":null,"y":[true,false,-0.5]})",
      R"( {"a":"é \" \\ \/ \b\f\n\r\t","a":[[[]],{}],"big":18446744073709551615} )", "[1,2,[3]]", "{}",
      std::string(199, '[') + std::string(199, ']')};
}

std::string png_of(int type, int depth, int interlace) {
  std::string bytes;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_set_write_fn(
      png, &bytes,
      [](png_structp to, png_bytep data, png_size_t size) {
        static_cast<std::string*>(png_get_io_ptr(to))->append(reinterpret_cast<const char*>(data), size);
      },
      nullptr);
  png_set_IHDR(png, info, 5, 4, depth, type, interlace, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  if (type == PNG_COLOR_TYPE_PALETTE) {
    const png_color palette[2] = {{255, 0, 0}, {0, 0, 255}};
    png_set_PLTE(png, info, palette, 2);
  }
  png_write_info(png, info);
  const std::vector<png_byte> row(5 * 4 * 2, 0);
  for (int pass = interlace == PNG_INTERLACE_NONE ? 1 : png_set_interlace_handling(png); pass > 0; --pass)
    for (int y = 0; y < 4; ++y) png_write_row(png, row.data());
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  return bytes;
}

std::vector<std::string> png_seeds() {
  return {png_of(PNG_COLOR_TYPE_GRAY, 1, PNG_INTERLACE_NONE),
          png_of(PNG_COLOR_TYPE_GRAY, 16, PNG_INTERLACE_ADAM7),
          png_of(PNG_COLOR_TYPE_RGB, 8, PNG_INTERLACE_ADAM7),
          png_of(PNG_COLOR_TYPE_RGBA, 16, PNG_INTERLACE_NONE),
          png_of(PNG_COLOR_TYPE_PALETTE, 2, PNG_INTERLACE_NONE)};
}

// Few colors in an order without symmetry.
TestImage small_picture(std::uint32_t colors) {
  return {11, 7, [=](std::uint32_t x, std::uint32_t y) {
            const std::uint32_t number = (x / 2 * 3 + y * 5) % colors;
            return std::vector<int>{static_cast<int>(40 * number), static_cast<int>(255 - number), 7};
          }};
}

std::vector<std::string> bmp_seeds() {
  const TestImage image = small_picture(6), two = small_picture(2);
  return {bmp_bytes(two, {1}),
          bmp_bytes(image, {4, true}),
          bmp_bytes(image, {8, false, false, 12}),
          bmp_bytes(image, {8, false, true}),
          bmp_bytes(image, {4, false, true}),
          bmp_bytes(image, {16, false, false, 108, {0xF800, 0x07E0, 0x001F}}),
          bmp_bytes(image, {24}),
          bmp_bytes(image, {32, true})};
}

std::vector<std::string> gif_seeds() {
  const TestImage image = small_picture(6);
  return {gif_bytes(image), gif_bytes(image, {true, true, true}),
          gif_bytes(small_picture(2), {false, false, false, 20, 20, 3, 4, 1, 2})};
}

std::vector<std::string> tga_seeds() {
  const TestImage image = small_picture(6);
  std::vector<std::string> seeds;
  for (const bool runs : {false, true}) {
    TgaKind kind;
    kind.runs = kind.footer = runs;
    kind.from_right = !runs;
    for (const unsigned bits : {16u, 24u, 32u}) {
      kind.bits = bits;
      seeds.push_back(tga_bytes(image, kind));
    }
    kind.bits = 8;
    kind.gray = true;
    seeds.push_back(tga_bytes(image, kind));
    kind.gray = false;
    kind.palette = true;
    kind.first_color = 3;
    seeds.push_back(tga_bytes(image, kind));
  }
  return seeds;
}

// The picture at (2, 4) of 40 x 30 pixels, as the first of an animation.
std::string webp_animation(const std::string& picture) {
  const auto chunk = [](const std::string& name, const std::string& content) {
    std::string bytes = name;
    append_number(bytes, static_cast<std::uint32_t>(content.size()), 4);
    return bytes + content + (content.size() % 2 == 1 ? "\0"s : ""s);
  };
  return chunk("RIFF", "WEBP" + chunk("VP8X", "\2\0\0\0\x27\0\0\x1D\0\0"s) + chunk("ANIM", "\1\2\3\4\0\0"s) +
                           chunk("ANMF", "\1\0\0\2\0\0\x0A\0\0\6\0\0\x64\0\0\0"s + picture.substr(12)));
}

std::vector<std::string> webp_seeds() {
  const TestImage image = small_picture(6);
  const TestImage larger(80, 60, [](std::uint32_t x, std::uint32_t y) {
    return std::vector<int>{static_cast<int>(3 * x), static_cast<int>(x * y % 256), static_cast<int>(4 * y)};
  });
  return {webp_bytes(image),
          webp_bytes(image, {50, false}),
          webp_bytes(image, {80, false, true}),
          webp_bytes(larger),
          webp_bytes(small_picture(2), {0, true, true, 0}),
          webp_animation(webp_bytes(image))};
}

std::vector<std::string> label_seeds() {
  return {
      "id,synsetId,subSynsetId,modelId,split\n1,02691156,02690373,1a,train\n2,03001627,03001627,1a,val\n",
      "a_0001\n# b\nc/d_2.txt\n",
      "Airplane\t02691156\nBag\t02773838\n",
      R"([{"synsetId":"02691156","name":"airplane,plane","children":["1"]},{"synsetId":"1","name":"plane"}])",
      R"({"set":{"02691156":["1a","2b"]},"other":{"test":["3c"]}})",
      R"([{"model_id":"1a","category":"Chair","split":"val"}])",
      R"({"1a":"train","2b":"test"})",
      "PSB 1\n3 3\nanimal 0 0\ndog animal 2\n1 2\ncar 0 1\nm3\n",
      "PSB 1 2 2 a 0 1 x b 0 1 y",
      "id,class,split\na.off,chair,train\n\"b,1.off\",\"a \"\"b\"\"\",test\r\n\nc.off,table,val\n",
      "\xEF\xBB\xBF"
      "a.off, chair\nb.off, table\n"};
}

}  // namespace

std::vector<std::string> seeds_of(std::string_view target) {
  if (target == "off") return off_seeds();
  if (target == "obj") return obj_seeds();
  if (target == "ply") return ply_seeds();
  if (target == "stl") return stl_seeds();
  if (target == "gltf") return gltf_seeds();
  if (target == "mtl") return mtl_seeds();
  if (target == "points") return point_seeds();
  if (target == "npy") return npy_seeds();
  if (target == "npz") return npz_seeds();
  if (target == "tensor") return {"# t\n1 0 0 1 0 1\n2 0 0 2 0 nan # c\n\n1 2 3 4 5 6\r\n", "1 0 0\n0 1 0"};
  if (target == "zip") return zip_seeds();
  if (target == "tar") return tar_seeds();
  if (target == "gz") return gz_seeds();
  if (target == "plan") return plan_seeds();
  if (target == "array")
    return {R"({"tool":"meander","array_version":1,"rows":600,"folder":"/data","inputs_listed_unix_ns":5,)"
            R"("arguments":{"0":"plan","1":"%41"},"shards":{"0":{"begin":256,"end":600,"cost_seconds":2.5},)"
            R"("1":{"begin":0,"end":256,"cost_seconds":1},"2":{"begin":600,"end":600}}})",
            R"({"array_version":1,"rows":0,"inputs_listed_unix_ns":0,"arguments":{},"shards":{}})"};
  if (target == "journal") return journal_seeds();
  if (target == "json") return json_seeds();
  if (target == "png") return png_seeds();
  if (target == "bmp") return bmp_seeds();
  if (target == "gif") return gif_seeds();
  if (target == "tga") return tga_seeds();
  if (target == "webp") return webp_seeds();
  if (target == "labels") return label_seeds();
  throw std::invalid_argument(fmt::format("no target `{}`", target));
}

std::string dictionary_of(std::string_view target) {
  std::vector<std::string_view> words;
  if (target == "off")
    words = {"OFF",          "COFF", "NOFF", "STOFF", "4OFF",      "nOFF",
             " BINARY\\x0a", "nan",  "inf",  "1e400", "\\x0d\\x0a"};
  if (target == "obj")
    words = {"\\x0av ", "\\x0avt ",   "\\x0avn ",   "\\x0af ",      "\\x0al ",    "\\x0ap ",
             "\\x0ag ", "\\x0ao ",    "//",         "mtllib a.mtl", "usemtl red", "\\x5c\\x0a",
             "-1",      "4294967295", "4294967296", "nan",          "1.#INF"};
  if (target == "ply")
    words = {"ply\\x0a",
             "format ascii 1.0\\x0a",
             "format binary_little_endian 1.0\\x0a",
             "format binary_big_endian 1.0\\x0a",
             "comment ",
             "element vertex ",
             "element face ",
             "element tristrips ",
             "property list uchar int vertex_indices\\x0a",
             "property float ",
             "property double ",
             "property uchar red\\x0a",
             "property list ",
             "char ",
             "short ",
             "ushort ",
             "int ",
             "uint ",
             "int8 ",
             "uint16 ",
             "float64 ",
             "end_header\\x0a",
             "density",
             "nx",
             "nan"};
  if (target == "stl")
    words = {"solid",    "facet normal", "outer loop",          "vertex ", "endloop", "endfacet",
             "endsolid", "nan",          "\\xff\\xff\\xff\\xff"};
  if (target == "gltf")
    words = {"\\\"buffers\\\":",
             "\\\"bufferViews\\\":",
             "\\\"accessors\\\":",
             "\\\"meshes\\\":",
             "\\\"primitives\\\":",
             "\\\"attributes\\\":",
             "\\\"POSITION\\\":",
             "\\\"COLOR_0\\\":",
             "\\\"JOINTS_0\\\":",
             "\\\"WEIGHTS_0\\\":",
             "\\\"indices\\\":",
             "\\\"mode\\\":",
             "\\\"nodes\\\":",
             "\\\"children\\\":",
             "\\\"targets\\\":",
             "\\\"weights\\\":",
             "\\\"extensions\\\":",
             "\\\"EXT_mesh_gpu_instancing\\\":",
             "\\\"TRANSLATION\\\":",
             "\\\"ROTATION\\\":",
             "\\\"SCALE\\\":",
             "\\\"KHR_node_visibility\\\":",
             "\\\"EXT_texture_webp\\\":",
             "\\\"skin\\\":",
             "\\\"skins\\\":",
             "\\\"joints\\\":",
             "\\\"inverseBindMatrices\\\":",
             "\\\"sparse\\\":",
             "\\\"count\\\":",
             "\\\"byteOffset\\\":",
             "\\\"byteLength\\\":",
             "\\\"byteStride\\\":",
             "\\\"componentType\\\":",
             "5120",
             "5121",
             "5122",
             "5123",
             "5125",
             "5126",
             "\\\"SCALAR\\\"",
             "\\\"VEC2\\\"",
             "\\\"VEC3\\\"",
             "\\\"VEC4\\\"",
             "\\\"MAT4\\\"",
             "\\\"normalized\\\":true",
             "\\\"uri\\\":",
             "data:application/octet-stream;base64,",
             "KHR_draco_mesh_compression",
             "EXT_meshopt_compression",
             "KHR_mesh_quantization",
             "\\\"extensionsRequired\\\":",
             "\\\"filter\\\":\\\"OCTAHEDRAL\\\"",
             "\\\"filter\\\":\\\"QUATERNION\\\"",
             "\\\"filter\\\":\\\"EXPONENTIAL\\\"",
             "\\\"mode\\\":\\\"TRIANGLES\\\"",
             "4294967295",
             "-1",
             "1e308",
             "DRACO"};
  if (target == "mtl")
    words = {"newmtl ", "Kd ", "spectral ", "xyz ", "map_Kd ", "red", "blue", "nan", "255", "1e400"};
  if (target == "points") words = {"x,y,z", "nx", "ny", "nz", "nan", "inf", ", ", "#", "\\x0d\\x0a"};
  if (target == "npy")
    words = {"\\x93NUMPY\\x01",
             "'descr'",
             "'fortran_order'",
             "'shape'",
             "True",
             "False",
             "<f4",
             ">f8",
             "[(",
             "L, "};
  if (target == "tensor") words = {"nan", "inf", "#", "\\x0d\\x0a", "1e400"};
  if (target == "zip")
    words = {"PK\\x01\\x02",         "PK\\x03\\x04",         "PK\\x05\\x06", "PK\\x06\\x06", "PK\\x06\\x07",
             "\\xff\\xff\\xff\\xff", "\\x01\\x00\\x1c\\x00", "../",          "up\\x09\\x00"};
  if (target == "tar")
    words = {"ustar\\x0000",       "ustar  \\x00", "././@LongLink",
             "12 path=a.b\\x0a",   "linkpath=",    "size=",
             "GNU.sparse.major=1", "../",          "\\x80\\x00\\x00\\x00\\x00\\x00\\x00\\x00"};
  if (target == "gz") words = {"\\x1f\\x8b\\x08", "\\x1f\\x8b\\x08\\x1c"};
  if (target == "array")
    words = {
        "\\\"begin\\\":", "\\\"end\\\":", "\\\"rows\\\":", "\\\"shards\\\":", "-1", "9223372036854775807"};
  if (target == "json")
    words = {"\\\"a\\\":", "null", "true", "false", "1e308", "1e-400", "\\\\ud800", "\\\\udc00", "[[[["};
  if (target == "png") words = {"IHDR", "PLTE", "IDAT", "IEND", "tRNS", "gAMA", "iCCP"};
  if (target == "gif") words = {"GIF87a", "GIF89a", "\\x21\\xf9\\x04", "\\x2c"};
  if (target == "tga") words = {"TRUEVISION-XFILE.\\x00"};
  if (target == "webp") words = {"RIFF", "WEBP", "VP8 ", "VP8L", "VP8X", "ALPH", "ANIM", "ANMF", "ICCP"};
  if (target == "labels")
    words = {"PSB 1", "\\\"\\\"",   "id,class,split", "train",   "test",    "val",
             ",",     "\\x0d\\x0a", "synsetId",       "modelId", "03001627"};
  std::string text;
  for (const std::string_view word : words) text += fmt::format("\"{}\"\n", word);
  return text;
}

}  // namespace meander::fuzz
