#include "jobs/laboratory/turntable_job.h"

#include <fmt/format.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/info.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <numbers>
#include <string>
#include <utility>

#include "io/json_writer.h"
#include "io/plot/png_writer.h"
#include "jobs/cli/command_line.h"
#include "jobs/cli/exit_status.h"
#include "jobs/cli/output_guard.h"
#include "jobs/cli/units.h"
#include "jobs/cli/usage_error.h"
#include "jobs/inputs/store_items.h"
#include "jobs/laboratory/colored_samples.h"
#include "jobs/laboratory/picture_options.h"
#include "jobs/laboratory/viewed_model.h"

namespace meander {

namespace {

namespace fs = std::filesystem;

struct TurntableOptions {
  std::string store, output, item, color = "plain", up = "y", memory = "4G";
  std::uint32_t frames = 180, samples = 0, width = 640, height = 480;
  double step = 2, from = 30, elevation = 20;
  int threads = 0;
  bool both_sides = false, json = false;
  SplatSizes sizes;
  StoreCheck check = StoreCheck::every_byte;
};

// The names of frames: by a pattern with one %d or %04d, or frame-0000.png ... in a folder.
class FrameNames {
 public:
  explicit FrameNames(const std::string& output) : in_folder_(output.find('%') == std::string::npos) {
    if (in_folder_) {
      before_ = (fs::path(output) / "frame-").string();
      width_ = 4;
      after_ = ".png";
      return;
    }
    const std::size_t at = output.find('%');
    std::size_t end = at + 1;
    while (end < output.size() && output[end] >= '0' && output[end] <= '9') ++end;
    const std::string digits = output.substr(at + 1, end - at - 1);
    const bool width = digits.empty() || (digits.size() == 2 && digits[0] == '0' && digits[1] > '0');
    after_ = end < output.size() ? output.substr(end + 1) : "";
    if (end >= output.size() || output[end] != 'd' || !width || after_.find('%') != std::string::npos ||
        !after_.ends_with(".png"))
      throw UsageError(fmt::format(
          "-o: `{}` is neither a folder nor a pattern of file names like turn/frame-%04d.png", output));
    before_ = output.substr(0, at);
    width_ = digits.empty() ? 1 : digits[1] - '0';
  }
  bool in_folder() const { return in_folder_; }
  fs::path name(std::uint32_t frame) const {
    return fmt::format("{}{:0{}}{}", before_, frame, width_, after_);
  }

