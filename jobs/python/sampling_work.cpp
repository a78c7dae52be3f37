#include "jobs/python/sampling_work.h"

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/info.h>
#include <oneapi/tbb/parallel_pipeline.h>
#include <oneapi/tbb/task_arena.h>

#include <stdexcept>
#include <utility>

#include "jobs/inputs/surface_sources.h"
#include "kernels/core/parallel.h"
#include "kernels/data/row_or_failure.h"
#include "kernels/surface/surface_row.h"

namespace meander {

namespace {

// Above this a call is worth a thread of its own, so that its caller can end it.
constexpr std::size_t long_work = 200000;

bool is_long_work(const ModelSampler& sampler, const PolygonMesh& mesh) {
  const SampleParameters& p = sampler.parameters();
  const std::size_t spaced = p.sequence == SequenceKind::spaced ? 10 : 1;
  return method_of(p).makes_charts || mesh.corners.size() + spaced * p.samples > long_work;
}

void sample_all(const ModelSampler& sampler, SampleQueue& queue, std::size_t tokens,
                std::optional<double> timeout, const std::atomic<bool>& canceled) {
  using oneapi::tbb::filter_mode;
  using Held = std::shared_ptr<SampleQueue::Entry>;
  oneapi::tbb::parallel_pipeline(
      tokens,
      oneapi::tbb::make_filter<void, Held>(filter_mode::serial_in_order,
                                           [&](oneapi::tbb::flow_control& control) -> Held {
                                             auto entry = queue.take();
                                             if (!entry || canceled) {
                                               control.stop();
                                               return nullptr;
                                             }
                                             return std::make_shared<SampleQueue::Entry>(std::move(*entry));
                                           }) &
          oneapi::tbb::make_filter<Held, void>(filter_mode::parallel, [&](const Held& entry) {
            ContentMesh& mesh = *entry->mesh;
            Row row = sampler.sample(std::move(mesh.mesh), mesh.content, token_of(&canceled, timeout));
            mesh.mesh = {};
            queue.put({entry->index, mesh.content, std::move(row), sampler.parameters().attributes});
          }));
}

}  // namespace

CancelToken token_of(const std::atomic<bool>* canceled, std::optional<double> timeout) {
  CancelToken token;
  token.canceled = canceled;
  if (timeout)
    token.deadline =
        std::chrono::steady_clock::now() + std::chrono::duration_cast<std::chrono::steady_clock::duration>(
                                               std::chrono::duration<double>(*timeout));
  return token;
}

void with_threads(int threads, const std::function<void()>& work) {
  require_task_memory();
  if (threads == 0) {
    work();
    return;
  }
  std::optional<oneapi::tbb::global_control> more;
  if (threads > oneapi::tbb::info::default_concurrency())
    more.emplace(oneapi::tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
  oneapi::tbb::task_arena(threads).execute(work);
}

SamplingWork::~SamplingWork() { queue_.close(); }

void SamplingWork::begin() {
  if (begun_) throw std::invalid_argument("the work was begun before");
  begun_ = true;
}

void SamplingWork::sample(SharedSampler sampler, SharedMesh mesh, const WorkLimits& limits, bool keep_mesh) {
  begin();
  const bool is_long = is_long_work(*sampler, mesh->mesh);
  auto work = [this, sampler = std::move(sampler), mesh = std::move(mesh), limits,
               keep_mesh](const std::atomic<bool>* canceled) {
    with_threads(limits.threads, [&] {
      PolygonMesh polygons = keep_mesh ? mesh->mesh : std::move(mesh->mesh);
      Row row = sampler->sample(std::move(polygons), mesh->content, token_of(canceled, limits.timeout));
      queue_.put({0, mesh->content, std::move(row), sampler->parameters().attributes});
    });
  };
  if (is_long)
    background_.emplace([work = std::move(work)](const std::atomic<bool>& canceled) { work(&canceled); });
  else
    work(nullptr);
}

void SamplingWork::sample_surface(const std::string& name, const SurfaceSampleParameters& parameters,
                                  const WorkLimits& limits) {
  begin();
  check_surface_name(name);
  background_.emplace([this, name, parameters, limits](const std::atomic<bool>& canceled) {
    with_threads(limits.threads, [&] {
      Content content{};
      Row row = row_or_failure("sample_surface", [&] {
        const SurfaceSource source = open_surface(name);
        content = source.content_sha256;
        return surface_row(*source.surface, meander::sample_surface(*source.surface, parameters,
                                                                    token_of(&canceled, limits.timeout)));
      });
      queue_.put({0, content, std::move(row)});
    });
  });
}

void SamplingWork::sample_function(const FunctionSurface& surface, const Content& content,
                                   const SurfaceSampleParameters& parameters, const WorkLimits& limits) {
  begin();
  // Loops in an arena of one slot stay in this thread.
  with_threads(1, [&] {
    queue_.put({0, content, row_or_failure("sample_surface", [&] {
                  return surface_row(surface, meander::sample_surface(surface, parameters,
                                                                      token_of(nullptr, limits.timeout)));
                })});
  });
}

void SamplingWork::sample_many(SharedSampler sampler, const WorkLimits& limits) {
  begin();
  const auto slots = static_cast<std::size_t>(limits.threads > 0 ? limits.threads
                                                                 : oneapi::tbb::info::default_concurrency());
  queue_.set_room(2 * slots);
  background_.emplace([this, sampler = std::move(sampler), limits, slots](const std::atomic<bool>& canceled) {
    with_threads(limits.threads, [&] { sample_all(*sampler, queue_, slots + 1, limits.timeout, canceled); });
  });
}

bool SamplingWork::offer(std::uint64_t index, SharedMesh mesh, std::chrono::milliseconds patience) {
  return queue_.offer({index, std::move(mesh)}, patience);
}

void SamplingWork::close() { queue_.close(); }

bool SamplingWork::ended_within(std::chrono::milliseconds time) {
  return !background_ || background_->ended_within(time);
}

std::optional<SampledRow> SamplingWork::take_row(std::chrono::milliseconds time) {
  return queue_.take_done(time);
}

}  // namespace meander
