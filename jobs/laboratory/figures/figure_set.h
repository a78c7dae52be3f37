// What the figures share: where they go, the page that shows them, and how large they are.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "io/plot/html_page.h"
#include "io/plot/svg_plot.h"
#include "io/plot/svg_points.h"
#include "kernels/core/vector3.h"
#include "kernels/mesh/prepared_mesh.h"
#include "kernels/render/rgb_image.h"

namespace meander {

// A triangle mesh that figures sample: from a file, or made here.
struct FigureMesh {
  std::string name;
  std::vector<double> positions;     // 3 V
  std::vector<std::uint32_t> faces;  // 3 T
};

// Names of the files that figures are written to: figure05_uniform.svg, table1_claims.csv ... What else
// stands in the folder is left alone.
bool is_figure_file(const std::string& name);

class FigureSet {
 public:
  FigureSet(std::filesystem::path folder, bool quick_ones, std::uint64_t seed_of_all,
            std::vector<FigureMesh> sampled_meshes, std::function<void(const std::string&)> note)
      : quick(quick_ones),
        seed(seed_of_all),
        meshes(std::move(sampled_meshes)),
        folder_(std::move(folder)),
        note_(std::move(note)) {}

  const bool quick;
  const std::uint64_t seed;
  const std::vector<FigureMesh> meshes;

  // Opens a figure of the page; pictures and texts below belong to it until the next one.
  void begin(const std::string& heading);
  void note(const std::string& text) const { note_(text); }
  void plot(const std::string& stem, const Plot& plot, const std::string& caption);  // SVG and CSV
  void drawing(const std::string& stem, const std::string& svg, const std::string& caption);
  void picture(const std::string& stem, const RgbImage& image, const std::string& caption);  // PNG
  void table(const std::string& stem, const std::string& caption, const Table& table);       // CSV and page
  void data(const std::string& name, const std::string& bytes);  // linked from the page
  void text(const std::string& label, const std::string& text);
  // Draws; a mesh that cannot be sampled is said on the page, and the other figures go on.
  void attempt(const std::string& mesh, const std::function<void()>& draw);

  FigurePage page;
  Vector3 up{0, 1, 0}, view{0.55, 0.42, 1};  // of the meshes in pictures that are painted

 private:
  std::filesystem::path file(const std::string& name) const;

  std::filesystem::path folder_;
  std::function<void(const std::string&)> note_;
};

// The figures, by subject. Each takes what it needs from the set and adds to its page.
void draw_point_sets(FigureSet& figures);            // figure 1
void draw_stretched_plane(FigureSet& figures);       // figure 2
void draw_curves(FigureSet& figures);                // figure 3
void draw_plane_discrepancy(FigureSet& figures);     // figure 4, the plane, and placement
void draw_sphere_discrepancy(FigureSet& figures);    // figure 4, the sphere
void draw_mesh_discrepancy(FigureSet& figures);      // figure 4, meshes
void draw_density_discrepancy(FigureSet& figures);   // figure 5
void draw_surfaces(FigureSet& figures);              // figure 6
void draw_from_mesh_to_splats(FigureSet& figures);   // figure 7
void draw_adaptive_curve(FigureSet& figures);        // figure 8
void draw_splats_beside_models(FigureSet& figures);  // figure 9
void draw_remeshed_models(FigureSet& figures);       // figure 10
void draw_view_detail(FigureSet& figures);           // figure 11
void draw_tensor_fields(FigureSet& figures);         // figure 12
void draw_segments(FigureSet& figures);              // figure 13
void draw_anisotropic_samples(FigureSet& figures);   // figure 14
void draw_tensor_discrepancy(FigureSet& figures);    // figure 15
void draw_tensor_differences(FigureSet& figures);    // figure 16, anisotropic samples
void draw_spectra(FigureSet& figures);               // figure 16
void draw_tensor_splats(FigureSet& figures);         // figure 17
void draw_strokes(FigureSet& figures);               // figures 18 to 20
void draw_mesh_distances(FigureSet& figures);        // figure 21
void draw_remeshed(FigureSet& figures);              // the survey's Metro table
void draw_distance_histograms(FigureSet& figures);   // figures 22 to 24 and table 1
void draw_histogram_floors(FigureSet& figures);      // what remains of the error with many points
void draw_geodesic_histograms(FigureSet& figures);   // figures 25 and 26
void draw_spaced_samples(FigureSet& figures);        // samples that keep their distance, by every measure
void draw_spaced_sets(FigureSet& figures);           // and beside others on models

// ---- errors over the number of points ---------------------------------------------------------------------

// Values of several measures over a series of numbers of points: mean and spread over the runs.
struct ErrorSeries {
  std::string name;
  std::vector<double> counts;
  std::vector<std::vector<double>> runs;  // by count: one value a run
};
PlotSeries plot_series(const ErrorSeries& errors, std::size_t colour);
// Name, slope with its standard error over counts >= `least`, and the mean values at some counts.
Table slope_table(const std::vector<ErrorSeries>& series, double least, const std::vector<double>& shown);
Plot error_plot(const std::string& title, const std::vector<ErrorSeries>& series, const std::string& measure);

}  // namespace meander
