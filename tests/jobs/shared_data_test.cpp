// The main job over the shared meshes: statuses, exact counts, points on their polygons, exact masses,
// memory.
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>

#include "dirty_statuses.h"
#include "io/mesh/mesh_reader.h"
#include "io/store/store_reader.h"
#include "io/store/store_verify.h"
#include "kernels/model/model.h"
#include "support/catch.h"
#include "support/meander_program.h"
#include "support/mesh_files.h"
#include "support/run_process.h"
#include "support/sanitized.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

// A run over shared files; returns its store.
std::filesystem::path run_over(const ScratchFolder& scratch, const std::string& folder, std::uint32_t samples,
                               std::vector<std::string> more = {}) {
  const auto store = scratch / ("n" + std::to_string(samples) + ".h5");
  std::vector<std::string> arguments = {program,
                                        "run",
                                        shared_data(folder).string(),
                                        "-o",
                                        store.string(),
                                        "-n",
                                        std::to_string(samples),
                                        "--compress",
                                        "none",
                                        "--timeout",
                                        "0"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  const ProcessResult result = run_process(arguments);
  INFO(result.err);
  REQUIRE((result.exit_code == 0 || result.exit_code == 3));
  return store;
}

PolygonMesh read_shared(const std::filesystem::path& path) {
  MeshFormat format{};
  REQUIRE(mesh_format_of(path, format));
  const FileBytes file(path);
  return read_mesh(file.bytes(), format);
}

// Exactly n distinct points, each a combination of corners of its polygon, re-created from corners and
// weights.
void check_points(const std::filesystem::path& store_path, const std::filesystem::path& root) {
  const StoreReader store(store_path);
  for (std::uint64_t row = 0; row < store.rows(); ++row) {
    if (store.report(row).status != Status::ok) continue;
    const Row content = store.read_row(row);
    const ItemReport& report = content.report;
    const Samples& s = content.samples;
    INFO(store.id(row));
    const PolygonMesh mesh = read_shared(root / store.id(row));
    const double diagonal = std::hypot(report.bbox[3] - report.bbox[0], report.bbox[4] - report.bbox[1],
                                       report.bbox[5] - report.bbox[2]);
    std::set<std::array<float, 3>> distinct;
    std::size_t off_polygon = 0, foreign_corners = 0, outside = 0;
    for (std::size_t i = 0; i < s.count(); ++i) {
      distinct.insert({s.points[3 * i], s.points[3 * i + 1], s.points[3 * i + 2]});
      const double b1 = s.barycentric[2 * i], b2 = s.barycentric[2 * i + 1], b0 = 1 - b1 - b2;
      outside += !(b0 >= -1e-6 && b1 >= 0 && b2 >= 0);
      const auto first = mesh.corners.begin() + mesh.polygon_begin[s.face[i]],
                 last = mesh.corners.begin() + mesh.polygon_begin[s.face[i] + 1];
      for (std::size_t k = 0; k < 3; ++k)
        foreign_corners += std::find(first, last, s.corners[3 * i + k]) == last;
      double distance = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::vector<double>& c = axis == 0 ? mesh.x : axis == 1 ? mesh.y : mesh.z;
        const double wanted =
            b0 * c[s.corners[3 * i]] + b1 * c[s.corners[3 * i + 1]] + b2 * c[s.corners[3 * i + 2]];
        distance = std::hypot(distance, report.loc[axis] + report.scale * s.points[3 * i + axis] - wanted);
      }
      off_polygon += !(distance <= 1e-5 * diagonal);
    }
    CHECK(distinct.size() == store.samples());
    CHECK(off_polygon == 0);
    CHECK(foreign_corners == 0);
    CHECK(outside == 0);
  }
}

std::vector<std::filesystem::path> good_models() {
  std::vector<std::filesystem::path> models;
  for (const char* folder : {"paper", "retrieval"})
    for (const auto& entry : std::filesystem::recursive_directory_iterator(shared_data(folder)))
      if (entry.is_regular_file()) models.push_back(entry.path());
  std::sort(models.begin(), models.end());
  return models;
}

