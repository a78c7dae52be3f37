#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <sstream>

#include "io/store/store_reader.h"
#include "io/store/store_verify.h"
#include "io/table/npy_header.h"
#include "support/archive_files.h"
#include "support/catch.h"
#include "support/meander_program.h"
#include "support/mesh_files.h"
#include "support/run_process.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

ProcessResult measure(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {program, "measure"});
  return run_process(arguments);
}

// Column `name` of a CSV file as numbers.
std::vector<double> csv_column(const std::filesystem::path& path, const std::string& name) {
  std::istringstream lines(read_file(path));
  std::vector<double> values;
  std::string line;
  std::size_t wanted = 0;
  for (bool head = true; std::getline(lines, line); head = false) {
    std::istringstream cells(line);
    std::string cell;
    for (std::size_t column = 0; std::getline(cells, cell, ','); ++column) {
      if (head && cell == name) wanted = column;
      if (!head && column == wanted) values.push_back(std::stod(cell));
    }
  }
  return values;
}

void sample(const std::filesystem::path& mesh, const std::filesystem::path& store,
            const std::string& sequence) {
  REQUIRE(
      run_process({program, "run", mesh.string(), "-o", store.string(), "-n", "2000", "--sequence", sequence})
          .exit_code == 0);
}

}  // namespace

TEST_CASE("measure discrepancy: one point in the middle of the square gives the closed form 3/4") {
  const ScratchFolder scratch;
  write_file(scratch / "p.xyz", "0.5 0.5 0\n");
  const ProcessResult result =
      measure({"discrepancy", scratch / "p.xyz", "--surface", "plane", "--csv", scratch / "d.csv"});
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  CHECK(csv_column(scratch / "d.csv", "boxes at 0") == std::vector<double>{0.75});
  // The point enters at r = sqrt(1/2), where the quarter has the share pi / 8.
  CHECK(csv_column(scratch / "d.csv", "quarter circles")[0] == Approx(1 - M_PI / 8));
}

TEST_CASE("measure discrepancy: a NumPy array is measured like text, and a damaged one is named") {
  const ScratchFolder scratch;
  const std::array<double, 4> points = {0.25, 0.5, 0.75, 0.125};
  const std::string values(reinterpret_cast<const char*>(points.data()), sizeof points);
  const std::array<std::uint64_t, 2> shape = {2, 2};
  write_file(scratch / "p.npy", npy_header("<f8", shape) + values);
  write_file(scratch / "p.xyz", "0.25 0.5 0\n0.75 0.125 0\n");
  const ProcessResult result = measure({"discrepancy", scratch / "p.npy", scratch / "p.xyz", "--surface",
                                        "plane", "--csv", scratch / "d.csv"});
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  const std::vector<double> boxes = csv_column(scratch / "d.csv", "boxes at 0");
  REQUIRE(boxes.size() == 2);
  CHECK(boxes[0] == boxes[1]);
  write_file(scratch / "short.npy", npy_header("<f8", shape) + values.substr(1));
  const ProcessResult damaged = measure({"discrepancy", scratch / "short.npy", "--surface", "plane"});
  CHECK(damaged.exit_code != 0);
  CHECK(damaged.err.find("short.npy") != std::string::npos);
  CHECK(damaged.err.find("promises 2 x 2 values") != std::string::npos);
}

