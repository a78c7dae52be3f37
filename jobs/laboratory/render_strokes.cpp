#include "jobs/laboratory/render_strokes.h"

#include <fmt/format.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/info.h>

#include <algorithm>
#include <charconv>
#include <iterator>
#include <memory>
#include <optional>

#include "io/file_kind.h"
#include "io/json_writer.h"
#include "io/plot/picture_sheet.h"
#include "io/plot/png_writer.h"
#include "jobs/cli/allow_failures.h"
#include "jobs/cli/command_line.h"
#include "jobs/cli/exit_status.h"
#include "jobs/cli/output_guard.h"
#include "jobs/cli/units.h"
#include "jobs/cli/usage_error.h"
#include "jobs/inputs/input_options.h"
#include "jobs/inputs/store_items.h"
#include "jobs/laboratory/painted_model.h"
#include "jobs/laboratory/picture_options.h"
#include "jobs/laboratory/picture_subjects.h"
#include "kernels/core/failure.h"
#include "pipeline/memory_estimate.h"

namespace meander {

namespace {

constexpr std::uint32_t sampled_strokes = 20000;
constexpr const char* british_watercolor = "watercolour";

struct StrokesOptions {
  std::vector<std::string> inputs, items, media = {"oil"};
  std::string output, tones = "one", palette, size = "1080", up = "y", view, light, memory = "4G";
  std::uint32_t strokes = 0, columns = 0;
  int threads = 0;
  InputOptions collect;
  StrokePictureParameters look;
  StoreCheck check = StoreCheck::every_byte;
  bool json = false;
};

template <class Names>
std::size_t position_of(const Names& names, const std::string& word) {
  return static_cast<std::size_t>(std::find(std::begin(names), std::end(names), word) - std::begin(names));
}

// "1080" or "1920x1080".
void parse_picture_size(const std::string& text, StrokePictureParameters& look) {
  const std::size_t cross = text.find('x');
  const auto side = [&](const std::string& digits) {
    std::uint32_t value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (error != std::errc() || end != digits.data() + digits.size() || value < 64 || value > 8192)
      throw UsageError(fmt::format(
          "--size: `{}` is not a size: give the pixels of a side, or WIDTHxHEIGHT, each 64 to 8192", text));
    return value;
  };
  look.width = side(text.substr(0, cross));
  look.height = cross == std::string::npos ? look.width : side(text.substr(cross + 1));
}

StrokePictureParameters strokes_look(const StrokesOptions& options) {
  StrokePictureParameters look = options.look;
  parse_picture_size(options.size, look);
  if (!options.palette.empty())
    look.palette = static_cast<StrokePalette>(position_of(stroke_palette_names, options.palette));
  look.up = axis_of(options.up);
  look.view = view_of(options.view, options.up);
  if (!options.light.empty()) look.light = parse_direction("--light", options.light);
  if (!(norm(look.light) > 0)) throw UsageError("--light must not be 0,0,0");
  return look;
}

std::vector<StrokeMedium> media_of(const StrokesOptions& options) {
  std::vector<StrokeMedium> media;
  for (const std::string& word : options.media) {
    if (word == british_watercolor) {
      media.push_back(StrokeMedium::watercolor);
      continue;
    }
    const std::size_t at = position_of(stroke_medium_names, word);
    if (at < stroke_medium_names.size()) {
      media.push_back(static_cast<StrokeMedium>(at));
      continue;
    }
    for (std::size_t k = 0; k < stroke_medium_names.size(); ++k)
      media.push_back(static_cast<StrokeMedium>(k));
  }
  if (options.tones == "multi" && std::none_of(media.begin(), media.end(), has_tones))
    throw UsageError("--tones: only ink and pencil have several tones");
  return media;
}

void require_directions(const StoreReader& store, const std::string& path) {
  if (!store.columns().tensors)
    throw UsageError(
        fmt::format("`{}` has no directions for strokes: make it with `meander run --method anisotropic`, "
                    "or give the meshes instead of it",
                    path));
  store.require(&Samples::tensor_direction, "`render strokes`");
  store.require(&Samples::normals, "`render strokes`");
}

// Paints one model after the other in all media; the loops inside are parallel.
class Paintings {
 public:
  Paintings(const StrokesOptions& options, const PictureSubjects& subjects, std::uint64_t memory)
      : options_(options),
        subjects_(subjects),
        look_(strokes_look(options)),
        media_(media_of(options)),
        memory_(memory),
        sampling_(painted_samples(options.strokes > 0 ? options.strokes : sampled_strokes, look_.seed)) {}

