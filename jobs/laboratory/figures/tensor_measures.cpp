// Figures 15 and 16, anisotropic samples: discrepancy in the metric, and differential domain analysis.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "io/plot/heat_map.h"
#include "io/plot/picture_sheet.h"
#include "jobs/laboratory/figures/figure_set.h"
#include "jobs/laboratory/figures/staged_model.h"
#include "kernels/analyse/discrepancy_anisotropic.h"
#include "kernels/analyse/histogram_error.h"
#include "kernels/analyse/pair_density.h"
#include "kernels/analyse/slope_fit.h"
#include "kernels/locate/embree_locator.h"

namespace meander {

namespace {

constexpr std::array<double, 4> plane_ratios = {1, 2, 4, 8};
constexpr double plane_angle = std::numbers::pi / 6;  // of e1: along neither the edges nor the diagonals

// The unit square of 2 n^2 triangles.
FigureMesh made_square(std::uint32_t n) {
  FigureMesh mesh;
  mesh.name = "square";
  for (std::uint32_t j = 0; j <= n; ++j)
    for (std::uint32_t i = 0; i <= n; ++i)
      mesh.positions.insert(mesh.positions.end(),
                            {static_cast<double>(i) / n, static_cast<double>(j) / n, 0.0});
  for (std::uint32_t j = 0; j < n; ++j)
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint32_t a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
      mesh.faces.insert(mesh.faces.end(), {a, b, d, a, d, c});
    }
  return mesh;
}

SampleParameters anisotropic_parameters(SequenceKind sequence) {
  SampleParameters parameters = parameters_for("anisotropic");
  parameters.place.sequence = sequence;
  return parameters;
}

// S with s1 s2 = 1 and e1 at plane_angle, for a plane whose normal is z.
std::array<double, 6> constant_spacing(double ratio) {
  const TangentTensor s =
      tensor_of({std::sqrt(ratio), 1 / std::sqrt(ratio), std::cos(plane_angle), std::sin(plane_angle)});
  return {s.xx, s.xy, 0, s.yy, 0, 1};
}

struct PlaneSamples {
  std::vector<double> x, y, s1, s2;
  std::vector<TangentTensor> log_spacing;  // s1 s2: the area per sample
};

PlaneSamples plane_samples(const Row& row) {
  PlaneSamples result;
  const Samples& samples = row.samples;
  const double scale = row.report.scale;
  for (std::size_t i = 0; i < samples.count(); ++i) {
    result.x.push_back(row.report.loc[0] + scale * samples.points[3 * i]);
    result.y.push_back(row.report.loc[1] + scale * samples.points[3 * i + 1]);
    result.s1.push_back(scale * samples.tensor_spacing[2 * i]);
    result.s2.push_back(scale * samples.tensor_spacing[2 * i + 1]);
    const double dx = samples.tensor_direction[3 * i], dy = samples.tensor_direction[3 * i + 1];
    const double length = std::hypot(dx, dy);
    result.log_spacing.push_back(
        tensor_of({std::log(result.s1.back()), std::log(result.s2.back()), dx / length, dy / length}));
  }
  return result;
}

// ---- figure 15 --------------------------------------------------------------------------------------------

void add_slopes(Table& table, const std::string& kind, double ratio, const std::string& sequence,
                const ErrorSeries& series) {
  std::vector<double> counts, errors;
  for (std::size_t i = 0; i < series.counts.size(); ++i) {
    const double mean = spread_of(series.runs[i]).mean;
    if (series.counts[i] < 16 || !(mean > 0)) continue;
    counts.push_back(series.counts[i]);
    errors.push_back(mean);
  }
  std::vector<TableCell> row = {kind, ratio, sequence};
  if (counts.size() > 2) {
    const SlopeFit fit = fit_slope(counts, errors);
    row.insert(row.end(), {fit.slope, fit.standard_error, counts.front(), counts.back(), fit.at(1000)});
  }
  table.rows.push_back(std::move(row));
}

// ---- figure 16 --------------------------------------------------------------------------------------------

DifferenceParameters map_parameters() {
  DifferenceParameters parameters;
  parameters.range = 3.5;
  parameters.cells = 160;
  return parameters;
}

struct MapPair {
  DifferenceMap ours, random;
  MapPair() : ours(make_difference_map(map_parameters())), random(ours) {}
  DifferenceMap& of(SequenceKind sequence) { return sequence == SequenceKind::random ? random : ours; }
};

Dip dip_of(const MapPair& maps) {
  DipParameters parameters;
  parameters.measured_reference = true;
  return dip_moments(maps.ours, maps.random, parameters);
}

constexpr std::uint32_t cell_pixels = 2;

// Black 0, white 2 times independent samples, and the ellipse of the dip at half its depth.
RgbImage map_picture(const MapPair& maps, const Dip& dip) {
  const std::vector<double> ratio = normalised_differences(maps.ours, maps.random);
  HeatMapParameters look;
  look.lower = 0;
  look.upper = 2;
  look.upwards = true;
  look.pixels = cell_pixels;
  look.not_a_number = {205, 212, 225};  // no pair of independent samples reaches there
  const auto side = static_cast<std::uint32_t>(maps.ours.side());
  RgbImage image = heat_map(ratio, side, side, look);
  if (!dip.found) return image;
  const double pixel = maps.ours.cell() / cell_pixels, middle = 0.5 * image.width;
  for (const std::array<double, 2>& q : half_depth_ellipse(dip, 4096)) {
    const double x = middle + q[0] / pixel, y = middle - q[1] / pixel;
    for (const double dx : {0.0, -1.0})
      for (const double dy : {0.0, -1.0}) {
        const auto px = static_cast<std::int64_t>(x + dx), py = static_cast<std::int64_t>(y + dy);
        if (px < 0 || py < 0 || px >= image.width || py >= image.height) continue;
        std::uint8_t* at = image.pixel(static_cast<std::uint32_t>(px), static_cast<std::uint32_t>(py));
        at[0] = 235, at[1] = 70, at[2] = 20;
      }
  }
  return image;
}

// Maps row by row, each with its label below. Rows: as many columns in each.
RgbImage map_sheet(const std::vector<SheetCell>& maps, std::uint32_t columns) {
  SheetLook look;
  look.cell = maps.front().picture.width;
  look.columns = columns;
  return picture_sheet(maps, {}, look);
}

Table dip_table(const char* first_column) {
  return {{{first_column},
           {"samples counted", 4},
           {"mean ratio", 3},
           {"dip ratio, area", 3},
           {"its angle to e1, degrees", 2},
           {"dip ratio, spacings", 3},
           {"depth, spacings", 3},
           {"signal to noise, area", 3}},
          {}};
}

void add_dips(Table& table, TableCell name, double counted, double wanted, const Dip& area,
              const Dip& spacings) {
  table.rows.push_back(
      {std::move(name), counted, wanted, area.found ? TableCell(area.ratio) : TableCell(),
       area.found && area.ratio > 1.2 ? TableCell(area.angle * 180 / std::numbers::pi) : TableCell(),
       spacings.found ? TableCell(spacings.ratio) : TableCell(), spacings.depth, area.signal_to_noise});
}

std::string dip_label(const std::string& name, const Dip& dip) {
  return dip.found ? fmt::format("{}: {:.2f}", name, dip.ratio) : name + ": no dip";
}

// On a mesh of side x side squares: adds to the table, and returns the maps.
std::vector<SheetCell> draw_constant_fields(FigureSet& figures, const EmbreeDevice& device,
                                            std::uint32_t side, Table& table) {
  const FigureMesh square = made_square(side);
  const std::uint32_t sets = figures.quick ? 3 : 10, count = figures.quick ? 1000 : 5000;
  std::vector<SheetCell> area_maps, spacing_maps;
  for (const double ratio : plane_ratios) {
    figures.note(fmt::format("  {} triangles, ratio {}", 2 * side * side, ratio));
    SampleParameters parameters = anisotropic_parameters(SequenceKind::shifted);
    parameters.tensor.kind = TensorKind::constant;
    parameters.tensor.constant = constant_spacing(ratio);
    const Model staged = staged_model(square, parameters);
    MapPair area, spacings;
    for (const SequenceKind sequence : {SequenceKind::shifted, SequenceKind::random})
      for (std::uint32_t s = 0; s < (sequence == SequenceKind::random ? 4 * sets : sets); ++s) {
        parameters.place.sequence = sequence;
        const PlaneSamples samples =
            plane_samples(sampled_row(staged, parameters, count, figures.seed + s, device));
        TensorDifferenceParameters differences;
        add_anisotropic_differences(spacings.of(sequence), samples.x, samples.y, samples.log_spacing,
                                    differences);
        differences.units = DifferenceUnits::area;
        add_anisotropic_differences(area.of(sequence), samples.x, samples.y, samples.log_spacing,
                                    differences);
      }
    const Dip area_dip = dip_of(area), spacing_dip = dip_of(spacings);
    add_dips(table, 2 * side * side, static_cast<double>(sets) * count, ratio, area_dip, spacing_dip);
    area_maps.push_back({map_picture(area, area_dip), dip_label(fmt::format("area, {:g}", ratio), area_dip)});
    spacing_maps.push_back(
        {map_picture(spacings, spacing_dip), dip_label(fmt::format("spacings, {:g}", ratio), spacing_dip)});
  }
  area_maps.insert(area_maps.end(), spacing_maps.begin(), spacing_maps.end());
  return area_maps;
}

void draw_plane(FigureSet& figures, const EmbreeDevice& device) {
  Table table = dip_table("triangles");
  constexpr std::uint32_t fine = 128, coarse = 32;
  const std::vector<SheetCell> maps = draw_constant_fields(figures, device, fine, table);
  draw_constant_fields(figures, device, coarse, table);
  figures.picture("figure16_tensor_plane", map_sheet(maps, 4),
                  "Constant fields of ratio 1, 2, 4 and 8 in the plane, in units of area (above) and of "
                  "spacings; under each the units, the ratio wanted and the axis ratio of the dip");
  figures.table("figure16_tensor_plane", "Dips in the plane, on a fine and on a coarse mesh", table);
}

// What one sampler gives, in classes of the ratio.
constexpr std::array<double, 3> class_edges = {1.5, 3, 5};
constexpr std::array<const char*, 4> class_names = {"1 - 1.5", "1.5 - 3", "3 - 5", "5 - 8"};

struct ClassMaps {
  MapPair spacings;
  std::array<MapPair, class_edges.size() + 1> area, own_spacings;
  std::array<double, class_edges.size() + 1> counted{}, ratio_sum{};

