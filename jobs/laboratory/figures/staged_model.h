// A mesh taken through the stages up to its charts once, then sampled many times.
#pragma once

#include <cstdint>
#include <memory>

#include "jobs/laboratory/figures/figure_set.h"
#include "kernels/model/model.h"

namespace meander {

class EmbreeDevice;

// Prepared, and with field, segments, cuts and charts as far as the method has them. `table`: of the tensor
// kind table. Throws ItemError.
Model staged_model(const FigureMesh& mesh, const SampleParameters& parameters,
                   std::shared_ptr<const TensorTable> table = nullptr);

// Samples from a copy of it; everything but the number, the seed and the sequence as it was staged with, and
// no more samples than its charts were made for.
Row sampled_row(const Model& staged, SampleParameters parameters, std::uint32_t count, std::uint64_t seed,
                const EmbreeDevice& device);

}  // namespace meander
