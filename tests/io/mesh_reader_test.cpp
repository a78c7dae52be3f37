#include "io/mesh/mesh_reader.h"

#include <atomic>
#include <locale>
#include <map>

#include "io/archive/model_bytes.h"
#include "io/reading.h"
#include "kernels/core/random.h"
#include "support/mesh_files.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

constexpr MeshFile all_files[] = {MeshFile::off,       MeshFile::off_binary,        MeshFile::obj,
                                  MeshFile::ply_ascii, MeshFile::ply_little_endian, MeshFile::ply_big_endian,
                                  MeshFile::stl_ascii, MeshFile::stl_binary};

MeshFormat format_of(MeshFile file) {
  switch (file) {
    case MeshFile::off:
    case MeshFile::off_binary:
      return MeshFormat::off;
    case MeshFile::obj:
      return MeshFormat::obj;
    case MeshFile::stl_ascii:
    case MeshFile::stl_binary:
      return MeshFormat::stl;
    default:
      return MeshFormat::ply;
  }
}

// A mesh or an ItemError with a sentence, nothing else.
void check_outcome(std::string_view content, MeshFormat format, const BlockRule& rule = {}) {
  try {
    check_consistent(read(content, format, rule));
  } catch (const ItemError& error) {
    const Status status = error.status();
    REQUIRE(
        (status == Status::unreadable || status == Status::empty || status == Status::unsupported_format));
    REQUIRE(std::string_view(error.what()).size() > 10);
  }
}

struct CommaPoint : std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\3"; }
};

}  // namespace

TEST_CASE("mesh_format_of: recognizes extensions in any case") {
  const std::map<std::string, MeshFormat> known = {{"a.off", MeshFormat::off},   {"a.OFF", MeshFormat::off},
                                                   {"b/a.Obj", MeshFormat::obj}, {"a.b.ply", MeshFormat::ply},
                                                   {"a.STL", MeshFormat::stl},   {"a.gltf", MeshFormat::gltf},
                                                   {"a.GLB", MeshFormat::gltf}};
  for (const auto& [path, expected] : known) {
    MeshFormat format{};
    REQUIRE(mesh_format_of(path, format));
    REQUIRE(format == expected);
  }
  MeshFormat format{};
  for (const char* const path : {"a", "a.gl", "off", ".off", "a.off.gz", "a.obj~", ""})
    REQUIRE_FALSE(mesh_format_of(path, format));
}

TEST_CASE("file bytes: read and mapped files, empty files, folders and missing files") {
  const ScratchFolder folder;
  const auto text_of = [](const FileBytes& file) {
    return std::string(reinterpret_cast<const char*>(file.bytes().data()), file.bytes().size());
  };
  // The longest that is read, and the shortest that is mapped.
  for (const std::size_t size : {std::size_t{1}, FileBytes::max_read, FileBytes::max_read + 1}) {
    CAPTURE(size);
    std::string text(size, 'x');
    text.back() = 'y';
    write_file(folder / "some", text);
    FileBytes some(folder / "some");
    REQUIRE(text_of(some) == text);
    const FileBytes moved(std::move(some));
    REQUIRE(text_of(moved) == text);
    REQUIRE(some.bytes().empty());
  }
  write_file(folder / "none", "");
  REQUIRE(FileBytes(folder / "none").bytes().empty());
  const auto reason = [](const std::filesystem::path& path) -> std::string {
    try {
      const FileBytes file(path);
    } catch (const ItemError& error) {
      REQUIRE(error.status() == Status::unreadable);
      return error.what();
    }
    return "opened";
  };
  REQUIRE(reason(folder / "absent") == "the file cannot be opened: No such file or directory");
  REQUIRE(reason(folder.path()) == "not a regular file");
}

