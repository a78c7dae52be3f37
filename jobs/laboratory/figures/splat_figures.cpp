// Figures 7, 9, 11 and 17: samples as splats, chosen for a view, and along a tensor.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "io/plot/picture_sheet.h"
#include "jobs/laboratory/figures/figure_set.h"
#include "jobs/laboratory/figures/staged_model.h"
#include "jobs/laboratory/viewed_model.h"
#include "kernels/analyse/curve_chains.h"
#include "kernels/locate/embree_locator.h"
#include "kernels/model/sampler.h"
#include "kernels/render/sampled_surface.h"
#include "kernels/sample/point_frames.h"

namespace meander {

namespace {

constexpr SrgbColour figure_dot = {196, 62, 28};
constexpr Vector3 front{0.55, 0.42, 1}, upwards{0, 1, 0};

std::uint32_t cell_size(const FigureSet& figures) { return figures.quick ? 240 : 440; }

Row row_of(const FigureMesh& mesh, SampleParameters parameters, std::uint32_t count, std::uint64_t seed) {
  set_samples(parameters, count);
  parameters.seed = seed;
  Row row = Sampler(parameters).sample(mesh.positions, mesh.faces);
  if (row.report.status != Status::ok) throw ItemError(row.report.status, row.report.reason);
  return row;
}

RgbImage splats_on(const Row& row, const SplatView& view, const SplatSizes& sizes) {
  std::vector<float> half_axes = splat_half_axes(row, sample_areas(row, row.samples.count()), sizes);
  return draw_splats(splats_of(row, half_axes, {&splat_colour, 1}, view), view, {.backs = !is_closed(row)})
      .image;
}

SplatView fitted_row(const Row& row, Vector3 towards, std::uint32_t size) {
  return fitted_view(row.samples.points, towards, upwards, size, size);
}

SurfacePictureParameters surface_of(std::uint32_t size, Vector3 towards) {
  SurfacePictureParameters look;
  look.size = size;
  look.margin = 0.05;
  look.view = towards;
  return look;
}

// The mesh without anything on it, in the colour of splats.
RgbImage rendered_model(const FigureMesh& mesh, std::uint32_t size) {
  return surface_picture(
      {mesh.positions, mesh.faces, std::vector<SrgbColour>(mesh.faces.size() / 3, splat_colour)},
      surface_of(size, front));
}

RgbImage sample_dots(const FigureMesh& mesh, const Row& row, std::uint32_t size) {
  const std::size_t count = row.samples.count();
  std::vector<double> points;
  for (std::size_t i = 0; i < count; ++i) {
    const Vector3 p = file_point(row.report, row.samples.points, i);
    points.insert(points.end(), {p.x, p.y, p.z});
  }
  const double radius = 0.25 * std::sqrt(row.report.area / static_cast<double>(count));
  return sampled_surface_picture(
      {mesh.positions, mesh.faces, points, row.samples.normals, {&figure_dot, 1}, {&radius, 1}},
      surface_of(size, front));
}

// ---- figure 7: from the mesh to splats --------------------------------------------------------------------

Vector3 vertex_of(const FigureMesh& mesh, std::uint32_t v) {
  return {mesh.positions[3 * v], mesh.positions[3 * v + 1], mesh.positions[3 * v + 2]};
}

RgbImage mesh_edges(const FigureMesh& mesh, std::uint32_t size) {
  SurfaceScene scene{mesh.positions, mesh.faces, {}};
  // Edges of fine meshes would leave nothing of the surface to be seen.
  const bool fine = mesh.faces.size() > 60000;
  const double width = fine ? 0.4 : 0.7;
  const SrgbColour colour = fine ? SrgbColour{165, 170, 180} : SrgbColour{70, 80, 95};
  for (std::size_t f = 0; f < mesh.faces.size(); f += 3)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = mesh.faces[f + k], b = mesh.faces[f + (k + 1) % 3];
      if (a < b) scene.lines.push_back({vertex_of(mesh, a), vertex_of(mesh, b), width, colour});
    }
  return surface_picture(scene, surface_of(size, front));
}

// The charts of the method `conformal` and their curves.
struct ChartedCurve {
  Model model;
  std::vector<std::vector<CurveChain>> chains;  // by chart

