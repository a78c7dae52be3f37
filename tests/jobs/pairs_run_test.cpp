// Descriptors of oriented pairs: run, describe, retrieve.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <initializer_list>

#include "io/store/store_reader.h"
#include "io/store/store_verify.h"
#include "support/catch.h"
#include "support/meander_program.h"
#include "support/mesh_files.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

namespace fs = std::filesystem;

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

TEST_CASE("run --describe pairs: square roots of shares, unoriented models, the same bytes for any threads") {
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
  // Not 0: the polygons have their corners in another order, and so the samples lie elsewhere. Two sets of
  // 300 samples of this ring differ by 0.3 to 0.75.
  CHECK(l1(ring, values_of(turned, "ring/b.off", "pairs")) < 1);
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

TEST_CASE("pairs: invalid uses are refused by describe and run") {
  const Base base;
  base.sample("in", "s.h5", {});
  const ProcessResult meshes = meander_with({"describe", base.path("s.h5"), "--descriptors", "pairs"});
  CHECK(meshes.exit_code == 2);
  CHECK(meshes.err.find("geodesic, basics, pairs, views and shapedna need the meshes") != std::string::npos);
  const ProcessResult bins =
      meander_with({"describe", base.path("s.h5"), "--descriptors", "pairs-unsigned", "--bins", "64"});
  CHECK(bins.exit_code == 2);
  CHECK(bins.err.find("--bins applies to d2, a3, d1, d3, d4 and geodesic only") != std::string::npos);
  CHECK(meander_with({"describe", base.path("s.h5"), "--descriptors", "pairs-unsigned"}).exit_code == 0);
}

TEST_CASE("export of descriptors: a NumPy array, and the list of its rows") {
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

TEST_CASE("retrieve and export: zeros of a described row are values") {
  const Base base;
  base.sample("in", "s.h5", {"--describe", "pairs"});
  const std::string store = base.path("s.h5"), both = "pairs+pairs_unoriented";
  // 12 of the 14 models are closed: their share is 0.
  const ProcessResult evaluated =
      meander_with({"retrieve", "evaluate", store, "--descriptor", both, "--json"});
  INFO(evaluated.err);
  REQUIRE(evaluated.exit_code == 0);
  CHECK(contains(evaluated.out, R"("models":14,)"));
  CHECK(contains(evaluated.out, R"("not_finite":0)"));
  const ProcessResult query =
      meander_with({"retrieve", "query", store, "ball/a.off", "--mesh", base.path("in/ring/a.off"),
                    "--descriptor", both, "-k", "20", "--csv", base.path("q.csv")});
  INFO(query.err);
  REQUIRE(query.exit_code == 0);
  const std::string found = read_file(base.path("q.csv"));
  CHECK(std::count(found.begin(), found.end(), '\n') == 1 + 13 + 14);
  REQUIRE(meander_with({"export", store, "--descriptors", both, "--format", "csv", "-o", base.path("d.csv")})
              .exit_code == 0);
  const std::string rows = read_file(base.path("d.csv"));
  CHECK(std::count(rows.begin(), rows.end(), '\n') == 1 + 14);

  // No two samples are connected: a geodesic histogram without a pair.
  fs::create_directories(base.path("dust"));
  PolygonMesh dust = moved(grid_plane(1, 1), 1, 0, 0, 0);
  for (int i = 1; i < 40; ++i) dust = merged(dust, moved(grid_plane(1, 1), 1, 3 * i, i % 3, 0));
  write_mesh(base.path("dust/dust.off"), dust);
  write_mesh(base.path("dust/ball.off"), icosphere(2));
  REQUIRE(meander_with({"run", base.path("dust"), "-o", base.path("dust.h5"), "-n", "16", "--describe",
                        "geodesic", "--progress", "none"})
              .exit_code == 0);
  const StoreReader dusty(base.path("dust.h5"));
  CHECK(values_of(dusty, "dust.off", "geodesic") == std::vector<float>(32, 0.0f));
  CHECK(values_of(dusty, "dust.off", "geodesic_disconnected") == std::vector<float>{1});
  const ProcessResult near =
      meander_with({"retrieve", "query", base.path("dust.h5"), "ball.off", "--descriptor", "geodesic"});
  INFO(near.err);
  CHECK(near.exit_code == 0);
  CHECK(contains(near.out, "dust.off"));
}

TEST_CASE("retrieve: emd is refused for bins that are not in line, and select omits it there") {
  const Base base;
  base.sample("in", "s.h5", {"--describe", "d2,pairs,pairs-unsigned"});
  const std::string store = base.path("s.h5");
  for (const char* descriptor : {"pairs-unsigned", "d2+pairs"}) {
    const ProcessResult refused =
        meander_with({"retrieve", "evaluate", store, "--descriptor", descriptor, "--distance", "emd"});
    CHECK(refused.exit_code == 2);
    CHECK(contains(refused.err, "are not bins along one line, and emd measures along a line of bins"));
  }
  CHECK(meander_with({"retrieve", "evaluate", store, "--descriptor", "d2", "--distance", "emd"}).exit_code ==
        0);
  const ProcessResult selected =
      meander_with({"retrieve", "select", store, "--csv", base.path("all.csv"), "--weights", "given"});
  INFO(selected.err);
  REQUIRE(selected.exit_code == 0);
  // Seven combinations under four distances, and d2 under emd.
  CHECK(contains(selected.out, "29 settings (6 more skipped: their distance does not fit)"));
  CHECK_FALSE(contains(read_file(base.path("all.csv")), "pairs,emd"));
  CHECK(contains(read_file(base.path("all.csv")), "d2,emd"));
  const ProcessResult nothing =
      meander_with({"retrieve", "select", store, "--descriptors", "pairs,d2+pairs", "--distances", "emd"});
  CHECK(nothing.exit_code == 2);
  CHECK(contains(nothing.err, "emd measures along a line of bins"));
}

TEST_CASE("retrieve: combinations with weights are scored") {
  const Base base;
  base.sample("in", "s.h5", {"--describe", "d2,pairs,basics", "--bins", "16"});
  const std::string store = base.path("s.h5");
  const auto scores = [&](const char* descriptor) {
    const ProcessResult result = meander_with(
        {"retrieve", "evaluate", store, "--descriptor", descriptor, "--matrix", base.path("m.bin")});
    INFO(result.err);
    REQUIRE(result.exit_code == 0);
    const std::string bytes = read_file(base.path("m.bin"));
    std::vector<float> distances(bytes.size() / sizeof(float));
    std::memcpy(distances.data(), bytes.data(), bytes.size());
    return distances;
  };
  const std::vector<float> even = scores("pairs+d2"), twice = scores("pairs=2+d2=2"),
                           first = scores("pairs=1000000+d2"), alone = scores("pairs");
  REQUIRE(even.size() == 14 * 14);
  // One distance is the other times a constant.
  const float factor = first[1] / alone[1];
  for (std::size_t i = 0; i < even.size(); ++i) {
    CHECK(twice[i] == Approx(2 * even[i]).epsilon(1e-5));
    CHECK(first[i] == Approx(factor * alone[i]).epsilon(1e-4).margin(1e-3 * factor));
  }

  // l1 between exported vectors is the combined distance.
  REQUIRE(meander_with(
              {"export", store, "--descriptors", "pairs=2+d2", "--format", "npy", "-o", base.path("d.npy")})
              .exit_code == 0);
  const std::string array = read_file(base.path("d.npy"));
  constexpr std::size_t width = 512 + 16;
  std::vector<float> values(14 * width);
  REQUIRE(array.size() == 128 + sizeof(float) * values.size());
  std::memcpy(values.data(), array.data() + 128, sizeof(float) * values.size());
  const std::vector<float> weighted = scores("pairs=2+d2");
  for (std::size_t i = 0; i < 14; ++i)
    for (std::size_t j = 0; j < i; ++j) {
      double sum = 0;
      for (std::size_t b = 0; b < width; ++b)
        sum += std::abs(double{values[i * width + b]} - double{values[j * width + b]});
      CHECK(sum == Approx(weighted[14 * i + j]).epsilon(1e-4));
    }

  const auto refusal = [&](std::vector<std::string> arguments) {
    const ProcessResult refused = meander_with(std::move(arguments));
    CHECK(refused.exit_code == 2);
    return refused.err;
  };
  for (const char* wrong : {"pairs=0+d2", "pairs=x+d2", "pairs=inf+d2"})
    CHECK(contains(refusal({"retrieve", "evaluate", store, "--descriptor", wrong}),
                   "a weight is a positive number"));
  CHECK(contains(refusal({"retrieve", "evaluate", store, "--descriptor", "pairs=2"}),
                 "a weight is relative to other descriptors"));
  CHECK(contains(refusal({"export", store, "--descriptors", "pairs=2+d2", "--format", "ann-hdf5", "-o",
                          base.path("d.hdf5")}),
                 "ann-hdf5 is for l2 or cosine"));
  CHECK(contains(refusal({"export", store, "--descriptors", "pairs=2+basics", "--format", "npy", "-o",
                          base.path("e.npy")}),
                 "no weights"));

  const ProcessResult selected = meander_with({"retrieve", "select", store, "--json"});
  INFO(selected.err);
  REQUIRE(selected.exit_code == 0);
  CHECK(contains(selected.out, R"("leaving_one_class_out_learnt":[)"));
  const std::size_t at = selected.out.find(R"("recommended":{"descriptor":")");
  REQUIRE(at != std::string::npos);
  const std::size_t begin = at + 29, end = selected.out.find('"', begin);
  CHECK(
      meander_with({"retrieve", "query", store, "0", "--descriptor", selected.out.substr(begin, end - begin)})
          .exit_code == 0);
}

TEST_CASE("retrieve: --memory is a bound, and larger work is refused") {
  const Base base;
  base.sample("in", "s.h5", {"--describe", "d2,pairs"});
  const std::string store = base.path("s.h5");
  const ProcessResult evaluate = meander_with({"retrieve", "evaluate", store, "--memory", "20M"});
  CHECK(evaluate.exit_code == 2);
  CHECK(contains(evaluate.err, "--memory: a comparison of 14 models needs about "));
  const ProcessResult ranked = meander_with({"retrieve", "query", store, "0", "--memory", "20M"});
  CHECK(ranked.exit_code == 2);
  CHECK(contains(ranked.err, "--memory: a comparison of 14 models needs about "));
  const ProcessResult query =
      meander_with({"retrieve", "query", store, "0", "--rank", "plain", "--memory", "20M"});
  CHECK(query.exit_code == 2);
  CHECK(contains(query.err, "--memory: a search of 14 rows needs about "));
  const auto found = [&](const char* memory) {
    const ProcessResult result = meander_with(
        {"retrieve", "query", store, "0", "3", "--descriptor", "d2+pairs", "--memory", memory, "--json"});
    INFO(result.err);
    REQUIRE(result.exit_code == 0);
    return result.out;
  };
  CHECK(found("90M") == found("4G"));
}

TEST_CASE("growing store: new models, new descriptors and both give the bytes of a run from scratch") {
  const Base base;
  const auto add = [&](const char* folder, std::initializer_list<const char*> models) {
    for (const char* model : models) {
      const fs::path to = fs::path(base.path(folder)) / model;
      fs::create_directories(to.parent_path());
      fs::copy_file(fs::path(base.path("in")) / model, to);
    }
  };
  add("every", {"ball/a.off", "ball/c.off", "both/a.off", "ring/a.off"});
  add("some", {"ball/c.off", "both/a.off"});
  base.sample("every", "all.h5", {"--describe", "d2,pairs", "--bins", "16"});
  const std::string whole = read_file(base.path("all.h5"));

  // New models, then a new descriptor for all.
  base.sample("some", "a.h5", {"--describe", "d2", "--bins", "16"});
  base.sample("some", "b.h5", {"--describe", "d2", "--bins", "16"});
  base.sample("some", "c.h5", {"--describe", "d2", "--bins", "16"});
  add("some", {"ball/a.off", "ring/a.off"});
  base.sample("some", "a.h5", {"--describe", "d2", "--bins", "16"});
  const auto describe = [&](const char* store, const char* descriptors) {
    const ProcessResult result =
        meander_with({"describe", base.path(store), base.path("some"), "--descriptors", descriptors});
    INFO(result.err);
    REQUIRE(result.exit_code == 0);
  };
  describe("a.h5", "pairs");
  CHECK((read_file(base.path("a.h5")) == whole));

  // A new descriptor first, then the new models with all descriptors.
  describe("b.h5", "pairs");
  base.sample("some", "b.h5", {"--describe", "d2,pairs", "--bins", "16"});
  CHECK((read_file(base.path("b.h5")) == whole));

  // Both at once is no second run of the store: it says which parameter differs, and changes nothing.
  const std::string before = read_file(base.path("c.h5"));
  const ProcessResult both =
      meander_with({"run", base.path("some"), "-o", base.path("c.h5"), "-n", "300", "--label-from-folder",
                    "--describe", "d2,pairs", "--bins", "16", "--progress", "none"});
  CHECK(both.exit_code == 2);
  CHECK(contains(both.err, "describe"));
  CHECK((read_file(base.path("c.h5")) == before));
  // --reuse takes rows of the described store.
  describe("c.h5", "pairs");
  base.sample("some", "d.h5", {"--describe", "d2,pairs", "--bins", "16", "--reuse", base.path("c.h5")});
  CHECK((read_file(base.path("d.h5")) == whole));

  const ProcessResult info = meander_with({"info", base.path("a.h5")});
  CHECK(contains(info.out, "descriptor pairs (512 values), version 1, made by meander "));
  CHECK(contains(info.out, "descriptor pairs_unoriented (1 value), version 1"));
  CHECK(contains(meander_with({"info", base.path("a.h5"), "--json"}).out,
                 R"("descriptors":[{"name":"d2","values":16,"version":1,"made_by":")"));
}

TEST_CASE("retrieve select: combinations of up to five of eleven histograms are tried", "[release]") {
  const Base base;
  base.sample("in", "s.h5",
              {"--describe", "d2,a3,d1,d3,d4,geodesic,pairs,pairs-unsigned,harmonics,views,shapedna"});
  const std::string store = base.path("s.h5");
  const ProcessResult tried =
      meander_with({"retrieve", "select", store, "--distances", "l1", "--weights", "given"});
  INFO(tried.err);
  REQUIRE(tried.exit_code == 0);
  CHECK(contains(tried.out, "1023 settings"));
  const ProcessResult refused = meander_with({"retrieve", "select", store, "--most", "6"});
  CHECK(refused.exit_code == 2);
  CHECK(contains(refused.err, "give a smaller --most"));
}