TEST_CASE(
    "measure boxes, rings, spacing: curve samples beat random ones, points of a file are measured alike") {
  const ScratchFolder scratch;
  const std::filesystem::path mesh = scratch / "torus.off", curve = scratch / "curve.h5",
                              random = scratch / "random.h5";
  write_mesh(mesh, torus(60, 30));
  sample(mesh, curve, "shifted");
  sample(mesh, random, "random");
  REQUIRE(
      run_process({program, "export", curve.string(), "-o", scratch / "out", "--format", "xyz"}).exit_code ==
      0);
  const std::string file = scratch / "out/torus.off.xyz";
  const auto both = [&](const char* what, const char* column) {
    const ProcessResult result = measure({what, curve.string(), random.string(), file, "--surface",
                                          mesh.string(), "--csv", scratch / "r.csv"});
    INFO(what << ": " << result.err);
    REQUIRE(result.exit_code == 0);
    return csv_column(scratch / "r.csv", column);
  };
  const std::vector<double> boxes = both("boxes", "error / random");
  REQUIRE(boxes.size() == 3);
  CHECK(boxes[0] < 0.35);
  CHECK(boxes[1] > 0.6);
  CHECK(boxes[1] < 1.6);
  CHECK(boxes[2] == Approx(boxes[0]).epsilon(0.02));  // the file has fewer digits
  const std::vector<double> rings = both("rings", "discrepancy");
  CHECK(2 * rings[0] < rings[1]);
  const std::vector<double> coverage = both("spacing", "coverage / mean spacing");
  CHECK(coverage[0] < coverage[1]);
}

TEST_CASE("measure boxes: every set stands beside the least error of its number of points") {
  const ScratchFolder scratch;
  const std::filesystem::path mesh = scratch / "ball.off";
  write_mesh(mesh, icosphere(4));
  std::vector<std::string> command = {"boxes"};
  for (const char* n : {"500", "8000"}) {
    command.push_back((scratch / (std::string(n) + ".h5")).string());
    REQUIRE(run_process({program, "run", mesh.string(), "-o", command.back(), "-n", n}).exit_code == 0);
  }
  command.insert(command.end(), {"--surface", mesh.string(), "--csv", scratch / "b.csv", "--json"});
  const ProcessResult result = measure(command);
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  CHECK(contains(result.out, "\"limit\":0."));
  CHECK(contains(result.out, "\"over_limit\":1."));
  const std::vector<double> error = csv_column(scratch / "b.csv", "error / random"),
                            limit = csv_column(scratch / "b.csv", "limit"),
                            over = csv_column(scratch / "b.csv", "over_limit");
  REQUIRE(limit.size() == 2);
  // Of relative boundaries of 12.9 to 13.4, by the draw of the boxes.
  CHECK(limit[0] == Approx(std::sqrt(0.0717 * 13.15 / std::sqrt(500.0))).epsilon(0.02));
  CHECK(limit[0] == Approx(2 * limit[1]));
  for (std::size_t i = 0; i < 2; ++i) {
    CHECK(over[i] == Approx(error[i] / limit[i]));
    CHECK(over[i] > 1);
    CHECK(over[i] < 1.7);
  }
}

TEST_CASE("measure modes: random points have one, even samples far less, and fewer functions are smoother") {
  const ScratchFolder scratch;
  const std::filesystem::path mesh = scratch / "ring.off";
  write_mesh(mesh, torus(48, 24));
  const std::string even = scratch / "even.h5", random = scratch / "random.h5";
  sample(mesh, even, "shifted");
  sample(mesh, random, "random");
  const auto errors = [&](const std::vector<std::string>& more) {
    std::vector<std::string> command = {"modes",       even,    random,           "--surface",
                                        mesh.string(), "--csv", scratch / "m.csv"};
    command.insert(command.end(), more.begin(), more.end());
    const ProcessResult result = measure(command);
    INFO(result.err);
    REQUIRE(result.exit_code == 0);
    return csv_column(scratch / "m.csv", "error / random");
  };
  const std::vector<double> thirty = errors({}), many = errors({"--shapes", "200"});
  CHECK(csv_column(scratch / "m.csv", "modes") == std::vector<double>{200, 200});
  CHECK(thirty[0] < 0.2);
  CHECK(thirty[0] < many[0]);
  CHECK(many[0] < 0.5);
  CHECK(thirty[1] > 0.6);
  CHECK(many[1] == Approx(1).margin(0.3));
  const ProcessResult refused = measure({"modes", even, "--surface", mesh.string(), "--shapes", "1001"});
  CHECK(refused.exit_code == 2);
  CHECK(contains(refused.err, "at most 1000"));
  CHECK(measure({"modes", even, "--surface", mesh.string(), "--seed", "2"}).exit_code == 2);
}

