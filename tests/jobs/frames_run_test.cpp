// In which coordinates points are stored (run --normalize) and handed out (export --frame).
#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "io/mesh/point_reader.h"
#include "io/store/store_reader.h"
#include "io/store/store_verify.h"
#include "kernels/sample/point_frames.h"
#include "support/catch.h"
#include "support/meander_program.h"
#include "support/mesh_files.h"
#include "support/sanitized.h"
#include "support/store_rows.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;
using Catch::Matchers::ContainsSubstring;

namespace {

namespace fs = std::filesystem;

const std::vector<std::string> normalizations = {"none", "unit-sphere", "unit-box", "unit-diagonal",
                                                 "pointnet"};

ProcessResult run_normalized(const fs::path& input, const fs::path& store, const std::string& word,
                             const std::vector<std::string>& more = {"-n", "500"}) {
  std::vector<std::string> arguments = {"run",        input.string(), "-o",          store.string(),
                                        "--progress", "none",         "--normalize", word};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return meander_with(arguments);
}

// Models whose samples have their mean far from the center of the box.
void put_models(const fs::path& folder) {
  fs::create_directories(folder / "a");
  fs::create_directories(folder / "b");
  const PolygonMesh lopsided = merged(icosphere(2), moved(cube(), 0.2, 3, 0, 0));
  write_mesh(folder / "a/lopsided.off", moved(lopsided, 7, 100, -50, 20));
  write_mesh(folder / "b/torus.ply", moved(torus(24, 12), 1e-3, 0.5, 0.25, 0));
}

double length_of(const std::array<double, 3>& v) { return std::hypot(v[0], v[1], v[2]); }

struct Spread {
  std::array<double, 3> mean{};
  double farthest = 0;
};
Spread spread_of(const Samples& samples) {
  Spread spread;
  for (std::size_t i = 0; i < samples.count(); ++i) {
    std::array<double, 3> point{};
    for (std::size_t k = 0; k < 3; ++k) {
      point[k] = samples.points[3 * i + k];
      spread.mean[k] += point[k] / static_cast<double>(samples.count());
    }
    spread.farthest = std::max(spread.farthest, length_of(point));
  }
  return spread;
}

}  // namespace

TEST_CASE("run --normalize: each mode has its frame, and loc and scale lead back to the file coordinates") {
  const ScratchFolder scratch;
  put_models(scratch / "in");
  for (const std::string& word : normalizations) {
    INFO(word);
    REQUIRE(run_normalized(scratch / "in", scratch / (word + ".h5"), word).exit_code == 0);
    CHECK(verify_store(scratch / (word + ".h5")).problems.empty());
    for (const std::string& id : ids_of(scratch / (word + ".h5"))) {
      const Row plain = row_of(scratch / "none.h5", id), row = row_of(scratch / (word + ".h5"), id);
      const ItemReport& report = row.report;
      const std::array<double, 6>& box = report.bbox;
      const std::array<double, 3> side = {box[3] - box[0], box[4] - box[1], box[5] - box[2]};
      CHECK(row.samples.barycentric == plain.samples.barycentric);
      double far = 0;
      for (std::size_t i = 0; i < row.samples.count(); ++i)
        far = std::max(far, distance(file_point(report, row.samples.points, i),
                                     file_point(plain.report, plain.samples.points, i)));
      CHECK(far < 1e-4 * length_of(side));
      if (word == "pointnet") {
        const Spread spread = spread_of(row.samples);
        CHECK(length_of(spread.mean) < 1e-7);
        CHECK(std::abs(spread.farthest - 1) <= 0x1p-24);
        continue;
      }
      for (std::size_t k = 0; k < 3; ++k)
        CHECK(report.loc[k] == Approx(word == "none" ? 0 : 0.5 * (box[k] + box[k + 3])).epsilon(1e-14));
      if (word == "none") CHECK(report.scale == 1);
      if (word == "unit-box") CHECK(report.scale == Approx(*std::max_element(side.begin(), side.end())));
      if (word == "unit-diagonal") CHECK(report.scale == Approx(length_of(side)).epsilon(1e-14));
      if (word == "unit-sphere") {
        CHECK(report.scale > 0.5 * *std::max_element(side.begin(), side.end()));
        CHECK(report.scale <= 0.5 * length_of(side));
        CHECK(spread_of(row.samples).farthest <= 1.0000001);
      }
    }
  }
  const ProcessResult unknown = run_normalized(scratch / "in", scratch / "no.h5", "unit-cube");
  CHECK(unknown.exit_code == 2);
  CHECK_THAT(unknown.err, ContainsSubstring("unit-diagonal"));
  CHECK(
      meander_with({"remesh", scratch / "in", "-o", scratch / "out", "--normalize", "pointnet"}).exit_code ==
      2);
}