 private:
  bool in_folder_;
  std::string before_, after_;
  int width_ = 0;
};

std::uint64_t turned_row(const StoreReader& store, const TurntableOptions& options) {
  if (!options.item.empty()) {
    const std::uint64_t row = find_item(store, options.item);
    const ItemReport report = store.report(row);
    if (report.status != Status::ok)
      throw UsageError(fmt::format("--item: `{}` has no samples: {}: {}", store.id(row),
                                   name_of(report.status), report.reason));
    return row;
  }
  for (std::uint64_t row = 0; row < store.rows(); ++row)
    if (store.report(row).status == Status::ok) return row;
  throw UsageError(fmt::format("`{}` has no row with samples", options.store));
}

// The memory of a picture with its sums, the row, its normals by component, the splats of a frame, and tiles.
void check_memory(const TurntableOptions& options, const StoreReader& store) {
  constexpr std::uint64_t pixel_bytes = 48, sample_bytes = 320, mebibyte = std::uint64_t{1} << 20;
  const std::uint64_t needed =
      pixel_bytes * options.width * options.height + sample_bytes * store.samples() + 8 * mebibyte;
  if (parse_bytes(options.memory) < needed)
    throw UsageError(fmt::format("--memory: {} samples and {} x {} pixels need {}M or more", store.samples(),
                                 options.width, options.height, (needed + mebibyte - 1) / mebibyte));
}

// The direction from the model to the eye; angles are in degrees, 0 being the front.
Vector3 turned_direction(Vector3 up, double azimuth, double elevation) {
  const double degree = std::numbers::pi / 180, around = azimuth * degree, above = elevation * degree;
  const Vector3 front = up.y > 0 ? Vector3{0, 0, 1} : up.z > 0 ? Vector3{0, -1, 0} : Vector3{0, 0, 1};
  const Vector3 side = cross(up, front);
  return std::cos(above) * (std::cos(around) * front + std::sin(around) * side) + std::sin(above) * up;
}

int render_turntable(const TurntableOptions& options) {
  const StoreReader store(options.store, options.check);
  const FrameNames names(options.output);
  if (store.order() != "progressive")
    throw UsageError(
        fmt::format("`{}` is in order of the curve: views are thinned from samples in progressive order, the "
                    "default of `run`",
                    options.store));
  store.require(&Samples::normals, "`render turntable`");
  store.require(
      store.columns().tensors ? column_of(&Samples::tensor_direction) : column_of(&Samples::density),
      "`render turntable`");
  check_memory(options, store);
  const SampleColoring coloring = coloring_named(store, options.color, "--color");
  OutputGuard guard;
  guard.protect(options.store, "the store itself");
  if (names.in_folder()) guard.check_folder(options.output, "-o");
  for (std::uint32_t frame = 0; frame < options.frames; ++frame)
    guard.check(names.name(frame), {FileKind::png}, "-o", Existing::replace, names.in_folder());
  const std::uint64_t number = turned_row(store, options);
  const Row row = store.read_row(number);
  if (names.in_folder()) fs::create_directories(options.output);
  const int threads = options.threads > 0 ? options.threads : oneapi::tbb::info::default_concurrency();
  const oneapi::tbb::global_control control(oneapi::tbb::global_control::max_allowed_parallelism,
                                            static_cast<std::size_t>(threads));
  ViewDetailParameters detail;
  detail.both_sides = options.both_sides;
  if (options.samples > row.samples.count())
    fmt::print(stderr, "meander: --samples {}: the model has {} in the store, all of them are drawn\n",
               options.samples, row.samples.count());
  const ViewedModel model(row, detail, options.samples);
  const ColorScale scale = color_scale(store, {&number, 1}, 0, coloring);
  const std::vector<SrgbColor> colors =
      colors_of(row.samples, store.label(number), row.samples.count(), coloring, scale, splat_color);
  const Vector3 up = axis_of(options.up);
  SplatView view = turning_view(row.samples.points, turned_direction(up, options.from, options.elevation), up,
                                options.width, options.height);
  TurnCounts counts;
  double behind = 0;
  for (std::uint32_t frame = 0; frame < options.frames; ++frame) {
    turn(view, turned_direction(up, options.from + frame * options.step, options.elevation), up);
    ViewDetail kept = model.detail(view.back);
    write_png(names.name(frame), model.draw(kept, view, options.sizes, colors));
    behind += model.behind(kept, view.back) / options.frames;
    counts.add(std::move(kept.kept));
  }
  if (options.json) {
    fmt::print("{}\n", json_object([&](JsonWriter& json) {
                 json.member("frames", std::uint64_t{options.frames});
                 json.member("output", options.output);
                 json.member("item", store.id(number));
                 json.member("fewest_samples", std::uint64_t{counts.fewest});
                 json.member("most_samples", std::uint64_t{counts.most});
                 if (counts.steps()) {
                   json.member("median_share_kept", counts.median());
                   json.member("least_share_kept", counts.worst());
                 }
                 json.member("share_behind", behind);
               }));
    return exit_done;
  }
  fmt::print("{}: {} frames of {}, {} to {} samples each\n", options.output, options.frames, store.id(number),
             counts.fewest, counts.most);
  if (const auto legend = legend_of(scale, coloring))
    fmt::print("{}{}\n", legend->title,
               legend->bar ? fmt::format(": {} (violet) to {} (yellow)", legend->low, legend->high) : "");
  if (counts.steps())
    fmt::print(
        "From frame to frame {:.1f} % of the samples stay (median), {:.1f} % in the worst frame; none "
        "moves\n",
        100 * counts.median(), 100 * counts.worst());
  if (behind > 0 && !options.both_sides)
    fmt::print(
        "{:.0f} % of a frame's samples lie just behind the silhouette, where they come and go unseen\n",
        100 * behind);
  return exit_done;
}

}  // namespace

JobFunction add_turntable(Command& render) {
  Command command = render.add_subcommand(
      "turntable", "Draw frames (PNG) of a turning model, its samples chosen for each view");
  command.example("meander render turntable store.h5 -o frames", "frames/frame-0000.png and so on");
  command.example("meander render turntable store.h5 -o frames --item chair/m12.off --frames 36 --step 10",
                  "A full turn of one model in 36 frames");
  auto options = std::make_shared<TurntableOptions>();
  command.add_option("STORE", options->store, "The store, in progressive order").required();
  command
      .add_option("-o,--output", options->output,
                  "A folder for frame-0000.png ..., or a pattern of names like frame-%04d.png")
      .required();
  command.add_option("--item", options->item,
                     "Id or row number of the model (default: the first with samples)");
  command.add_option("--frames", options->frames, "Frames, 1 to 3600").show_default().range(1, 3600);
  command.add_option("--step", options->step, "Degrees that the model turns from frame to frame, -180 to 180")
      .show_default()
      .range(-180.0, 180.0);
  command.add_option("--from", options->from, "Angle of the first frame, in degrees from the front")
      .show_default()
      .range(-360.0, 360.0);
  command
      .add_option("--elevation", options->elevation,
                  "Height of the eye, in degrees above the horizon, -85 to 85")
      .show_default()
      .range(-85.0, 85.0);
  command
      .add_option(
          "--samples", options->samples,
          "Samples to draw, on average over all views: a view in which the model looks larger has more "
          "(default: as many as leave out none along the silhouette)")
      .range(1, 100000000);
  command.add_flag(
      "--both-sides", options->both_sides,
      "Also draw samples that face away from the eye: for models whose normals do not all point outward");
  command.add_option("--up", options->up, "The axis of the model that points up, about which it turns")
      .show_default()
      .one_of({"x", "y", "z"});
  add_color_option(command, options->color);
  command.add_option("--width", options->width, "Width of a frame in pixels, 64 to 4096")
      .show_default()
      .range(64, 4096);
  command.add_option("--height", options->height, "Height of a frame in pixels, 64 to 4096")
      .show_default()
      .range(64, 4096);
  command
      .add_option(
          "--cover", options->sizes.cover,
          "Size of the splats: their area over the area of surface that a sample stands for, 0.05 to 16")
      .show_default()
      .range(0.05, 16.0);
  command.add_flag("--round", options->sizes.round, "Draw discs instead of ellipses for anisotropic samples");
  add_drawing_options(command, options->memory, options->threads);
  add_trust_option(command, options->check);
  command.add_flag("--json", options->json, "What was drawn as JSON on standard output");
  return [options] { return render_turntable(*options); };
}

}  // namespace meander
