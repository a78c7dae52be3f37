// Descriptors of oriented pairs: run, describe, retrieve.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <filesystem>

#include "io/store/store.h"
#include "support/meander_program.h"
#include "support/mesh_files.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

namespace fs = std::filesystem;

PolygonMesh inside_out(PolygonMesh mesh) {
  for (std::size_t f = 0; f < mesh.polygon_count(); ++f)
    std::reverse(mesh.corners.begin() + static_cast<std::ptrdiff_t>(mesh.polygon_begin[f]),
                 mesh.corners.begin() + static_cast<std::ptrdiff_t>(mesh.polygon_begin[f + 1]));
  return mesh;
}

// Three models of each of four classes; every other one inside out if wanted.
void write_classes(const fs::path& folder, bool turned) {
  std::size_t number = 0;
  const auto add = [&](const char* name, const PolygonMesh& mesh) {
    fs::create_directories((folder / name).parent_path());
    write_mesh(folder / name, turned && number++ % 2 == 1 ? inside_out(mesh) : mesh);
  };
  add("ball/a.off", icosphere(2));
  add("ball/b.off", moved(icosphere(3), 4, 1, 2, 3));
  add("ball/c.off", icosphere(1, 9));
  add("plate/a.off", two_sided_plate(6, 0.1));
  add("plate/b.off", moved(two_sided_plate(5, 0.14), 0.3, 1, 2, 3));
  add("plate/c.off", two_sided_plate(4, 0.12));
  add("ring/a.off", torus(24, 12));
  add("ring/b.off", moved(torus(20, 10, 1, 0.35), 7, 0, 0, 1));
  add("ring/c.off", torus(30, 14, 1, 0.45));
  add("slab/a.off", slab_with_tunnels(2));
  add("slab/b.off", moved(slab_with_tunnels(3), 2, 3, 2, 1));
  add("slab/c.off", slab_with_tunnels(4));
}

struct Base {
  ScratchFolder scratch;
  std::string path(const char* name) const { return scratch / name; }

  Base() {
    write_classes(scratch / "in", false);
    write_classes(scratch / "turned", true);
    for (const char* folder : {"in/sheet", "in/both"}) fs::create_directories(scratch / folder);
    write_mesh(scratch / "in/sheet/a.off", moved(grid_plane(9, 5), 3, 1, 2, 3));
    write_mesh(scratch / "in/both/a.off", merged(icosphere(2), moved(grid_plane(9, 5), 2, 5, 0, 0)));
  }
  void sample(const char* in, const char* store, std::vector<std::string> more) const {
    std::vector<std::string> arguments = {
        "run", path(in), "-o", path(store), "-n", "300", "--label-from-folder", "--progress", "none"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ProcessResult result = meander_with(arguments);
    INFO(result.err);
    REQUIRE(result.exit_code == 0);
  }
};

std::vector<float> values_of(const StoreReader& store, const char* id, const char* descriptor) {
  for (const DescriptorRow& row : store.read_row(*store.find(id)).descriptors)
    if (row.name == descriptor) return row.values;
  return {};
}

double l1(const std::vector<float>& a, const std::vector<float>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += std::abs(double{a[i]} - double{b[i]});
  return sum;
}

}  // namespace

TEST_CASE("run --describe pairs: roots of shares, what is unoriented, the same bytes for any threads") {
  const Base base;
  base.sample("in", "a.h5", {"--describe", "d2,pairs,pairs-unsigned", "--bins", "16", "-j", "1"});
  base.sample("in", "b.h5", {"--describe", "d2,pairs,pairs-unsigned", "--bins", "16", "-j", "2"});
  CHECK((read_file(base.path("a.h5")) == read_file(base.path("b.h5"))));
  CHECK(verify_store(base.path("a.h5")).problems.empty());
  const StoreReader store(base.path("a.h5"));
  REQUIRE(store.descriptors().size() == 4);
  CHECK(store.descriptors()[1].width == 512);
  CHECK(store.descriptors()[2].name == "pairs_unoriented");
  for (std::uint64_t row = 0; row < store.rows(); ++row)
    for (const char* name : {"pairs", "pairs-unsigned"}) {
      double squares = 0;
      for (const float root : values_of(store, store.id(row).c_str(), name))
        squares += double{root} * double{root};
      CHECK(squares == Approx(1).epsilon(1e-5));
    }
  CHECK(values_of(store, "ball/a.off", "pairs_unoriented").at(0) == 0);
  CHECK(values_of(store, "sheet/a.off", "pairs_unoriented").at(0) == 1);
  const float both = values_of(store, "both/a.off", "pairs_unoriented").at(0);
  CHECK(both == Approx(4 / (4 + 12.57)).margin(0.02));

  // The same descriptors, added to a finished store.
  base.sample("in", "c.h5", {"--describe", "d2", "--bins", "16"});
  const ProcessResult described =
      meander_with({"describe", base.path("c.h5"), base.path("in"), "--descriptors", "pairs,pairs-unsigned"});
  INFO(described.err);
  REQUIRE(described.exit_code == 0);
  const StoreReader later(base.path("c.h5"));
  for (std::uint64_t row = 0; row < store.rows(); ++row)
    for (const char* name : {"d2", "pairs", "pairs_unoriented", "pairs-unsigned"})
      CHECK(values_of(later, store.id(row).c_str(), name) == values_of(store, store.id(row).c_str(), name));
}

