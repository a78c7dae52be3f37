// The stages of anisotropic sampling: field, density, segments, charts, and the tensors at the samples
// (docs/METHODS.md 9).
#pragma once

#include "kernels/sample_mesh.h"

namespace meander {

// Fills model.tensor, model.density and the report's measure; cuts the mesh into segments (and, for charts
// that follow the directions, through the field's singularities): from here on the components of model.mesh
// are the segments. Measures lengths in the field's metric, if the charts do.
void make_tensor_segments(ModelState& model, const SampleParameters& parameters);

// Charts of all segments; segments whose chart does not follow the field well enough are bisected and charted
// again, in rounds. Fills model.charts, model.masses and model.anisotropy.
void flatten_segments(ModelState& model, const SampleParameters& parameters);

// Samples::tensor_direction and tensor_spacing of the placed samples.
void add_sample_tensors(ModelState& model);

}  // namespace meander