TEST_CASE("file bytes: the lost part of a mapped file reads as zeros, and the model is unreadable") {
  const ScratchFolder folder;
  const std::filesystem::path path = folder / "model.ply";
  const std::string text = mesh_bytes(icosphere(7), MeshFile::ply_little_endian);
  REQUIRE(text.size() > FileBytes::max_read);
  for (const std::size_t left : {std::size_t{0}, std::size_t{5000}}) {
    write_file(path, text);
    const FileBytes bytes(path);
    const ModelBytes model({path, {}, MeshFormat::ply});
    REQUIRE_FALSE(bytes.is_cut());
    const auto message_of = [](const auto& work) -> std::string {
      try {
        work();
      } catch (const ItemError& error) {
        CHECK(error.status() == Status::unreadable);
        return error.what();
      }
      return "read";
    };
    std::filesystem::resize_file(path, left);
    CHECK(bytes.bytes().back() == std::byte{0});
    CHECK(bytes.is_cut());
    const std::string expected = "the file, or one beside it, was shortened while it was read";
    CHECK(message_of([&] { model.mesh(); }) == expected);
    CHECK(message_of([&] { model.content_sha256(); }) == expected);
  }
  write_file(path, text);
  CHECK(ModelBytes({path, {}, MeshFormat::ply}).mesh().polygon_count() == icosphere(7).polygon_count());
}

TEST_CASE("read_mesh: every format gives back what was written") {
  const PolygonMesh mesh = mesh_with_attributes();
  for (const MeshFile file : all_files) {
    CAPTURE(static_cast<int>(file));
    const PolygonMesh back = read(mesh_bytes(mesh, file), format_of(file));
    check_consistent(back);
    if (format_of(file) == MeshFormat::stl) {
      REQUIRE(back.polygon_count() == 16);
      continue;
    }
    REQUIRE(back.x == mesh.x);
    REQUIRE(back.y == mesh.y);
    REQUIRE(back.z == mesh.z);
    REQUIRE(faces_of(back) == faces_of(mesh));
    REQUIRE(back.normals == mesh.normals);
  }
}

TEST_CASE("read_mesh: content of another format is named") {
  const PolygonMesh mesh = mesh_with_attributes();
  const std::map<MeshFormat, std::string> names = {{MeshFormat::off, "an OFF file"},
                                                   {MeshFormat::obj, "an OBJ file"},
                                                   {MeshFormat::ply, "a PLY file"},
                                                   {MeshFormat::stl, "an STL file"}};
  for (const MeshFile file : all_files)
    for (const auto& [format, name] : names) {
      const std::string content = mesh_bytes(mesh, file);
      if (format_of(file) == format) {
        REQUIRE(foreign_content(content, format).empty());
      } else if (file != MeshFile::stl_binary) {
        REQUIRE(outcome(content, format) == "unreadable: by its name this is " + name +
                                                ", by its content it is " + names.at(format_of(file)));
      } else {
        REQUIRE(failure(content, format)->status() == Status::unreadable);
      }
    }
  const std::pair<std::string, const char*> others[] = {
      {std::string("\x1F\x8B\x08\0\0", 5), "a gzip archive"},
      {"PK\x03\x04 and more", "a zip archive"},
      {"<!DOCTYPE html>\n<html>", "a web page"},
      {"version https://git-lfs.github.com/spec/v1\noid sha256:1\n",
       "a Git LFS pointer; the file itself was not fetched"}};
  for (const auto& [content, what] : others)
    for (const auto& [format, name] : names)
      REQUIRE(outcome(content, format) ==
              "unreadable: by its name this is " + name + ", by its content it is " + what);
}

