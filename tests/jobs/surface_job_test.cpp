#include <sched.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <functional>

#include "io/mesh/point_reader.h"
#include "io/plot/png_writer.h"
#include "io/store/store_reader.h"
#include "io/store/store_verify.h"
#include "kernels/surface/surface.h"
#include "support/catch.h"
#include "support/meander_program.h"
#include "support/mesh_files.h"
#include "support/run_process.h"
#include "support/sanitized.h"

using namespace meander;
using namespace meander::test;

namespace {

ProcessResult surface(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {program, "surface"});
  return run_process(arguments);
}

// A flat bilinear patch over [0, 2] x [0, 1].
constexpr const char* patch_text =
    "degree 1 1\nknots_u 0 0 1 1\nknots_v 0 0 1 1\npoint 0 0 0\npoint 0 1 0\npoint 2 0 0\npoint 2 1 0\n";

}  // namespace

TEST_CASE("surface: points lie where uv says, the store is valid, the same command gives the same bytes") {
  const ScratchFolder scratch;
  const std::string store = scratch / "a.h5", again = scratch / "b.h5";
  const ProcessResult result = surface({"torus", "sphere", "eight", "-n", "700", "-o", store});
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  REQUIRE(surface({"eight", "sphere", "torus", "-n", "700", "-o", again}).exit_code == 0);
  CHECK(read_file(store) == read_file(again));
  CHECK(verify_store(store).problems.empty());
  const StoreReader reader(store);
  CHECK(reader.columns() == StoreColumns{.rows = RowKind::surfaces});
  REQUIRE(reader.rows() == 3);
  for (std::uint64_t row = 0; row < reader.rows(); ++row) {
    const Row content = reader.read_row(row);
    REQUIRE(content.samples.uv.size() == 1400);
    CHECK(content.samples.face.empty());
    const auto f = make_surface(reader.id(row));
    std::vector<double> u, v;
    for (std::size_t i = 0; i < 1400; i += 2) {
      u.push_back(content.samples.uv[i]);
      v.push_back(content.samples.uv[i + 1]);
    }
    std::vector<Vector3> positions(u.size());
    f->positions(u, v, positions);
    double farthest = 0;  // uv is kept in float32
    for (std::size_t i = 0; i < positions.size(); ++i)
      farthest = std::max({farthest, std::abs(positions[i].x - content.samples.points[3 * i]),
                           std::abs(positions[i].y - content.samples.points[3 * i + 1]),
                           std::abs(positions[i].z - content.samples.points[3 * i + 2])});
    CHECK(farthest < 2e-6);
  }
  CHECK(std::abs(reader.report(*reader.find("sphere")).area - 4 * M_PI) < 1e-3);
}

TEST_CASE("surface: control nets and height fields are rows, invalid ones with their status") {
  const ScratchFolder scratch;
  write_file(scratch / "flat.nurbs", patch_text);
  write_file(scratch / "broken.nurbs", "degree 1 1\nknots_u 0 0 1 1\nknots_v 0 zero 1 1\n");
  RgbImage image(8, 5);  // all white: a plane at the height of white
  write_png(scratch / "white.png", image);
  const std::string store = scratch / "s.h5";
  const ProcessResult result =
      surface({scratch / "flat.nurbs", scratch / "broken.nurbs", scratch / "white.png", "--height-scale",
               "0.5", "--height-width", "3", "-n", "64", "-o", store});
  INFO(result.out << result.err);
  REQUIRE(result.exit_code == 3);
  const StoreReader reader(store);
  REQUIRE(reader.rows() == 3);
  CHECK(reader.id(0) == "broken.nurbs");
  CHECK(reader.report(0).status == Status::unreadable);
  CHECK(reader.report(0).reason.find("line 3") != std::string::npos);
  CHECK(reader.report(1).area == Approx(2).epsilon(1e-6));
  CHECK(reader.report(2).area == Approx(3).epsilon(1e-6));
  const Row white = reader.read_row(2);
  for (std::size_t i = 0; i < 64; ++i) REQUIRE(white.samples.points[3 * i + 2] == Approx(0.5));
  CHECK(verify_store(store).problems.empty());
}

TEST_CASE("surface: many patches in one call are rows with a status, the same bytes for any parallelism") {
  const ScratchFolder scratch;
  std::vector<std::string> arguments = {"-n", "50"};
  for (int i = 0; i < 40; ++i) {
    const std::string name = scratch / ("p" + std::to_string(i) + ".nurbs");
    write_file(name, i == 17 ? "degree 1 1\n" : patch_text);
    arguments.push_back(name);
  }
  const auto sampled = [&](const std::string& store, const std::function<void()>& in_child) {
    std::vector<std::string> all = {program, "surface", "-o", scratch / store};
    all.insert(all.end(), arguments.begin(), arguments.end());
    ProcessOptions process;
    process.in_child = in_child;
    return run_process(all, process).exit_code;
  };
  REQUIRE(sampled("a.h5", {}) == 3);
  REQUIRE(sampled("b.h5", [] {
            cpu_set_t first;
            CPU_ZERO(&first);
            CPU_SET(0, &first);
            sched_setaffinity(0, sizeof first, &first);
          }) == 3);
  CHECK(read_file(scratch / "a.h5") == read_file(scratch / "b.h5"));
  const StoreReader reader(scratch / "a.h5");
  REQUIRE(reader.rows() == 40);
  for (std::uint64_t row = 0; row < 40; ++row)
    CHECK(reader.report(row).status == (reader.id(row) == "p17.nurbs" ? Status::unreadable : Status::ok));
}