  const PreparedMesh& mesh() const { return model.coarse.empty() ? model.surface : model.coarse.mesh; }
};

ChartedCurve charted_curve(const FigureMesh& mesh, std::uint32_t count) {
  SampleParameters parameters = parameters_for("conformal");
  set_samples(parameters, count);
  parameters.locator.curve.leaves_per_sample = 1;
  ChartedCurve result{staged_model(mesh, parameters), {}};
  Model& model = result.model;
  model.trees = build_curves(result.mesh(), model.charts,
                             model.coarse.empty() ? model.measure.masses : model.coarse.masses,
                             parameters.locator, model.cancel);
  const CurveTree none;
  for (std::size_t c = 0; c < model.charts.size(); ++c)
    result.chains.push_back(
        curve_chains(result.mesh(), model.charts[c], c < model.trees.size() ? model.trees[c] : none, 8));
  return result;
}

double leaves_in(const ChartedCurve& curve, std::size_t chart) {
  const std::vector<CurveTree>& trees = curve.model.trees;
  return chart < trees.size() ? static_cast<double>(std::max<std::size_t>(1, trees[chart].leaf_count())) : 1;
}

RgbImage curve_on_surface(const FigureMesh& mesh, const ChartedCurve& curve, std::uint32_t size) {
  SurfaceScene scene{mesh.positions, mesh.faces, {}};
  for (std::size_t c = 0; c < curve.chains.size(); ++c)
    for (const CurveChain& chain : curve.chains[c])
      for (std::size_t i = 0; i + 1 < chain.position.size(); ++i)
        scene.lines.push_back(
            {to_file(curve.mesh(), chain.position[i]), to_file(curve.mesh(), chain.position[i + 1]), 1.5,
             srgb(map_colour(ColourMap::lagoon, 0.8 * chain.along[i] / leaves_in(curve, c)))});
  return surface_picture(scene, surface_of(size, front));
}

std::vector<PlanarDrawing> chart_and_curve(const ChartedCurve& curve) {
  std::size_t largest = 0;
  for (std::size_t c = 0; c < curve.model.charts.size(); ++c)
    if (curve.model.charts[c].report.area > curve.model.charts[largest].report.area) largest = c;
  const FlatChart& chart = curve.model.charts[largest];
  PlanarDrawing edges, line;
  edges.caption = fmt::format("the chart, {} triangles", chart.cut.triangle_count());
  edges.frame = line.frame = false;
  for (std::uint32_t h = 0; h < chart.cut.triangles.size(); ++h) {
    if (chart.cut.opposite[h] != no_index && chart.cut.opposite[h] < h) continue;
    const std::uint32_t a = chart.cut.triangles[h], b = chart.cut.triangles[next_half_edge(h)];
    PlanarPolyline edge;
    edge.x = {chart.u[a], chart.u[b]};
    edge.y = {chart.v[a], chart.v[b]};
    edge.width = chart.cut.opposite[h] == no_index ? 1.2 : 0.35;
    if (chart.cut.opposite[h] == no_index) line.lines.push_back(edge);
    edges.lines.push_back(std::move(edge));
  }
  line.caption = "the curve in the plane";
  for (PlanarPolyline& edge : line.lines) edge.colour = {150, 150, 150};
  for (const CurveChain& chain : curve.chains[largest])
    for (std::size_t i = 0; i + 1 < chain.u.size(); i += 8) {
      PlanarPolyline piece;
      piece.width = 0.9;
      piece.colour = map_colour(ColourMap::lagoon, 0.8 * chain.along[i] / leaves_in(curve, largest));
      for (std::size_t k = i; k < std::min(i + 9, chain.u.size()); ++k) {
        piece.x.push_back(chain.u[k]);
        piece.y.push_back(chain.v[k]);
      }
      line.lines.push_back(std::move(piece));
    }
  return {std::move(edges), std::move(line)};
}

void draw_one_way(FigureSet& figures, const FigureMesh& mesh) {
  const std::uint32_t size = cell_size(figures), samples = 1024;
  const ChartedCurve curve = charted_curve(mesh, samples);
  const SampleParameters parameters = parameters_for("conformal");
  std::vector<SheetCell> cells;
  cells.push_back({mesh_edges(mesh, size), "the mesh", fmt::format("{} triangles", mesh.faces.size() / 3)});
  cells.push_back({curve_on_surface(mesh, curve, size), "the curve on it", ""});
  const std::uint32_t most = figures.quick ? 4096 : 65536;
  const SplatView view = fitted_view(row_of(mesh, parameters, most, figures.seed).samples.points, front,
                                     upwards, size, size, 0.1);
  for (const std::uint32_t count : {1024u, most / 256, most / 64, most / 16, most / 4, most}) {
    const Row row = row_of(mesh, parameters, count, figures.seed);
    const bool dots = cells.size() == 2;
    if (dots)
      cells.push_back({sample_dots(mesh, row, size), "samples", fmt::format("{}", count)});
    else
      cells.push_back({splats_on(row, view, {}), "splats", fmt::format("{}", count)});
  }
  SheetLook sheet;
  sheet.cell = size;
  sheet.columns = 4;
  figures.picture("figure07_" + mesh.name, picture_sheet(cells, {}, sheet),
                  mesh.name + ": mesh, curve, samples, and splats of more and more samples");
  PanelGrid grid;
  grid.panel_width = grid.panel_height = 420;
  figures.drawing("figure07_" + mesh.name + "_chart", svg_panels(chart_and_curve(curve), grid),
                  mesh.name + ": the chart, and the curve over it");
}

// ---- figure 9: splats beside the model --------------------------------------------------------------------

void draw_one_splatted(FigureSet& figures, const FigureMesh& mesh) {
  const std::uint32_t size = cell_size(figures), count = figures.quick ? 2000 : 8000;
  std::vector<SheetCell> cells;
  cells.push_back(
      {rendered_model(mesh, size), "the model", fmt::format("{} triangles", mesh.faces.size() / 3)});
  for (const DensityKind density : {DensityKind::uniform, DensityKind::mean}) {
    SampleParameters parameters = parameters_for("conformal");
    parameters.density.kind = density;
    const Row row = row_of(mesh, parameters, count, figures.seed);
    const char* const title = density == DensityKind::uniform ? "uniform" : "by mean curvature";
    const SplatView view = fitted_row(row, front, size);
    cells.push_back({splats_on(row, view, {0.7, false}), title, fmt::format("{} splats, cover 0.7", count)});
    cells.push_back({splats_on(row, view, {}), title, fmt::format("{} splats, cover 4", count)});
  }
  SheetLook sheet;
  sheet.cell = size;
  sheet.columns = 5;
  figures.picture("figure09_" + mesh.name, picture_sheet(cells, {}, sheet),
                  mesh.name + ": rendered from its triangles, and by its samples alone");
}

// ---- figure 11: detail for a view -------------------------------------------------------------------------

struct Turn {
  TurnCounts counts;
  double behind = 0;  // mean share of the samples that face away
};

Turn turned_samples(const ViewedModel& model, int steps) {
  Turn turned;
  for (int k = 0; k <= steps; ++k) {
    const double angle = 0.0349065850398866 * k;  // two degrees
    const Vector3 towards{std::sin(angle), 0.3, std::cos(angle)};
    ViewDetail detail = model.detail(towards);
    turned.behind += model.behind(detail, towards) / (steps + 1);
    turned.counts.add(std::move(detail.kept));
  }
  return turned;
}

// The samples kept for one direction, as points, seen from another.
RgbImage kept_points(const Row& row, const ViewDetail& detail, const SplatView& view) {
  std::vector<float> centres, normals;
  for (const std::uint32_t i : detail.kept)
    for (std::size_t k = 3 * std::size_t{i}; k < 3 * std::size_t{i} + 3; ++k) {
      centres.push_back(row.samples.points[k]);
      normals.push_back(row.samples.normals[k]);
    }
  const std::vector<float> half_axes(2 * detail.kept.size(), static_cast<float>(1.3 / view.scale));
  return draw_splats({centres, normals, {}, half_axes, {&figure_dot, 1}}, view, {.hollows = 0}).image;
}

void draw_one_view(FigureSet& figures, const FigureMesh& mesh, Table& table) {
  const std::uint32_t size = cell_size(figures), all = figures.quick ? 10000 : 150000;
  const Row row = row_of(mesh, parameters_for("auto"), all, figures.seed);
  const ViewedModel model(row, {}, 0);
  SplatView view = turning_view(row.samples.points, front, upwards, size, size);
  const ViewDetail detail = model.detail(view.back);
  std::vector<SheetCell> cells;
  const std::string count = fmt::format("{} of {} samples", detail.kept.size(), all);
  cells.push_back({rendered_model(mesh, size), "the model", ""});
  cells.push_back({kept_points(row, detail, view), "samples for this view", count});
  SplatView side = view;
  turn(side, {1, 0.42, -0.55}, upwards);
  cells.push_back(
      {kept_points(row, detail, side), "the same from the side", "a margin behind the silhouette"});
  cells.push_back({model.draw(detail, view, {}), "their splats", count});
  SheetLook sheet;
  sheet.cell = size;
  sheet.columns = 4;
  figures.picture("figure11_" + mesh.name, picture_sheet(cells, {}, sheet),
                  mesh.name + ": dense along the silhouette of one view");
  const Turn turned = turned_samples(model, figures.quick ? 30 : 180);
  table.rows.push_back({mesh.name, all, turned.counts.fewest, turned.counts.most, 100 * turned.behind,
                        100 * turned.counts.median(), 100 * turned.counts.worst()});
}

// ---- figure 17: splats along a tensor ---------------------------------------------------------------------

constexpr std::array<Vector3, 6> white_space_views = {
    {{0.55, 0.42, 1}, {-1, 0.3, 0.2}, {0.3, 0.2, -1}, {1, 0.5, -0.2}, {0.2, 1, 0.3}, {-0.3, -0.9, 0.5}}};

// Percent, the mean over the views.
double mean_white_space(const FigureMesh& mesh, const Row& row, const SplatSizes& sizes, std::uint32_t size) {
  std::vector<double> positions(mesh.positions.size());
  for (std::size_t k = 0; k < positions.size(); ++k)
    positions[k] = (mesh.positions[k] - row.report.loc[k % 3]) / row.report.scale;
  double sum = 0;
  for (const Vector3& towards : white_space_views) {
    const SplatView view = fitted_row(row, towards, size);
    std::vector<float> half_axes = splat_half_axes(row, sample_areas(row, row.samples.count()), sizes);
    const OrientedSplats splats = splats_of(row, half_axes, {&splat_colour, 1}, view);
    sum += white_space(splats, view, surface_depth(positions, mesh.faces, view)).share();
  }
  return 100 * sum / static_cast<double>(white_space_views.size());
}

void draw_one_tensor(FigureSet& figures, const FigureMesh& mesh, Table& table) {
  const std::uint32_t size = cell_size(figures), many = figures.quick ? 2000 : 20000,
                      few = figures.quick ? 500 : 2000, pixels = figures.quick ? 200 : 512;
  const SplatSizes once{2, false}, round{2, true};
  for (const bool balanced : {false, true}) {
    SampleParameters isotropic = parameters_for(balanced ? "auto" : "conformal"),
                     anisotropic = parameters_for("anisotropic");
    if (balanced) anisotropic.order = ElementOrder::balanced;
    const Row even = row_of(mesh, isotropic, many, figures.seed),
              along = row_of(mesh, anisotropic, many, figures.seed);
    table.rows.push_back(
        {mesh.name, balanced ? "balanced" : "Hilbert", many, mean_white_space(mesh, even, once, pixels),
         mean_white_space(mesh, along, once, pixels), mean_white_space(mesh, along, round, pixels)});
  }
  std::vector<SheetCell> cells;
  for (const double cover : {0.8, 4.0})
    for (const char* method : {"conformal", "anisotropic"}) {
      const Row row = row_of(mesh, parameters_for(method), few, figures.seed);
      cells.push_back({splats_on(row, fitted_row(row, front, size), {cover, false}),
                       std::string_view(method) == "conformal" ? "isotropic" : "anisotropic",
                       fmt::format("{} splats, cover {:g}", few, cover)});
    }
  SheetLook sheet;
  sheet.cell = size;
  sheet.columns = 4;
  figures.picture("figure17_" + mesh.name, picture_sheet(cells, {}, sheet),
                  mesh.name + ": discs, and ellipses of the same total area");
}

}  // namespace

