// The stages of a method over meshes in memory: what <meander/sampler.h> and the Python package stand on.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "kernels/core/cancel.h"
#include "kernels/data/samples.h"
#include "kernels/mesh/polygon_mesh.h"
#include "kernels/model/sample_parameters.h"
#include "kernels/public/sampler.h"

namespace meander {

// Samples meshes with one set of parameters. Holds what all of them share: the stages of the method and, for
// methods that cast rays, one Embree device. sample() may be called from any number of threads at a time.
class ModelSampler {
 public:
  // Throws std::invalid_argument with all that validate() finds, ItemError(out_of_memory) when Embree cannot
  // be started.
  explicit ModelSampler(const SampleParameters& parameters);
  ~ModelSampler();
  ModelSampler(ModelSampler&&) noexcept;
  ModelSampler& operator=(ModelSampler&&) noexcept;

  const SampleParameters& parameters() const;

  // Returns a row as `meander run` stores it; content, statuses, errors and cost: see Sampler::sample. Takes
  // the mesh by value: move it in where it is not needed again.
  Row sample(PolygonMesh mesh, std::span<const std::uint8_t> content = {},
             const CancelToken& cancel = {}) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Copies the arrays. Throws std::invalid_argument when their lengths do not fit each other,
// ItemError(unsupported_format) for more than 32 bits can number.
PolygonMesh polygon_mesh_of(const Mesh& mesh);

}  // namespace meander
