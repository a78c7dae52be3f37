// Figures 18 - 20: anisotropic samples as brush strokes.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "io/plot/picture_sheet.h"
#include "jobs/laboratory/figures/figure_models.h"
#include "jobs/laboratory/figures/figure_set.h"
#include "jobs/laboratory/figures/staged_model.h"
#include "jobs/laboratory/painted_model.h"
#include "kernels/render/shading.h"
#include "kernels/render/stroke_picture.h"

namespace meander {

namespace {

struct Medium {
  const char* name;
  StrokeMedium medium;
  bool many_tones;
};
constexpr std::array<Medium, 9> media = {{{"watercolour", StrokeMedium::watercolour, false},
                                          {"crayon", StrokeMedium::crayon, false},
                                          {"pencil", StrokeMedium::pencil, false},
                                          {"pencil, three tones", StrokeMedium::pencil, true},
                                          {"ink", StrokeMedium::ink, false},
                                          {"ink, three tones", StrokeMedium::ink, true},
                                          {"acrylic", StrokeMedium::acrylic, false},
                                          {"pastel", StrokeMedium::pastel, false},
                                          {"oil", StrokeMedium::oil, false}}};

struct Subject {
  const char* figure;
  FigureMesh mesh;
  std::uint32_t samples;
  Vector3 up{0, 1, 0}, view{0.55, 0.75, 1};
};

StrokePictureParameters look_of(const FigureSet& figures, const Subject& subject, const Medium& medium,
                                std::uint32_t size) {
  StrokePictureParameters look;
  look.medium = medium.medium;
  look.many_tones = medium.many_tones;
  look.width = look.height = size;
  look.up = subject.up;
  look.view = subject.view;
  look.seed = figures.seed;
  return look;
}

RgbImage crop(const RgbImage& image, std::uint32_t x, std::uint32_t y, std::uint32_t size) {
  RgbImage part(size, size);
  for (std::uint32_t row = 0; row < size; ++row)
    std::copy_n(image.pixel(x, y + row), 3 * std::size_t{size}, part.pixel(0, row));
  return part;
}

// All media on a sheet, and one from each picture at full size, where the model's middle is.
void draw_media(FigureSet& figures, const Subject& subject, const PaintedModel& model) {
  const std::uint32_t size = figures.quick ? 360 : 1080, part = size / 2;
  std::vector<SheetCell> whole, parts;
  for (const Medium& medium : media) {
    RgbImage image = stroke_picture(model.spans(), look_of(figures, subject, medium, size));
    SheetCell detail;
    detail.picture = crop(image, size / 4, size / 4, part);
    detail.title = medium.name;
    parts.push_back(std::move(detail));
    SheetCell cell;
    cell.picture = std::move(image);
    cell.title = medium.name;
    whole.push_back(std::move(cell));
  }
  SheetLook sheet;
  sheet.columns = 3;
  sheet.cell = size;
  sheet.text_size = figures.quick ? 14 : 26;
  const std::string stem = fmt::format("figure{}_{}", subject.figure, subject.mesh.name);
  figures.picture(stem + "_media", picture_sheet(whole, {}, sheet),
                  fmt::format("{}, {} samples, in all media", subject.mesh.name, subject.samples));
  sheet.cell = part;
  figures.picture(stem + "_crops", picture_sheet(parts, {}, sheet),
                  "The middle of each, a pixel of the picture for a pixel");
}

// Share of the model's picture that no stroke of the body reaches, and the spread of how often a pixel is
// painted: strokes of full cover that leave a mark each.
struct Coverage {
  double bare = 0, spread = 0;
};
Coverage coverage_of(const StrokePlan& plan) {
  StrokeStyle style = plan.style;
  style.glaze = true;
  style.grain = style.granulation = style.edge = style.impasto = 0;
  style.paper = PaperKind::smooth;
  style.paper_colour = {1, 1, 1};
  const float mark = std::exp(-0.25f);
  std::vector<Stroke> body;
  for (Stroke stroke : plan.strokes) {
    if (stroke.layer >= plan.style.layers.size() ||
        plan.style.layers[stroke.layer].purpose != LayerPurpose::body)
      continue;
    stroke.opacity = 1;
    stroke.colour = {mark, mark, mark};
    body.push_back(stroke);
  }
  const RgbImage image = paint_strokes(body, plan.brushes, style, plan.canvas, LatticeNoise(picture_key(1)));
  double pixels = 0, bare = 0, sum = 0, squares = 0;
  for (std::uint32_t y = 0; y < image.height; ++y)
    for (std::uint32_t x = 0; x < image.width; ++x) {
      if (!plan.depth.covered(x, y)) continue;
      // 1/4 for every stroke; paper has a little relief.
      const double marks = -4 * std::log(std::max(1e-4, double{linear_light(image.pixel(x, y)[1])}));
      ++pixels;
      bare += marks < 0.25;
      sum += marks;
      squares += marks * marks;
    }
  const double mean = sum / std::max(1.0, pixels);
  return {bare / std::max(1.0, pixels),
          std::sqrt(std::max(0.0, squares / std::max(1.0, pixels) - mean * mean)) / mean};
}

// The same strokes from independent and from low-discrepancy samples.
void draw_random_beside(FigureSet& figures, const Subject& subject, const Model& staged,
                        const SampleParameters& parameters, const EmbreeDevice& device) {
  const std::uint32_t size = figures.quick ? 360 : 900;
  constexpr std::array<std::size_t, 3> shown = {1, 4, 6};  // of `media`
  std::vector<SheetCell> cells;
  Table table{{{"samples"}, {"medium"}, {"bare %", 3}, {"spread of cover", 3}}, {}};
  for (const std::size_t m : shown)
    for (const SequenceKind sequence : {SequenceKind::random, SequenceKind::shifted}) {
      SampleParameters sampled = parameters;
      sampled.place.sequence = sequence;
      // A quarter: gaps show where samples are few.
      const Row row = sampled_row(staged, sampled, subject.samples / 4, figures.seed, device);
      const PaintedModel model = painted_model(staged.surface, row);
      const StrokePictureParameters look = look_of(figures, subject, media[m], size);
      const StrokePlan plan = plan_strokes(model.spans(), look);
      const Coverage cover = coverage_of(plan);
      const char* name = sequence == SequenceKind::random ? "random" : "low discrepancy";
      table.rows.push_back({name, media[m].name, 100 * cover.bare, cover.spread});
      SheetCell cell;
      cell.picture = paint_strokes(plan.strokes, plan.brushes, plan.style, plan.canvas,
                                   LatticeNoise(picture_key(look.seed)));
      cell.title = fmt::format("{}, {} samples", media[m].name, name);
      // Ink leaves the light bare on purpose.
      cell.note = has_tones(look.medium)
                      ? fmt::format("cover varies by {:.0f} % of its mean", 100 * cover.spread)
                      : fmt::format("{:.1f} % of the model without a stroke of the body", 100 * cover.bare);
      cells.push_back(std::move(cell));
    }
  SheetLook sheet;
  sheet.columns = 2;
  sheet.cell = size;
  sheet.text_size = figures.quick ? 14 : 22;
  const std::string stem = fmt::format("figure{}_{}_samples", subject.figure, subject.mesh.name);
  figures.picture(
      stem, picture_sheet(cells, {}, sheet),
      fmt::format("{} strokes from random and from low-discrepancy samples", subject.samples / 4));
  figures.table(stem,
                "Pixels of the model that no stroke of the body covers, and standard deviation over mean of "
                "how often one is covered",
                table);
}

void draw_subject(FigureSet& figures, const Subject& subject) {
  figures.begin(fmt::format("Figure {}: {} in strokes", subject.figure, subject.mesh.name));
  figures.attempt(subject.mesh.name, [&] {
    const EmbreeDevice device;
    const SampleParameters parameters = painted_samples(subject.samples, figures.seed);
    const Model staged = staged_model(subject.mesh, parameters);
    const Row row = sampled_row(staged, parameters, subject.samples, figures.seed, device);
    draw_media(figures, subject, painted_model(staged.surface, row));
    draw_random_beside(figures, subject, staged, parameters, device);
    figures.note(fmt::format("  {} in strokes", subject.mesh.name));
  });
}

}  // namespace

void draw_strokes(FigureSet& figures) {
  const std::uint32_t detail = figures.quick ? 1 : 2, share = figures.quick ? 4 : 1;
  draw_subject(figures, {"18", knot_mesh(200 * detail, 24 * detail), 30000 / share});
  draw_subject(figures, {"19", eight_mesh(200 * detail, 24 * detail), 20000 / share});
  for (const FigureMesh& mesh : figures.meshes)
    draw_subject(figures, {"20", mesh, 35000 / share, figures.up, figures.view});
}

}  // namespace meander