TEST_CASE("measure spacing: a hexagonal lattice has the least hole and mean distance, random points do not") {
  const ScratchFolder scratch;
  // 20 by 20 rows on 1 x sqrt(3 / 4), with the copies across the border that the edges of a cell need.
  std::string lattice, plane = "OFF\n4 2 0\n0 0 0\n20 0 0\n20 ";
  const std::string height = fmt::format("{:.17g}", 20 * std::sqrt(0.75));
  plane += height + " 0\n0 " + height + " 0\n3 0 1 2\n3 0 2 3\n";
  for (int j = 0; j <= 20; ++j)
    for (int i = 0; i <= 20; ++i)
      lattice += fmt::format("{:.17g} {:.17g} 0\n", std::min(20.0, i + 0.5 * (j & 1)), j * std::sqrt(0.75));
  write_file(scratch / "plane.off", plane);
  write_file(scratch / "lattice.xyz", lattice);
  const std::string random = scratch / "random.h5";
  REQUIRE(run_process({program, "run", scratch / "plane.off", "-o", random, "-n", "441", "--sequence",
                       "random", "--method", "direct"})
              .exit_code == 0);
  const ProcessResult result = measure({"spacing", scratch / "lattice.xyz", random, "--surface",
                                        scratch / "plane.off", "--csv", scratch / "s.csv"});
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  const std::vector<double> hole = csv_column(scratch / "s.csv", "hole"),
                            chamfer = csv_column(scratch / "s.csv", "chamfer"),
                            radius = csv_column(scratch / "s.csv", "coverage radius");
  REQUIRE(hole.size() == 2);
  // Distances are those of the lattice but at the left border, whose odd rows begin half a cell inside; the
  // ratios are those of 441 points, where 400 are due.
  CHECK(radius[0] == Approx(1 / std::sqrt(3.0)).epsilon(0.002));
  CHECK(hole[0] == Approx(std::sqrt(441.0 / 400)).epsilon(0.002));
  CHECK(chamfer[0] == Approx(std::sqrt(441.0 / 400)).epsilon(0.03));
  CHECK(hole[1] > 2.5);
  // Of Poisson points in the plane 1 / (2 sqrt(density)), 1.3256 times that of the lattice.
  CHECK(chamfer[1] == Approx(1.3256).epsilon(0.05));
}