TEST_CASE("read_mesh: blocks of any size give the same mesh") {
  // Relative and absolute indices, normals, comments, blank lines and mixed polygons.
  std::string obj;
  for (int i = 0; i < 300; ++i) {
    for (int k = 0; k < 4; ++k)
      obj += "v " + std::to_string(i) + " " + std::to_string(k * 0.125) + " " + std::to_string(i * k) + "\n";
    obj += i % 7 == 0 ? "# comment \\\n" : "vn 0 " + std::to_string(i) + " 1\n";
    obj += i % 3 == 0 ? "f -4 -3 -2\n" : "f -4//-1 -3//-1 \\\n -2//-1 -1//-1\n";
    if (i % 5 == 0) obj += "\nf 1 2 " + std::to_string(4 * i + 900) + "\n";
    if (i % 50 == 49) obj += "f 1 x 2\n";
  }
  PolygonMesh mixed = merged(merged(icosphere(3), cube()), torus(20, 10));
  mixed.vertex_attributes.push_back({"height", mixed.z});
  std::string commented = mesh_bytes(mixed, MeshFile::off);
  for (std::size_t at = 40; at < commented.size(); at = commented.find('\n', at + 500))
    commented.insert(commented.find('\n', at), " # comment\n\n#");
  std::vector<std::pair<std::string, MeshFormat>> contents = {{obj, MeshFormat::obj},
                                                              {commented, MeshFormat::off}};
  for (const MeshFile file : all_files) {
    contents.emplace_back(mesh_bytes(mixed, file), format_of(file));
    contents.emplace_back(mesh_bytes(icosphere(4), file), format_of(file));
    // Cut, so that the last face is missing.
    std::string cut = mesh_bytes(mixed, file);
    cut.resize(cut.size() - 5);
    contents.emplace_back(cut, format_of(file));
  }
  for (const auto& [content, format] : contents) {
    const PolygonMesh whole =
        read(content, format, {.parallel_from = ~std::size_t{0}, .block_bytes = 1 << 20});
    for (const std::size_t block : {1, 13, 100, 1000, 4096, 30000}) {
      CAPTURE(content.substr(0, 30), block);
      REQUIRE(same_mesh(read(content, format, {.parallel_from = 0, .block_bytes = block}), whole));
    }
  }
}

TEST_CASE("read_mesh: a file cut at any byte gives a mesh or an error") {
  const PolygonMesh mesh = mesh_with_attributes();
  for (const MeshFile file : all_files) {
    const std::string content = mesh_bytes(mesh, file);
    for (std::size_t length = 0; length < content.size(); ++length) {
      CAPTURE(static_cast<int>(file), length);
      // On the heap in its exact size, so that a sanitizer detects every read past its end.
      const std::vector<char> cut(content.begin(), content.begin() + static_cast<std::ptrdiff_t>(length));
      check_outcome({cut.data(), cut.size()}, format_of(file));
    }
  }
}

TEST_CASE("read_mesh: random damage gives a mesh or an error") {
  const PolygonMesh mesh = mesh_with_attributes();
  for (const MeshFile file : all_files) {
    const std::string content = mesh_bytes(mesh, file);
    for (std::uint32_t round = 0; round < 1500; ++round) {
      CAPTURE(static_cast<int>(file), round);
      std::vector<char> bytes(content.begin(), content.end());
      const PhiloxBlock shape = philox4x32({round, static_cast<std::uint32_t>(file), 0, 0}, {3, 4});
      // Mostly a single change; half of them in the header, where they matter most.
      const std::uint32_t hits = 1 + shape[0] % 8 / 3;
      for (std::uint32_t hit = 0; hit < hits; ++hit) {
        const PhiloxBlock random = philox4x32({round, static_cast<std::uint32_t>(file), hit, 1}, {3, 4});
        const std::size_t range =
            random[0] % 2 == 0 ? bytes.size() : std::min<std::size_t>(bytes.size(), 300);
        const std::size_t at = random[1] % range;
        switch (random[2] % 4) {
          case 0:
            bytes[at] = static_cast<char>(random[3]);
            break;
          case 1:
            bytes[at] = static_cast<char>(bytes[at] ^ (1 << random[3] % 8));
            break;
          case 2:
            bytes[at] = "0123456789-+.eE#/\\\n\r \"\xFF"[random[3] % 23];
            break;
          default:
            bytes.erase(bytes.begin() + static_cast<std::ptrdiff_t>(at));
            break;
        }
      }
      const std::string_view view(bytes.data(), bytes.size());
      check_outcome(view, format_of(file));
      if (round % 8 == 0) check_outcome(view, format_of(file), {.parallel_from = 0, .block_bytes = 50});
    }
  }
}

