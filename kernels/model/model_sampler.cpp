#include "kernels/model/model_sampler.h"

#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "kernels/core/failure.h"
#include "kernels/model/model.h"
#include "kernels/rays/embree_locator.h"

namespace meander {

namespace {

const SampleParameters& checked(const SampleParameters& parameters) {
  std::string all;
  for (const std::string& problem : validate(parameters)) all += (all.empty() ? "" : "; ") + problem;
  if (!all.empty()) throw std::invalid_argument(all);
  return parameters;
}

}  // namespace

struct ModelSampler::State {
  SampleParameters parameters;
  std::optional<EmbreeDevice> device;
  ModelStages stages;
};

ModelSampler::ModelSampler(const SampleParameters& parameters) : state_(std::make_unique<State>()) {
  state_->parameters = checked(parameters);
  if (casts_rays(parameters)) state_->device.emplace();
  state_->stages = stages_of(parameters, state_->device ? &*state_->device : nullptr);
}

ModelSampler::~ModelSampler() = default;
ModelSampler::ModelSampler(ModelSampler&&) noexcept = default;
ModelSampler& ModelSampler::operator=(ModelSampler&&) noexcept = default;

const SampleParameters& ModelSampler::parameters() const { return state_->parameters; }

Row ModelSampler::sample(PolygonMesh mesh, std::span<const std::uint8_t> content,
                         const CancelToken& cancel) const {
  Model model;
  model.cancel = cancel;
  std::string_view running = "read_mesh";
  try {
    model.file = std::move(mesh);
    model.key = make_random_key(state_->parameters.seed, content);
    for (const ModelStage& stage : state_->stages) {
      running = stage.name;
      stage.run(model);
    }
  } catch (const RunCanceled&) {
    throw;
  } catch (...) {
    Failure failure = current_failure(running);
    model.row.report.status = failure.status;
    model.row.report.reason = std::move(failure.reason);
    model.row.samples = {};
    model.row.descriptors.clear();
  }
  return std::move(model.row);
}

}  // namespace meander
