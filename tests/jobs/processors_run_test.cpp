// The promise of equal bytes, on a processor that lacks what this one has: glibc is told so and then calls
// other functions, with other last bits. On a processor without these instructions both runs are the same.
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "support/catch.h"
#include "support/meander_program.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;
namespace fs = std::filesystem;

namespace {

// A closed, a bumpy, an open surface and one with a handle.
void write_models(const fs::path& folder) {
  fs::create_directories(folder);
  PolygonMesh bumpy = icosphere(3);
  for (std::size_t v = 0; v < bumpy.vertex_count(); ++v) {
    const double x = bumpy.x[v], y = bumpy.y[v], z = bumpy.z[v];
    const double size = 1 + 0.2 * x * y * z + 0.3 * x * x * z - 0.15 * y * y * y;
    bumpy.x[v] = x * size;
    bumpy.y[v] = y * size * 1.3;
    bumpy.z[v] = z * size * 0.7;
  }
  write_mesh(folder / "bumpy.off", bumpy);
  write_mesh(folder / "torus.off", torus(40, 20));
  write_mesh(folder / "sheet.off", moved(folded_sheet(3, 12, 0.1), 0.7, 0.1, 0.2, 0.3));
  write_mesh(folder / "tunnels.off", slab_with_tunnels(2));
}

// Programs of glibc 2.33 and later are given the first names, those before the second; others are ignored.
ProcessOptions older_processor() {
  ProcessOptions options;
  options.environment = {
      {"GLIBC_TUNABLES", "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4,-AVX512F,-AVX512VL,-AVX2_Usable,-FMA_Usable"}};
  return options;
}

// What the command, whose last argument is an output in a folder of its own, writes; reports with times
// aside.
std::map<std::string, std::string> files_of(std::vector<std::string> command, const fs::path& folder,
                                            const std::string& output, const ProcessOptions& options) {
  fs::create_directories(folder);
  command.insert(command.end(), {"-o", (folder / output).string()});
  const ProcessResult result = meander_with(command, options);
  INFO(result.err);
  CHECK(result.exit_code == 0);
  std::map<std::string, std::string> files;
  for (auto& [path, bytes] : content_of(folder))
    if (!path.ends_with(".json") && !path.ends_with(".csv"))
      files[fs::relative(path, folder).string()] = std::move(bytes);
  return files;
}

void check_same_files(const std::vector<std::string>& command, const fs::path& folder,
                      const std::string& output) {
  const auto here = files_of(command, folder / "here", output, {});
  const auto there = files_of(command, folder / "there", output, older_processor());
  CHECK(!here.empty());
  CHECK((here == there));
}

}  // namespace

TEST_CASE(
    "processors: stores are the same bytes without AVX2 and FMA, for every method, density and descriptor") {
  const ScratchFolder scratch;
  const fs::path models = scratch / "models";
  write_models(models);
  const std::vector<std::vector<std::string>> settings = {
      {"--describe", "d2,a3,d1,d3,d4,geodesic,basics,pairs,pairs-unsigned,harmonics,views,shapedna"},
      {"--sequence", "spaced"},
      {"--method", "direct", "--density", "mean", "--density-exponent", "0.7"},
      {"--method", "direct", "--density", "gaussian", "--density-exponent", "1.3", "--sequence", "owen"},
      {"--method", "direct", "--density", "max", "--normalize", "unit-sphere"},
      {"--method", "conformal", "--density", "gaussian"},
      {"--method", "conformal", "--locate", "elements"},
      {"--method", "anisotropic"},
      {"--method", "anisotropic", "--tensor", "isotropic"},
      {"--method", "anisotropic", "--tensor-density", "follow"},
      {"--method", "anisotropic", "--tensor-form", "metric", "--tensor", "constant:1,0.1,0.2,3,0,2"}};
  for (std::size_t s = 0; s < settings.size(); ++s) {
    std::vector<std::string> command = {"run", models.string(), "-n", "300"};
    command.insert(command.end(), settings[s].begin(), settings[s].end());
    CAPTURE(settings[s]);
    check_same_files(command, scratch / std::to_string(s), "store.h5");
  }
}

TEST_CASE("processors: formula samples and remeshed files are the same bytes without AVX2 and FMA",
          "[release]") {
  const ScratchFolder scratch;
  const fs::path models = scratch / "models";
  write_models(models);
  check_same_files({"remesh", models.string(), "-n", "400"}, scratch / "plain", "meshes");
  check_same_files({"remesh", models.string(), "-n", "400", "--fit"}, scratch / "fitted", "meshes");
  int made = 0;
  for (const char* density :
       {"gaussian", "mean", "exp(-x^2) + log(2 + y^2) + pow(2 + z, 1.7) + sin(900*u)^2"}) {
    CAPTURE(density);
    check_same_files(
        {"surface", "torus", "eight", "monkey-saddle", "klein-bottle", "-n", "300", "--density", density},
        scratch / std::to_string(++made), "store.h5");
  }
}
