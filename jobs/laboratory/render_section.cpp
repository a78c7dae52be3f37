#include "jobs/laboratory/render_section.h"

#include <fmt/format.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/info.h>

#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "io/archive/model_bytes.h"
#include "io/json_writer.h"
#include "io/plot/picture_sheet.h"
#include "io/plot/png_writer.h"
#include "jobs/cli/allow_failures.h"
#include "jobs/cli/command_line.h"
#include "jobs/cli/exit_status.h"
#include "jobs/cli/option_words.h"
#include "jobs/cli/units.h"
#include "jobs/cli/usage_error.h"
#include "jobs/inputs/store_items.h"
#include "jobs/laboratory/picture_options.h"
#include "jobs/laboratory/picture_subjects.h"
#include "kernels/core/failure.h"
#include "kernels/mesh/prepare_mesh.h"
#include "kernels/render/section_picture.h"

namespace meander {

namespace {

struct SectionOptions {
  std::vector<std::string> inputs, items;
  std::string output, axis = "z", sign = "auto", memory = "4G";
  double at = 0;
  bool placed = false;  // --at was given
  SheetLook sheet;
  int threads = 0;
  InputOptions collect;
  StoreCheck check = StoreCheck::every_byte;
  bool json = false;
};

// One model's section, or why there is none.
struct DrawnSection {
  SheetCell cell;
  SignRule rule = SignRule::none;
  double at = 0, inside = 0, uncertain = 0;  // file units; shares of the picture
};

// Draws one model after the other; the loops inside are parallel.
class Sections {
 public:
  Sections(const SectionOptions& options, const PictureSubjects& subjects, std::uint64_t memory)
      : options_(options), subjects_(subjects), memory_(memory) {}

  std::vector<DrawnSection> draw() {
    std::vector<DrawnSection> drawn;
    for (std::size_t i = 0; i < subjects_.count(); ++i) {
      DrawnSection& section = drawn.emplace_back();
      section.cell.title = subjects_.name(i);
      try {
        draw_model(i, section);
      } catch (const UsageError&) {
        throw;
      } catch (...) {
        const Failure reason = current_failure("section");
        section.cell.failure = fmt::format("{}: {}", name_of(reason.status), reason.reason);
      }
      failed_ += !section.cell.failure.empty();
    }
    return drawn;
  }

  std::size_t failed() const { return failed_; }

 private:
  void draw_model(std::size_t i, DrawnSection& section) const {
    PolygonMesh file = read_model(i);
    drop_doubled_faces(file);
    const PreparedMesh mesh = prepare_mesh(file);
    const TriangleTree tree = build_triangle_tree(mesh.x, mesh.y, mesh.z, mesh.triangles);
    const OrientedSurface oriented = orient_outward(mesh);
    const std::optional<SignRule> rule =
        chosen_rule(value_of(sign_choice_words, options_.sign), mesh, tree, oriented);
    if (!rule) {
      section.cell.failure =
          fmt::format("the surface is not closed: it has {} open edges", oriented.open_edges);
      return;
    }
    SectionParameters parameters;
    parameters.axis = static_cast<std::size_t>(options_.axis.front() - 'x');
    parameters.size = options_.sheet.cell;
    const double center[3] = {mesh.center.x, mesh.center.y, mesh.center.z};
    const double middle = 0.5 * (mesh.bbox[parameters.axis] + mesh.bbox[parameters.axis + 3]);
    section.at = options_.placed ? options_.at : middle;
    parameters.at = (section.at - center[parameters.axis]) / mesh.unit;
    if (!(std::abs(parameters.at) <= farthest_point))
      throw UsageError(fmt::format("--at: {:g} is too far from `{}`", section.at, subjects_.name(i)));
    Section picture = section_picture(mesh, tree, oriented, *rule, parameters);
    section.rule = *rule;
    section.inside = picture.inside;
    section.uncertain = picture.uncertain;
    section.cell.picture = std::move(picture.picture);
    section.cell.note = fmt::format("{} = {:g}; sign {}", options_.axis, section.at, name_of(*rule));
    if (*rule != SignRule::none)
      section.cell.note += fmt::format(", {:.1f} % uncertain", 100 * section.uncertain);
  }

