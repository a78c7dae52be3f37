// meander render draws pictures of sampled models.
#include <fmt/format.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/info.h>

#include <algorithm>
#include <memory>
#include <stdexcept>
#include <utility>

#include "io/json_writer.h"
#include "io/plot/png_writer.h"
#include "jobs/cli/command_line.h"
#include "jobs/cli/exit_status.h"
#include "jobs/cli/output_guard.h"
#include "jobs/cli/units.h"
#include "jobs/cli/usage_error.h"
#include "jobs/inputs/input_options.h"
#include "jobs/inputs/inputs.h"
#include "jobs/inputs/store_items.h"
#include "jobs/laboratory/commands.h"
#include "jobs/laboratory/model_pictures.h"
#include "jobs/laboratory/picture_options.h"
#include "jobs/laboratory/render_section.h"
#include "jobs/laboratory/render_strokes.h"
#include "jobs/laboratory/turntable_job.h"
#include "jobs/rows/described_meshes.h"

namespace meander {

namespace {

constexpr int max_models = 400;

struct RenderOptions {
  std::string store, output, color = "plain", up = "y", view, memory = "4G";
  std::vector<std::string> inputs, items;
  std::uint32_t models = 24;
  int threads = 0;
  InputOptions collect;
  SheetLook sheet;
  ModelLook look;
  StoreCheck check = StoreCheck::every_byte;
  bool json = false;
};

ModelLook look_of(const RenderOptions& options) {
  ModelLook look = options.look;
  look.size = options.sheet.cell;
  look.surfaces = !options.inputs.empty();
  look.up = axis_of(options.up);
  look.view = view_of(options.view, options.up);
  return look;
}

// Spreads the models evenly over the rows: the first ones of a sorted collection are seldom typical.
std::vector<PicturedModel> chosen_models(const StoreReader& store, const RenderOptions& options) {
  std::vector<PicturedModel> models;
  for (const std::string& item : options.items) models.push_back({find_item(store, item), {}});
  if (!models.empty()) return models;
  const std::uint64_t count = std::min<std::uint64_t>(store.rows(), options.models);
  for (std::uint64_t i = 0; i < count; ++i) models.push_back({i * store.rows() / count, {}});
  return models;
}

void find_meshes(const StoreReader& store, const RenderOptions& options, std::vector<PicturedModel>& models,
                 OutputGuard& guard) {
  if (options.inputs.empty()) return;
  std::vector<std::string> ids;
  for (std::uint64_t row = 0; row < store.rows(); ++row) ids.push_back(store.id(row));
  const DescribedMeshes meshes(options.store, ids, options.inputs, options.collect);
  guard.protect(meshes.files_read());
  for (PicturedModel& model : models) {
    PlanItem item;
    item.row = model.row;
    if (meshes.add_file(item)) model.file = std::move(item);
  }
}

// The part of --memory that the sheet leaves.
std::uint64_t memory_for_pictures(const RenderOptions& options, const StoreReader& store,
                                  const ModelLook& look, std::size_t models) {
  const std::uint64_t memory = parse_bytes(options.memory), sheet = sheet_bytes(options.sheet, models),
                      least = sheet + picture_bytes(store, {}, look);
  constexpr std::uint64_t mebibyte = std::uint64_t{1} << 20;
  if (memory < least)
    throw UsageError(fmt::format(
        "--memory: {} models of {} x {} pixels need {}M or more: give it, or lower --size or --models",
        models, options.sheet.cell, options.sheet.cell, (least + mebibyte - 1) / mebibyte));
  return memory - sheet;
}

const std::string& words_of(const SheetCell& cell) { return cell.failure.empty() ? cell.note : cell.failure; }

int render_sheet(const RenderOptions& options) {
  ModelLook look = look_of(options);
  if (options.inputs.empty() && (!options.collect.root.empty() || options.collect.null_lists))
    throw UsageError("--root and --null apply to lists in INPUT: give INPUT as well");
  if (options.inputs.empty() && look.sharp_angle > 0)
    throw UsageError("--sharp-edges draws on surfaces, which a store does not hold: give INPUT as well");
  const StoreReader store(options.store, options.check);
  store.require(&Samples::normals, "`render`");
  store.require(&Samples::density, "`render`");
  look.color = coloring_named(store, options.color, "--color");
  OutputGuard guard;
  guard.protect(options.store, "the store itself");
  if (std::filesystem::path(options.output).extension() != ".png")
    throw UsageError(fmt::format("-o: `{}` should end in .png, the format of sheets", options.output));
  std::vector<PicturedModel> models = chosen_models(store, options);
  if (models.empty()) throw UsageError(fmt::format("`{}` has no rows", options.store));
  if (models.size() > std::size_t{max_models})
    throw UsageError(
        fmt::format("--item: {} models are too many for a sheet, which holds {}", models.size(), max_models));
  const std::uint64_t memory = memory_for_pictures(options, store, look, models.size());
  find_meshes(store, options, models, guard);
  guard.check(options.output, {FileKind::png}, "-o");
  const int threads = options.threads > 0 ? options.threads : oneapi::tbb::info::default_concurrency();
  const oneapi::tbb::global_control control(oneapi::tbb::global_control::max_allowed_parallelism,
                                            static_cast<std::size_t>(threads));
  std::vector<std::uint64_t> rows;
  for (const PicturedModel& model : models) rows.push_back(model.row);
  const ColorScale scale = color_scale(store, rows, look.points, look.color);
  const std::vector<SheetCell> cells =
      model_cells(store, std::move(models), scale, look, memory, static_cast<std::size_t>(threads));
  write_png(options.output, picture_sheet(cells, legend_of(scale, look.color), options.sheet));
  std::size_t alone = 0, failed = 0;
  for (const SheetCell& cell : cells) {
    failed += cell.picture.width == 0;
    alone += cell.note.starts_with("points only") || cell.note.starts_with("white space unknown");
  }
  if (options.json) {
    fmt::print("{}\n", json_object([&](JsonWriter& json) {
                 json.member("picture", options.output);
                 json.member("without_surface", std::uint64_t{alone});
                 json.member("without_points", std::uint64_t{failed});
                 json.list("models", cells, [&](const SheetCell& cell) {
                   json.member("title", cell.title);
                   json.member("note", words_of(cell));
                 });
               }));
  } else {
    fmt::print("{}: {}", options.output, counted(cells.size(), "model"));
    if (alone > 0) fmt::print(", {} without a surface", alone);
    if (failed > 0) fmt::print(", {} without points", failed);
    fmt::print("\n");
  }
  if (!options.json && look.style == SampleStyle::splats && look.surfaces)
    for (const SheetCell& cell : cells) fmt::print("{}: {}\n", cell.title, words_of(cell));
  if (options.inputs.empty() && look.style == SampleStyle::surface)
    fmt::print(stderr,
               "meander: a store holds no surfaces: give the INPUT of its run as well to draw them\n");
  return exit_done;
}

struct StyleWords {
  SampleStyle style;
  const char* name;
  const char* help;
  const char* input;  // the help of INPUT
  CommandExample examples[2];
};
const StyleWords styles[] = {
    {SampleStyle::surface,
     "sheet",
     "Draw a PNG sheet of sampled models, their samples on the surfaces",
     "Inputs of its run, for the meshes (default: samples are drawn without surfaces)",
     {{"meander render sheet store.h5 models/ -o sheet.png", "24 models of a store on their meshes"},
      {"meander render sheet store.h5 models/ -o chair.png --item chair/m12.off --size 600", "One of them"}}},
    {SampleStyle::splats,
     "splats",
     "Draw sampled models by their samples alone, as splats (PNG)",
     "Inputs of its run, to measure the white space between the splats on its meshes",
     {{"meander render splats store.h5 -o splats.png", "Six models as shaded discs"},
      {"meander render splats store.h5 -o chair.png --item chair/m12.off --cover 4",
       "One, with larger discs"}}},
    {SampleStyle::points,
     "points",
     "Draw sampled models by their samples alone, as points (PNG)",
     nullptr,
     {{"meander render points store.h5 -o points.png", "Six models"},
      {"meander render points store.h5 -o prefix.png --points 256", "The first 256 samples of each"}}}};

JobFunction add_pictures(Command& render, const StyleWords& words) {
  Command command = render.add_subcommand(words.name, words.help);
  auto options = std::make_shared<RenderOptions>();
  options->look.style = words.style;
  const bool surfaces = words.style == SampleStyle::surface;
  if (!surfaces) {
    options->models = 6;
    options->sheet.cell = 480;
  }
  for (const CommandExample& example : words.examples) command.example(example.line, example.purpose);
  command.add_option("STORE", options->store, "The store").required();
  if (words.input != nullptr) command.add_option("INPUT", options->inputs, words.input);
  command.add_option("-o,--output", options->output, "The picture, a .png file").required();
  const Option items = command.add_option("--item", options->items,
                                          "Ids or row numbers of the models (default: --models of all rows)");
  command
      .add_option("--models", options->models, "Models on the sheet, evenly spread over the rows, 1 to 400")
      .show_default()
      .range(1, max_models)
      .excludes(items);
  command.add_option("--size", options->sheet.cell, "Pixels of a model's picture, 64 to 2048")
      .show_default()
      .range(64, 2048);
  command
      .add_option("--columns", options->sheet.columns, "Pictures in a row (default: a sheet of about 4 : 3)")
      .range(1, 400);
  command
      .add_option("--points", options->look.points, "Number of samples of each model to draw, the first ones")
      .range(1, 100000000);
  add_color_option(command, options->color);
  if (surfaces)
    command
        .add_option(
            "--sharp-edges", options->look.sharp_angle,
            "Also draw the edges of the surfaces between triangles at this angle or more, in degrees, "
            "1 to 179 (default: none)")
        .range(1.0, 179.0);
  if (!surfaces) {
    SplatSizes& sizes = options->look.splats;
    if (words.style == SampleStyle::splats)
      command
          .add_option("--cover", sizes.cover,
                      "Area of a splat over that of the surface which its sample stands for, 0.05 to 16")
          .show_default()
          .range(0.05, 16.0);
    command.add_flag("--both-sides", options->look.both_sides,
                     "Also draw the inside of closed surfaces, which shows through gaps");
    command.add_flag("--round", sizes.round, "Draw anisotropic samples as discs, too");
  }
  add_view_options(command, options->up, options->view);
  add_drawing_options(command, options->memory, options->threads);
  if (words.input != nullptr) add_list_options(command, options->collect);
  add_trust_option(command, options->check);
  command.add_flag("--json", options->json, "What was drawn as JSON on standard output");
  return [options] { return render_sheet(*options); };
}

}  // namespace

JobFunction add_render_job(Command& program) {
  Command command = program.add_subcommand("render", "Draw pictures of sampled models");
  command.example("meander render sheet store.h5 models/ -o sheet.png",
                  "24 models of a store on their meshes");
  command.example("meander render turntable store.h5 -o frames", "The frames of a turning model");
  command.require_subcommand();
  std::vector<std::pair<std::string, JobFunction>> jobs;
  for (const StyleWords& words : styles) jobs.emplace_back(words.name, add_pictures(command, words));
  jobs.emplace_back("turntable", add_turntable(command));
  jobs.emplace_back("strokes", add_strokes(command));
  jobs.emplace_back("section", add_section(command));
  return [command, jobs] {
    for (const auto& [name, job] : jobs)
      if (command.chose(name)) return job();
    throw std::logic_error("a subcommand of render without a job");
  };
}

}  // namespace meander
