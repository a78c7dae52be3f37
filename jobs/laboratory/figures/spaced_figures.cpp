// Samples that keep their distance, measured beside others: error, spacing, spectra, differences, bias, time.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "io/plot/picture_row.h"
#include "jobs/laboratory/figures/figure_models.h"
#include "jobs/laboratory/figures/figure_set.h"
#include "jobs/laboratory/figures/radial_figures.h"
#include "jobs/laboratory/figures/spaced_sets.h"
#include "kernels/analyse/differential_domain.h"
#include "kernels/analyse/spectrum.h"

namespace meander {

namespace {

PictureRowParameters row_look() {
  PictureRowParameters look;
  look.gap = 10;
  look.title_size = 13;
  return look;
}

Plot count_plot(const std::string& title, const std::string& measure, AxisScale scale) {
  Plot plot;
  plot.title = title;
  plot.x = {"points", AxisScale::log10, {}, {}};
  plot.y = {measure, scale, {}, {}};
  plot.legend = LegendPlace::right;
  plot.width = 720;
  plot.height = 460;
  return plot;
}

void add_value(Plot& plot, std::size_t method, std::uint32_t count, double value) {
  if (plot.series.size() <= method) {
    plot.series.emplace_back();
    plot.series.back().name = compared_methods[method].name;
    plot.series.back().colour = method;
    plot.series.back().marker_size = 2;
    if (method == spaced_method) plot.series.back().line_width = 3;
  }
  plot.series[method].x.push_back(count);
  plot.series[method].y.push_back(value);
}

// ---- error, spacing and time over the number of points

void draw_errors(FigureSet& figures, const std::string& name, const ComparedModel& model,
                 std::uint32_t most) {
  const std::vector<RotatedBox> boxes = model.boxes(figures.quick ? 200 : 1000, figures.seed);
  Plot error = count_plot(name + ": rotated boxes", "error / that of random points", AxisScale::log10),
       rho = count_plot(name + ": smallest distance", "rho: smallest / hexagonal", AxisScale::linear),
       mean = count_plot(name + ": nearest samples", "mean distance / hexagonal", AxisScale::linear),
       time = count_plot(name + ": time", "us a sample", AxisScale::log10);
  Table table{{{"samples"},
               {"points"},
               {"sets"},
               {"error", 3},
               {"rho", 3},
               {"least rho", 3},
               {"mean distance / hexagonal", 3}},
              {}};
  for (std::size_t m = 0; m < compared_methods.size(); ++m)
    for (std::uint32_t count = 64; count <= most; count *= 4) {
      const std::uint32_t sets = figures.quick ? 3 : std::clamp(32768u / count, 3u, 16u);
      SetMeasures measures;
      for (std::uint32_t s = 0; s < sets; ++s)
        measures.add(model, boxes, model.set(compared_methods[m], count, figures.seed + s));
      add_value(error, m, count, measures.error());
      add_value(rho, m, count, measures.mean_rho());
      add_value(mean, m, count, measures.mean_distance / sets);
      add_value(time, m, count, 1e6 * measures.seconds / sets / count);
      table.rows.push_back({compared_methods[m].name, count, sets, measures.error(), measures.mean_rho(),
                            measures.least_rho, measures.mean_distance / sets});
    }
  const std::string stem = "spaced_" + name;
  figures.plot(stem + "_boxes", error,
               fmt::format("Root mean square over {} boxes and all sets", boxes.size()));
  figures.plot(stem + "_rho", rho, "Mean over the sets");
  figures.plot(stem + "_mean_distance", mean, "Distance to the nearest sample: mean over samples and sets");
  figures.plot(stem + "_time", time,
               "Cutting into strata and placing, all threads; of sample elimination with its five times as "
               "many samples");
  figures.table(stem + "_sets", "Means over the sets; error: root mean square", table);
}

// ---- difference maps

// Those whose maps are drawn.
bool is_mapped(std::size_t method) {
  return method != random_method && compared_methods[method].spacing != SpacingKind::fast;
}

void draw_differences(FigureSet& figures, const std::string& name, const ComparedModel& model) {
  const std::uint32_t sets = figures.quick ? 2 : 10, count = figures.quick ? 1000 : 3000;
  const std::vector<double> spacing(count, std::sqrt(model.surface().total_area / count));
  const auto map_of = [&](const ComparedMethod& method, std::uint32_t of, std::uint64_t first_seed) {
    DifferenceMap map = make_difference_map();
    for (std::uint32_t s = 0; s < of; ++s) {
      const ComparedSet set = model.set(method, count, first_seed + s);
      add_surface_differences(map, set.points, set.normals, spacing);
    }
    return map;
  };
  const DifferenceMap random = map_of(compared_methods[random_method], 4 * sets, figures.seed + 1000);
  Plot plot;
  plot.title = name + ": geodesic differences";
  plot.x.label = "distance / sqrt(area / n)";
  plot.y = {"pairs / those of random samples", AxisScale::linear, 0.0, {}};
  plot.legend = LegendPlace::right;
  plot.width = 720;
  plot.guides.push_back({1, false, "random"});
  std::vector<CaptionedPicture> maps;
  for (std::size_t m = 0; m < compared_methods.size(); ++m) {
    if (!is_mapped(m)) continue;
    const DifferenceMap map = map_of(compared_methods[m], sets, figures.seed);
    const std::vector<double> ratio = normalised_differences(map, random);
    const RadialProfile profile = radial_differences(map, ratio, 2);
    plot.series.push_back(profile_series(compared_methods[m].name, profile, profile.mean, map.cell()));
    plot.series.back().colour = m;
    if (m == spaced_method) plot.series.back().line_width = 3;
    maps.push_back({grey_map(ratio, map.side(), 2, 256), compared_methods[m].name, {}});
  }
  const std::string stem = "spaced_" + name + "_differences";
  figures.picture(stem, picture_row(maps, row_look()),
                  "Differences between samples, to 4 mean spacings: black none, white twice those of random");
  figures.plot(stem + "_radial", plot,
               fmt::format("{} points, {} sets against {} random ones", count, sets, 4 * sets));
}

// ---- spectra

void draw_spectra_of_sets(FigureSet& figures) {
  figures.begin("Spaced samples: power spectra in the plane");
  constexpr std::uint32_t count = 1024;
  const std::uint32_t sets = figures.quick ? 4 : 20;
  const double root = std::sqrt(static_cast<double>(count));
  const ComparedModel model(square_mesh(16), count);
  const PreparedMesh& mesh = model.surface();
  Plot power, anisotropy;
  power.title = "Radially averaged power";
  power.x.label = anisotropy.x.label = "f / sqrt(n)";
  power.y = {"power", AxisScale::linear, 0.0, {}};
  anisotropy.title = "Anisotropy";
  anisotropy.y = {"dB", AxisScale::linear, -20.0, 20.0};
  std::vector<CaptionedPicture> maps;
  for (std::size_t m = 0; m < compared_methods.size(); ++m) {
    PowerSpectrum spectrum = make_power_spectrum(static_cast<std::uint32_t>(2.5 * root));
    for (std::uint32_t s = 0; s < sets; ++s) {
      const ComparedSet set = model.set(compared_methods[m], count, figures.seed + s);
      std::vector<double> x, y;
      for (std::size_t i = 0; i < set.points.size(); i += 3) {
        x.push_back(mesh.centre.x + mesh.unit * set.points[i]);
        y.push_back(mesh.centre.y + mesh.unit * set.points[i + 1]);
      }
      add_periodogram(spectrum, x, y);
    }
    std::vector<double> map(spectrum.sum);
    for (double& p : map) p /= spectrum.sets;
    map[map.size() / 2] = 0;
    const RadialProfile profile = radial_power(spectrum);
    power.series.push_back(profile_series(compared_methods[m].name, profile, profile.mean, 1 / root));
    anisotropy.series.push_back(
        profile_series(compared_methods[m].name, profile, profile.anisotropy_db, 1 / root));
    power.series.back().colour = anisotropy.series.back().colour = m;
    if (m == spaced_method) power.series.back().line_width = 3;
    if (m == random_method || is_mapped(m))
      maps.push_back({grey_map(map, spectrum.side(), 2, 200), compared_methods[m].name, {}});
  }
  for (Plot* plot : {&power, &anisotropy}) {
    plot->legend = LegendPlace::right;
    plot->width = 720;
  }
  power.guides.push_back({1, false, "white noise"});
  anisotropy.guides.push_back(
      {-10 * std::log10(static_cast<double>(sets)), false, fmt::format("white noise, {} sets", sets)});
  figures.picture("spaced_spectrum_maps", picture_row(maps, row_look()),
                  "Periodograms at integer frequencies: black 0, white twice white noise");
  figures.plot("spaced_spectrum_power", power, fmt::format("{} points, means of {} sets", count, sets));
  figures.plot("spaced_spectrum_anisotropy", anisotropy, "Variance over each ring");
}

// ---- bias

// Share of the samples of the unit square (in working units around its centre) at most .1 sqrt(A / n) from
// its border, over the share of the area.
double border_density(const PreparedMesh& mesh, const ComparedSet& set) {
  const auto count = static_cast<double>(set.points.size() / 3);
  const double side = std::sqrt(mesh.total_area), strip = 0.1 * side / std::sqrt(count);
  double inside = 0;
  for (std::size_t i = 0; i < set.points.size(); i += 3)
    inside += 0.5 * side - std::max(std::abs(set.points[i]), std::abs(set.points[i + 1])) < strip;
  return inside / (count * (1 - std::pow(1 - 2 * strip / side, 2)));
}

void draw_bias(FigureSet& figures) {
  figures.begin("Spaced samples: bias");
  constexpr std::uint32_t count = 256;
  const std::uint32_t sets = figures.quick ? 50 : 1000;
  Table table{
      {{"samples"}, {"square", 2}, {"sphere", 2}, {"cube", 2}, {"density at the border of the square", 3}},
      {}};
  for (const ComparedMethod& method : compared_methods) table.rows.push_back({method.name});
  const std::vector<FigureMesh> meshes = {square_mesh(12), sphere_mesh(24), cube_mesh(4)};
  std::vector<double> border(compared_methods.size(), 0.0);
  for (std::size_t k = 0; k < meshes.size(); ++k) {
    figures.note("  " + meshes[k].name);
    const ComparedModel model(meshes[k], count);
    const std::vector<RotatedBox> boxes = model.boxes(300, figures.seed);
    for (std::size_t m = 0; m < compared_methods.size(); ++m) {
      BoxBias bias;
      for (std::uint32_t s = 0; s < sets; ++s) {
        const ComparedSet set = model.set(compared_methods[m], count, figures.seed + s);
        bias.add(box_errors(boxes, set.points));
        if (k == 0) border[m] += border_density(model.surface(), set) / sets;
      }
      table.rows[m].emplace_back(bias.ratio());
    }
  }
  for (std::size_t m = 0; m < border.size(); ++m) table.rows[m].emplace_back(border[m]);
  figures.table(
      "spaced_bias",
      fmt::format("Mean error of a box over {} sets of {} points, root mean square over 300 boxes, in "
                  "parts of the error of one set; samples at most .1 sqrt(area / n) from the border "
                  "of the square, over their share of the area",
                  sets, count),
      table);
  figures.text(
      "Measured",
      "`random`, `stratified` and `shifted` are unbiased by construction: what they have here is the "
      "noise of the measure.");
}

void draw_on_surface(FigureSet& figures, const FigureMesh& mesh) {
  figures.begin("Spaced samples: " + mesh.name);
  figures.attempt(mesh.name, [&] {
    const std::uint32_t most = figures.quick ? 1024 : 16384;
    const ComparedModel model(mesh, most);
    draw_errors(figures, mesh.name, model, most);
    draw_differences(figures, mesh.name, model);
  });
}

}  // namespace

void draw_spaced_samples(FigureSet& figures) {
  draw_on_surface(figures, square_mesh(32));
  FigureMesh sphere = sphere_mesh(48);
  sphere.name = "unit-sphere";
  draw_on_surface(figures, sphere);
  for (const FigureMesh& mesh : figures.meshes) draw_on_surface(figures, mesh);
  figures.text(
      "Measured",
      "Method `auto`; `spaced` along the path and in progressive order, by the efforts fast, default "
      "and best. Sample elimination (Yuksel 2015) starts from five times as many random samples; its "
      "distances, too, are those in space.");
  draw_spectra_of_sets(figures);
  draw_bias(figures);
}

}  // namespace meander