TEST_CASE("run --normalize pointnet: all samples define the frame, the same bytes for any threads and shards",
          "[release]") {
  const ScratchFolder scratch;
  put_models(scratch / "in");
  for (const std::vector<std::string>& more : {std::vector<std::string>{"-n", "2048"},
                                               {"-n", "2048", "--curved", "--order", "curve"},
                                               {"-n", "300", "--method", "anisotropic", "--describe", "d2"},
                                               {"-n", "300", "--sequence", "spaced", "--certify"}}) {
    INFO(Catch::StringMaker<std::vector<std::string>>::convert(more));
    const auto with = [&](const std::vector<std::string>& last) {
      std::vector<std::string> all = more;
      all.insert(all.end(), last.begin(), last.end());
      return all;
    };
    REQUIRE(run_normalized(scratch / "in", scratch / "one.h5", "pointnet", with({"-j", "1", "--fresh"}))
                .exit_code == 0);
    const std::string expected = read_file(scratch / "one.h5");
    REQUIRE(run_normalized(scratch / "in", scratch / "s.h5", "pointnet", with({"-j", "3", "--fresh"}))
                .exit_code == 0);
    CHECK((read_file(scratch / "s.h5") == expected));
    REQUIRE(run_normalized(scratch / "in", scratch / "s.h5", "pointnet", more).exit_code == 0);
    CHECK((read_file(scratch / "s.h5") == expected));
    // A row less, and then the rest.
    fs::rename(scratch / "in/b/torus.ply", scratch / "torus.ply");
    REQUIRE(run_normalized(scratch / "in", scratch / "s.h5", "pointnet", with({"--fresh"})).exit_code == 0);
    fs::rename(scratch / "torus.ply", scratch / "in/b/torus.ply");
    REQUIRE(run_normalized(scratch / "in", scratch / "s.h5", "pointnet", more).exit_code == 0);
    CHECK((read_file(scratch / "s.h5") == expected));
    std::vector<std::string> plan = {"plan", scratch / "in", "-o",      scratch / "m.h5", "--shards",
                                     "2",    "--normalize",  "pointnet"};
    plan.insert(plan.end(), more.begin(), more.end());
    REQUIRE(meander_with(plan).exit_code == 0);
    for (const char* shard : {"0/2", "1/2"})
      REQUIRE(meander_with({"run", scratch / "m.h5.run", "--shard", shard, "--progress", "none"}).exit_code ==
              0);
    REQUIRE(meander_with({"merge", scratch / "m.h5.run"}).exit_code == 0);
    CHECK((read_file(scratch / "m.h5") == expected));
    fs::remove(scratch / "m.h5");
    // The whole row defines the frame: a prefix has a mean of its own.
    for (const std::string& id : ids_of(scratch / "one.h5")) {
      Row row = row_of(scratch / "one.h5", id);
      CHECK(length_of(spread_of(row.samples).mean) < 1e-7);
      CHECK(std::abs(spread_of(row.samples).farthest - 1) <= 0x1p-24);
      row.samples.points.resize(3 * 50);
      CHECK(length_of(spread_of(row.samples).mean) > 1e-5);
    }
    // Another word is another store.
    const ProcessResult other = run_normalized(scratch / "in", scratch / "s.h5", "unit-sphere", more);
    CHECK(other.exit_code == 2);
    CHECK_THAT(other.err, ContainsSubstring("normalize"));
  }
}

