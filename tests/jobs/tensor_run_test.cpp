// run --method anisotropic as a user runs it: mistakes, stores, resuming.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <set>

#include "io/store/store_reader.h"
#include "io/store/store_verify.h"
#include "kernels/model/tensor_segments.h"
#include "support/catch.h"
#include "support/collection.h"
#include "support/fault_program.h"
#include "support/mesh_files.h"
#include "support/run_process.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

std::vector<std::string> command(const std::filesystem::path& input, const std::filesystem::path& store,
                                 const std::vector<std::string>& more = {}) {
  std::vector<std::string> arguments = {fault_program, "run", input.string(), "-o",         store.string(),
                                        "-n",          "64",  "--method",     "anisotropic"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

// A few shapes with a vector at every vertex, "grain", and spacings six, "S".
void write_shapes(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  const PolygonMesh shapes[] = {icosphere(2), torus(20, 10), grid_plane(8, 8)};
  const char* const names[] = {"ball.ply", "ring.ply", "sheet.ply"};
  for (std::size_t i = 0; i < 3; ++i) {
    PolygonMesh mesh = shapes[i];
    const std::size_t count = mesh.vertex_count();
    mesh.vertex_attributes = {{"grain_x", std::vector<double>(count, 3)},
                              {"grain_y", std::vector<double>(count, 0)},
                              {"grain_z", std::vector<double>(count, 1)}};
    for (const char* const name : {"S_xx", "S_xy", "S_xz", "S_yy", "S_yz", "S_zz"})
      mesh.vertex_attributes.push_back(
          {name, std::vector<double>(count, name[2] == name[3] ? (name[2] == 'x' ? 2.0 : 1.0) : 0.25)});
    write_mesh(folder / names[i], mesh);
  }
}

}  // namespace

TEST_CASE("run --method anisotropic: mistakes are usage errors") {
  const ScratchFolder scratch;
  write_shapes(scratch / "in");
  const auto store = scratch / "s.h5";
  const auto says = [&](const std::vector<std::string>& more, const std::string& text) {
    const ProcessResult result = run_process(command(scratch / "in", store, more));
    INFO(result.err);
    CHECK(result.exit_code == 2);
    CHECK(result.err.find(text) != std::string::npos);
  };
  says({"--tensor", "curvatur"}, "not one of curvature|isotropic|");
  says({"--tensor", "constant:1,0,0,1,0"}, "six numbers");
  says({"--tensor", "constant:1,0,0,1,0,x"}, "six numbers");
  says({"--tensor", "constant:1,0,0,1,0,-1"}, "positive definite");
  says({"--tensor-form", "spacings"}, "did you mean `spacing`");
  says({"--tensor-form", "metric"}, "--tensor-form");
  says({"--tensor", "isotropic", "--tensor-density", "follow"}, "--tensor-density");
  says({"--tensor-density", "drop"}, "--tensor-density");
  says({"--tensor-ratio", "0.5"}, "1 to 64");
  says({"--tensor", "attribute:"}, "name");
  says({"--parameterisation", "gradiant"}, "did you mean `gradient`");
  says({"--segments", "0"}, "segments");
  says({"--certify"}, "certify");
  for (const std::vector<std::string>& option : {std::vector<std::string>{"--tensor", "curvature"},
                                                 {"--tensor-ratio", "4"},
                                                 {"--segments", "3"},
                                                 {"--parameterization", "gradient"}}) {
    const ProcessResult result =
        run_process({fault_program, "run", scratch / "in", "-o", store, "-n", "64", option[0], option[1]});
    CHECK(result.exit_code == 2);
    CHECK(result.err.find(option[0] + " applies to --method anisotropic only") != std::string::npos);
  }
  CHECK_FALSE(std::filesystem::exists(store));
}

TEST_CASE("run --method anisotropic: every tensor and form gives a valid store with its tensors") {
  const ScratchFolder scratch;
  write_shapes(scratch / "in");
  const std::vector<std::vector<std::string>> variants = {
      {},
      {"--parameterisation", "gradient"},
      {"--tensor", "isotropic"},
      {"--tensor", "constant:3,0,0,1,0,1"},
      {"--tensor", "constant:3,0,0,1,0,1", "--tensor-form", "metric"},
      {"--tensor", "attribute:grain"},
      {"--tensor", "attribute:S", "--tensor-form", "metric", "--parameterisation", "gradient"},
      {"--tensor-density", "follow", "--tensor-ratio", "3", "--tensor-smoothing", "0"},
      {"--segments", "6", "--normalize", "unit-sphere"},
      {"--locate", "elements", "--density", "mean"},
      {"--place", "vertex", "--curve", "peano", "--order", "curve"},
      {"--describe", "d2,geodesic", "--bins", "16"}};
  std::set<std::string> stores;
  for (const auto& variant : variants) {
    std::vector<std::string> more = variant;
    more.push_back("--fresh");
    const ProcessResult result = run_process(command(scratch / "in", scratch / "s.h5", more));
    INFO((variant.empty() ? "default" : variant[0] + " " + variant[1]) << "\n" << result.err);
    REQUIRE(result.exit_code == 0);
    const VerifyResult verified = verify_store(scratch / "s.h5");
    CHECK(verified.problems.empty());
    CHECK(verified.ok_rows == 3);
    CHECK(stores.insert(read_file(scratch / "s.h5")).second);  // no option is without effect
    const StoreReader reader(scratch / "s.h5");
    for (const char* const name : anisotropy_names)
      CHECK(
          std::any_of(reader.descriptors().begin(), reader.descriptors().end(),
                      [&](const DescriptorSchema& d) { return d.name == name && d.group == "anisotropy"; }));
    for (std::uint64_t row = 0; row < reader.rows(); ++row) {
      const Row content = reader.read_row(row);
      REQUIRE(content.samples.tensor_direction.size() == 3 * 64);
      REQUIRE(content.samples.tensor_spacing.size() == 2 * 64);
      for (std::size_t i = 0; i < 64; ++i) {
        const float* const d = &content.samples.tensor_direction[3 * i];
        CHECK(std::hypot(d[0], d[1], d[2]) == Approx(1).epsilon(1e-5));
        CHECK(content.samples.tensor_spacing[2 * i] >= content.samples.tensor_spacing[2 * i + 1]);
      }
      REQUIRE(content.descriptors.size() == reader.descriptors().size());
    }
  }
  // No tensor arrays in stores of other methods.
  REQUIRE(run_process({fault_program, "run", scratch / "in", "-o", scratch / "c.h5", "-n", "64"}).exit_code ==
          0);
  CHECK(StoreReader(scratch / "c.h5").read_row(0).samples.tensor_direction.empty());
}

TEST_CASE("run --method anisotropic: a missing attribute is the status of that file") {
  const ScratchFolder scratch;
  write_shapes(scratch / "in");
  write_mesh(scratch / "in/plain.off", icosphere(1));
  const ProcessResult result =
      run_process(command(scratch / "in", scratch / "s.h5", {"--tensor", "attribute:grain"}));
  REQUIRE(result.exit_code == 3);
  const StoreReader reader(scratch / "s.h5");
  REQUIRE(reader.rows() == 4);
  const ItemReport report = reader.report(*reader.find("plain.off"));
  CHECK(report.status == Status::missing_attribute);
  CHECK(report.reason.find("grain") != std::string::npos);
  CHECK(reader.report(*reader.find("ball.ply")).status == Status::ok);
  CHECK(verify_store(scratch / "s.h5").problems.empty());
}

TEST_CASE("run --method anisotropic: info, verify and export read the store") {
  const ScratchFolder scratch;
  write_shapes(scratch / "in");
  const std::string store = (scratch / "s.h5").string();
  REQUIRE(run_process(command(scratch / "in", store, {"--label-from-folder"})).exit_code == 0);
  CHECK(run_process({fault_program, "verify", store}).exit_code == 0);
  const ProcessResult info = run_process({fault_program, "info", store});
  CHECK(info.exit_code == 0);
  CHECK(info.out.find("3 models x 64 points") != std::string::npos);
  CHECK(run_process({fault_program, "info", store, "ring.ply"}).out.find("anisotropic") != std::string::npos);
  for (const std::string format : {"ply", "off", "xyz"}) {
    REQUIRE(run_process({fault_program, "export", store, "ring.ply", "--format", format, "-o",
                         (scratch / "out").string()})
                .exit_code == 0);
    CHECK(std::filesystem::file_size(scratch / ("out/ring.ply." + format)) > 500);
  }
  REQUIRE(run_process({fault_program, "export", store, "--pointnet", "-o", (scratch / "pn").string()})
              .exit_code == 0);
  REQUIRE(
      run_process({fault_program, "render", "sheet", store, "-o", (scratch / "p.png").string()}).exit_code ==
      0);
  CHECK(std::filesystem::file_size(scratch / "p.png") > 1000);
  std::string bytes = read_file(store);
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 4);
  write_file(store, bytes);
  CHECK(run_process({fault_program, "verify", store}).exit_code == 3);
}

