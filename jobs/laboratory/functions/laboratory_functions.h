// The functions of the laboratory over arrays, which Python calls by name (meander.laboratory).
#pragma once

#include <span>
#include <vector>

#include "jobs/python/laboratory_call.h"
#include "kernels/analyse/box_discrepancy.h"
#include "kernels/mesh/prepared_mesh.h"
#include "kernels/model/sample_parameters.h"

namespace meander {

// The options run (a list of those of `meander run`), n, seed and leaves_per_sample.
SampleParameters parameters_of(const LaboratoryArguments& given);
// A mesh or a staged model with n samples, by the same options except n, seed, sequence and order.
Model sampled_model(const LaboratoryArguments& given);

// Random boxes on the surface, by the options boxes and seed. Throws ItemError(zero_area) if there are none.
std::vector<RotatedBox> boxes_on(const PreparedMesh& surface, const LaboratoryArguments& given);

struct LaboratoryFunction {
  const char* name;
  LaboratoryResult (*call)(const LaboratoryArguments&);
};

// The functions by subject, one source file each.
extern const std::span<const LaboratoryFunction> histogram_functions, measure_functions, model_functions,
    picture_functions, plane_functions, splat_functions, surface_functions, tensor_functions;

}  // namespace meander
