// The tables of `meander measure`, one function for each measure.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "io/table/table.h"
#include "jobs/inputs/store_items.h"
#include "jobs/laboratory/measured_sets.h"

namespace meander {

struct MeasureOptions {
  std::string what;
  std::vector<std::string> inputs;
  std::string surface, csv, picture;
  std::uint32_t shapes = 0;  // 0: the measure's own default
  std::uint64_t seed = 1;
  bool seed_given = false;
  std::uint64_t samples = 0;  // for `distance`: on each surface; 0: 100,000
  bool json = false;
  StoreCheck check = StoreCheck::every_byte;
};

// Each function reads the sets one after the other and throws UsageError for a set or a surface that it
// cannot measure. Its rows are sets, except for `integral` (integrands and numbers of points), and `spectrum`
// and `differences` (rings), which also draw their map to options.picture.
Table measure_boxes(PointSets& sets, MeasuredSurfaces& surfaces, const MeasureOptions& options);
Table measure_rings(PointSets& sets, MeasuredSurfaces& surfaces, const MeasureOptions& options);
Table measure_spacing(PointSets& sets, MeasuredSurfaces& surfaces, const MeasureOptions& options);
Table measure_modes(PointSets& sets, MeasuredSurfaces& surfaces, const MeasureOptions& options);
Table measure_discrepancy(PointSets& sets, MeasuredSurfaces& surfaces, const MeasureOptions& options);
Table measure_integral(PointSets& sets, MeasuredSurfaces& surfaces, const MeasureOptions& options);
Table measure_spectrum(PointSets& sets, MeasuredSurfaces& surfaces, const MeasureOptions& options);
Table measure_differences(PointSets& sets, MeasuredSurfaces& surfaces, const MeasureOptions& options);
// Measures the distances between the two meshes that are the inputs.
Table measure_distance(const MeasureOptions& options);

}  // namespace meander