  // add(map, parameters) adds the set to a map.
  template <class Add>
  void add_set(SequenceKind sequence, std::span<const double> s1, std::span<const double> s2, Add add) {
    TensorDifferenceParameters differences;
    add(spacings.of(sequence), differences);
    const std::vector<std::uint32_t> classes = ratio_classes(s1, s2, class_edges);
    for (std::size_t c = 0; c < area.size(); ++c) {
      std::vector<std::uint8_t> counts(classes.size());
      for (std::size_t i = 0; i < classes.size(); ++i) {
        counts[i] = classes[i] == c;
        if (!counts[i] || sequence == SequenceKind::random) continue;
        counted[c] += 1;
        ratio_sum[c] += s1[i] / s2[i];
      }
      differences.counted = counts;
      differences.units = DifferenceUnits::spacings;
      add(own_spacings[c].of(sequence), differences);
      differences.units = DifferenceUnits::area;
      add(area[c].of(sequence), differences);
    }
  }

  void draw(FigureSet& figures, const std::string& stem, const std::string& name) {
    std::vector<SheetCell> above, below;
    Table table = dip_table("ratios");
    const Dip all = dip_of(spacings);
    for (std::size_t c = 0; c < area.size(); ++c) {
      if (counted[c] < 300) continue;
      const Dip dip = dip_of(area[c]), own = dip_of(own_spacings[c]);
      const double mean = ratio_sum[c] / counted[c];
      above.push_back({map_picture(area[c], dip), dip_label(fmt::format("area, {:.1f}", mean), dip)});
      below.push_back(
          {map_picture(own_spacings[c], own), dip_label(fmt::format("spacings, {:.1f}", mean), own)});
      add_dips(table, class_names[c], counted[c], mean, dip, own);
    }
    const auto columns = static_cast<std::uint32_t>(above.size());
    above.insert(above.end(), below.begin(), below.end());
    table.rows.push_back({"all", TableCell(), TableCell(), TableCell(), TableCell(),
                          all.found ? TableCell(all.ratio) : TableCell(), all.depth});
    figures.picture(
        stem, map_sheet(above, columns),
        name +
            ": samples by classes of s1 / s2, in units of area (above) and of spacings; under each "
            "the units, the mean ratio wanted and the axis ratio of the dip");
    figures.picture(stem + "_spacings", map_picture(spacings, all),
                    name + ": all samples, units of spacings");
    figures.table(stem, name, table);
  }
};

// e1 runs round the middle; the ratio grows from 1 there to 8 at the middles of the sides.
void draw_swirl(FigureSet& figures, const EmbreeDevice& device) {
  const FigureMesh square = made_square(96);
  const std::uint32_t sets = figures.quick ? 3 : 10, count = figures.quick ? 1000 : 5000;
  auto table = std::make_shared<TensorTable>();
  table->columns = 3;
  for (std::size_t i = 0; i < square.positions.size(); i += 3) {
    const double x = square.positions[i] - 0.5, y = square.positions[i + 1] - 0.5, r = std::hypot(x, y);
    const double ratio = 1 + 7 * std::min(1.0, 2 * r);
    const double dx = r > 0 ? -y / r : 1, dy = r > 0 ? x / r : 0;
    table->values.insert(table->values.end(), {ratio * dx, ratio * dy, 0.0});
  }
  SampleParameters parameters = anisotropic_parameters(SequenceKind::shifted);
  parameters.tensor.kind = TensorKind::table;
  parameters.tensor.table = table;
  const Model staged = staged_model(square, parameters, table);
  ClassMaps maps;
  for (const SequenceKind sequence : {SequenceKind::shifted, SequenceKind::random})
    for (std::uint32_t s = 0; s < (sequence == SequenceKind::random ? 4 * sets : sets); ++s) {
      parameters.place.sequence = sequence;
      const PlaneSamples samples =
          plane_samples(sampled_row(staged, parameters, count, figures.seed + s, device));
      maps.add_set(sequence, samples.s1, samples.s2,
                   [&](DifferenceMap& map, const TensorDifferenceParameters& differences) {
                     add_anisotropic_differences(map, samples.x, samples.y, samples.log_spacing, differences);
                   });
    }
  maps.draw(figures, "figure16_tensor_swirl", "Swirl in the plane");
}

void draw_mesh_field(FigureSet& figures, const FigureMesh& mesh, const EmbreeDevice& device) {
  const std::uint32_t sets = figures.quick ? 2 : 8, count = figures.quick ? 1000 : 3000;
  SampleParameters parameters = anisotropic_parameters(SequenceKind::shifted);
  const Model staged = staged_model(mesh, parameters);
  ClassMaps maps;
  for (const SequenceKind sequence : {SequenceKind::shifted, SequenceKind::random})
    for (std::uint32_t s = 0; s < (sequence == SequenceKind::random ? 4 * sets : sets); ++s) {
      parameters.place.sequence = sequence;
      const Row row = sampled_row(staged, parameters, count, figures.seed + s, device);
      const Samples& samples = row.samples;
      const std::vector<double> points(samples.points.begin(), samples.points.end()),
          normals(samples.normals.begin(), samples.normals.end()),
          axes(samples.tensor_direction.begin(), samples.tensor_direction.end());
      std::vector<double> s1, s2;
      for (std::size_t i = 0; i < samples.count(); ++i) {
        s1.push_back(samples.tensor_spacing[2 * i]);
        s2.push_back(samples.tensor_spacing[2 * i + 1]);
      }
      maps.add_set(sequence, s1, s2, [&](DifferenceMap& map, const TensorDifferenceParameters& differences) {
        add_anisotropic_surface_differences(map, {points, normals, axes, s1, s2}, differences);
      });
    }
  maps.draw(figures, "figure16_tensor_" + mesh.name, mesh.name);
}

}  // namespace

