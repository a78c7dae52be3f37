// Figures 12 - 14: tensor fields, their segments and charts, and the samples that follow them.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "io/plot/coloured_ply.h"
#include "io/plot/text_painter.h"
#include "io/table/csv_writer.h"
#include "jobs/laboratory/figures/figure_set.h"
#include "jobs/laboratory/figures/staged_model.h"
#include "kernels/analyse/curve_chains.h"
#include "kernels/locate/embree_locator.h"
#include "kernels/model/sampler.h"
#include "kernels/render/surface_picture.h"
#include "kernels/tensor/singularities.h"

namespace meander {

namespace {

// Ratio 1: pale green, the largest ratio: dark violet.
SrgbColour ratio_colour(double ratio, double most) {
  const double t = std::clamp(std::log(ratio) / std::log(most), 0.0, 1.0);
  return srgb(map_colour(ColourMap::lagoon, 0.86 * (1 - t)));
}

// What the colours mean, in the lower left corner.
void draw_ratio_scale(RgbImage& image, double most) {
  const std::uint32_t size = image.width >= 700 ? 16 : 11, width = image.width / 4, height = 3 * size / 4;
  const std::uint32_t left = image.width / 40, top = image.height - left - height - 5 * size / 4;
  for (std::uint32_t x = 0; x < width; ++x) {
    const SrgbColour colour = ratio_colour(std::pow(most, (x + 0.5) / width), most);
    for (std::uint32_t y = 0; y < height; ++y)
      std::copy(colour.begin(), colour.end(), image.pixel(left + x, top + y));
  }
  const TextStyle style{static_cast<double>(size), false, {40, 40, 40}};
  const double baseline = top + height + 1.1 * size;
  paint_text(image, "1", left, baseline, style);
  paint_text(image, fmt::format("{:g}", most), left + width, baseline, style, TextAlign::right);
  paint_text(image, "s1/s2", left + 0.5 * width, baseline, style, TextAlign::centre);
}

SurfacePictureParameters picture_of(const FigureSet& figures) {
  SurfacePictureParameters parameters;
  parameters.size = figures.quick ? 480 : 900;
  return parameters;
}

// Samples of every figure here: those of `meander run --method anisotropic`.
SampleParameters anisotropic_parameters() {
  SampleParameters parameters = parameters_for("anisotropic");
  return parameters;
}

Vector3 vector_of(const std::vector<float>& values, std::size_t i) {
  return {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
}

// In the coordinates of the file.
Vector3 sample_point(const Row& row, std::size_t i) {
  const std::array<double, 3>& loc = row.report.loc;
  return Vector3{loc[0], loc[1], loc[2]} + row.report.scale * vector_of(row.samples.points, i);
}

Vector3 file_point(const PreparedMesh& mesh, Vector3 working) { return mesh.centre + mesh.unit * working; }

// An ellipsoid with three different axes: its lines of curvature have four wedges, at the umbilics.
FigureMesh made_ellipsoid(std::uint32_t rings, const std::array<double, 3>& axes) {
  FigureMesh mesh;
  mesh.name = "ellipsoid";
  const std::uint32_t sectors = 2 * rings;
  // The poles lie on the middle axis: the umbilics are far from them.
  const auto add = [&](double polar, double around) {
    mesh.positions.insert(mesh.positions.end(),
                          {axes[0] * std::sin(polar) * std::cos(around), axes[1] * std::cos(polar),
                           axes[2] * std::sin(polar) * std::sin(around)});
  };
  add(0, 0);
  for (std::uint32_t i = 1; i < rings; ++i)
    for (std::uint32_t j = 0; j < sectors; ++j)
      add(std::numbers::pi * i / rings, 2 * std::numbers::pi * (j + 0.5 * (i % 2)) / sectors);
  add(std::numbers::pi, 0);
  const std::uint32_t last = 1 + (rings - 1) * sectors;
  const auto at = [&](std::uint32_t ring, std::uint32_t j) { return 1 + (ring - 1) * sectors + j % sectors; };
  for (std::uint32_t j = 0; j < sectors; ++j) {
    mesh.faces.insert(mesh.faces.end(), {0, at(1, j + 1), at(1, j)});
    mesh.faces.insert(mesh.faces.end(), {last, at(rings - 1, j), at(rings - 1, j + 1)});
  }
  for (std::uint32_t i = 1; i + 1 < rings; ++i)
    for (std::uint32_t j = 0; j < sectors; ++j) {
      const std::uint32_t a = at(i, j), b = at(i, j + 1), c = at(i + 1, j), d = at(i + 1, j + 1);
      if (i % 2 == 1)
        mesh.faces.insert(mesh.faces.end(), {a, b, d, a, d, c});
      else
        mesh.faces.insert(mesh.faces.end(), {a, b, c, b, d, c});
    }
  return mesh;
}

// ---- figure 12: fields ------------------------------------------------------------------------------------

// Every sample a short line along e1.
std::vector<SurfaceLine> direction_lines(const Row& row, double most, double width) {
  std::vector<SurfaceLine> lines;
  const Samples& samples = row.samples;
  for (std::size_t i = 0; i < samples.count(); ++i) {
    const double s1 = samples.tensor_spacing[2 * i], s2 = samples.tensor_spacing[2 * i + 1];
    const Vector3 p = sample_point(row, i);
    const Vector3 half =
        (0.5 * row.report.scale * std::sqrt(s1 * s2)) * vector_of(samples.tensor_direction, i);
    lines.push_back({p - half, p + half, width, ratio_colour(s1 / s2, most)});
  }
  return lines;
}

// The colours of figure 12's dots: wedges vermilion, trisectors blue.
SrgbColour singularity_colour(std::int32_t half_turns) {
  return half_turns > 0 ? SrgbColour{213, 62, 20} : SrgbColour{0, 90, 200};
}

void draw_one_field(FigureSet& figures, const FigureMesh& mesh, unsigned smoothing) {
  SampleParameters parameters = anisotropic_parameters();
  parameters.tensor.smoothing = smoothing;
  const Model model = staged_model(mesh, parameters_for("direct"));
  TensorFieldReport report;
  const TensorField field = make_tensor_field(model.file, model.surface, parameters.tensor, {}, &report);
  const std::vector<Singularity> singularities = find_singularities(model.surface, field);
  set_samples(parameters, figures.quick ? 1200 : 6000);
  parameters.seed = figures.seed;
  const Row row = Sampler(parameters).sample(mesh.positions, mesh.faces);
  if (row.report.status != Status::ok) throw ItemError(row.report.status, row.report.reason);

  SurfaceScene scene{mesh.positions, mesh.faces, {}};
  scene.lines = direction_lines(row, parameters.tensor.max_ratio, figures.quick ? 1.6 : 2);
  std::uint64_t wedges = 0, trisectors = 0;
  std::int64_t half_turns = 0;
  std::vector<double> positions;
  std::vector<PlyColour> colours;
  std::vector<float> indices;
  Table table{{{"kind"}, {"index"}, {"x"}, {"y"}, {"z"}}, {}};
  for (const Singularity& s : singularities) {
    const Vector3 p = file_point(model.surface, s.position);
    half_turns += s.half_turns;
    ++(s.half_turns > 0 ? wedges : trisectors);
    scene.dots.push_back({p, figures.quick ? 4.0 : 5.5, singularity_colour(s.half_turns)});
    positions.insert(positions.end(), {p.x, p.y, p.z});
    colours.push_back(singularity_colour(s.half_turns));
    indices.push_back(0.5f * static_cast<float>(s.half_turns));
    table.rows.push_back({s.half_turns > 0 ? "wedge" : "trisector", 0.5 * s.half_turns, p.x, p.y, p.z});
  }
  RgbImage image = surface_picture(scene, picture_of(figures));
  draw_ratio_scale(image, parameters.tensor.max_ratio);
  const std::string stem = fmt::format("figure12_{}{}", mesh.name, smoothing > 3 ? "_smooth" : "");
  figures.picture(stem + "_field", image,
                  fmt::format("{}, {} rounds of smoothing: {} wedges (red) and {} trisectors (blue)",
                              mesh.name, smoothing, wedges, trisectors));
  figures.data(stem + "_singularities.csv", csv_text(table));
  const std::vector<std::string> names = {"index"};
  figures.data(stem + "_singularities.ply",
               coloured_points_ply({positions, {}, colours, {}, names, indices}));
  figures.text(fmt::format("{}, {} rounds of smoothing", mesh.name, smoothing),
               fmt::format("Euler characteristic {}, sum of the indices left {:g}, mean ratio {:.2f}.",
                           2 * static_cast<std::int64_t>(row.report.components) -
                               2 * static_cast<std::int64_t>(row.report.genus) -
                               static_cast<std::int64_t>(row.report.boundaries),
                           0.5 * static_cast<double>(half_turns), report.mean_ratio));
}

// ---- figure 13: segments and charts -----------------------------------------------------------------------

// The numbers of the file for everything of a mesh that was split.
struct FileNumbers {
  std::vector<std::uint32_t> segment;                 // by face of the file; no_index: none
  std::vector<std::array<std::uint32_t, 2>> borders;  // vertices of the file
  std::vector<std::set<std::uint32_t>> neighbours;    // by segment
};

FileNumbers file_numbers(const Model& model) {
  const PreparedMesh& mesh = model.segments.mesh;
  FileNumbers result;
  result.segment.assign(model.file.polygon_count(), no_index);
  result.neighbours.resize(mesh.components.size());
  std::map<std::array<std::uint32_t, 2>, std::uint32_t> other;
  for (std::uint32_t c = 0; c < mesh.components.size(); ++c)
    for (std::uint32_t t = mesh.components[c].triangle_begin; t < mesh.components[c].triangle_end; ++t) {
      result.segment[mesh.polygon[t]] = c;
      for (std::uint32_t h = 3 * t; h < 3 * t + 3; ++h) {
        if (mesh.opposite[h] != no_index) continue;
        std::array<std::uint32_t, 2> edge = {model.file.corners[mesh.corner_slot[h]],
                                             model.file.corners[mesh.corner_slot[next_half_edge(h)]]};
        if (edge[0] > edge[1]) std::swap(edge[0], edge[1]);
        const auto [at, first] = other.try_emplace(edge, c);
        if (first) continue;
        result.borders.push_back(edge);
        if (at->second == c) continue;
        result.neighbours[c].insert(at->second);
        result.neighbours[at->second].insert(c);
      }
    }
  return result;
}

// Neighbours get different colours while there are enough; colours are used about equally often.
std::vector<SrgbColour> segment_colours(const FileNumbers& numbers) {
  // Without black, on which no shading would show.
  constexpr std::array<std::size_t, palette_size - 1> usable = {0, 1, 2, 3, 4, 5, 7, 8, 9};
  constexpr std::size_t count = usable.size();
  std::vector<std::size_t> chosen(numbers.neighbours.size(), count);
  std::array<std::uint32_t, count> used{};
  std::vector<SrgbColour> colours;
  for (std::size_t c = 0; c < chosen.size(); ++c) {
    std::array<std::uint32_t, count> cost = used;
    for (const std::uint32_t n : numbers.neighbours[c])
      if (chosen[n] < count) cost[chosen[n]] += 1u << 20;
    chosen[c] = static_cast<std::size_t>(std::min_element(cost.begin(), cost.end()) - cost.begin());
    ++used[chosen[c]];
    SrgbColour colour = srgb(palette_colour(usable[chosen[c]]));
    // Paler, so that shading shows.
    for (std::uint8_t& part : colour) part = static_cast<std::uint8_t>(part + (255 - part) * 2 / 5);
    colours.push_back(colour);
  }
  return colours;
}

// One line of a colour for each of `bins` stretches of the curve.
constexpr std::size_t curve_bins = 48;
void add_chain(PlanarDrawing& drawing, const CurveChain& chain, double leaves) {
  const auto bin_of = [&](std::size_t i) {
    return std::min(curve_bins - 1, static_cast<std::size_t>(chain.along[i] / leaves * curve_bins));
  };
  for (std::size_t i = 0; i + 1 < chain.u.size();) {
    const std::size_t bin = bin_of(i);
    PlanarPolyline line;
    line.colour = map_colour(ColourMap::lagoon, 0.78 * (static_cast<double>(bin) + 0.5) / curve_bins);
    line.width = 0.9;
    line.x.push_back(chain.u[i]);
    line.y.push_back(chain.v[i]);
    for (; i + 1 < chain.u.size() && bin_of(i) == bin; ++i) {
      line.x.push_back(chain.u[i + 1]);
      line.y.push_back(chain.v[i + 1]);
    }
    drawing.lines.push_back(std::move(line));
  }
}

void add_outline(PlanarDrawing& drawing, const FlatChart& chart, SrgbColour colour) {
  const CutChart& cut = chart.cut;
  std::vector<std::uint32_t> next(cut.vertex_count(), no_index);
  for (std::uint32_t h = 0; h < cut.triangles.size(); ++h)
    if (cut.opposite[h] == no_index) next[cut.triangles[h]] = cut.triangles[next_half_edge(h)];
  for (std::uint32_t v = 0; v < next.size(); ++v) {
    if (next[v] == no_index) continue;
    PlanarPolyline line;
    line.closed = true;
    line.colour = {colour[0], colour[1], colour[2]};
    line.width = 2;
    for (std::uint32_t at = v; next[at] != no_index;) {
      line.x.push_back(chart.u[at]);
      line.y.push_back(chart.v[at]);
      const std::uint32_t to = next[at];
      next[at] = no_index;
      at = to;
    }
    drawing.lines.push_back(std::move(line));
  }
}

void draw_one_segmentation(FigureSet& figures, const FigureMesh& mesh, AlignmentForm form) {
  SampleParameters parameters = anisotropic_parameters();
  parameters.tensor_charts.form = form;
  parameters.tensor_charts.segment.count = form == AlignmentForm::gradient ? 16 : 8;
  set_samples(parameters, figures.quick ? 512 : 2048);
  parameters.locator.curve.leaves_per_sample = 1;
  Model model = staged_model(mesh, parameters);
  model.trees = build_curves(model.segments.mesh, model.charts, model.segments.measure.masses,
                             parameters.locator, model.cancel);

  const FileNumbers numbers = file_numbers(model);
  const std::vector<SrgbColour> colours = segment_colours(numbers);
  SurfaceScene scene{mesh.positions, mesh.faces, {}};
  constexpr SrgbColour grey = {160, 160, 160};
  for (const std::uint32_t segment : numbers.segment)
    scene.face_colours.push_back(segment == no_index ? grey : colours[segment]);
  const auto vertex = [&](std::uint32_t v) {
    return Vector3{mesh.positions[3 * v], mesh.positions[3 * v + 1], mesh.positions[3 * v + 2]};
  };
  for (const std::array<std::uint32_t, 2>& edge : numbers.borders)
    scene.lines.push_back({vertex(edge[0]), vertex(edge[1]), figures.quick ? 1.2 : 1.8, {30, 30, 30}});
  const char* const name = form == AlignmentForm::gradient ? "gradient" : "metric";
  const std::string stem = fmt::format("figure13_{}_{}", mesh.name, name);
  const AnisotropyReport& report = model.segments.report;
  figures.picture(stem + "_segments", surface_picture(scene, picture_of(figures)),
                  fmt::format("{}, {}: {} segments", mesh.name, name, model.segments.mesh.components.size()));
  figures.data(stem + "_segments.ply", coloured_mesh_ply(mesh.positions, mesh.faces, scene.face_colours));

  // The curve of every chart, on paper and on the surface.
  std::vector<std::uint32_t> largest(model.charts.size());
  for (std::uint32_t c = 0; c < largest.size(); ++c) largest[c] = c;
  std::sort(largest.begin(), largest.end(), [&](std::uint32_t a, std::uint32_t b) {
    return model.segments.mesh.components[a].area != model.segments.mesh.components[b].area
               ? model.segments.mesh.components[a].area > model.segments.mesh.components[b].area
               : a < b;
  });
  scene.face_colours.clear();
  for (SurfaceLine& border : scene.lines) border.colour = {150, 150, 150};
  std::vector<PlanarDrawing> drawings;
  Table table{{{"segment"}, {"share of the area"}, {"triangles"}, {"leaves"}, {"chains"}, {"chart"}}, {}};
  constexpr std::size_t most_charts = 8;
  std::uint64_t chains_in_all = 0, charts_with_curve = 0;
  for (const std::uint32_t c : largest) {
    const CurveTree empty;
    const CurveTree& tree = c < model.trees.size() ? model.trees[c] : empty;
    const std::vector<CurveChain> chains = curve_chains(model.segments.mesh, model.charts[c], tree, 12);
    const double leaves = static_cast<double>(std::max<std::size_t>(1, tree.leaf_count()));
    chains_in_all += chains.size();
    charts_with_curve += chains.empty() ? 0 : 1;
    const Component& component = model.segments.mesh.components[c];
    const double share = component.area / model.segments.mesh.total_area;
    table.rows.push_back({c, share, component.triangle_end - component.triangle_begin, tree.leaf_count(),
                          chains.size(), name_of(model.charts[c].report.method)});
    for (const CurveChain& chain : chains)
      for (std::size_t i = 0; i + 1 < chain.position.size(); ++i)
        scene.lines.push_back({file_point(model.segments.mesh, chain.position[i]),
                               file_point(model.segments.mesh, chain.position[i + 1]),
                               figures.quick ? 1.2 : 1.6,
                               srgb(map_colour(ColourMap::lagoon, 0.78 * chain.along[i] / leaves))});
    if (drawings.size() == most_charts || chains.empty()) continue;
    PlanarDrawing drawing;
    drawing.caption = fmt::format("{:.1f} % of the area, {} chain{}", 100 * share, chains.size(),
                                  chains.size() == 1 ? "" : "s");
    drawing.fit = true;
    drawing.frame = false;
    add_outline(drawing, model.charts[c], colours[c]);
    for (const CurveChain& chain : chains) add_chain(drawing, chain, leaves);
    drawings.push_back(std::move(drawing));
  }
  PanelGrid grid;
  grid.columns = 4;
  grid.panel_height = 220;
  figures.drawing(stem + "_charts", svg_panels(drawings, grid),
                  fmt::format("Charts of the {} largest segments, {} form", drawings.size(), name));
  figures.picture(stem + "_curve", surface_picture(scene, picture_of(figures)),
                  fmt::format("{}, {}: the curves on the surface", mesh.name, name));
  figures.data(stem + "_segments.csv", csv_text(table));
  figures.text(
      fmt::format("{}, {}", mesh.name, name),
      fmt::format("{} segments, {:.1f} % of the area in charts within the limits; mean angle to e1 {:.1f} "
                  "degrees, mean ratio of the chart in the metric {:.3f}; {} chains in {} charts.",
                  report.segments, 100 * report.accepted_share, report.mean_angle * 180 / std::numbers::pi,
                  report.mean_chart_ratio, chains_in_all, charts_with_curve));
}

// ---- figure 14: samples -----------------------------------------------------------------------------------

void draw_one_sampling(FigureSet& figures, const FigureMesh& mesh) {
  SampleParameters parameters = anisotropic_parameters();
  set_samples(parameters, figures.quick ? 800 : 5000);
  parameters.seed = figures.seed;
  const Row row = Sampler(parameters).sample(mesh.positions, mesh.faces);
  if (row.report.status != Status::ok) throw ItemError(row.report.status, row.report.reason);
  const Samples& samples = row.samples;
  SurfaceScene scene{mesh.positions, mesh.faces, {}};
  std::vector<double> positions;
  std::vector<PlyColour> colours;
  for (std::size_t i = 0; i < samples.count(); ++i) {
    const double s1 = row.report.scale * samples.tensor_spacing[2 * i],
                 s2 = row.report.scale * samples.tensor_spacing[2 * i + 1];
    const Vector3 along = vector_of(samples.tensor_direction, i),
                  across = cross(vector_of(samples.normals, i), along);
    const double length = norm(across);
    const SrgbColour colour = ratio_colour(s1 / s2, parameters.tensor.max_ratio);
    const Vector3 p = sample_point(row, i);
    positions.insert(positions.end(), {p.x, p.y, p.z});
    colours.push_back(colour);
    if (length > 0) scene.ellipses.push_back({p, (0.44 * s1) * along, (0.44 * s2 / length) * across, colour});
  }
  RgbImage image = surface_picture(scene, picture_of(figures));
  draw_ratio_scale(image, parameters.tensor.max_ratio);
  const std::string stem = fmt::format("figure14_{}", mesh.name);
  figures.picture(stem + "_ellipses", image,
                  fmt::format("{}: {} samples as ellipses of their spacings", mesh.name, samples.count()));
  constexpr SrgbColour ink = {20, 45, 110};
  for (SurfaceEllipse& mark : scene.ellipses) {
    const double a = norm(mark.first), b = norm(mark.second), radius = 0.42 * std::sqrt(a * b);
    mark = {mark.centre, (radius / a) * mark.first, (radius / b) * mark.second, ink};
  }
  figures.picture(stem + "_points", surface_picture(scene, picture_of(figures)),
                  fmt::format("{}: the same as points", mesh.name));
  const std::vector<std::string> names = {"spacing_1", "spacing_2"};
  std::vector<float> spacings;
  for (const float s : samples.tensor_spacing)
    spacings.push_back(static_cast<float>(row.report.scale * double{s}));
  figures.data(stem + "_samples.ply", coloured_points_ply({positions, samples.normals, colours,
                                                           samples.tensor_direction, names, spacings}));
}

// Meshes of files, or the ellipsoid too where there are none.
std::vector<FigureMesh> figure_meshes(const FigureSet& figures, bool with_ellipsoid) {
  std::vector<FigureMesh> meshes;
  if (with_ellipsoid) meshes.push_back(made_ellipsoid(figures.quick ? 32 : 64, {1.6, 1.2, 0.8}));
  meshes.insert(meshes.end(), figures.meshes.begin(), figures.meshes.end());
  return meshes;
}

}  // namespace

void draw_tensor_fields(FigureSet& figures) {
  figures.begin("Figure 12: tensor fields and their singularities");
  for (const FigureMesh& mesh : figure_meshes(figures, true)) {
    figures.note("  " + mesh.name);
    for (const unsigned smoothing : {3u, 64u})
      figures.attempt(mesh.name, [&] { draw_one_field(figures, mesh, smoothing); });
  }
  figures.text(
      "Measured",
      "Lines along the direction of least absolute curvature, coloured by the ratio of the two wanted "
      "spacings (`--tensor curvature`). The ellipsoid has its four wedges at the umbilics. Singularities "
      "of isotropic regions count once, by the sum of their indices.");
  figures.text("The survey",
               "Shows the field that the segmentation follows, with its wedges and trisectors.");
}

void draw_segments(FigureSet& figures) {
  figures.begin("Figure 13: segments, charts and curves");
  for (const FigureMesh& mesh : figures.meshes)
    for (const AlignmentForm form : {AlignmentForm::metric, AlignmentForm::gradient}) {
      figures.note(fmt::format("  {}, {}", mesh.name, form == AlignmentForm::metric ? "metric" : "gradient"));
      figures.attempt(mesh.name, [&] { draw_one_segmentation(figures, mesh, form); });
    }
  figures.text(
      "Measured",
      "Segments by random walks, their charts with the part of the Hilbert curve that lies inside, from "
      "violet to green along the curve of each chart, and the same curves on the surface. The metric "
      "form makes charts conformal in the field's metric; the gradient form lays u along e1. PLY: "
      "faces coloured by segment.");
  figures.text("The survey", "One curve over each chart, clipped to it: several chains per segment.");
}

void draw_anisotropic_samples(FigureSet& figures) {
  figures.begin("Figure 14: anisotropic samples");
  for (const FigureMesh& mesh : figures.meshes) {
    figures.note("  " + mesh.name);
    figures.attempt(mesh.name, [&] { draw_one_sampling(figures, mesh); });
  }
  figures.text(
      "Measured",
      "Samples along the curvature (ratios to 8, equal density), drawn as ellipses whose axes are 0.88 of "
      "the wanted spacings along and across e1, and as points. PLY: points with normals, colours, "
      "direction and spacings.");
  figures.text("The survey",
               "Elongated samples follow ridges and cylinders and are round where the surface is.");
}

}  // namespace meander
