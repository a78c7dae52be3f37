#include <sys/stat.h>

#include <cstring>
#include <vector>

#include "io/archive/archive_writers.h"
#include "io/file_kind.h"
#include "io/json_writer.h"
#include "io/plot/png_writer.h"
#include "io/run_error.h"
#include "io/store/run_directory.h"
#include "io/table/table.h"
#include "support/catch.h"
#include "support/mesh_files.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

FileKind kind_of(std::string_view bytes) {
  const ScratchFolder scratch;
  write_file(scratch / "f", bytes);
  return kind_of_file(scratch / "f");
}

template <class Number>
std::string raw(const std::vector<Number>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Number)};
}

}  // namespace

TEST_CASE("file kind: files that this program writes are recognized") {
  const ScratchFolder scratch;
  {
    StoreHeader header;
    header.samples = 4;
    RunDirectory(scratch / "s.h5", header).finish();
  }
  CHECK(kind_of_file(scratch / "s.h5") == FileKind::store);
  write_png(scratch / "p.png", RgbImage(2, 2));
  CHECK(kind_of_file(scratch / "p.png") == FileKind::png);
  CHECK(kind_of("<?xml version=\"1.0\"?>\n<!DOCTYPE svg PUBLIC \"-//W3C//DTD SVG 1.1//EN\">\n<svg "
                "width=\"1pt\"></svg>") == FileKind::svg);
  const Table table{{{"name"}, {"value"}}, {{"a, \"quoted\"\nname", 1.5}, {"b", TableCell()}}};
  CHECK(kind_of(csv_text(table)) == FileKind::csv);
  CHECK(kind_of(csv_text(Table{{{"name"}, {"value"}}, {}})) == FileKind::csv);
  CHECK(kind_of("f / sqrt(n),mean\n0.1,2\n") == FileKind::csv);
  CHECK(kind_of("{\"store\":\"s.h5\"}\n") == FileKind::json);
  CHECK(kind_of(R"({"accessors":[],"asset":{"version":"2.0"}})") == mesh_kind(MeshFormat::gltf));
  CHECK(kind_of(std::string("glTF\2\0\0\0", 8)) == mesh_kind(MeshFormat::gltf));
  std::string tar, zip;
  TarWriter([&tar](std::string_view piece) { tar += piece; }).add("a.npy", {"values"});
  CHECK(kind_of(tar) == FileKind::tar);
  StoredZipWriter([&zip](std::string_view piece) { zip += piece; }).finish();
  CHECK(kind_of(zip) == FileKind::zip);
  CHECK(kind_of("PK\3\4 and so on") == FileKind::zip);
  CHECK(kind_of("[\"a.off\",\"b.off\"]\n") == FileKind::json);
  CHECK(kind_of("# a.off: empty: no face\nin/a.off\n") == FileKind::item_list);
  // As many commas on every line, or on the only one.
  CHECK(kind_of("# in, 2024/a.off: empty: no face\nscans, 2024/a.off\n") == FileKind::item_list);
  CHECK(kind_of("# a.off: unreadable: by its name OFF, by its content OBJ\n\n") == FileKind::item_list);
  CHECK(kind_of("ply\nformat ascii 1.0\nelement vertex 2\nend_header\n") == FileKind::ply_points);
  CHECK(kind_of("OFF\n2 0 0\n0 0 0\n1 1 1\n") == FileKind::off_points);
  CHECK(kind_of("1 2 3 0 0 1\n1e-5 -2 3 0 0 1\n") == FileKind::xyz);
  CHECK(kind_of("1 2 3 0 0 1\n1e-5 -2 3 0 0 1\n# frame file\n") == FileKind::xyz);
  const std::vector<std::uint32_t> header = {2, 3};
  CHECK(kind_of(raw(header) + raw(std::vector<float>(6, 0.5f))) == FileKind::fbin);
  CHECK(kind_of(raw(std::vector<float>{0, 1, 2, 1, 0, 3, 2, 3, 0})) == FileKind::distance_matrix);
  CHECK(kind_of("") == FileKind::empty);
}

TEST_CASE("file kind: meshes of every format are recognized") {
  const PolygonMesh mesh = grid_plane(3, 3);
  const auto kind = [&](MeshFile file) { return kind_of(mesh_bytes(mesh, file)); };
  CHECK(kind(MeshFile::off) == mesh_kind(MeshFormat::off));
  CHECK(kind(MeshFile::off_binary) == mesh_kind(MeshFormat::off));
  CHECK(kind(MeshFile::obj) == mesh_kind(MeshFormat::obj));
  CHECK(kind(MeshFile::ply_ascii) == mesh_kind(MeshFormat::ply));
  CHECK(kind(MeshFile::ply_little_endian) == mesh_kind(MeshFormat::ply));
  CHECK(kind(MeshFile::ply_big_endian) == mesh_kind(MeshFormat::ply));
  CHECK(kind(MeshFile::stl_ascii) == mesh_kind(MeshFormat::stl));
  CHECK(kind(MeshFile::stl_binary) == mesh_kind(MeshFormat::stl));
  CHECK(kind_of("# made by hand\nOFF 3 1 0\n0 0 0\n") != FileKind::off_points);
  CHECK(kind_of("OFF # comment\n# another\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n") ==
        mesh_kind(MeshFormat::off));
}

TEST_CASE("file kind: files of other programs are not recognized as our own") {
  CHECK(kind_of("import sys, os\nprint(sys.argv, os.name, 1)\n") == FileKind::text);
  CHECK(kind_of("Dear reader,\n\nthis is a letter.\n") == FileKind::text);
  CHECK(kind_of("v for victory, f for fun\nand more\n") == FileKind::text);
  CHECK(kind_of("# name, value\na, 1\n") == FileKind::csv);
  CHECK(kind_of("[section]\nkey = 1\n") == FileKind::text);
  CHECK(kind_of("<?xml version=\"1.0\"?>\n<note/>\n") == FileKind::text);
  CHECK(kind_of("\x89HDF\r\n\x1a\n and more") == FileKind::hdf5);
  CHECK(kind_of(std::string(512, '\0') + "\x89HDF\r\n\x1a\n") == FileKind::hdf5);
  CHECK(kind_of(std::string("\x7f"
                            "ELF\0\1\2\3",
                            8)) == FileKind::unknown);
  CHECK(kind_of("caf\xe9") == FileKind::unknown);  // Latin-1
  CHECK(kind_of(raw(std::vector<float>{0, 1, 2, 1, 0})) == FileKind::unknown);
  CHECK(kind_of(raw(std::vector<float>{1, 1, 1, 1})) == FileKind::unknown);
  const ScratchFolder scratch;
  CHECK_THROWS_AS(kind_of_file(scratch / "nothing"), RunError);
}

TEST_CASE("file kind: long files are recognized by their beginning") {
  std::string table = "id,value\n";
  while (table.size() < (std::size_t{1} << 17)) table += "a,1\n";
  CHECK(kind_of(table) == FileKind::csv);
  std::string points;
  while (points.size() < (std::size_t{1} << 17)) points += "0.25 0.5 0.75\n";
  CHECK(kind_of(points) == FileKind::xyz);
  std::string letters = "x";
  while (letters.size() < (std::size_t{1} << 17)) letters += "\xc3\xa9";  // one of them is cut
  CHECK(kind_of(letters) == FileKind::text);
}