void draw_tensor_discrepancy(FigureSet& figures) {
  figures.begin("Figure 15: discrepancy of anisotropic samples in the plane");
  const EmbreeDevice device;
  const FigureMesh square = made_square(128);
  const std::uint32_t most = figures.quick ? 1536 : 12288, runs = 3;
  AnisotropicDiscrepancyParameters measure;
  measure.shapes.shapes = figures.quick ? 512 : 1024;
  measure.shapes.seed = figures.seed;
  measure.shapes.stable_rise = 0;
  measure.windows = 4;
  constexpr std::array<const char*, 3> kinds = {"disks", "boxes", "triangles"};
  std::array<Plot, kinds.size()> plots;
  for (std::size_t k = 0; k < kinds.size(); ++k) {
    plots[k] = error_plot(fmt::format("Anisotropic {}", kinds[k]), {}, "discrepancy");
    plots[k].x.label = "points in the window";
  }
  Table table{{{"shapes"},
               {"ratio"},
               {"sequence"},
               {"slope", 3},
               {"its error", 2},
               {"from points", 3},
               {"to points", 4},
               {"fit at 1000 points", 3}},
              {}};
  for (std::size_t r = 0; r < plane_ratios.size(); ++r) {
    const double ratio = plane_ratios[r];
    SampleParameters parameters = anisotropic_parameters(SequenceKind::shifted);
    parameters.tensor.kind = TensorKind::constant;
    parameters.tensor.constant = constant_spacing(ratio);
    const Model staged = staged_model(square, parameters);
    const TangentTensor log_spacing = tensor_of(
        {0.5 * std::log(ratio), -0.5 * std::log(ratio), std::cos(plane_angle), std::sin(plane_angle)});
    for (const SequenceKind sequence : {SequenceKind::shifted, SequenceKind::random}) {
      const std::string name = sequence == SequenceKind::random ? "random" : "shifted";
      figures.note(fmt::format("  ratio {}, {}", ratio, name));
      std::array<ErrorSeries, kinds.size()> series;
      for (ErrorSeries& s : series) s.name = fmt::format("{}, ratio {:g}", name, ratio);
      for (const std::uint32_t count : survey_counts(most, 64)) {
        std::array<std::vector<double>, kinds.size()> errors;
        double points = 0;
        for (std::uint32_t run = 0; run < runs; ++run) {
          parameters.place.sequence = sequence;
          const PlaneSamples samples =
              plane_samples(sampled_row(staged, parameters, count, figures.seed + run, device));
          const AnisotropicDiscrepancy found =
              anisotropic_discrepancy(samples.x, samples.y, log_spacing, measure);
          if (found.windows == 0) continue;
          points += found.points / runs;
          errors[0].push_back(found.disks);
          errors[1].push_back(found.boxes);
          errors[2].push_back(found.triangles);
        }
        if (errors[0].size() < runs) continue;
        for (std::size_t k = 0; k < kinds.size(); ++k) {
          series[k].counts.push_back(points);
          series[k].runs.push_back(std::move(errors[k]));
        }
      }
      for (std::size_t k = 0; k < kinds.size(); ++k) {
        PlotSeries line = plot_series(series[k], r);
        if (sequence == SequenceKind::random) line.dash = LineDash::dashed;
        plots[k].series.push_back(std::move(line));
        add_slopes(table, kinds[k], ratio, name, series[k]);
      }
    }
  }
  for (std::size_t k = 0; k < kinds.size(); ++k)
    figures.plot(fmt::format("figure15_{}", kinds[k]), plots[k],
                 fmt::format("{} {}, round or square in the metric, in {} windows; means of {} runs",
                             measure.shapes.shapes, kinds[k], measure.windows, runs));
  std::stable_sort(table.rows.begin(), table.rows.end(), [](const auto& a, const auto& b) {
    return a[0].text != b[0].text ? a[0].text < b[0].text : a[2].text > b[2].text;
  });
  figures.table("figure15_slopes", "Slopes over the points in the window, from 16, and the fit at 1,000",
                table);
  figures.text(
      "Measured",
      "`--method anisotropic` on a square with a constant tensor (e1 at 30 degrees), shapes that are "
      "disks, boxes and triangles of the metric inside the largest ellipse of the field. Errors are over "
      "the number of points in that window, so that lines of all ratios fall on one another.");
  figures.text("The survey",
               "The rate of the plane holds under anisotropy: a constant tensor changes shapes, not errors.");
}

void draw_tensor_differences(FigureSet& figures) {
  figures.begin("Figure 16: differential domain analysis of anisotropic samples");
  const EmbreeDevice device;
  draw_plane(figures, device);
  figures.note("  swirl");
  draw_swirl(figures, device);
  for (const FigureMesh& mesh : figures.meshes) {
    figures.note("  " + mesh.name);
    figures.attempt(mesh.name, [&] { draw_mesh_field(figures, mesh, device); });
  }
  figures.text(
      "Measured",
      "Differences between samples in the frame of e1 (to the right), over those of independent samples "
      "in the same field: black 0, white 2 times white noise; 3.5 units to each side. Red: the dip at "
      "half its depth, by adaptive moments. In units of area the dip is an ellipse of the wanted ratio; "
      "in units of spacings it is round whatever the ratio. Triangles whose sides lie between the two "
      "spacings "
      "are taken whole, so that samples across e1 come nearer to each other than wanted: see the meshes of "
      "32,768 and 2,048 triangles at high ratios.");
  figures.text("The survey",
               "Shows that anisotropic samples keep their distances in the metric of the tensor.");
}

}  // namespace meander