// Areas of the file's triangles in long double against the masses of the curve's elements.
void check_masses(const std::filesystem::path& path, std::string_view method) {
  INFO(path.filename() << ", " << method);
  SampleParameters parameters = parameters_for(method);
  parameters.samples = 2048;
  parameters.sequence = SequenceKind::stratified;  // cells of nets may be points, without elements
  const EmbreeDevice device;
  Model model;
  model.file = read_shared(path);
  const PolygonMesh file = model.file;
  model.key = make_random_key(1, {});
  for (const ModelStage& stage : stages_of(parameters, &device)) {
    if (stage.name == "place_samples") break;
    stage.run(model);
  }
  const std::size_t triangles = model.surface.triangle_count();
  std::vector<double> mass(triangles, 0.0);
  double sum = 0;
  if (const auto* const elements = std::get_if<CurveElements>(&model.order)) {
    sum = elements->total();
    for (std::size_t i = 0; i < elements->count(); ++i)
      mass[elements->triangle[i]] += elements->cumulative[i + 1] - elements->cumulative[i];
  } else {
    const auto& cells = std::get<ElementCells>(model.order);
    for (const Cell& cell : cells.cells.cell)
      for (const CellEntry& entry : cells.cells.entries(cell)) {
        mass[cells.triangle[entry.element()]] += cells.cells.mass(entry);
        sum += cells.cells.mass(entry);
      }
  }
  const long double unit = static_cast<long double>(model.surface.unit) * model.surface.unit;
  long double total = 0, worst = 0;
  for (std::size_t t = 0; t < triangles; ++t) {
    long double p[3][3];
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t v = file.corners[model.surface.corner_slot[3 * t + k]];
      p[k][0] = file.x[v];
      p[k][1] = file.y[v];
      p[k][2] = file.z[v];
    }
    long double a[3], b[3];
    for (int axis = 0; axis < 3; ++axis) {
      a[axis] = p[1][axis] - p[0][axis];
      b[axis] = p[2][axis] - p[0][axis];
    }
    const long double cx = a[1] * b[2] - a[2] * b[1], cy = a[2] * b[0] - a[0] * b[2],
                      cz = a[0] * b[1] - a[1] * b[0];
    const long double area = 0.5L * std::sqrt(cx * cx + cy * cy + cz * cz);
    total += area;
    if (area > 0) worst = std::max(worst, std::abs(mass[t] * unit - area) / area);
  }
  CHECK(static_cast<double>(std::abs(sum * unit - total) / total) <= 1e-6);
  CHECK(static_cast<double>(worst) <= 1e-6);
}

}  // namespace

TEST_CASE("shared data: every file of dirty/ has its expected status") {
  MEANDER_NEEDS_SHARED_DATA();
  const ScratchFolder scratch;
  const auto store = run_over(scratch, "dirty", 64);
  const StoreReader reader(store);
  REQUIRE(reader.rows() == dirty_statuses.size());
  int usable = 0;
  for (const DirtyStatus& expected : dirty_statuses) {
    INFO(expected.file << ": " << expected.why);
    const auto row = reader.find(expected.file);
    REQUIRE(row);
    INFO(reader.report(*row).reason);
    CHECK(reader.report(*row).status == expected.status);
    usable += reader.report(*row).status == Status::ok;
  }
  CHECK(usable >= 70);
  CHECK(verify_store(store).problems.empty());
}

TEST_CASE("shared data: a row for each of the 212 files, paper/ and retrieval/ ok, auto") {
  MEANDER_NEEDS_SHARED_DATA();
  const ScratchFolder scratch;
  const StoreReader reader(run_over(scratch, "", 16));
  REQUIRE(reader.rows() == 212);
  for (std::uint64_t row = 0; row < reader.rows(); ++row) {
    if (reader.id(row).starts_with("dirty/")) continue;
    const ItemReport report = reader.report(row);
    INFO(reader.id(row) << ": " << report.reason);
    CHECK(report.status == Status::ok);
    CHECK(report.method == Method::balanced);
  }
}

