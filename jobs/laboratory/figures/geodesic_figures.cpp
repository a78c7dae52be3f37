// Figures 25 and 26: histograms of geodesic distances between samples.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "io/table/text_table.h"
#include "jobs/laboratory/figures/histogram_figures.h"
#include "kernels/core/random.h"
#include "kernels/describe/heat_geodesics.h"

namespace meander {

namespace {

const std::string every_vertex = "all vertices", area_weighted = "vertices by area";

// The bin of a distance; those above the range are in the last one.
std::size_t bin_of(double distance, double range) {
  return static_cast<std::size_t>(std::min(distance / range * histogram_bins, histogram_bins - 1.0));
}

void normalise(std::vector<double>& shares) {
  const double sum = std::accumulate(shares.begin(), shares.end(), 0.0);
  for (double& share : shares) share /= sum;
}

// The largest distance met on going to the farthest vertex again and again: the diameter, or nearly.
double far_distance(const HeatGeodesics& geodesics, const PreparedMesh& mesh) {
  std::vector<double> distance(mesh.vertex_count());
  std::uint32_t from = 0;
  double largest = 0;
  for (int step = 0; step < 8; ++step) {
    geodesics.to_vertices(vertices_as_points(mesh, std::span(&from, 1)), distance);
    for (std::uint32_t v = 0; v < distance.size(); ++v)
      if (!std::isfinite(distance[v])) distance[v] = 0;
    from = static_cast<std::uint32_t>(std::max_element(distance.begin(), distance.end()) - distance.begin());
    largest = std::max(largest, distance[from]);
  }
  return largest;
}

// Shares of the pairs of one of `sources` and any other vertex: all alike, and weighted by area.
struct GeodesicTruths {
  std::vector<double> alike, by_area;
};
GeodesicTruths ground_truths(const HeatGeodesics& geodesics, const HistogramModel& model,
                             const std::vector<std::uint32_t>& sources, double range) {
  const PreparedMesh& mesh = model.charted.surface;
  const std::size_t vertices = mesh.vertex_count(), block = 256;
  GeodesicTruths truths{std::vector<double>(histogram_bins), std::vector<double>(histogram_bins)};
  std::vector<double> distance(block * vertices);
  for (std::size_t begin = 0; begin < sources.size(); begin += block) {
    const std::size_t rows = std::min(block, sources.size() - begin);
    geodesics.to_vertices(vertices_as_points(mesh, std::span(sources).subspan(begin, rows)),
                          std::span(distance).first(rows * vertices));
    for (std::size_t r = 0; r < rows; ++r) {
      const std::uint32_t source = sources[begin + r];
      for (std::size_t v = 0; v < vertices; ++v) {
        const double d = distance[r * vertices + v];
        if (v == source || !std::isfinite(d)) continue;
        const std::size_t bin = bin_of(d, range);
        truths.alike[bin] += 1;
        truths.by_area[bin] += model.vertex_area[source] * model.vertex_area[v];
      }
    }
  }
  normalise(truths.alike);
  normalise(truths.by_area);
  return truths;
}

// Shares of all pairs of samples, with multiplicity.
std::vector<double> sample_shares(const HeatGeodesics& geodesics, const PreparedMesh& mesh,
                                  const std::vector<std::uint32_t>& vertices, double range) {
  const PointsOnMeshArrays points = vertices_as_points(mesh, vertices);
  const std::size_t count = vertices.size();
  std::vector<double> distance(count * count), shares(histogram_bins);
  geodesics.to_points(points, points, distance);
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t j = 0; j < count; ++j)
      if (i != j && std::isfinite(distance[i * count + j]))
        shares[bin_of(distance[i * count + j], range)] += 1;
  normalise(shares);
  return shares;
}

std::vector<HistogramErrors> draw_one_model(FigureSet& figures, const FigureMesh& mesh,
                                            const EmbreeDevice& device) {
  const HistogramModel model(mesh, figures.seed);
  const PreparedMesh& surface = model.charted.surface;
  const KdTree<3> tree(model.vertices);
  const HeatGeodesics geodesics(surface);
  const double range = far_distance(geodesics, surface);
  if (!(range > 0)) throw ItemError(Status::zero_area, "all vertices are at one place");

  // All vertices where time allows it, else one of every so many.
  const std::size_t most = figures.quick ? 256 : 8192, vertices = surface.vertex_count();
  std::vector<std::uint32_t> sources(std::min(most, vertices));
  const RandomKey key = make_random_key(figures.seed, {});
  for (std::size_t s = 0; s < sources.size(); ++s) {
    const double u = sources.size() == vertices ? 0.5 : random_pair(key, Stream::point_set, s).first;
    const auto at = static_cast<std::size_t>((static_cast<double>(s) + u) * static_cast<double>(vertices) /
                                             static_cast<double>(sources.size()));
    sources[s] = static_cast<std::uint32_t>(std::min(at, vertices - 1));
  }
  const GeodesicTruths truths = ground_truths(geodesics, model, sources, range);
  figures.note(fmt::format("  ground truths from {} vertices made", sources.size()));

  std::vector<HistogramErrors> all;
  ShownHistograms shown{truths.alike, truths.by_area, {}};
  const std::vector<std::uint32_t> counts = histogram_counts(figures.quick ? 500 : 1000);
  for (const HistogramMethod method :
       {HistogramMethod::shifted, HistogramMethod::random, HistogramMethod::spaced}) {
    HistogramErrors alike{every_vertex, name_of(method)}, by_area{area_weighted, name_of(method)};
    for (const std::uint32_t count : counts) {
      alike.open(count);
      by_area.open(count);
      const std::uint32_t runs = figures.quick ? 5 : count > 500 ? 3 : 10;
      for (std::uint32_t run = 0; run < runs; ++run) {
        const std::vector<double> shares = sample_shares(
            geodesics, surface,
            nearest_vertices(tree, model, draw_samples(model, method, count, run, device)), range);
        alike.add(shares, truths.alike);
        by_area.add(shares, truths.by_area);
        if (run == 0 && count == 100) shown.samples.emplace_back(name_of(method), shares);
      }
    }
    all.push_back(std::move(alike));
    all.push_back(std::move(by_area));
  }

  const Plot histograms =
      histogram_plot(mesh.name + ": geodesic distances, 100 samples", "geodesic distance", shown, range);
  figures.plot("figure25_geodesic_histograms_" + mesh.name, histograms,
               "Ground truths over the vertices, and one set of each kind, snapped to vertices");
  for (const bool relative : {true, false}) {
    const std::string suffix = mesh.name + (relative ? "_relative" : "_largest");
    figures.plot("figure26_geodesic_published_" + suffix,
                 histogram_error_plot(mesh.name + ": geodesic, as published", all, every_vertex, relative, 0),
                 "Samples snapped to vertices against all vertices alike");
    figures.plot(
        "figure26_geodesic_weighted_" + suffix,
        histogram_error_plot(mesh.name + ": geodesic, vertices by area", all, area_weighted, relative, 0),
        "Samples snapped to vertices against vertices weighted by area");
  }
  figures.data("figure26_geodesic_errors_" + mesh.name + ".csv", csv_text(histogram_error_table(all)));
  figures.text(
      "Measured",
      fmt::format("Distances by the heat method; ground truths from {} of {} vertices to all. Means and "
                  "standard errors over 10 runs to 500 points, 3 above (5 with --quick).",
                  sources.size(), vertices));
  return all;
}

}  // namespace

void draw_geodesic_histograms(FigureSet& figures) {
  const EmbreeDevice device;
  Table errors = histogram_error_table({}), claims = claim_table();
  errors.columns.insert(errors.columns.begin(), {"model"});
  for (const FigureMesh& mesh : figures.meshes) {
    figures.begin("Figures 25 and 26, geodesic distances between samples: " + mesh.name);
    figures.attempt(mesh.name, [&] {
      const std::vector<HistogramErrors> all = draw_one_model(figures, mesh, device);
      for (std::vector<TableCell>& row : histogram_error_table(all).rows) {
        row.insert(row.begin(), mesh.name);
        errors.rows.push_back(row);
      }
      add_claims(claims, mesh.name, all, {every_vertex, area_weighted});
    });
  }
  figures.begin("Geodesic histograms: errors of all models");
  figures.table("figure26_geodesic_errors", "Errors, their deviation over runs and standard errors", errors);
  figures.table("figure26_geodesic_claims", "Claims, decided at two standard errors of the difference",
                claims);
  write_json(figures, "figure26_geodesic", {{"errors", errors}, {"claims", claims}});
  figures.note(text_table(errors));
}

}  // namespace meander