TEST_CASE("run --method anisotropic: every model has the status of a conformal run") {
  const ScratchFolder scratch;
  const auto expected = write_collection(scratch / "in");
  for (const char* const form : {"metric", "gradient"}) {
    const auto store = scratch / (std::string(form) + ".h5");
    const ProcessResult result = run_process(command(scratch / "in", store, {"--parameterisation", form}));
    INFO(result.err);
    REQUIRE(result.exit_code == 3);
    const StoreReader reader(store);
    REQUIRE(reader.rows() == expected.size());
    for (const auto& [id, status] : expected) {
      INFO(form << " " << id << ": " << reader.report(*reader.find(id)).reason);
      CHECK(reader.report(*reader.find(id)).status == status);
    }
    CHECK(verify_store(store).problems.empty());
  }
}

TEST_CASE("run --method anisotropic: killed and restarted, it ends with the bytes of an undisturbed run",
          "[release]") {
  const ScratchFolder scratch;
  write_collection(scratch / "in");
  REQUIRE(run_process(command(scratch / "in", scratch / "calm.h5", {"-j", "1"})).exit_code == 3);
  ProcessOptions options;
  options.environment = {{"MEANDER_TEST_FAULT", "slow:25"}};
  const ProcessResult result =
      run_killed(command(scratch / "in", scratch / "s.h5", {"-j", "2"}), options,
                 {2, 10, std::chrono::milliseconds(60), std::chrono::milliseconds(260)}, 3,
                 [&] { std::filesystem::remove(scratch / "s.h5"); });
  INFO(result.err);
  REQUIRE(result.exit_code == 3);
  CHECK(same_bytes(scratch / "calm.h5", scratch / "s.h5"));
  // Other tensor parameters are other parameters.
  const ProcessResult other = run_process(command(scratch / "in", scratch / "s.h5", {"--tensor-ratio", "4"}));
  CHECK(other.exit_code == 2);
  CHECK(other.err.find("other parameters") != std::string::npos);
}

