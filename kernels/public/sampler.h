// <meander/sampler.h>: samples meshes given as arrays, from any number of threads.
//
//   #include <meander/sampler.h>
//
//   const meander::Sampler sampler({{"samples", 4096}, {"sequence", "spaced"}});
//   const meander::SampledModel model = sampler.sample({positions, corners});
//   if (model.report.status != meander::Status::ok) std::cerr << model.report.reason << '\n';
//
// docs/examples has programs. Parametric surfaces are in <meander/surface.h>, distances between descriptors
// in <meander/descriptors.h>. All of it is deterministic: equal input gives equal bytes, whatever the number
// of threads and the processor.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "samples.h"
#include "settings.h"
#include "status.h"

namespace meander {

// One number for every vertex or every face of a mesh, by name: a density, a component of a tensor, or a
// column that the samples take over.
struct MeshAttribute {
  std::string name;
  std::span<const double> values;
  bool classes = false;  // whole numbers that stand for classes: never interpolated
};

// V vertices and F faces as arrays of the caller, which must not change during the call. Faces that name a
// missing vertex, have a vertex that is not finite, or have no area are repaired or left out, and counted
// (SampleReport::repairs).
struct Mesh {
  std::span<const double> positions;       // 3 V: x, y, z of every vertex, in any units
  std::span<const std::uint32_t> corners;  // numbers of vertices from 0, face after face
  std::uint32_t corners_per_face = 3;      // at least 3; not read when there is face_begin
  // F + 1 ascending offsets into `corners`, the first 0, the last their number: polygons of different
  // lengths. Polygons may be concave.
  std::span<const std::uint32_t> face_begin = {};
  std::span<const float> normals = {};        // 3 V, or none: those of the triangles
  std::span<const float> vertex_colors = {};  // 3 V red, green, blue in [0, 1], as displayed; NaN: none
  std::span<const float> face_colors = {};    // 3 F, for vertices without a color
  std::span<const float> texcoords = {};      // 2 for every corner
  std::vector<MeshAttribute> vertex_attributes = {};  // V values each
  std::vector<MeshAttribute> face_attributes = {};    // F values each
};

// Samples meshes with one choice of settings, and holds what they share; make one and keep it. Every const
// function may be called from any number of threads at once. Large meshes are also sampled by several threads
// of oneTBB: tbb::global_control bounds their number.
class Sampler {
 public:
  // Throws std::invalid_argument with a sentence for each setting that is unknown, out of range, without
  // effect, or in conflict with another; ItemError(out_of_memory) when Embree, which the methods conformal
  // and anisotropic need, cannot be started.
  explicit Sampler(const Settings& settings = {});
  ~Sampler();
  Sampler(Sampler&&) noexcept;
  Sampler& operator=(Sampler&&) noexcept;

  // content: names the model. Randomness is a pure function of the setting `seed`, the first 16 bytes of
  // content and the index of the sample. With the SHA-256 of a file these are the samples that `meander run`
  // stores for it.
  //
  // A mesh that cannot be sampled does not throw, nor does a lack of memory or time: the status of the report
  // says what is wrong, and its reason says it in a sentence. Throws std::invalid_argument when the lengths
  // of the arrays do not fit each other, RunCanceled when `cancel` is set.
  //
  // Cost for the default settings: O((F + N) log (F + N)) time, O(F + N) memory.
  SampledModel sample(const Mesh& mesh, std::span<const std::uint8_t> content = {},
                      const CancelToken& cancel = {}) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace meander
