// Points and polylines in the plane as a standalone SVG picture, alone or as panels side by side.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "io/plot/colour.h"
#include "io/plot/svg_plot.h"

namespace meander {

struct DotSet {
  std::vector<double> x{}, y{};
  double radius = 1.2;  // px
  Rgb colour{0, 0, 0};
  std::vector<Rgb> colours{};  // empty, or one per dot instead of `colour`
};

struct PlanarPolyline {
  std::vector<double> x{}, y{};
  double width = 1;  // px
  Rgb colour{0, 0, 0};
  bool closed = false;
  bool along = false;  // coloured by map_colour(lagoon) from the first point to the last instead of `colour`
};

// What is drawn in one square of paper, y upwards, one unit as long in x as in y. Lines lie under dots.
struct PlanarDrawing {
  std::string caption{};                              // below; empty: none
  double x_min = 0, x_max = 1, y_min = 0, y_max = 1;  // the window; what lies outside is left out or cut
  bool fit = false;   // the window is the bounding box of everything drawn instead, with a margin of 2 %
  bool frame = true;  // a thin box around the window
  std::vector<PlanarPolyline> lines{};
  std::vector<DotSet> dots{};
};

// How panels are laid out; px.
struct PanelGrid {
  std::string title{};   // above all; empty: none
  unsigned columns = 0;  // 0: all in one row up to 4, then the rows as even as they get
  double panel_width = 280, panel_height = 280;  // of the drawing without its caption
  double gap = 18;
};

// One drawing of at most width x height px (its caption comes on top of that). The window keeps its aspect
// and is centred. Points that are not finite are left out and interrupt polylines. Same promises about the
// text as svg_plot. O(points). Throws std::invalid_argument when x and y (or colours) of a layer differ in
// length or the window is not finite and increasing.
std::string svg_points(const PlanarDrawing& drawing, double width = 420, double height = 420);

// Drawings, row by row from the top left, each with its caption below. No drawings: an empty picture. Throws
// what svg_points throws.
std::string svg_panels(std::span<const PlanarDrawing> drawings, const PanelGrid& grid = {});

// Whole plots as panels; their own width and height are replaced by those of the grid, their title stands
// above them. Throws what svg_plot throws.
std::string svg_panels(std::span<const Plot> plots, const PanelGrid& grid);

}  // namespace meander
