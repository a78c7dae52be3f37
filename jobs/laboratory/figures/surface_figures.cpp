// Figures 2, 6, 8 and the sphere of figure 4: parametric surfaces.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "io/plot/picture_sheet.h"
#include "jobs/laboratory/figures/figure_set.h"
#include "kernels/analyse/discrepancy_sphere.h"
#include "kernels/analyse/slope_fit.h"
#include "kernels/pointset/sphere_points.h"
#include "kernels/render/splat_picture.h"
#include "kernels/surface/sample_surface.h"
#include "kernels/surface/surface.h"

namespace meander {

namespace {

// The curve through the leaf centres, in the parameter square.
PlanarDrawing draw_curve(const SurfaceCurve& curve, std::string caption) {
  PlanarDrawing drawing;
  drawing.caption = std::move(caption);
  PlanarPolyline line;
  line.along = true;
  for (std::size_t i = 0; i < curve.mass.size(); ++i) {
    line.x.push_back(curve.uv[2 * i]);
    line.y.push_back(curve.uv[2 * i + 1]);
  }
  drawing.lines.push_back(std::move(line));
  return drawing;
}

// The same curve on the surface, seen along (1, 0.6, 0.8).
PlanarDrawing draw_curve_on(const ParametricSurface& surface, const SurfaceCurve& curve,
                            std::string caption) {
  std::vector<double> u, v;
  for (std::size_t i = 0; i < curve.mass.size(); ++i) {
    u.push_back(curve.uv[2 * i]);
    v.push_back(curve.uv[2 * i + 1]);
  }
  std::vector<Vector3> positions(u.size());
  surface.positions(u, v, positions);
  const double length = std::sqrt(1 + 0.36 + 0.64), flat = std::sqrt(1 + 0.36);
  const Vector3 towards{1 / length, 0.6 / length, 0.8 / length}, right{-0.6 / flat, 1 / flat, 0};
  const Vector3 up = cross(towards, right);
  PlanarDrawing drawing;
  drawing.caption = std::move(caption);
  drawing.fit = true;
  drawing.frame = false;
  PlanarPolyline line;
  line.along = true;
  line.width = 0.8;
  for (const Vector3& p : positions) {
    line.x.push_back(dot(p, right));
    line.y.push_back(dot(p, up));
  }
  drawing.lines.push_back(std::move(line));
  return drawing;
}

}  // namespace

void draw_stretched_plane(FigureSet& figures) {
  figures.begin("Figure 2: extreme stretch, u -> u^8");
  const auto surface = make_surface("stretched-plane");
  std::vector<PlanarDrawing> drawings;
  for (const bool reparameterise : {false, true}) {
    SurfaceSampleParameters parameters;
    parameters.samples = 256;
    parameters.seed = figures.seed;
    parameters.leaves_per_sample = 1;
    parameters.reparameterise = reparameterise;
    const SurfaceCurve curve = build_surface_curve(*surface, parameters);
    drawings.push_back(
        draw_curve(curve, reparameterise ? "reparameterised: parameters" : "as given: parameters"));
    PlanarDrawing on_surface =
        draw_curve(curve, reparameterise ? "reparameterised: surface" : "as given: surface");
    for (double& x : on_surface.lines.front().x) x = std::pow(x, 8);
    parameters.samples = 1024;
    const SurfaceSamples samples = sample_surface(*surface, parameters);
    DotSet dots;
    dots.radius = 1.3;
    for (std::size_t i = 0; i < samples.count(); ++i) {
      dots.x.push_back(samples.points[3 * i]);
      dots.y.push_back(samples.points[3 * i + 1]);
    }
    drawings.push_back(std::move(on_surface));
    PlanarDrawing points;
    points.caption = reparameterise ? "reparameterised: 1,024 samples" : "as given: 1,024 samples";
    points.dots.push_back(std::move(dots));
    drawings.push_back(std::move(points));
  }
  PanelGrid grid;
  grid.columns = 3;
  figures.drawing("figure02_stretched_plane", svg_panels(drawings, grid),
                  "Leaves of about equal area, joined in curve order");
  figures.text("Measured",
               "The curve of 256 leaves over the given parameters (above) and over the square warped by "
               "the cumulative area of rows, then of columns (below), and samples of both.");
  figures.text("The survey",
               "Adaptive refinement copes with stretch until machine precision ends it; a "
               "reparameterisation balances the tree (its right panel).");
}

void draw_surfaces(FigureSet& figures) {
  figures.begin("Figure 6: sampled parametric surfaces");
  struct Case {
    const char* name;
    std::uint32_t samples;
    SurfaceDensityKind density;
    const char* label;
  };
  constexpr Case cases[] = {
      {"sphere", 3000, SurfaceDensityKind::uniform, "sphere 3000"},
      {"torus", 3000, SurfaceDensityKind::uniform, "torus 3000"},
      {"monkey-saddle", 3000, SurfaceDensityKind::uniform, "monkey saddle 3000"},
      {"eight", 10000, SurfaceDensityKind::uniform, "eight 10000"},
      {"klein-bottle", 6000, SurfaceDensityKind::uniform, "Klein bottle 6000"},
      {"torus", 3000, SurfaceDensityKind::gaussian, "torus Gaussian curvature"},
      {"monkey-saddle", 3000, SurfaceDensityKind::max, "saddle max curvature"},
      {"eight", 10000, SurfaceDensityKind::mean, "eight mean curvature"},
  };
  std::vector<SurfaceSamples> samples;
  std::vector<SheetCell> cells;
  SplatParameters look;
  look.up = {0, 0, 1};
  look.view = {1, 0.6, 0.8};
  for (const Case& c : cases) {
    SurfaceSampleParameters parameters;
    parameters.samples = c.samples;
    parameters.seed = figures.seed;
    parameters.density.kind = c.density;
    parameters.density.floor = 0.05;
    samples.push_back(sample_surface(*make_surface(c.name), parameters));
  }
  for (std::size_t i = 0; i < samples.size(); ++i)
    cells.push_back(
        {splat_picture(samples[i].points, samples[i].normals, samples[i].area, look), cases[i].label, ""});
  SheetLook sheet;
  sheet.cell = look.size;
  sheet.columns = 4;
  figures.picture("figure06_surfaces", picture_sheet(cells, {}, sheet), "Every sample is a bead");
  figures.text("Measured",
               "Samples of one-patch surfaces, uniform and by curvature, in shifted sequence; seams, poles "
               "and the pinch of the eight show neither gaps nor crowds.");
  figures.text("The survey", "Samples the monkey saddle with 3,000 and the eight with 10,000 points.");
}

void draw_adaptive_curve(FigureSet& figures) {
  figures.begin("Figure 8: uniform and adaptive curve");
  const auto surface = make_surface("eight");
  SurfaceSampleParameters parameters;
  parameters.seed = figures.seed;
  parameters.leaves_per_sample = 1;
  parameters.samples = 1024;
  const SurfaceCurve adaptive = build_surface_curve(*surface, parameters);
  SurfaceCurve uniform;
  uniform.tree = curve_root(CurveKind::hilbert);
  for (int level = 0; level < 5; ++level)
    uniform.tree = refine(uniform.tree, std::vector<std::uint8_t>(uniform.tree.leaf_count(), 1));
  uniform.mass.assign(uniform.tree.leaf_count(), 1.0 / static_cast<double>(uniform.tree.leaf_count()));
  for (std::size_t i = 0; i < uniform.tree.leaf_count(); ++i) {
    uniform.uv.push_back(uniform.tree.u[i] + 0.5 * uniform.tree.side[i]);
    uniform.uv.push_back(uniform.tree.v[i] + 0.5 * uniform.tree.side[i]);
  }
  const std::vector<PlanarDrawing> drawings = {
      draw_curve(uniform, "uniform: parameters"), draw_curve_on(*surface, uniform, "uniform: surface"),
      draw_curve(adaptive, fmt::format("adaptive: parameters, {} leaves", adaptive.mass.size())),
      draw_curve_on(*surface, adaptive, "adaptive: surface")};
  PanelGrid grid;
  grid.columns = 2;
  figures.drawing("figure08_adaptive_curve", svg_panels(drawings, grid), "The surface `eight`");
  figures.text("Measured",
               "A Hilbert curve of 1,024 equal cells, and one refined until no cell has more than 1/1024 "
               "of the area.");
  figures.text("The survey",
               "The uniform curve crowds where the map shrinks; the adaptive one covers the surface "
               "evenly.");
}

void draw_sphere_discrepancy(FigureSet& figures) {
  figures.begin("Figure 4, sphere: discrepancy of point sets on the sphere");
  ShapeParameters triangles, axes;
  triangles.shapes = figures.quick ? 512 : 4096;
  triangles.seed = axes.seed = figures.seed;
  triangles.stable_rise = axes.stable_rise = 0;
  axes.shapes = 200;
  const std::uint32_t most = figures.quick ? 3072 : 196608, runs = 3;
  std::vector<ErrorSeries> cap_errors, triangle_errors;
  const auto measure = [&](const std::string& name, std::uint32_t run_count, const auto& make) {
    figures.note("  " + name);
    ErrorSeries caps{name, {}, {}}, spherical{name, {}, {}};
    for (const std::uint32_t count : survey_counts(most, 16)) {
      caps.counts.push_back(count);
      spherical.counts.push_back(count);
      caps.runs.emplace_back();
      spherical.runs.emplace_back();
      for (std::uint32_t run = 0; run < run_count; ++run) {
        const SpherePoints points = make(count, figures.seed + run);
        caps.runs.back().push_back(cap_discrepancy(points.x, points.y, points.z, axes).discrepancy);
        spherical.runs.back().push_back(
            spherical_triangle_discrepancy(build_point_index(points.x, points.y, points.z), triangles)
                .discrepancy);
      }
    }
    cap_errors.push_back(std::move(caps));
    triangle_errors.push_back(std::move(spherical));
  };
  for (const SphereMethod method :
       {SphereMethod::random, SphereMethod::hilbert_stratified, SphereMethod::hilbert_shifted,
        SphereMethod::hammersley, SphereMethod::fibonacci, SphereMethod::spiral})
    measure(std::string(name_of(method)), is_deterministic(method) ? 1 : runs,
            [&](std::uint32_t count, std::uint64_t seed) { return sphere_points(method, count, seed); });
  const auto sphere = make_surface("sphere");
  measure("surface sampler", runs, [&](std::uint32_t count, std::uint64_t seed) {
    SurfaceSampleParameters parameters;
    parameters.samples = count;
    parameters.seed = seed;
    const SurfaceSamples samples = sample_surface(*sphere, parameters);
    SpherePoints points;
    for (std::size_t i = 0; i < samples.count(); ++i) {
      points.x.push_back(samples.points[3 * i]);
      points.y.push_back(samples.points[3 * i + 1]);
      points.z.push_back(samples.points[3 * i + 2]);
    }
    return points;
  });
  figures.plot("figure04_sphere_caps", error_plot("Spherical caps", cap_errors, "discrepancy"),
               fmt::format("Exact over heights for {} random axes, the same for all", axes.shapes));
  figures.plot("figure04_sphere_triangles", error_plot("Spherical triangles", triangle_errors, "discrepancy"),
               fmt::format("{} random triangles, the same for all", triangles.shapes));
  figures.table("figure04_sphere_caps_slopes", "Caps: slopes from 16 points",
                slope_table(cap_errors, 16, {1024, static_cast<double>(std::min(most, 4096u))}));
  figures.table("figure04_sphere_triangles_slopes", "Triangles: slopes from 16 points",
                slope_table(triangle_errors, 16, {1024, static_cast<double>(std::min(most, 4096u))}));
  figures.text("Measured",
               "Hilbert sets are planar sets on the equal-area cylinder map; the surface sampler knows "
               "only the formula of the sphere.");
  figures.text("The survey",
               "As well as methods made for the sphere. That holds for the slope; the constant is "
               "larger.");
}

}  // namespace meander
