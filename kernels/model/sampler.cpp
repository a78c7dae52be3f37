#include "kernels/model/sampler.h"

#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "kernels/core/failure.h"
#include "kernels/mesh/count_limit.h"
#include "kernels/model/model.h"
#include "kernels/rays/embree_locator.h"

namespace meander {

namespace {

PolygonMesh mesh_of(std::span<const double> positions, std::span<const std::uint32_t> faces) {
  check_count(positions.size() / 3, "vertices");
  check_count(faces.size(), "corners");
  PolygonMesh mesh;
  for (std::size_t i = 0; i < positions.size(); i += 3) {
    mesh.x.push_back(positions[i]);
    mesh.y.push_back(positions[i + 1]);
    mesh.z.push_back(positions[i + 2]);
  }
  mesh.corners.assign(faces.begin(), faces.end());
  for (std::size_t f = 0; f <= faces.size(); f += 3)
    mesh.polygon_begin.push_back(static_cast<std::uint32_t>(f));
  return mesh;
}

const SampleParameters& checked(const SampleParameters& parameters) {
  std::string all;
  for (const std::string& problem : validate(parameters)) all += (all.empty() ? "" : "; ") + problem;
  if (!all.empty()) throw std::invalid_argument(all);
  return parameters;
}

}  // namespace

struct Sampler::State {
  SampleParameters parameters;
  std::optional<EmbreeDevice> device;
  ModelStages stages;
};

Sampler::Sampler(const SampleParameters& parameters) : state_(std::make_unique<State>()) {
  state_->parameters = checked(parameters);
  if (casts_rays(parameters)) state_->device.emplace();
  state_->stages = stages_of(parameters, state_->device ? &*state_->device : nullptr);
}

Sampler::~Sampler() = default;
Sampler::Sampler(Sampler&&) noexcept = default;
Sampler& Sampler::operator=(Sampler&&) noexcept = default;

const SampleParameters& Sampler::parameters() const { return state_->parameters; }

namespace {

// Runs the stages over the mesh that `read` gives; what it throws is a failure of the item too.
template <class Read>
Row sample_with(const ModelStages& stages, std::uint64_t seed, const Read& read,
                std::span<const std::uint8_t> content, const CancelToken& cancel) {
  Model model;
  model.cancel = cancel;
  std::string_view running = "read_mesh";
  try {
    model.file = read();
    model.key = make_random_key(seed, content);
    for (const ModelStage& stage : stages) {
      running = stage.name;
      stage.run(model);
    }
  } catch (const RunCancelled&) {
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

}  // namespace

Row Sampler::sample(std::span<const double> positions, std::span<const std::uint32_t> faces,
                    std::span<const std::uint8_t> content, const CancelToken& cancel) const {
  if (positions.size() % 3 != 0 || faces.size() % 3 != 0)
    throw std::invalid_argument("positions and faces must hold three entries per vertex and face");
  return sample_with(
      state_->stages, state_->parameters.seed, [&] { return mesh_of(positions, faces); }, content, cancel);
}

Row Sampler::sample(PolygonMesh mesh, std::span<const std::uint8_t> content,
                    const CancelToken& cancel) const {
  return sample_with(
      state_->stages, state_->parameters.seed, [&] { return std::move(mesh); }, content, cancel);
}

}  // namespace meander