  std::vector<SheetCell> paint() {
    std::vector<SheetCell> cells;
    for (std::size_t i = 0; i < subjects_.count(); ++i) paint_model(i, cells);
    return cells;
  }

  std::size_t failed() const { return failed_; }
  std::size_t lacking() const { return lacking_; }

 private:
  void paint_model(std::size_t i, std::vector<SheetCell>& cells) {
    std::string note, failure;
    PaintedModel model;
    try {
      model = read(i, note);
    } catch (const UsageError&) {
      throw;
    } catch (...) {
      const Failure reason = current_failure("strokes");
      failure = fmt::format("{}: {}", name_of(reason.status), reason.reason);
      ++failed_;
    }
    lacking_ += !note.empty();
    for (const StrokeMedium medium : media_) {
      SheetCell cell;
      cell.title = subjects_.name(i);
      cell.note =
          media_.size() > 1 ? std::string(stroke_medium_names[static_cast<std::size_t>(medium)]) : note;
      cell.failure = failure;
      if (failure.empty()) {
        StrokePictureParameters look = look_;
        look.medium = medium;
        look.many_tones = options_.tones == "multi" && has_tones(medium);
        cell.picture = stroke_picture(model.spans(), look);
      }
      cells.push_back(std::move(cell));
    }
  }

  PaintedModel read(std::size_t i, std::string& note) {
    require_memory(i);
    if (subjects_.stored()) {
      PaintedModel model = stored_model(subjects_.row(i), subjects_.file(i), options_.strokes, note);
      if (!note.empty()) note = "on discs: " + note;
      return model;
    }
    if (!device_) device_.emplace();
    return sampled_file(*subjects_.file(i), sampling_, *device_);
  }

  void require_memory(std::size_t i) const {
    std::uint64_t bytes = 0;
    const std::optional<PlanItem>& file = subjects_.file(i);
    SampleParameters sampling = sampling_;
    if (subjects_.stored()) sampling.samples = subjects_.samples();
    MeshEstimate mesh;
    if (file && file->known_format) {
      mesh = peek_model(*file);
      bytes += estimate_bytes(mesh, sampling, std::max(1, options_.threads));
    }
    bytes += stroke_picture_bytes(sampling.samples, look_.width, look_.height);
    if (bytes > memory_)
      throw ItemError(Status::too_large, fmt::format("it needs {}M beside the pictures; --memory leaves {}M",
                                                     bytes >> 20, memory_ >> 20));
  }

