// Work of the C interface: one mesh, one surface or many meshes, sampled while the caller does something
// else.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "jobs/python/array_mesh.h"
#include "jobs/python/background_work.h"
#include "jobs/python/sample_queue.h"
#include "kernels/model/model_sampler.h"
#include "kernels/surface/function_surface.h"
#include "kernels/surface/sample_surface.h"

namespace meander {

using SharedSampler = std::shared_ptr<const ModelSampler>;

// Seconds that a mesh may take, and threads: 0 for all of the machine.
struct WorkLimits {
  int threads = 0;
  std::optional<double> timeout;
};

CancelToken token_of(const std::atomic<bool>* canceled, std::optional<double> timeout);
// Calls work() in as many threads; all that there are for 0.
void with_threads(int threads, const std::function<void()>& work);

// One of the functions that start it may be called, once; what they throw ends it. A mesh or a surface that
// cannot be sampled gives a row with its status.
class SamplingWork {
 public:
  SamplingWork() = default;
  ~SamplingWork();  // cancels what has not ended
  SamplingWork(const SamplingWork&) = delete;
  SamplingWork& operator=(const SamplingWork&) = delete;

  // In this thread where it is short. Without keep_mesh the mesh is taken apart.
  void sample(SharedSampler sampler, SharedMesh mesh, const WorkLimits& limits, bool keep_mesh);
  // Throws UsageError for a name that there is not.
  void sample_surface(const std::string& name, const SurfaceSampleParameters& parameters,
                      const WorkLimits& limits);
  // In this thread, which alone calls the function; throws what the function throws.
  void sample_function(const FunctionSurface& surface, const Content& content,
                       const SurfaceSampleParameters& parameters, const WorkLimits& limits);
  void sample_many(SharedSampler sampler, const WorkLimits& limits);

  // Offers a mesh to sample_many; false when there is no room yet.
  bool offer(std::uint64_t index, SharedMesh mesh, std::chrono::milliseconds patience);
  void close();

  // Rethrows what the work threw.
  bool ended_within(std::chrono::milliseconds time);
  // Any of the rows that are done; none when there is none within that time.
  std::optional<SampledRow> take_row(std::chrono::milliseconds time);

 private:
  void begin();

  bool begun_ = false;
  SampleQueue queue_;
  std::optional<BackgroundWork> background_;
};

}  // namespace meander
