// Figure 16: spectra and differential domain analysis.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "jobs/laboratory/figures/figure_set.h"
#include "jobs/laboratory/figures/radial_figures.h"
#include "kernels/analyse/differential_domain.h"
#include "kernels/analyse/spectrum.h"
#include "kernels/model/sampler.h"
#include "kernels/pointset/planar_points.h"
#include "kernels/surface/sample_surface.h"
#include "kernels/surface/surface.h"

namespace meander {

namespace {

void draw_planar_spectra(FigureSet& figures) {
  figures.begin("Figure 16, plane: power spectra");
  constexpr std::uint32_t count = 1024;
  const std::uint32_t sets = 10;
  const double root = std::sqrt(static_cast<double>(count));
  Plot power, anisotropy;
  power.title = "Radially averaged power";
  power.x.label = anisotropy.x.label = "f / sqrt(n)";
  power.y = {"power", AxisScale::linear, 0.0, 2.5};
  anisotropy.title = "Anisotropy";
  anisotropy.y = {"dB", AxisScale::linear, -20.0, 20.0};
  for (const PlanarMethod method :
       {PlanarMethod::random, PlanarMethod::jittered, PlanarMethod::hilbert_stratified,
        PlanarMethod::hilbert_shifted, PlanarMethod::hilbert_regular, PlanarMethod::poisson_disk}) {
    PowerSpectrum spectrum = make_power_spectrum(static_cast<std::uint32_t>(2.5 * root));
    const std::uint32_t own_sets = is_deterministic(method) ? 1 : sets;
    for (std::uint32_t s = 0; s < own_sets; ++s) {
      const PlanarPoints points = planar_points(method, count, figures.seed + s);
      add_periodogram(spectrum, points.x, points.y);
    }
    std::vector<double> map(spectrum.sum);
    for (double& p : map) p /= spectrum.sets;
    map[map.size() / 2] = 0;
    const RadialProfile profile = radial_power(spectrum);
    const std::string name(name_of(method));
    power.series.push_back(profile_series(name, profile, profile.mean, 1 / root));
    anisotropy.series.push_back(profile_series(name, profile, profile.anisotropy_db, 1 / root));
    figures.picture("figure16_spectrum_" + name, grey_map(map, spectrum.side(), 2), name);
  }
  power.guides.push_back({1, false, "white noise"});
  anisotropy.guides.push_back({-10, false, "white noise, 10 sets"});
  figures.plot("figure16_power", power,
               fmt::format("{} points, means of {} sets (regular: the one there is)", count, sets));
  figures.plot("figure16_anisotropy", anisotropy, "Variance over each ring; one set would lie at 0 dB");
  figures.text("Measured", "Periodograms at integer frequencies, black 0, white 2 times white noise.");
  figures.text("The survey",
               "Stratified samples along the curve have the spectrum of blue noise. Measured: low "
               "frequencies are missing, but there is no peak; regular samples have spikes.");
}

using Points = PlanarPoints;

// The map of several sets over that of as many independent ones of the same density and number.
void draw_density_differences(FigureSet& figures, const std::string& stem, const std::string& title,
                              const std::string& expression, std::uint32_t count) {
  const auto plane = make_surface("plane");
  const std::uint32_t sets = figures.quick ? 2 : 10;
  DifferenceMap random = make_difference_map(), stratified = make_difference_map();
  for (std::uint32_t s = 0; s < 4 * sets; ++s)
    for (const SequenceKind sequence : {SequenceKind::random, SequenceKind::shifted}) {
      if (sequence == SequenceKind::shifted && s >= sets) continue;
      SurfaceSampleParameters parameters;
      parameters.samples = count;
      parameters.seed = figures.seed + s;
      parameters.sequence = sequence;
      parameters.density = {SurfaceDensityKind::expression, expression, 0.02, 1, 0.99};
      const SurfaceSamples samples = sample_surface(*plane, parameters);
      std::vector<double> x, y, density(samples.density.begin(), samples.density.end());
      for (std::size_t i = 0; i < samples.count(); ++i) {
        x.push_back(samples.uv[2 * i]);
        y.push_back(samples.uv[2 * i + 1]);
      }
      // Spacings beyond 8 times the mean would make every pair of a nearly empty region a neighbour.
      const std::vector<double> spacing =
          spacing_from_density(density, samples.measure, 8 / std::sqrt(static_cast<double>(count)));
      add_density_differences(sequence == SequenceKind::random ? random : stratified, x, y, spacing);
    }
  const std::vector<double> ratio = normalised_differences(stratified, random);
  figures.picture(stem, grey_map(ratio, stratified.side(), 2), title);
  const RadialProfile profile = radial_differences(stratified, ratio, 2);
  Plot plot;
  plot.title = title;
  plot.x.label = "distance / local spacing";
  plot.y = {"pairs / white noise", AxisScale::linear, 0.0, 1.5};
  plot.series.push_back(profile_series("shifted", profile, profile.mean, stratified.cell()));
  plot.guides.push_back({1, false, "white noise"});
  figures.plot(stem + "_radial", plot,
               fmt::format("{} points, {} sets against {} random ones", count, sets, 4 * sets));
}

void draw_mesh_differences(FigureSet& figures, const FigureMesh& mesh) {
  const std::uint32_t sets = figures.quick ? 2 : 10, count = 3000;
  SampleParameters parameters;
  set_samples(parameters, count);
  DifferenceMap random = make_difference_map(), shifted = make_difference_map();
  for (std::uint32_t s = 0; s < 4 * sets; ++s)
    for (const SequenceKind sequence : {SequenceKind::random, SequenceKind::shifted}) {
      if (sequence == SequenceKind::shifted && s >= sets) continue;
      parameters.seed = figures.seed + s;
      parameters.place.sequence = sequence;
      parameters.method = parameters_for(sequence == SequenceKind::random ? "direct" : "conformal").method;
      const Row row = Sampler(parameters).sample(mesh.positions, mesh.faces);
      if (row.report.status != Status::ok) throw ItemError(row.report.status, row.report.reason);
      const std::vector<double> points(row.samples.points.begin(), row.samples.points.end()),
          normals(row.samples.normals.begin(), row.samples.normals.end());
      add_surface_differences(sequence == SequenceKind::random ? random : shifted, points, normals,
                              std::vector<double>(count, std::sqrt(row.report.area / count)));
    }
  const std::vector<double> ratio = normalised_differences(shifted, random);
  const std::string stem = "figure16_mesh_" + mesh.name;
  figures.picture(stem, grey_map(ratio, shifted.side(), 2), mesh.name);
  const RadialProfile profile = radial_differences(shifted, ratio, 2);
  Plot plot;
  plot.title = mesh.name + ": geodesic differences";
  plot.x.label = "distance / spacing";
  plot.y = {"pairs / white noise", AxisScale::linear, 0.0, 1.5};
  plot.series.push_back(profile_series("conformal, shifted", profile, profile.mean, shifted.cell()));
  plot.guides.push_back({1, false, "white noise"});
  figures.plot(stem + "_radial", plot, fmt::format("{} points, {} sets", count, sets));
}

}  // namespace

void draw_spectra(FigureSet& figures) {
  draw_planar_spectra(figures);
  figures.begin("Figure 16: differential domain analysis");
  draw_density_differences(figures, "figure16_blob", "Gaussian blob", "blob", 2500);
  draw_density_differences(figures, "figure16_balzer", "Balzer density", "balzer", 10000);
  for (const FigureMesh& mesh : figures.meshes)
    figures.attempt(mesh.name, [&] { draw_mesh_differences(figures, mesh); });
  figures.text("Measured",
               "Histograms of differences between samples in units of the wanted local spacing, over those "
               "of random sets of the same density: 1 is white noise, black 0, white 2.");
  figures.text("The survey",
               "A dip around 0 that rises to 1 at the mean spacing, the same in all directions, for "
               "2,500 (blob), 10,000 (Balzer) and 3,000 samples (bunny).");
}

}  // namespace meander