  const StrokesOptions& options_;
  const PictureSubjects& subjects_;
  StrokePictureParameters look_;
  std::vector<StrokeMedium> media_;
  std::uint64_t memory_;
  SampleParameters sampling_;
  std::optional<EmbreeDevice> device_;
  std::size_t failed_ = 0, lacking_ = 0;
};

// The part of --memory that the finished pictures and their sheet leave.
std::uint64_t memory_beside_pictures(const StrokesOptions& options, const StrokePictureParameters& look,
                                     std::size_t pictures) {
  const std::uint64_t memory = parse_bytes(options.memory),
                      finished = std::uint64_t{look.width} * look.height * 6 * pictures,
                      least = finished + stroke_picture_bytes(1, look.width, look.height);
  if (memory < least)
    throw UsageError(
        fmt::format("--memory: pictures ({}) of {} x {} pixels need {}M or more: give it, or lower --size",
                    pictures, look.width, look.height, (least >> 20) + 1));
  return memory - finished;
}

void write_pictures(const StrokesOptions& options, const StrokePictureParameters& look,
                    std::vector<SheetCell>& cells) {
  if (cells.size() == 1) {
    write_png(options.output, cells.front().picture);
    return;
  }
  SheetLook sheet;
  sheet.cell = look.width;
  sheet.columns = options.columns;
  write_png(options.output, picture_sheet(cells, {}, sheet));
}

int render_strokes(const StrokesOptions& options) {
  const StrokePictureParameters look = strokes_look(options);
  if (std::filesystem::path(options.output).extension() != ".png")
    throw UsageError(fmt::format("-o: `{}` should end in .png, the format of pictures", options.output));
  OutputGuard guard;
  const PictureSubjects subjects({options.inputs, options.items, options.collect, options.check}, guard,
                                 require_directions);
  const std::size_t pictures = subjects.count() * media_of(options).size();
  if (pictures > max_pictures)
    throw UsageError(fmt::format("{} pictures are too many for a sheet, which holds {}: name fewer models{}",
                                 pictures, max_pictures, subjects.stored() ? " with --item" : ""));
  if (pictures > 1 && (look.width != look.height || look.width > 2048))
    throw UsageError("--size: several pictures are put on a sheet, and need a square of at most 2048 pixels");
  if (pictures == 1 && options.columns > 0)
    throw UsageError("--columns applies to several pictures: leave it out for one");
  const std::uint64_t memory = memory_beside_pictures(options, look, pictures);
  guard.check(options.output, {FileKind::png}, "-o");
  const int threads = options.threads > 0 ? options.threads : oneapi::tbb::info::default_concurrency();
  const oneapi::tbb::global_control control(oneapi::tbb::global_control::max_allowed_parallelism,
                                            static_cast<std::size_t>(threads));
  Paintings paintings(options, subjects, memory);
  std::vector<SheetCell> cells = paintings.paint();
  if (cells.size() == 1 && !cells.front().failure.empty()) {
    fmt::print(stderr, "meander: {}: {}; no picture was written\n", cells.front().title,
               cells.front().failure);
    return exit_some_failed;
  }
  write_pictures(options, look, cells);
  const int status = paintings.failed() > 0 || subjects.folders_unread() ? exit_some_failed : exit_done;
  if (options.json) {
    fmt::print("{}\n", json_object([&](JsonWriter& json) {
                 json.member("picture", options.output);
                 json.member("pictures", std::uint64_t{cells.size()});
                 json.member("models", std::uint64_t{subjects.count()});
                 json.member("without_surface", std::uint64_t{paintings.lacking()});
                 json.member("failed", std::uint64_t{paintings.failed()});
               }));
    return status;
  }
  fmt::print("{}: {} picture{} of {} model{}", options.output, cells.size(), cells.size() == 1 ? "" : "s",
             subjects.count(), subjects.count() == 1 ? "" : "s");
  if (paintings.lacking() > 0) fmt::print(", {} without a surface", paintings.lacking());
  if (paintings.failed() > 0) fmt::print(", {} failed", paintings.failed());
  fmt::print("\n");
  return status;
}

void add_look_options(Command& command, StrokesOptions& options) {
  std::vector<std::string> media(stroke_medium_names.begin(), stroke_medium_names.end());
  media.emplace_back("all");
  command
      .add_option("--medium", options.media,
                  "Medium to paint with; several, separated by commas, for a sheet")
      .show_default("oil")
      .separator(',')
      .one_of(media, {british_watercolor});
  command.add_option("--tones", options.tones, "Ink and pencil: one tone, or three (multi)")
      .show_default()
      .one_of({"one", "multi"});
  command.add_option("--palette", options.palette, "Colors (default: those of the medium)")
      .one_of({stroke_palette_names.begin(), stroke_palette_names.end()});
  command
      .add_option("--strokes", options.strokes,
                  "Samples to paint, 1 to 10000000 (default: 20000 of a mesh, all of a store)")
      .range(1, 10000000);
  command.add_option("--size", options.size, "Pixels: SIDE or WIDTHxHEIGHT, 64 to 8192 each").show_default();
  command
      .add_option("--columns", options.columns,
                  "Pictures in a row, for several (default: a sheet of about 4 : 3)")
      .range(1, static_cast<int>(max_pictures));
  add_view_options(command, options.up, options.view);
  command.add_option(
      "--light", options.light,
      "Direction towards the light, as the eye sees it: RIGHT,UP,NEAR (default: -0.6,0.62,0.5)");
  command.add_option("--margin", options.look.margin, "Unpainted border, share of the smaller side, 0 to 0.3")
      .show_default()
      .range(0.0, 0.3);
  command
      .add_option("--seed", options.look.seed,
                  "Seed of the samples of meshes and of the brushes, 0 to 2^64 - 1")
      .show_default();
}

}  // namespace

JobFunction add_strokes(Command& render) {
  Command command = render.add_subcommand("strokes", "Paint models in brush strokes (PNG)");
  command.example("meander render strokes bunny.obj -o bunny.png", "A mesh in oil");
  command.example("meander render strokes bunny.obj -o sheet.png --medium oil,ink,pencil", "In three media");
  auto options = std::make_shared<StrokesOptions>();
  command
      .add_option("INPUT", options->inputs,
                  "Meshes, which are sampled first; or a store of `run --method anisotropic`, followed by "
                  "the inputs of its run for the meshes (default: strokes without surfaces)")
      .required();
  command.add_option("-o,--output", options->output, "The picture, a .png file").required();
  command.add_option("--item", options->items, "Ids or row numbers of models of the store (default: all)");
  add_look_options(command, *options);
  add_drawing_options(command, options->memory, options->threads);
  add_list_options(command, options->collect);
  add_trust_option(command, options->check);
  command.add_flag("--json", options->json, "What was painted as JSON on standard output");
  return with_failures_option(command, [options] { return render_strokes(*options); });
}

}  // namespace meander