TEST_CASE("run --normalize pointnet: a large set in blocks equals one in memory, for any threads") {
  const ScratchFolder scratch;
  fs::create_directories(scratch / "in");
  write_mesh(scratch / "in/a.off", moved(merged(icosphere(2), moved(cube(), 0.2, 3, 0, 0)), 7, 100, -50, 20));
  const std::vector<std::string> large = {"-n", std::to_string((1 << 18) + 1)};
  const auto with = [&](const std::vector<std::string>& more) {
    std::vector<std::string> all = large;
    all.insert(all.end(), more.begin(), more.end());
    return all;
  };
  REQUIRE(run_normalized(scratch / "in", scratch / "one.h5", "pointnet", with({"-j", "1"})).exit_code == 0);
  const Row row = StoreReader(scratch / "one.h5").read_row(0);
  CHECK(length_of(spread_of(row.samples).mean) < 1e-7);
  CHECK(std::abs(spread_of(row.samples).farthest - 1) <= 0x1p-24);
  if (sanitized) return;  // for the time that whole sets take; release builds go on
  REQUIRE(run_normalized(scratch / "in", scratch / "s.h5", "pointnet", with({"-j", "3"})).exit_code == 0);
  CHECK((read_file(scratch / "s.h5") == read_file(scratch / "one.h5")));
  REQUIRE(run_normalized(scratch / "in", scratch / "d.h5", "pointnet", with({"--describe", "basics"}))
              .exit_code == 0);
  const Row whole = StoreReader(scratch / "d.h5").read_row(0);
  CHECK((whole.samples.points == row.samples.points));
  CHECK(whole.report.loc == row.report.loc);
  CHECK(whole.report.scale == row.report.scale);
}

TEST_CASE("export --frame: PLY, OFF and XYZ are written in either frame, and say which") {
  const ScratchFolder scratch;
  put_models(scratch / "in");
  const fs::path store = scratch / "s.h5";
  REQUIRE(run_normalized(scratch / "in", store, "pointnet").exit_code == 0);
  for (const std::string format : {"ply", "off", "xyz"})
    for (const std::string frame : {"", "file", "stored"}) {
      INFO(format << " " << frame);
      const fs::path out = scratch / (format + frame);
      std::vector<std::string> command = {"export", store, "-o", out, "--format", format};
      if (!frame.empty()) command.insert(command.end(), {"--frame", frame});
      REQUIRE(meander_with(command).exit_code == 0);
      for (const std::string& id : ids_of(store)) {
        const Row row = row_of(store, id);
        const fs::path path = out / (id + "." + format);
        const std::string content = read_file(path);
        const std::string words = frame == "stored" ? "frame stored loc " : "frame file\n";
        CHECK_THAT(content, ContainsSubstring((format == "ply" ? "\ncomment " : "\n# ") + words));
        const PointCloud cloud = read_points(path);
        REQUIRE(cloud.count() == row.samples.count());
        bool equal = true;
        for (std::size_t i = 0; i < cloud.count(); ++i) {
          const Vector3 at = file_point(row.report, row.samples.points, i);
          const float* const stored = &row.samples.points[3 * i];
          equal =
              equal && (frame == "stored" ? static_cast<float>(cloud.x[i]) == stored[0] &&
                                                static_cast<float>(cloud.y[i]) == stored[1] &&
                                                static_cast<float>(cloud.z[i]) == stored[2]
                                          : cloud.x[i] == at.x && cloud.y[i] == at.y && cloud.z[i] == at.z);
        }
        CHECK(equal);
      }
      // Our own files may be replaced.
      command.emplace_back("--fresh");
      CHECK(meander_with(command).exit_code == 0);
    }
  // The default is the frame of the file.
  for (const std::string format : {"ply", "off", "xyz"})
    for (const std::string& id : ids_of(store))
      CHECK((read_file(scratch / format / (id + "." + format)) ==
             read_file(scratch / (format + "file") / (id + "." + format))));
}