TEST_CASE("pairs: a model turned inside out keeps its descriptor, and classes are found among such models") {
  const Base base;
  base.sample("in", "s.h5", {"--describe", "pairs,pairs-unsigned"});
  base.sample("turned", "t.h5", {"--describe", "pairs,pairs-unsigned"});
  const StoreReader store(base.path("s.h5")), turned(base.path("t.h5"));
  REQUIRE(read_file(base.path("in/ring/b.off")) != read_file(base.path("turned/ring/b.off")));
  const std::vector<float> ring = values_of(store, "ring/b.off", "pairs");
  // Not 0: the polygons have their corners in another order, and so the samples lie elsewhere.
  CHECK(l1(ring, values_of(turned, "ring/b.off", "pairs")) < 0.5);
  CHECK(l1(ring, values_of(store, "ball/a.off", "pairs")) > 2);
  for (const char* name : {"s.h5", "t.h5"})
    for (const char* descriptor : {"pairs", "pairs-unsigned"}) {
      const ProcessResult result = meander_with({"retrieve", "evaluate", base.path(name), "--descriptor",
                                                 descriptor, "--csv", base.path("scores.csv")});
      INFO(name << " " << descriptor << "\n" << result.out << result.err);
      REQUIRE(result.exit_code == 0);
      CHECK(read_file(base.path("scores.csv")).find("(micro),12,1,1,") != std::string::npos);
    }
}

TEST_CASE("pairs: what describe and run refuse") {
  const Base base;
  base.sample("in", "s.h5", {});
  const ProcessResult meshes = meander_with({"describe", base.path("s.h5"), "--descriptors", "pairs"});
  CHECK(meshes.exit_code == 2);
  CHECK(meshes.err.find("the meshes are needed for geodesic, basics and pairs") != std::string::npos);
  const ProcessResult bins =
      meander_with({"describe", base.path("s.h5"), "--descriptors", "pairs-unsigned", "--bins", "64"});
  CHECK(bins.exit_code == 2);
  CHECK(bins.err.find("--bins applies to d2, a3, d1, d3, d4 and geodesic only") != std::string::npos);
  CHECK(meander_with({"describe", base.path("s.h5"), "--descriptors", "pairs-unsigned"}).exit_code == 0);
}

TEST_CASE("export of descriptors: a numpy array, and the list of its rows") {
  const Base base;
  base.sample("in", "s.h5", {"--describe", "pairs"});
  const ProcessResult result = meander_with({"export", base.path("s.h5"), "0", "2", "--descriptors", "pairs",
                                             "--format", "npy", "-o", base.path("d.npy")});
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  const std::string array = read_file(base.path("d.npy"));
  REQUIRE(array.size() == 128 + 2 * 512 * sizeof(float));
  CHECK(array.substr(0, 10) == std::string("\x93NUMPY\x01\x00\x76\x00", 10));
  CHECK(array.substr(10, 62) == "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 512), } ");
  CHECK(array[127] == '\n');
  std::vector<float> second(512);
  std::memcpy(second.data(), array.data() + 128 + 512 * sizeof(float), 512 * sizeof(float));
  const StoreReader store(base.path("s.h5"));
  CHECK(second == values_of(store, store.id(2).c_str(), "pairs"));
  CHECK(read_file(base.path("d.npy.ids.csv")) ==
        "position,row,id,label\n0,0,ball/a.off,ball\n1,2," + store.id(2) + ",ball\n");
}
