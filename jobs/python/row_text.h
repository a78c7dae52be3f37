// Rows and meshes as JSON that says where their arrays are: what meander_text of interface.h gives.
#pragma once

#include <string>
#include <vector>

#include "jobs/python/array_mesh.h"
#include "jobs/python/laboratory_call.h"
#include "jobs/python/sample_queue.h"

namespace meander {

// A row and what is computed from it: the shares of the surface in area (measure / (n density)).
struct WeightedRow {
  explicit WeightedRow(SampledRow row);
  SampledRow sampled;
  std::vector<double> weights;
};

// The members of meander.Samples by name; null for arrays that the row does not have. Of a row that is not ok
// its status and reason.
std::string text_of(WeightedRow& row);

// vertices are x, y and z by themselves; corners of faces that do not all have equally many: null.
std::string text_of(ContentMesh& mesh);

// The result of a function of the laboratory: {"numbers": {...}, "arrays": {...}}.
std::string text_of(LaboratoryResult& result);

}  // namespace meander
