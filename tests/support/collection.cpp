#include "support/collection.h"

#include <limits>

#include "support/mesh_files.h"
#include "support/test_meshes.h"

namespace meander::test {

std::map<std::string, Status> write_collection(const std::filesystem::path& folder) {
  std::map<std::string, Status> expected;
  const auto add = [&](const std::string& id, const PolygonMesh& mesh, MeshFile kind,
                       Status status = Status::ok) {
    std::filesystem::create_directories((folder / id).parent_path());
    write_mesh(folder / id, mesh, kind);
    expected[id] = status;
  };
  const auto add_text = [&](const std::string& id, const std::string& text, Status status) {
    std::filesystem::create_directories((folder / id).parent_path());
    write_file(folder / id, text);
    expected[id] = status;
  };
  for (int i = 0; i < 8; ++i) {
    const std::string number = std::to_string(i);
    const double scale = 1 + i, shift = i * 0.3;
    add("sphere/" + number + ".off", moved(icosphere(1 + i % 4), scale, shift, 0, 0), MeshFile::off);
    add("torus/" + number + ".ply",
        moved(torus(10 + 3 * static_cast<std::uint32_t>(i), 8), scale, 0, shift, 0),
        i % 2 ? MeshFile::ply_ascii : MeshFile::ply_little_endian);
    add("plane/" + number + ".obj",
        moved(grid_plane(3 + static_cast<std::uint32_t>(i), 5, 1, 2), scale, 0, 0, shift), MeshFile::obj);
    add("plate/" + number + ".stl", two_sided_plate(4 + static_cast<std::uint32_t>(i), 0.02 * (1 + i)),
        i % 2 ? MeshFile::stl_ascii : MeshFile::stl_binary);
  }
  add("odd/moebius.off", moebius_strip(30), MeshFile::off);
  add("odd/two.obj", merged(cube(), moved(icosphere(2), 0.5, 3, 0, 0)), MeshFile::obj);
  add("odd/tetrahedron.ply", tetrahedron(), MeshFile::ply_big_endian);
  add("odd/huge.off", moved(torus(12, 8), 1e30, 0, 0, 0), MeshFile::off);
  add("odd/tiny.off", moved(torus(12, 8), 1e-30, 0, 0, 0), MeshFile::off);
  add("odd/copy_of_moebius.off", moebius_strip(30), MeshFile::off);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  add("broken/nan.off", polygon_mesh({0, 0, nan, 1, 0, 0, 0, 1, 0}, {{0, 1, 2}}), MeshFile::off,
      Status::non_finite);
  add("broken/range.off", polygon_mesh({0, 0, 0, 1, 0, 0, 0, 1, 0}, {{0, 1, 7}}), MeshFile::off,
      Status::index_out_of_range);
  add("broken/flat.off", polygon_mesh({0, 0, 0, 1, 0, 0, 2, 0, 0}, {{0, 1, 2}}), MeshFile::off,
      Status::zero_area);
  add("broken/points.obj", polygon_mesh({0, 0, 0, 1, 0, 0, 2, 0, 0}, {}), MeshFile::obj, Status::empty);
  add_text("broken/nothing.off", "", Status::empty);
  add_text("broken/garbage.ply", "this is no mesh at all\n", Status::unreadable);
  return expected;
}

}  // namespace meander::test
