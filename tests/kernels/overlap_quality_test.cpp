// The benefit of rays: where a chart overlaps itself, sheets reduce the error to that of a chart without
// overlap.
#include <cmath>
#include <numbers>

#include "kernels/analyse/box_discrepancy.h"
#include "kernels/model/model.h"
#include "support/catch.h"
#include "support/hand_charts.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

constexpr double turns =
    1.4;  // of the ramp: 0.4 of a turn lies over another 0.4, 28 % of its area seen from above

// A spiral ramp of radius 1 to 2 that rises by 0.6 a turn.
PolygonMesh spiral_ramp() {
  PolygonMesh mesh = grid_plane(160, 16, turns, 1);
  for (std::size_t v = 0; v < mesh.x.size(); ++v) {
    const double turn = mesh.x[v], radius = 1 + mesh.y[v];
    mesh.x[v] = radius * std::cos(2 * std::numbers::pi * turn);
    mesh.y[v] = radius * std::sin(2 * std::numbers::pi * turn);
    mesh.z[v] = 0.6 * turn;
  }
  return mesh;
}

// Seen from above: the ends of the ramp lie over each other.
std::pair<double, double> from_above(Vector3 p) { return {0.5 + 0.24 * p.x, 0.5 + 0.24 * p.y}; }

// Unrolled: a straight strip of nearly the same lengths.
std::pair<double, double> unrolled(Vector3 p) {
  const double turn = p.z / 0.6, radius = std::hypot(p.x, p.y);
  return {0.01 + 0.07 * 2 * std::numbers::pi * 1.5 * turn, 0.4 + 0.07 * (radius - 1)};
}

// Root mean square over seeds of the error over rotated boxes, relative to random points.
double error_of(const ChartMap& map, LocatorKind locate, std::uint32_t samples) {
  Model model;
  SampleParameters parameters = parameters_for("conformal");
  parameters.locate = locate;
  parameters.samples = samples;
  model.file = spiral_ramp();
  charting_stages(parameters).front().run(model);
  model.charts = {hand_chart(model.surface, model.surface.components[0], map)};
  BoxParameters box;
  box.boxes = 400;
  const auto boxes = random_boxes(model.file.x, model.file.y, model.file.z, model.file.corners, box);
  const EmbreeDevice device;
  double sum = 0;
  constexpr int seeds = 16;
  for (std::uint64_t seed = 0; seed < seeds; ++seed) {
    model.key = make_random_key(seed, {});
    run_stages(placing_stages(parameters, &device), model);
    const std::vector<double> points(model.row.samples.points.begin(), model.row.samples.points.end());
    const double ratio = box_error_ratio(boxes, points);
    sum += ratio * ratio / seeds;
  }
  return std::sqrt(sum);
}

}  // namespace

TEST_CASE("overlap quality: sheets bring an overlapping chart within 15 % of one without overlap") {
  const std::uint32_t samples = 2048;
  const double flat = error_of(unrolled, LocatorKind::embree, samples);
  const double sheets = error_of(from_above, LocatorKind::embree, samples);
  const double mixed = error_of(from_above, LocatorKind::elements, samples);
  WARN("error relative to random points: without overlap "
       << flat << ", overlap with sheets " << sheets << ", overlap without sheets (elements) " << mixed);
  CHECK(sheets <= 1.15 * flat);
  CHECK(mixed > 1.2 * sheets);
}
