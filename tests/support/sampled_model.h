// A model charted once and sampled with many seeds, and what is measured of its samples.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "kernels/analyse/box_discrepancy.h"
#include "kernels/analyse/spacing.h"
#include "kernels/model/model.h"
#include "support/shared_mesh.h"

namespace meander::test {

// A prepared model; only its last stages run again for every seed.
struct SpacedModel {
  Model state;
  SampleParameters parameters;

  SpacedModel(PolygonMesh file, const char* method, SequenceKind sequence, OrderKind order,
              SpacingKind spacing = SpacingKind::standard)
      : parameters(parameters_for(method)) {
    parameters.sequence = sequence;
    parameters.order = order;
    parameters.spacing = spacing;
    state.file = std::move(file);
    run_stages(charting_stages(parameters), state);
  }

  // In the working units of the prepared mesh, in the order of the file.
  std::vector<double> points(std::uint32_t n, std::uint64_t seed) {
    static const EmbreeDevice device;
    parameters.samples = n;
    state.key = make_random_key(seed, {});
    run_stages(placing_stages(parameters, &device), state);
    const ItemReport& report = state.row.report;
    const double center[3] = {state.surface.center.x, state.surface.center.y, state.surface.center.z};
    const std::vector<float>& stored = state.row.samples.points;
    std::vector<double> points(stored.size());
    for (std::size_t i = 0; i < points.size(); ++i)
      points[i] = (report.loc[i % 3] + report.scale * static_cast<double>(stored[i]) - center[i % 3]) /
                  state.surface.unit;
    return points;
  }
  double rho(std::span<const double> points) const {
    return spacing_of(nearest_distances(points), state.surface.total_area).rho;
  }
  std::vector<RotatedBox> boxes(std::uint32_t count) const {
    BoxParameters wanted;
    wanted.boxes = count;
    return random_boxes(state.surface.x, state.surface.y, state.surface.z, state.surface.triangles, wanted);
  }
};

}  // namespace meander::test