TEST_CASE("read_mesh: random bytes give a mesh or an error in any format") {
  for (std::uint32_t round = 0; round < 2000; ++round) {
    std::vector<char> bytes(philox4x32({round, 0, 0, 0}, {5, 6})[0] % 400);
    for (std::size_t k = 0; k < bytes.size(); ++k)
      bytes[k] = static_cast<char>(philox4x32({round, static_cast<std::uint32_t>(k), 1, 0}, {5, 6})[0]);
    for (const MeshFormat format :
         {MeshFormat::off, MeshFormat::obj, MeshFormat::ply, MeshFormat::stl, MeshFormat::gltf})
      check_outcome({bytes.data(), bytes.size()}, format);
  }
}

TEST_CASE("read_mesh: does not depend on the locale") {
  const std::locale before = std::locale::global(std::locale(std::locale(), new CommaPoint));
  const PolygonMesh mesh = read("v 1.5 1000.25 0\nv 0 0.5 0\nv 1 1 1\nf 1 2 3\n", MeshFormat::obj);
  std::locale::global(before);
  REQUIRE(mesh.x[0] == 1.5);
  REQUIRE(mesh.y[0] == 1000.25);
}

TEST_CASE("read_mesh: respects deadline and cancellation") {
  const std::string content = mesh_bytes(icosphere(2), MeshFile::off);
  const std::span bytes = std::as_bytes(std::span(content));
  CancelToken late;
  late.deadline = std::chrono::steady_clock::now() - std::chrono::seconds(1);
  REQUIRE_THROWS_AS(read_mesh(bytes, MeshFormat::off, late), ItemError);
  const std::atomic<bool> stop{true};
  CancelToken stopped;
  stopped.canceled = &stop;
  REQUIRE_THROWS_AS(read_mesh(bytes, MeshFormat::off, stopped), RunCanceled);
}

TEST_CASE("reader: CR, LF, CRLF and LF CR end lines, also mixed in one file and in UTF-16") {
  const std::string obj = "# made by hand\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\n";
  const std::string off = "OFF\n# counts\n4 2 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2\n3 0 1 3\n";
  const auto with_ends = [](const std::string& text, const std::vector<std::string>& ends) {
    std::string changed;
    std::size_t line = 0;
    for (const char c : text) changed += c == '\n' ? ends[line++ % ends.size()] : std::string(1, c);
    return changed;
  };
  const auto utf16 = [](const std::string& text) {
    std::string wide = "\xFF\xFE";
    for (const char c : text) wide += {c, '\0'};
    return wide;
  };
  const std::string cr = "\r", lf = "\n", crlf = "\r\n", lfcr = "\n\r";
  for (const std::vector<std::string>& ends : std::vector<std::vector<std::string>>{
           {cr}, {crlf}, {lfcr}, {cr, lf}, {lf, cr}, {crlf, cr}, {lf, lf, lf, cr}, {"\r\r\n"}}) {
    for (const auto& [text, format] : {std::pair(obj, MeshFormat::obj), std::pair(off, MeshFormat::off)}) {
      INFO(text << ends.size() << ends.front().size());
      const PolygonMesh expected = read(text, format);
      CHECK(same_mesh(read(with_ends(text, ends), format), expected));
      CHECK(same_mesh(read(utf16(with_ends(text, ends)), format), expected));
      CHECK(same_mesh(read(with_ends(text, ends) + lf, format), expected));
    }
  }
}
