// Sampling meshes from a C++ program: no files, no store, no graph.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "kernels/core/cancel.h"
#include "kernels/data/samples.h"
#include "kernels/mesh/polygon_mesh.h"
#include "kernels/model/sample_parameters.h"

namespace meander {

// Samples meshes with one set of parameters. Holds what all of them share: the stages of the method and, for
// methods that cast rays, one Embree device. sample() may be called from any number of threads at a time.
//
//   SampleParameters parameters;
//   parameters.samples = 2048;
//   const Sampler sampler(parameters);
//   const Row row = sampler.sample(positions, faces);
class Sampler {
 public:
  // Throws std::invalid_argument with all that validate() finds, ItemError(out_of_memory) when Embree cannot
  // be started.
  explicit Sampler(const SampleParameters& parameters);
  ~Sampler();
  Sampler(Sampler&&) noexcept;
  Sampler& operator=(Sampler&&) noexcept;

  const SampleParameters& parameters() const;

  // Samples a mesh given as arrays.
  //   positions: V x 3, any units; faces: F x 3 vertex numbers.
  //   content: names the model; randomness is a pure function of (seed, the first 16 bytes of content,
  //   index). Give a digest of what the model is: the SHA-256 of a file gives the points that `meander run`
  //   stores for that file.
  // Returns a row as `meander run` stores it. A mesh that cannot be sampled does not throw, nor does a lack
  // of memory: the status of the row says what is wrong, report.reason in words. Throws std::invalid_argument
  // when a length is no multiple of 3, RunCancelled when `cancel` is set. Deterministic for every thread
  // count. Cost: the README has the rates; O((F + N) log (F + N)) for the method direct.
  Row sample(std::span<const double> positions, std::span<const std::uint32_t> faces,
             std::span<const std::uint8_t> content = {}, const CancelToken& cancel = {}) const;

  // The same of a mesh with polygons, normals and attributes, which density and tensors may be read from.
  // Takes it by value: move it in where it is not needed again. Throws RunCancelled when `cancel` is set.
  Row sample(PolygonMesh mesh, std::span<const std::uint8_t> content = {},
             const CancelToken& cancel = {}) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace meander
