// Figures 1, 3, 4 (plane) and 5: point sets in the unit square.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "jobs/laboratory/figures/figure_set.h"
#include "kernels/analyse/discrepancy_plane.h"
#include "kernels/analyse/discrepancy_star.h"
#include "kernels/analyse/slope_fit.h"
#include "kernels/curve/curve_point.h"
#include "kernels/pointset/planar_points.h"
#include "kernels/surface/sample_surface.h"
#include "kernels/surface/surface.h"

namespace meander {

namespace {

constexpr std::uint32_t exact_star_limit = 1u << 14;
constexpr std::uint32_t slow_method_limit = 1u << 14;

bool is_slow(PlanarMethod method) {
  return method == PlanarMethod::poisson_disk || method == PlanarMethod::lloyd;
}

double star_discrepancy(const PlanarPoints& points, std::uint64_t seed) {
  if (points.count() <= exact_star_limit) return star_discrepancy_exact(points.x, points.y);
  StarSearchParameters search;
  search.seed = seed;
  return star_discrepancy_search(points.x, points.y, search);
}

struct PlaneErrors {
  std::vector<ErrorSeries> boxes, triangles, circles;
};

void measure_sets(const std::string& name, const std::vector<std::uint32_t>& counts, std::uint32_t runs,
                  const ShapeParameters& shapes,
                  const std::function<PlanarPoints(std::uint32_t count, std::uint64_t seed)>& make,
                  PlaneErrors& errors) {
  ErrorSeries boxes{name, {}, {}}, triangles{name, {}, {}}, circles{name, {}, {}};
  for (const std::uint32_t count : counts) {
    for (ErrorSeries* series : {&boxes, &triangles, &circles}) {
      series->counts.push_back(count);
      series->runs.emplace_back();
    }
    for (std::uint32_t run = 0; run < runs; ++run) {
      const PlanarPoints points = make(count, shapes.seed + run);
      boxes.runs.back().push_back(star_discrepancy(points, shapes.seed));
      triangles.runs.back().push_back(
          triangle_discrepancy(build_point_index(points.x, points.y), shapes).discrepancy);
      circles.runs.back().push_back(quarter_circle_discrepancy(points.x, points.y));
    }
  }
  errors.boxes.push_back(std::move(boxes));
  errors.triangles.push_back(std::move(triangles));
  errors.circles.push_back(std::move(circles));
}

ShapeParameters shapes_of(const FigureSet& figures) {
  ShapeParameters shapes;
  shapes.shapes = figures.quick ? 512 : 4096;
  shapes.seed = figures.seed;
  shapes.stable_rise = 0;  // the same number for every method and count
  return shapes;
}

}  // namespace

void draw_point_sets(FigureSet& figures) {
  figures.begin("Figure 1: point sets in the unit square");
  std::vector<PlanarDrawing> drawings;
  for (const PlanarMethod method : {PlanarMethod::random, PlanarMethod::jittered, PlanarMethod::halton,
                                    PlanarMethod::hammersley, PlanarMethod::sobol, PlanarMethod::poisson_disk,
                                    PlanarMethod::hilbert_stratified, PlanarMethod::hilbert_shifted}) {
    PlanarPoints points = planar_points(method, 1024, figures.seed);
    PlanarDrawing drawing;
    drawing.caption = std::string(name_of(method));
    drawing.dots.push_back({std::move(points.x), std::move(points.y), 1.6, {0, 0, 0}, {}});
    drawings.push_back(std::move(drawing));
  }
  figures.drawing("figure01_point_sets", svg_panels(drawings), "1,024 points each");
  figures.text("Measured", "Sets of 1,024 points as each method gives them.");
  figures.text(
      "The survey",
      "Random points clump; low-discrepancy sets fill the square evenly, with visible regular structure in "
      "Halton, Hammersley and Sobol sets; stratified points along a Hilbert curve are even without it.");
}

void draw_curves(FigureSet& figures) {
  figures.begin("Figure 3: space-filling curves");
  std::vector<PlanarDrawing> drawings;
  const auto draw = [&](CurveKind kind, int level, const char* caption) {
    const int branching = kind == CurveKind::hilbert ? 4 : 9;
    std::uint64_t cells = 1;
    for (int l = 0; l < level; ++l) cells *= static_cast<std::uint64_t>(branching);
    PlanarPolyline line;
    line.along = true;
    line.width = 1.6;
    for (std::uint64_t rank = 0; rank < cells; ++rank) {
      const CurvePoint p = curve_cell_centre(kind, rank, level);
      line.x.push_back(p.u);
      line.y.push_back(p.v);
    }
    PlanarDrawing drawing;
    drawing.caption = caption;
    drawing.lines.push_back(std::move(line));
    drawings.push_back(std::move(drawing));
  };
  draw(CurveKind::hilbert, 5, "Hilbert, level 5");
  draw(CurveKind::peano, 3, "Peano, level 3");
  draw(CurveKind::peano_meander, 3, "Peano-meander, level 3");
  figures.drawing("figure03_curves", svg_panels(drawings),
                  "Coloured from the start (dark) to the end (light)");
  figures.text("Measured", "Cell centres of one level joined in curve order.");
  figures.text(
      "The survey",
      "Shows Hilbert, Peano and an alternative Peano construction; which alternative it drew could not be "
      "told from its text: the Peano-meander is the one with entry and exit on the same edge.");
}

void draw_plane_discrepancy(FigureSet& figures) {
  figures.begin("Figure 4, plane: discrepancy of point sets in the unit square");
  const ShapeParameters shapes = shapes_of(figures);
  const std::uint32_t most = figures.quick ? 12288 : 1572864, runs = 3;
  PlaneErrors errors;
  for (const PlanarMethod method :
       {PlanarMethod::random, PlanarMethod::hilbert_stratified, PlanarMethod::hilbert_shifted,
        PlanarMethod::jittered, PlanarMethod::halton, PlanarMethod::hammersley, PlanarMethod::sobol,
        PlanarMethod::poisson_disk, PlanarMethod::lloyd}) {
    const std::uint32_t limit =
        is_slow(method) ? std::min(most, figures.quick ? 1024u : slow_method_limit) : most;
    figures.note(fmt::format("  {} to {} points", name_of(method), limit));
    measure_sets(
        std::string(name_of(method)), survey_counts(limit), is_deterministic(method) ? 1 : runs, shapes,
        [&](std::uint32_t count, std::uint64_t seed) { return planar_points(method, count, seed); }, errors);
  }
  const double to = figures.quick ? 12288 : 1572864;
  const std::vector<double> shown = {1024, 4096, 12288};
  figures.plot("figure04_plane_boxes",
               error_plot("Boxes anchored at the origin", errors.boxes, "discrepancy"),
               fmt::format("Exact to {} points, above a search from 2^14 random boxes (a lower bound)",
                           exact_star_limit));
  figures.plot("figure04_plane_triangles", error_plot("Triangles", errors.triangles, "discrepancy"),
               fmt::format("{} triangles with a corner at the origin, the same for all", shapes.shapes));
  figures.plot("figure04_plane_circles", error_plot("Quarter circles", errors.circles, "discrepancy"),
               "Exact over radii up to 1");
  figures.table("figure04_plane_boxes_slopes", "Boxes: slopes from 16 points",
                slope_table(errors.boxes, 16, shown));
  figures.table("figure04_plane_triangles_slopes", "Triangles: slopes from 16 points",
                slope_table(errors.triangles, 16, shown));
  figures.table("figure04_plane_circles_slopes", "Quarter circles: slopes from 16 points",
                slope_table(errors.circles, 16, shown));
  figures.text(
      "Measured",
      fmt::format("N = 2^l and 1.5 x 2^l to {}, means of {} runs (one for deterministic sets), error bars "
                  "of one standard error, least-squares slopes in log-log.",
                  to, runs));
  figures.text("The survey",
               "Stratified sampling along a Hilbert curve equals the best sets on quarter circles, beats "
               "low-discrepancy sets on triangles and is worse on boxes.");

  figures.begin("Figure 4, placement: at curve vertices and inside elements");
  PlaneErrors placement;
  const std::uint32_t limit = figures.quick ? 3072 : 12288;
  for (const double leaves : {1.0, 4.0, 16.0, 64.0}) {
    PlanarParameters parameters;
    parameters.leaves_per_point = leaves;
    measure_sets(
        fmt::format("vertex, {} leaves a point", leaves), survey_counts(limit, 16), runs, shapes,
        [&](std::uint32_t count, std::uint64_t seed) {
          return planar_points(PlanarMethod::hilbert_vertex, count, seed, parameters);
        },
        placement);
  }
  measure_sets(
      "inside the element", survey_counts(limit, 16), runs, shapes,
      [&](std::uint32_t count, std::uint64_t seed) {
        return planar_points(PlanarMethod::hilbert_stratified, count, seed);
      },
      placement);
  figures.plot("figure04_placement",
               error_plot("Placement: boxes at the origin", placement.boxes, "discrepancy"),
               "Hilbert stratified, exact");
  figures.table("figure04_placement_slopes", "Slopes from 16 points",
                slope_table(placement.boxes, 16, {1024, static_cast<double>(limit)}));
  figures.text("Measured",
               "Samples moved to centres of curve leaves are quantised: 64 leaves a sample are needed "
               "before the error is nearly that of a point inside its element.");
  figures.text("The survey", "Places every sample at a vertex of the curve.");
}

void draw_density_discrepancy(FigureSet& figures) {
  figures.begin("Figure 5: densities in the plane");
  const ShapeParameters shapes = shapes_of(figures);
  const std::uint32_t most = figures.quick ? 3072 : 98304, runs = 3;
  const auto plane = make_surface("plane");
  struct Case {
    PlanarDensity density;
    const char* expression;
    const char* title;
  };
  std::vector<PlanarDrawing> drawings;
  for (const Case& c : {Case{PlanarDensity::squares, "x2y2", "x^2 y^2"},
                        Case{PlanarDensity::waves, "cos3sin3", "cos 3x sin 3y cos xy + 1"},
                        Case{PlanarDensity::product_wave, "cos10", "cos 10xy + 1"}}) {
    std::vector<ErrorSeries> all;
    for (const SequenceKind sequence :
         {SequenceKind::random, SequenceKind::stratified, SequenceKind::shifted}) {
      const char* const name = sequence == SequenceKind::random       ? "random"
                               : sequence == SequenceKind::stratified ? "hilbert-stratified"
                                                                      : "hilbert-shifted";
      ErrorSeries series{name, {}, {}};
      for (const std::uint32_t count : survey_counts(most, 16)) {
        series.counts.push_back(count);
        series.runs.emplace_back();
        for (std::uint32_t run = 0; run < runs; ++run) {
          SurfaceSampleParameters parameters;
          parameters.samples = count;
          parameters.seed = figures.seed + run;
          parameters.sequence = sequence;
          parameters.tolerance = 1e-5;
          parameters.density = {SurfaceDensityKind::expression, c.expression, 0.02, 1, 0.99};
          const SurfaceSamples samples = sample_surface(*plane, parameters);
          std::vector<double> x, y;
          for (std::size_t i = 0; i < samples.count(); ++i) {
            x.push_back(samples.uv[2 * i]);
            y.push_back(samples.uv[2 * i + 1]);
          }
          series.runs.back().push_back(
              density_box_discrepancy(build_point_index(x, y), c.density, shapes).discrepancy);
          if (count == 2048 && run == 0 && sequence == SequenceKind::shifted)
            drawings.push_back({c.title, 0, 1, 0, 1, false, true, {}, {{x, y, 1.3, {0, 0, 0}, {}}}});
        }
      }
      all.push_back(std::move(series));
    }
    const std::string stem = fmt::format("figure05_{}", c.expression);
    figures.plot(stem, error_plot(fmt::format("Density {}", c.title), all, "discrepancy"),
                 fmt::format("{} boxes at the origin with exact measures", shapes.shapes));
    figures.table(stem + "_slopes", fmt::format("{}: slopes from 16 points", c.title),
                  slope_table(all, 16, {1024}));
  }
  figures.drawing("figure05_samples", svg_panels(drawings), "2,048 samples, shifted sequence");
  figures.text("Measured", "Boxes anchored at the origin against the exact integral of the density.");
  figures.text("The survey", "The rate of the uniform case carries over to varying densities.");
}

}  // namespace meander