  PolygonMesh read_model(std::size_t i) const {
    const std::optional<PlanItem>& plan = subjects_.file(i);
    std::optional<Row> row;
    if (subjects_.stored()) {
      row = subjects_.row(i);
      if (row->report.status != Status::ok) throw ItemError(row->report.status, row->report.reason);
    }
    if (!plan) throw ItemError(Status::unreadable, "no mesh in the INPUT");
    if (!plan->known_format)
      throw ItemError(Status::unsupported_format, "the extension is not that of a known mesh format");
    require_memory(*plan);
    const ModelBytes bytes(*plan);
    if (row && bytes.content_sha256() != row->report.content_sha256)
      throw ItemError(Status::unreadable, "the mesh has changed");
    return bytes.mesh();
  }

  void require_memory(const PlanItem& plan) const {
    const MeshEstimate mesh = peek_model(plan);
    const auto triangles = static_cast<double>(mesh.triangles), vertices = static_cast<double>(mesh.vertices);
    const double bytes = static_cast<double>(mesh.file_bytes + mesh.decoding_bytes) +
                         drop_doubled_faces_bytes(triangles, 3 * triangles, vertices) +
                         prepared_bytes(triangles, vertices, true).peak + triangle_tree_bytes(triangles) +
                         orient_outward_bytes(triangles) +
                         section_picture_bytes(triangles, options_.sheet.cell);
    if (bytes > static_cast<double>(memory_))
      throw ItemError(Status::too_large,
                      fmt::format("it needs {:.0f}M beside the pictures; --memory leaves {}M",
                                  bytes / (1 << 20), memory_ >> 20));
  }