TEST_CASE("shared data: a row for each of the 212 files, paper/ and retrieval/ ok, 95 % conformal") {
  MEANDER_NEEDS_SHARED_DATA();
  const ScratchFolder scratch;
  const auto store = run_over(scratch, "", 16, {"--method", "conformal"});
  const StoreReader reader(store);
  REQUIRE(reader.rows() == 212);
  int good = 0, conformal = 0;
  for (std::uint64_t row = 0; row < reader.rows(); ++row) {
    if (reader.id(row).starts_with("dirty/")) continue;
    const ItemReport report = reader.report(row);
    INFO(reader.id(row) << ": " << report.reason);
    CHECK(report.status == Status::ok);
    ++good;
    conformal += report.method == Method::conformal && report.flips == 0;
  }
  CHECK(good == 131);
  CHECK(conformal >= 125);
  for (const char* id :
       {"paper/bunny_closed.off", "paper/maxplanck_25k.off", "paper/fandisk.off", "paper/igea_full.ply"}) {
    const ItemReport report = reader.report(*reader.find(id));
    INFO(id);
    CHECK(report.method == Method::conformal);
    CHECK(report.flips == 0);
    CHECK(report.distortion <= 1.2);  // of coarse charts, which get no more seams below 1.3
  }
}

TEST_CASE("shared data: exactly n distinct points on their polygons, for small and large n, over dirty/") {
  MEANDER_NEEDS_SHARED_DATA();
  const ScratchFolder scratch;
  for (const std::uint32_t samples : thinned<std::uint32_t>(2, {1, 256, 7}))
    for (const char* method : {"auto", "conformal"})
      check_points(run_over(scratch, "dirty", samples, {"--method", method, "--fresh"}),
                   shared_data("dirty"));
}

TEST_CASE("shared data: exactly n distinct points on their polygons, every n, over all files", "[slow]") {
  MEANDER_NEEDS_SHARED_DATA();
  const ScratchFolder scratch;
  for (const std::uint32_t samples : {1u, 7u, 256u, 2048u, 100000u})
    for (const char* method : {"auto", "conformal"})
      check_points(run_over(scratch, "", samples, {"--method", method, "--fresh"}), shared_data(""));
}

TEST_CASE("shared data: masses equal areas in long double, twelve models") {
  MEANDER_NEEDS_SHARED_DATA();
  const auto models = good_models();
  for (std::size_t i = 10; i < models.size(); i += 10)
    check_masses(models[i], i % 20 == 10 ? "auto" : "conformal");
}

TEST_CASE("shared data: masses equal areas in long double, all of paper/ and retrieval/", "[slow]") {
  MEANDER_NEEDS_SHARED_DATA();
  for (const auto& model : good_models())
    for (const std::string_view method : {"auto", "conformal"}) check_masses(model, method);
}

TEST_CASE("shared data: the same bytes for 1 and 2 threads, half the memory, other lists", "[slow]") {
  MEANDER_NEEDS_SHARED_DATA();
  const ScratchFolder one, two;
  const std::string first = read_file(run_over(one, "", 2048, {"-j", "1"}));
  CHECK(read_file(run_over(two, "", 2048, {"-j", "2", "--memory", "2G"})) == first);
}

TEST_CASE("shared data: memory stays within the budget and 128 MiB", "[slow]") {
  MEANDER_NEEDS_SHARED_DATA();
  const ScratchFolder scratch;
  for (const long budget : {512L, 256L}) {
    const ProcessResult result =
        run_process({program, "run", shared_data("").string(), "-o", (scratch / "m.h5").string(), "-n",
                     "2048", "-j", "2", "--fresh", "--memory", std::to_string(budget) + "M"});
    INFO(budget << " MiB: peak " << result.peak_kilobytes / 1024 << " MiB");
    REQUIRE(result.exit_code == 3);
    CHECK(result.peak_kilobytes <= (budget + 128) * 1024);
    const StoreReader reader(scratch / "m.h5");
    for (std::uint64_t row = 0; row < reader.rows(); ++row)
      CHECK(reader.report(row).status != Status::too_large);
  }
}