void draw_from_mesh_to_splats(FigureSet& figures) {
  figures.begin("Figure 7: from the mesh to splats");
  for (const FigureMesh& mesh : figures.meshes)
    figures.attempt(mesh.name, [&] { draw_one_way(figures, mesh); });
  figures.text(
      "Shown",
      "A mesh, its conformal chart, the Hilbert curve over the chart and on the surface, 1,024 samples "
      "along it, and the surface drawn by samples alone: each a disc of four times the area that it "
      "stands for, blended where they overlap.");
}

void draw_splats_beside_models(FigureSet& figures) {
  figures.begin("Figure 9: models drawn by their samples");
  for (const FigureMesh& mesh : figures.meshes)
    figures.attempt(mesh.name, [&] { draw_one_splatted(figures, mesh); });
  figures.text("Shown",
               "The model rendered from its triangles, and as many splats with uniform density and with that "
               "of mean curvature, small and apart, then large enough to cover the surface.");
}

void draw_view_detail(FigureSet& figures) {
  figures.begin("Figure 11: detail for a view");
  Table table{{{"mesh"}, {"samples"}, {"fewest"}, {"most"}, {"behind %", 1}, {"stay %", 1}, {"worst", 1}},
              {}};
  for (const FigureMesh& mesh : figures.meshes)
    figures.attempt(mesh.name, [&] { draw_one_view(figures, mesh, table); });
  figures.table(
      "figure11_turning",
      "A turn in steps of two degrees: samples of a view, and how many of them the next one keeps (median)",
      table);
  figures.text("Measured",
               "Weight 0.1 + 0.9 (1 - |n.v|)^4, on the back (1 - |n.v| / 0.35)^2 as far as n.v = -0.35 and "
               "nothing beyond, the number by the projected area. Every "
               "view keeps those of one progressive set whose place in it is below their weight, so that no "
               "sample moves when the view does.");
  figures.text("The survey", "Weights the density by the silhouette and samples each view anew.");
}

void draw_tensor_splats(FigureSet& figures) {
  figures.begin("Figure 17: isotropic and anisotropic splats");
  Table table{{{"mesh"},
               {"order"},
               {"splats"},
               {"isotropic %", 2},
               {"anisotropic %", 2},
               {"discs at anisotropic samples %", 2}},
              {}};
  for (const FigureMesh& mesh : figures.meshes)
    figures.attempt(mesh.name, [&] { draw_one_tensor(figures, mesh, table); });
  figures.table(
      "figure17_white_space",
      "White space: pixels of the visible surface that no splat covers, mean of six views; the total "
      "area of the splats is twice that of the surface",
      table);
  figures.text(
      "Measured",
      "Discs at isotropic samples, and ellipses along the curvature at anisotropic ones, of the same "
      "number, order and total area.");
  figures.text("The survey", "Anisotropic splats leave less white space.");
}

}  // namespace meander