  const SectionOptions& options_;
  const PictureSubjects& subjects_;
  std::uint64_t memory_;
  std::size_t failed_ = 0;
};

Rgb color_of(SrgbColor color) { return {color[0], color[1], color[2]}; }

void print_summary(const SectionOptions& options, const std::vector<DrawnSection>& drawn,
                   std::size_t failed) {
  if (options.json) {
    fmt::print("{}\n", json_object([&](JsonWriter& json) {
                 json.member("picture", options.output);
                 json.member("failed", std::uint64_t{failed});
                 json.list("models", drawn, [&](const DrawnSection& section) {
                   json.member("title", section.cell.title);
                   if (!section.cell.failure.empty()) {
                     json.member("failure", section.cell.failure);
                     return;
                   }
                   json.member("at", section.at);
                   json.member("sign", name_of(section.rule));
                   json.member("inside", section.inside);
                   json.member("uncertain", section.uncertain);
                 });
               }));
    return;
  }
  fmt::print("{}: {}", options.output, counted(drawn.size(), "model"));
  if (failed > 0) fmt::print(", {} failed", failed);
  fmt::print("\n");
  for (const DrawnSection& section : drawn)
    fmt::print("{}: {}\n", section.cell.title,
               section.cell.failure.empty() ? section.cell.note : section.cell.failure);
}

int render_section(const SectionOptions& options) {
  if (std::filesystem::path(options.output).extension() != ".png")
    throw UsageError(fmt::format("-o: `{}` should end in .png, the format of pictures", options.output));
  OutputGuard guard;
  const PictureSubjects subjects(
      {options.inputs, options.items, options.collect, options.check}, guard,
      [&](const StoreReader&, const std::string& path) {
        if (options.inputs.size() < 2)
          throw UsageError(
              fmt::format("`{}` is a store, which holds no surfaces: give the INPUT of its run "
                          "as well",
                          path));
      });
  if (subjects.count() > max_pictures)
    throw UsageError(fmt::format("{} models are too many for a sheet, which holds {}: name fewer{}",
                                 subjects.count(), max_pictures, subjects.stored() ? " with --item" : ""));
  const std::uint64_t memory = parse_bytes(options.memory),
                      pictures =
                          std::uint64_t{options.sheet.cell} * options.sheet.cell * 6 * subjects.count();
  if (memory < pictures)
    throw UsageError(fmt::format("--memory: {} of {} x {} pixels need {}M or more: give it, or lower --size",
                                 counted(subjects.count(), "picture"), options.sheet.cell, options.sheet.cell,
                                 (pictures >> 20) + 1));
  guard.check(options.output, {FileKind::png}, "-o");
  const int threads = options.threads > 0 ? options.threads : oneapi::tbb::info::default_concurrency();
  const oneapi::tbb::global_control control(oneapi::tbb::global_control::max_allowed_parallelism,
                                            static_cast<std::size_t>(threads));
  Sections sections(options, subjects, memory - pictures);
  std::vector<DrawnSection> drawn = sections.draw();
  if (sections.failed() == drawn.size()) {
    for (const DrawnSection& section : drawn)
      fmt::print(stderr, "meander: {}: {}\n", section.cell.title, section.cell.failure);
    fmt::print(stderr, "meander: no picture was written\n");
    return exit_some_failed;
  }
  std::vector<SheetCell> cells;
  for (DrawnSection& section : drawn) {
    cells.push_back(section.cell);
    section.cell.picture = {};
  }
  const SheetLegend legend{"",
                           false,
                           "",
                           "",
                           {{color_of(section_inside), "inside"},
                            {color_of(section_outside), "outside"},
                            {color_of(section_uncertain), "uncertain"}}};
  write_png(options.output, picture_sheet(cells, legend, options.sheet));
  print_summary(options, drawn, sections.failed());
  return sections.failed() > 0 || subjects.folders_unread() ? exit_some_failed : exit_done;
}

}  // namespace

JobFunction add_section(Command& render) {
  Command command =
      render.add_subcommand("section", "Draw the signed distance from surfaces on planes through them (PNG)");
  command.example("meander render section bunny.obj -o bunny.png --axis y", "A cut through a mesh");
  command.example("meander render section store.h5 models/ -o cuts.png --item chair/m12.off --axis x",
                  "One of a store, seen along x");
  auto options = std::make_shared<SectionOptions>();
  options->sheet.cell = 480;
  command
      .add_option("INPUT", options->inputs,
                  "Meshes; or a store, followed by the inputs of its run for the meshes")
      .required();
  command.add_option("-o,--output", options->output, "The picture, a .png file").required();
  command.add_option("--item", options->items, "Ids or row numbers of models of the store (default: all)");
  command.add_option("--axis", options->axis, "The axis at right angles to the plane")
      .show_default()
      .one_of({"x", "y", "z"});
  command
      .add_option("--at", options->at,
                  "Place of the plane on the axis, in the coordinates of the file (default: the middle)")
      .on_given([&placed = options->placed] { placed = true; });
  command.add_option("--sign", options->sign, "How sides are told (auto: by the surface)")
      .show_default()
      .one_of(all_words(sign_choice_words));
  command.add_option("--size", options->sheet.cell, "Pixels of a model's picture, 64 to 2048")
      .show_default()
      .range(64, 2048);
  command
      .add_option("--columns", options->sheet.columns, "Pictures in a row (default: a sheet of about 4 : 3)")
      .range(1, static_cast<int>(max_pictures));
  add_drawing_options(command, options->memory, options->threads);
  add_list_options(command, options->collect);
  add_trust_option(command, options->check);
  command.add_flag("--json", options->json, "What was drawn as JSON on standard output");
  return with_failures_option(command, [options] { return render_section(*options); });
}

}  // namespace meander
