// meander figures: the survey's figures, remade.
#include <fmt/format.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/info.h>

#include <chrono>
#include <filesystem>
#include <memory>

#include "io/file/atomic_file.h"
#include "jobs/command_line.h"
#include "jobs/exit_status.h"
#include "jobs/inputs.h"
#include "jobs/laboratory/commands.h"
#include "jobs/laboratory/figures/figure_models.h"
#include "jobs/laboratory/figures/figure_set.h"
#include "jobs/laboratory/measured_sets.h"
#include "jobs/laboratory/picture_options.h"
#include "jobs/output_guard.h"
#include "meander_version.h"

namespace meander {

namespace {

namespace fs = std::filesystem;

struct FiguresOptions {
  std::string folder;
  std::vector<std::string> models;
  std::vector<std::string> only;
  std::string up = "y", view;
  std::uint64_t seed = 1;
  int threads = 0;
  bool quick = false;
};

struct FigureName {
  const char* name;
  void (*draw)(FigureSet&);
};
constexpr FigureName figure_names[] = {
    {"1", draw_point_sets},
    {"2", draw_stretched_plane},
    {"3", draw_curves},
    {"4-plane", draw_plane_discrepancy},
    {"4-sphere", draw_sphere_discrepancy},
    {"4-mesh", draw_mesh_discrepancy},
    {"5", draw_density_discrepancy},
    {"6", draw_surfaces},
    {"7", draw_from_mesh_to_splats},
    {"8", draw_adaptive_curve},
    {"9", draw_splats_beside_models},
    {"10", draw_remeshed_models},
    {"11", draw_view_detail},
    {"12", draw_tensor_fields},
    {"13", draw_segments},
    {"14", draw_anisotropic_samples},
    {"15", draw_tensor_discrepancy},
    {"16", draw_spectra},
    {"16-tensor", draw_tensor_differences},
    {"17", draw_tensor_splats},
    {"18-20", draw_strokes},
    {"21", draw_mesh_distances},
    {"metro", draw_remeshed},
    {"22-24", draw_distance_histograms},
    {"24-floor", draw_histogram_floors},
    {"25-26", draw_geodesic_histograms},
    {"spaced", draw_spaced_samples},
    {"spaced-sets", draw_spaced_sets},
};
constexpr int last_figure = 26;

// Whether a figure, by its name or number, is drawn with the one of this name: 4 and 4-mesh with 4-mesh, 18,
// 19, 20 and 18-20 with 18-20.
bool is_part_of(const std::string& wanted, const std::string& name) {
  if (wanted == name) return true;
  if (wanted.find_first_not_of("0123456789") != std::string::npos) return false;
  const std::size_t dash = name.find('-');
  if (dash == std::string::npos || name.find_first_not_of("0123456789") != dash) return false;
  const int number = std::stoi(wanted), first = std::stoi(name);
  const bool is_range = name.find_first_not_of("0123456789", dash + 1) == std::string::npos;
  return is_range ? first <= number && number <= std::stoi(name.substr(dash + 1)) : number == first;
}

FigureMesh read_model(const std::string& path) {
  const PolygonMesh mesh = read_model_mesh(path);
  FigureMesh result;
  result.name = fs::path(path).stem().string();
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
    result.positions.insert(result.positions.end(), {mesh.x[v], mesh.y[v], mesh.z[v]});
  if (mesh.corners.size() != 3 * mesh.polygon_count())
    throw UsageError("`" + path + "` has faces that are not triangles; figures need triangle meshes");
  result.faces = mesh.corners;
  return result;
}

// The page and the files of earlier figures, which the new ones may replace.
void check_outputs(const FiguresOptions& options) {
  OutputGuard guard;
  for (const std::string& model : options.models) guard.protect(model);
  guard.check_folder(options.folder, "-o");
  std::error_code none;
  for (const fs::directory_entry& entry : fs::directory_iterator(options.folder, none)) {
    if (!is_figure_file(entry.path().filename().string())) continue;
    const std::string extension = entry.path().extension().string();
    if (extension == ".svg") guard.check(entry.path(), {FileKind::svg}, "-o");
    if (extension == ".png") guard.check(entry.path(), {FileKind::png}, "-o");
    if (extension == ".csv") guard.check(entry.path(), {FileKind::csv}, "-o");
    if (extension == ".json") guard.check(entry.path(), {FileKind::json}, "-o");
    if (extension == ".ply") guard.check(entry.path(), {FileKind::ply_mesh, FileKind::ply_points}, "-o");
  }
  guard.check(fs::path(options.folder) / "index.html", {FileKind::html}, "-o", Existing::replace, true);
}

int draw_figures(const FiguresOptions& options) {
  const Vector3 view = view_of(options.view, options.up);
  check_outputs(options);
  std::vector<FigureMesh> meshes;
  for (const std::string& model : options.models) {
    meshes.push_back(read_model(model));
    for (std::size_t i = 0; i + 1 < meshes.size(); ++i)
      if (meshes[i].name == meshes.back().name)
        throw UsageError("two models are called `" + meshes.back().name +
                         "`: their figures would have the same names");
  }
  if (meshes.empty()) meshes.push_back(torus_mesh(96, 48));  // for machines without models
  fs::create_directories(options.folder);
  const int threads = options.threads > 0 ? options.threads : oneapi::tbb::info::default_concurrency();
  const oneapi::tbb::global_control control(oneapi::tbb::global_control::max_allowed_parallelism,
                                            static_cast<std::size_t>(threads));
  const auto start = std::chrono::steady_clock::now();
  const auto seconds = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  FigureSet figures(options.folder, options.quick, options.seed, std::move(meshes),
                    [&](const std::string& text) { fmt::print(stderr, "{:7.1f} s  {}\n", seconds(), text); });
  figures.up = axis_of(options.up);
  figures.view = view;
  figures.page.title = "The survey's figures, measured again";
  figures.page.introduction = {{"",
                                "Figures of the survey \"Fast Low-discrepancy Sampling of Parametric "
                                "Surfaces and Meshes\", remade from "
                                "its description: what was measured here stands beside what the survey "
                                "claims. The numbers behind each "
                                "picture are in the CSV files."}};
  for (const FigureName& figure : figure_names)
    if (options.only.empty() ||
        std::any_of(options.only.begin(), options.only.end(),
                    [&](const auto& wanted) { return is_part_of(wanted, figure.name); }))
      figure.draw(figures);
  figures.page.footer =
      fmt::format("meander {}, seed {}{}", meander_version, options.seed, options.quick ? ", --quick" : "");
  const fs::path page = fs::path(options.folder) / "index.html";
  replace_file(page, html_page(figures.page));
  fmt::print("{} figures in {}, {:.0f} s\n", figures.page.figures.size(), page.string(), seconds());
  return exit_done;
}

}  // namespace

JobFunction add_figures_job(Command& program) {
  Command command =
      program.add_subcommand("figures", "Reproduce the survey's figures: pictures, data and an HTML page");
  auto options = std::make_shared<FiguresOptions>();
  command.add_option("-o,--output", options->folder, "Output folder, created if missing").required();
  command.add_option(
      "--models", options->models,
      "Triangle meshes for figures 4, 7, 9 to 14, 16, 17, 20, 22 to 26, of spaced samples and remeshed "
      "surfaces (default: a "
      "generated torus)");
  std::vector<std::string> names;
  for (const FigureName& figure : figure_names) names.emplace_back(figure.name);
  for (int number = 1; number <= last_figure; ++number) {
    const std::string name = std::to_string(number);
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  command.add_option("--only", options->only, "Draw these figures only").separator(',').one_of(names);
  command.add_option("--up", options->up, "Figure 20: the axis of the models that points up")
      .show_default()
      .one_of({"x", "y", "z"});
  command.add_option(
      "--view", options->view,
      "Figure 20: direction from the model towards the eye, X,Y,Z (default: from the front, right and "
      "above)");
  command.add_option("--seed", options->seed, "Seed, 0 to 2^64 - 1").show_default().whole_number();
  command.add_option("-j,--threads", options->threads, "Threads, up to 1024 (0: all available)")
      .show_default()
      .range(0, 1024);
  command.add_flag("--quick", options->quick, "Fewer points, shapes and sets");
  return [options] { return draw_figures(*options); };
}

}  // namespace meander