TEST_CASE("measure integral: stored densities are weighted, prefixes give a slope") {
  const ScratchFolder scratch;
  const std::string store = scratch / "s.h5";
  REQUIRE(run_process({program, "surface", "plane", "-n", "4096", "--density", "0.2 + x", "-o", store})
              .exit_code == 0);
  const ProcessResult result =
      measure({"integral", store, "--surface", "plane", "--csv", scratch / "i.csv", "--json"});
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  CHECK(result.out.find("\"measure\":\"integral\"") != std::string::npos);
  const std::vector<double> points = csv_column(scratch / "i.csv", "points"),
                            errors = csv_column(scratch / "i.csv", "RMS error");
  REQUIRE(points.size() == errors.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    if (points[i] == 4096) CHECK(errors[i] < 0.01);  // random points: 0.008 to 0.02 at one standard deviation
}

TEST_CASE("measure spectrum and differences: white noise is 1, and the map is drawn") {
  const ScratchFolder scratch;
  const std::string store = scratch / "s.h5", picture = scratch / "map.png";
  REQUIRE(run_process({program, "surface", "plane", "-n", "2048", "--sequence", "random", "-o", store})
              .exit_code == 0);
  for (const char* what : {"spectrum", "differences"}) {
    const ProcessResult result =
        measure({what, store, "--surface", "plane", "--csv", scratch / "p.csv", "--picture", picture});
    INFO(what << ": " << result.err);
    REQUIRE(result.exit_code == 0);
    const std::vector<double> mean = csv_column(scratch / "p.csv", "mean");
    REQUIRE(mean.size() > 20);
    double sum = 0;
    for (std::size_t i = mean.size() / 2; i < mean.size(); ++i) sum += mean[i];
    CHECK(sum / static_cast<double>(mean.size() - mean.size() / 2) == Approx(1).margin(0.05));
    CHECK(read_file(picture).substr(1, 3) == "PNG");
  }
}

TEST_CASE("measure differences: random points on an open mesh with sharp edges are white noise") {
  const ScratchFolder scratch;
  const std::filesystem::path mesh = scratch / "plate.off", store = scratch / "s.h5";
  write_file(mesh,
             "OFF\n6 4 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n1 0 1\n1 1 1\n3 0 1 2\n3 0 2 3\n3 1 4 5\n3 1 5 2\n");
  std::vector<std::string> arguments = {"differences"};
  for (const char* seed : {"1", "2", "3", "4"}) {
    arguments.push_back(scratch / (std::string(seed) + ".h5"));
    REQUIRE(run_process({program, "run", mesh.string(), "-o", arguments.back(), "-n", "2000", "--sequence",
                         "random", "--method", "direct", "--seed", seed})
                .exit_code == 0);
  }
  arguments.insert(arguments.end(), {"--surface", mesh.string(), "--csv", scratch / "d.csv"});
  const ProcessResult result = measure(arguments);
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  for (const double mean : csv_column(scratch / "d.csv", "mean")) CHECK(mean == Approx(1).margin(0.12));
}

TEST_CASE("measure differences: densities and tensors are compared with their own random sets",
          "[statistics]") {
  const ScratchFolder scratch;
  // Far from the origin, in small units; the inside of the tube is more curved than its outside.
  const std::filesystem::path ring = scratch / "ring.off";
  write_mesh(ring, moved(torus(96, 48, 1, 0.6), 1e-3, 5, -7, 3));
  struct Case {
    std::string surface;
    std::vector<std::string> options;
    bool export_points = false;
  };
  const std::vector<std::string> curved = {"--density", "mean", "--density-exponent", "2"},
                                 tensors = {"--method", "anisotropic", "--density", "mean"};
  for (const Case& c : {Case{ring.string(), curved}, Case{ring.string(), curved, true},
                        Case{ring.string(), tensors}, Case{"plane", {"--density", "0.05 + x^2*y"}}}) {
    for (const std::string sequence : {"random", "shifted"}) {
      std::vector<std::string> measured = {"differences"};
      for (const char* seed : {"1", "2", "3", "4"}) {
        const std::string store = scratch / (std::string(seed) + ".h5");
        std::vector<std::string> run = {program,   c.surface == "plane" ? "surface" : "run",
                                        c.surface, "-o",
                                        store,     "-n",
                                        "2000",    "--sequence",
                                        sequence,  "--seed",
                                        seed,      "--fresh"};
        run.insert(run.end(), c.options.begin(), c.options.end());
        REQUIRE(run_process(run).exit_code == 0);
        measured.push_back(store);
        if (!c.export_points) continue;
        const std::string folder = scratch / (std::string("out") + seed + sequence);
        REQUIRE(run_process({program, "export", store, "-o", folder}).exit_code == 0);
        measured.back() = folder + "/ring.off.ply";
      }
      measured.insert(measured.end(), {"--surface", c.surface, "--csv", scratch / "d.csv"});
      const ProcessResult result = measure(measured);
      INFO(c.surface << ", " << c.options[1] << ", " << sequence << ": " << result.err);
      REQUIRE(result.exit_code == 0);
      const std::vector<double> mean = csv_column(scratch / "d.csv", "mean"),
                                bins = csv_column(scratch / "d.csv", "bins");
      REQUIRE(mean.size() > 20);
      for (std::size_t i = 0; i < mean.size(); ++i)
        if (sequence == "random" || i > 11) CHECK(mean[i] == Approx(1).margin(bins[i] < 40 ? 0.15 : 0.08));
      if (sequence != "random") CHECK(mean[0] < 0.4);
    }
  }
  // A set of one density says nothing about another.
  const std::string plain = scratch / "plain.h5";
  REQUIRE(run_process({program, "run", ring.string(), "-o", plain, "-n", "2000"}).exit_code == 0);
  CHECK(measure({"differences", scratch / "1.h5", plain, "--surface", ring.string()}).exit_code == 2);
}

TEST_CASE("measure: the density of an exported PLY file is used") {
  const ScratchFolder scratch;
  const std::string store = scratch / "s.h5";
  REQUIRE(run_process({program, "surface", "plane", "-n", "512", "--density", "0.1 + x", "-o", store})
              .exit_code == 0);
  REQUIRE(run_process({program, "export", store, "-o", scratch / "out"}).exit_code == 0);
  const ProcessResult result = measure({"discrepancy", scratch / "out/plane.ply", "--surface", "plane"});
  CHECK(result.exit_code == 2);
  CHECK(result.err.find("density") != std::string::npos);
  for (const std::string& set : {store, std::string(scratch / "out/plane.ply")}) {
    REQUIRE(measure({"integral", set, "--surface", "plane", "--csv", scratch / "i.csv"}).exit_code == 0);
    CHECK(csv_column(scratch / "i.csv", "RMS error").back() < 0.05);
  }
}

TEST_CASE("measure: points of an exported .npz file are measured as those of the store, in any frame") {
  const ScratchFolder scratch;
  const std::string mesh = scratch / "ball.off", store = scratch / "s.h5", points = scratch / "ball.npz";
  write_mesh(mesh, icosphere(2, 7.5));
  REQUIRE(
      run_process({program, "run", mesh, "-o", store, "-n", "300", "--normalize", "pointnet"}).exit_code ==
      0);
  for (const char* frame : {"stored", "file"}) {
    REQUIRE(run_process({program, "export", store, "-o", points, "--frame", frame, "--fresh"}).exit_code ==
            0);
    const ProcessResult result =
        measure({"boxes", points, store, "--surface", mesh, "--csv", scratch / "b.csv"});
    INFO(result.err);
    REQUIRE(result.exit_code == 0);
    const std::vector<double> errors = csv_column(scratch / "b.csv", "error / random");
    REQUIRE(errors.size() == 2);
    CHECK(errors[0] == Approx(errors[1]).epsilon(1e-3));
    CHECK(errors[0] < 0.5);
  }
}

TEST_CASE("measure: the surfaces of a store are found as by its run, by ids and in packed files") {
  const ScratchFolder scratch;
  std::filesystem::create_directories(scratch / "in");
  const std::string sphere = mesh_bytes(icosphere(3), MeshFile::off);
  write_file(scratch / "in/a\tb\xFF.off", sphere);
  write_file(scratch / "in/packed.off.gz", gzip_bytes(sphere));
  const std::string store = scratch / "s.h5";
  REQUIRE(run_process({program, "run", scratch / "in", "-o", store, "-n", "200"}).exit_code == 0);
  const ProcessResult result = measure({"spacing", store, "--surface", scratch / "in"});
  INFO(result.err);
  CHECK(result.exit_code == 0);
  CHECK(result.out.find("a%09b%FF.off") != std::string::npos);
  CHECK(result.out.find("packed.off") != std::string::npos);
  std::filesystem::remove(scratch / "in/packed.off.gz");
  const ProcessResult gone = measure({"spacing", store, "--surface", scratch / "in"});
  CHECK(gone.exit_code == 2);
  CHECK(gone.err.find("has no item `packed.off`") != std::string::npos);
}

TEST_CASE("measure distance: a mesh has distance 0 to itself, and the gap to a larger sphere") {
  const ScratchFolder scratch;
  write_mesh(scratch / "a.off", icosphere(3));
  PolygonMesh larger = icosphere(3);
  for (std::vector<double>* axis : {&larger.x, &larger.y, &larger.z})
    for (double& value : *axis) value *= 1.1;
  write_mesh(scratch / "b.off", larger);
  const auto means = [&](const char* other) {
    const ProcessResult result = measure(
        {"distance", scratch / "a.off", scratch / other, "--samples", "5000", "--csv", scratch / "d.csv"});
    INFO(result.err);
    REQUIRE(result.exit_code == 0);
    return csv_column(scratch / "d.csv", "mean");
  };
  for (const double mean : means("a.off")) CHECK(mean < 1e-12);
  for (const double mean : means("b.off")) CHECK(mean == Approx(0.1).epsilon(0.02));
}

TEST_CASE("measure: anything that cannot be measured is a usage error with the reason") {
  const ScratchFolder scratch;
  write_file(scratch / "p.xyz", "0.5 0.5 0\n2 0.5 0\n");
  write_mesh(scratch / "m.off", icosphere(2));
  const auto error_of = [](const std::vector<std::string>& arguments) {
    const ProcessResult result = measure(arguments);
    INFO(result.err);
    CHECK(result.exit_code == 2);
    return result.err;
  };
  const std::string points = scratch / "p.xyz", mesh = scratch / "m.off";
  CHECK(error_of({"boxs", points}).find("boxes") != std::string::npos);
  CHECK(error_of({"boxes", points}).find("--surface") != std::string::npos);
  write_file(scratch / "inside.xyz", "0.5 0.5 0\n0.2 0.5 0\n");
  CHECK(error_of({"boxes", scratch / "inside.xyz", "--surface", "plane"}).find("MESH") != std::string::npos);
  CHECK(error_of({"discrepancy", points, "--surface", "plane"}).find("not in the unit square") !=
        std::string::npos);
  CHECK(error_of({"boxes", points, "--surface", mesh, "--picture", "x.png"}).find("has no picture") !=
        std::string::npos);
  CHECK(error_of({"spacing", points, "--surface", mesh, "--shapes", "9"}).find("no shapes") !=
        std::string::npos);
  CHECK(error_of({"distance", mesh}).find("two meshes") != std::string::npos);
  CHECK(error_of({"boxes", points, "--surface", mesh}).find("is it the surface") != std::string::npos);
  CHECK(error_of({"boxes", points, "--surface", mesh, "--samples", "9"}).find("--samples") !=
        std::string::npos);
  CHECK(error_of({"boxes", points, "--surface", mesh, "--seed", "-1"}).find("whole number") !=
        std::string::npos);
  CHECK(error_of({"integral", scratch / "inside.xyz", "--surface", "plane", "--seed", "2"}).find("--seed") !=
        std::string::npos);
  write_file(scratch / "deep.xyz", "0.5 0.5 0.1\n");
  CHECK(
      error_of({"discrepancy", scratch / "deep.xyz", "--surface", "plane"}).find("not in the unit square") !=
      std::string::npos);
  write_file(scratch / "one.xyz", "0.5 0.5 0\n");
  CHECK(error_of({"spacing", scratch / "one.xyz", "--surface", "plane"}).find("no neighbor") !=
        std::string::npos);
  CHECK(error_of({"boxes", scratch / "absent.xyz", "--surface", mesh}).find("unreadable") !=
        std::string::npos);
  const std::string store = scratch / "s.h5";
  REQUIRE(run_process({program, "surface", "plane", "-n", "16", "--density", "x", "-o", store}).exit_code ==
          0);
  CHECK(error_of({"discrepancy", store, "--surface", "plane"}).find("density") != std::string::npos);
}

TEST_CASE("run --certify: every ok row holds the measures of its own samples") {
  const ScratchFolder scratch;
  std::filesystem::create_directories(scratch / "in");
  write_mesh(scratch / "in/sphere.off", icosphere(4));
  write_mesh(scratch / "in/torus.off", torus(40, 20));
  const std::string store = scratch / "s.h5";
  REQUIRE(run_process({program, "run", scratch / "in", "-o", store, "-n", "1024", "--certify"}).exit_code ==
          0);
  CHECK(verify_store(store).problems.empty());
  const StoreReader reader(store);
  std::vector<std::string> names;
  for (const DescriptorSchema& column : reader.descriptors()) {
    CHECK(column.group == "certificate");
    names.push_back(column.name);
  }
  REQUIRE(names == std::vector<std::string>{"box_rms_ratio", "box_limit", "over_limit", "rho"});
  for (std::uint64_t row = 0; row < reader.rows(); ++row) {
    const Row content = reader.read_row(row);
    REQUIRE(content.descriptors.size() == 4);
    const auto value = [&](std::size_t k) { return content.descriptors[k].values.at(0); };
    CHECK(value(0) > 0.1);
    CHECK(value(0) < 0.4);
    CHECK(value(1) == Approx(0.17).margin(0.02));
    CHECK(value(2) == Approx(value(0) / value(1)));
    CHECK(value(3) > 0);
    CHECK(value(3) < 0.6);
  }
  const ProcessResult judged =
      measure({"boxes", store + "::sphere.off", "--surface", scratch / "in", "--csv", scratch / "b.csv"});
  INFO(judged.err);
  REQUIRE(judged.exit_code == 0);
  CHECK(csv_column(scratch / "b.csv", "error / random")[0] ==
        Approx(reader.read_row(0).descriptors[0].values[0]).epsilon(1e-5));
  CHECK(csv_column(scratch / "b.csv", "limit")[0] ==
        Approx(reader.read_row(0).descriptors[1].values[0]).epsilon(1e-5));
  const ProcessResult refused =
      run_process({program, "run", scratch / "in", "-o", scratch / "t.h5", "--certify", "--density", "mean"});
  CHECK(refused.exit_code == 2);
  CHECK(refused.err.find("uniform density") != std::string::npos);
}

TEST_CASE("measure and run --certify: spaced samples show by their distance and lower error",
          "[statistics]") {
  const ScratchFolder scratch;
  // More triangles than samples need for cells that are cut exactly, whose `shifted` samples do as well.
  write_mesh(scratch / "torus.off", torus(80, 40));
  struct Judged {
    double error = 0, rho = 0, mean = 0, coverage = 0;
  };
  const auto judged = [&](const std::vector<std::string>& words) {
    const std::string store = scratch / "s.h5", mesh = scratch / "torus.off";
    std::vector<std::string> command = {program, "run",  mesh,        "-o",     store,
                                        "-n",    "1024", "--certify", "--fresh"};
    command.insert(command.end(), words.begin(), words.end());
    REQUIRE(run_process(command).exit_code == 0);
    const Row row = StoreReader(store).read_row(0);
    const auto of = [&](const char* what, const char* column) {
      REQUIRE(measure({what, store, "--surface", mesh, "--csv", scratch / "r.csv"}).exit_code == 0);
      return csv_column(scratch / "r.csv", column).at(0);
    };
    const Judged result{of("boxes", "error / random"), of("spacing", "rho"), of("spacing", "mean"),
                        of("spacing", "coverage / mean spacing")};
    CHECK(row.descriptors.at(0).values[0] == Approx(result.error).epsilon(1e-5));
    CHECK(row.descriptors.at(3).values[0] == Approx(result.rho).epsilon(1e-5));
    return result;
  };
  const Judged shifted = judged({"--sequence", "shifted"}), progressive = judged({"--sequence", "spaced"}),
               along = judged({"--sequence", "spaced", "--order", "curve"}),
               best = judged({"--sequence", "spaced", "--order", "curve", "--spacing", "best"});
  CHECK(shifted.rho < 0.2);
  CHECK(progressive.rho > 0.5);
  CHECK(along.rho > 0.62);
  CHECK(best.rho > along.rho);
  CHECK(along.error < shifted.error);
  CHECK(progressive.mean > 1.15 * shifted.mean);
  CHECK(along.mean > progressive.mean);
  CHECK(best.mean > along.mean);
  CHECK(along.coverage < shifted.coverage);
}