TEST_CASE("export --frame: arrays say their frame, and formats without one refuse the option") {
  const ScratchFolder scratch;
  put_models(scratch / "in");
  const fs::path store = scratch / "s.h5";
  REQUIRE(run_normalized(scratch / "in", store, "unit-box",
                         {"-n", "64", "--label-from-folder", "--describe", "d2"})
              .exit_code == 0);
  for (const std::string frame : {"", "stored", "file"}) {
    INFO(frame);
    const std::string type = frame == "file" ? "'<f8'" : "'<f4'", said = frame.empty() ? "stored" : frame;
    std::vector<std::string> more;
    if (!frame.empty()) more = {"--frame", frame};
    const auto does = [&](std::vector<std::string> command) {
      command.insert(command.end(), more.begin(), more.end());
      const ProcessResult result = meander_with(command);
      INFO(result.err);
      REQUIRE(result.exit_code == 0);
    };
    does({"export", store, "-o", scratch / ("npz" + frame), "--format", "npz", "--arrays", "points"});
    std::string words;  // UTF-32
    for (const char c : said) words += std::string{c, 0, 0, 0};
    const std::string npz = read_file(scratch / ("npz" + frame) / "b/torus.ply.npz");
    CHECK_THAT(
        npz, ContainsSubstring("frame.npy") && ContainsSubstring("'<U" + std::to_string(said.size()) + "'") &&
                 ContainsSubstring(words) && ContainsSubstring("loc.npy") && ContainsSubstring("scale.npy") &&
                 ContainsSubstring("{'descr': " + type + ", 'fortran_order': False, 'shape': (64, 3)"));
    does({"export", store, "-o", scratch / ("wds" + frame), "--format", "webdataset"});
    CHECK_THAT(read_file(scratch / ("wds" + frame) / "s-000000.tar"),
               ContainsSubstring("\"frame\":\"" + said + "\",\"loc\":[") &&
                   ContainsSubstring("{'descr': " + type + ", 'fortran_order': False, 'shape': (64, 3)"));
    does({"export", store, "-o", scratch / ("pn" + frame), "--pointnet"});
    CHECK(fs::exists(scratch / ("pn" + frame) / "ply_data_train0.h5"));
  }
  for (const std::string kind : {"npz", "wds", "pn"}) {
    auto with = content_of(scratch / (kind + "stored")), without = content_of(scratch / kind);
    REQUIRE(with.size() == without.size());
    for (auto a = with.begin(), b = without.begin(); a != with.end(); ++a, ++b)
      if (!a->first.ends_with("_files.txt")) CHECK((a->second == b->second));  // these name the folder
  }
  const auto refused = [&](const std::vector<std::string>& command, const std::string& words) {
    const ProcessResult result = meander_with(command);
    CHECK(result.exit_code == 2);
    CHECK_THAT(result.err, ContainsSubstring(words));
  };
  refused({"export", store, "--html", scratch / "page.html", "--frame", "file"}, "--frame applies to points");
  refused({"export", store, "--descriptors", "d2", "--format", "csv", "-o", scratch / "d.csv", "--frame",
           "stored"},
          "--frame applies to points");
  refused({"export", store, "-o", scratch / "x", "--frame", "world"}, "--frame");
  // Another frame is another export: one that was begun does not go on in it.
  ProcessOptions short_of_room;
  short_of_room.in_child = [] {
    const rlimit limit{1000, 1000};
    setrlimit(RLIMIT_FSIZE, &limit);
  };
  const std::vector<std::string> begun = {"export", store, "-o", scratch / "begun"};
  REQUIRE(meander_with(begun, short_of_room).exit_code == 75);
  refused({"export", store, "-o", scratch / "begun", "--frame", "stored"}, "parameter \"frame\"");
  CHECK(meander_with({"export", store, "-o", scratch / "begun", "--frame", "file"}).exit_code == 0);
}