TEST_CASE("run --method anisotropic: samples every shared mesh that conformal samples", "[slow]") {
  MEANDER_NEEDS_SHARED_DATA();
  const ScratchFolder scratch;
  const auto run = [&](const char* name, const std::vector<std::string>& more) {
    const auto store = scratch / name;
    std::vector<std::string> arguments = {
        fault_program, "run", shared_data("").string(), "-o", store.string(), "-n", "256", "--timeout", "0"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ProcessResult result = run_process(arguments);
    INFO(result.err);
    REQUIRE(result.exit_code == 3);
    return store;
  };
  const StoreReader conformal(run("conformal.h5", {"--method", "conformal"}));
  for (const char* const form : {"metric", "gradient"}) {
    const std::vector<std::string> options = {"--method", "anisotropic", "--parameterisation", form, "-j"};
    const auto with = [&](const char* threads) {
      std::vector<std::string> more = options;
      more.push_back(threads);
      return more;
    };
    const auto store = run((std::string(form) + "1.h5").c_str(), with("1"));
    CHECK(same_bytes(store, run((std::string(form) + "2.h5").c_str(), with("2"))));
    const StoreReader reader(store);
    REQUIRE(reader.rows() == conformal.rows());
    for (std::uint64_t row = 0; row < reader.rows(); ++row) {
      INFO(form << " " << reader.id(row) << ": " << reader.report(row).reason);
      CHECK(reader.report(row).status == conformal.report(row).status);
      if (reader.report(row).status != Status::ok) continue;
      const Samples samples = reader.read_row(row).samples;
      std::set<std::array<float, 3>> distinct;
      for (std::size_t i = 0; i < samples.count(); ++i)
        distinct.insert({samples.points[3 * i], samples.points[3 * i + 1], samples.points[3 * i + 2]});
      CHECK(distinct.size() == 256);
      CHECK(std::all_of(samples.tensor_spacing.begin(), samples.tensor_spacing.end(),
                        [](float s) { return std::isfinite(s) && s > 0; }));
    }
    CHECK(verify_store(store).problems.empty());
  }
}