TEST_CASE("surface: an expression as density moves the samples") {
  const ScratchFolder scratch;
  const std::string store = scratch / "s.h5";
  REQUIRE(surface({"plane", "-n", "4096", "--density", "x", "-o", store}).exit_code == 0);
  const Row row = StoreReader(store).read_row(0);
  double mean = 0;
  for (std::size_t i = 0; i < 4096; ++i) mean += row.samples.points[3 * i] / 4096.0;
  CHECK(mean == Approx(2.0 / 3).margin(0.005));  // integral of x^2 over integral of x
  CHECK(row.report.measure == Approx(0.5).epsilon(1e-3));
}

TEST_CASE("surface: points are exported in every format, as PLY with u and v") {
  const ScratchFolder scratch;
  const std::string store = scratch / "s.h5";
  REQUIRE(surface({"torus", "-n", "100", "-o", store}).exit_code == 0);
  for (const std::string format : {"ply", "off", "xyz"}) {
    INFO(format);
    REQUIRE(run_process({program, "export", store, "-o", scratch / "out", "--format", format}).exit_code ==
            0);
    const PointCloud cloud = read_points(scratch / ("out/torus." + format));
    REQUIRE(cloud.count() == 100);
    const Row row = StoreReader(store).read_row(0);
    for (std::size_t i = 0; i < 100; ++i) REQUIRE(cloud.x[i] == Approx(row.samples.points[3 * i]));
  }
  CHECK(read_file(scratch / "out/torus.ply").find("property float u\nproperty float v\n") !=
        std::string::npos);
}

TEST_CASE("surface: a stopped run exits with 75, and the same command resumes") {
  const ScratchFolder scratch;
  const std::vector<std::string> command = {
      program, "surface", "torus", "eight", "-n", sanitized ? "100000" : "400000", "-o", scratch / "s.h5"};
  // Earlier the process does not listen yet, later it is done.
  ProcessResult stopped;
  for (int wait = 20; wait < 5000 && stopped.exit_code != 75 && stopped.exit_code != 0; wait += wait / 2) {
    ProcessOptions soon;
    soon.signal_after = std::chrono::milliseconds(wait);
    soon.send_signal = SIGTERM;
    stopped = run_process(command, soon);
    CHECK((stopped.exit_code == 75 || stopped.exit_code == 0 || stopped.signal == SIGTERM));
  }
  if (stopped.exit_code == 75) {
    CHECK(stopped.err.find("the same command continues") != std::string::npos);
    CHECK(run_process(command).exit_code == 0);
  }
  std::vector<std::string> whole = command;
  whole.back() = scratch / "whole.h5";
  REQUIRE(run_process(whole).exit_code == 0);
  CHECK((read_file(scratch / "s.h5") == read_file(scratch / "whole.h5")));
}

TEST_CASE("surface: mistakes are usage errors that suggest what was meant") {
  const ScratchFolder scratch;
  const std::string store = scratch / "s.h5";
  const auto error_of = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"-o", store});
    const ProcessResult result = surface(arguments);
    CHECK(result.exit_code == 2);
    return result.err;
  };
  CHECK(error_of({"toru"}).find("did you mean `torus`?") != std::string::npos);
  CHECK(error_of({"plane", "--density", "sinn(x)"}).find("sin") != std::string::npos);
  CHECK(error_of({"plane", "--tolerance", "3"}).find("tolerance") != std::string::npos);
  CHECK(error_of({"plane", "plane"}).find("two surfaces have the id `plane`") != std::string::npos);
  CHECK(error_of({"plane", "--density", "maen"}).find("did you mean `mean`?") != std::string::npos);
  CHECK(error_of({"plane", "--height-scale", "2"}).find("height fields") != std::string::npos);
  CHECK(error_of({"plane", "--density-floor", "0.1"}).find("curvature") != std::string::npos);
  CHECK(error_of({"plane", "--seed", "-1"}).find("whole number") != std::string::npos);
  CHECK(error_of({"plane", "--curve", "hilbret"}).find("hilbert") != std::string::npos);
  REQUIRE(surface({"plane", "-n", "16", "-o", store}).exit_code == 0);
  CHECK(error_of({"plane", "-n", "16"}).find("--fresh") != std::string::npos);
  CHECK(surface({"plane", "-n", "16", "-o", store, "--fresh"}).exit_code == 0);
}
