#include "jobs/laboratory/figures/staged_model.h"

#include <utility>

#include "kernels/locate/embree_locator.h"

namespace meander {

Model staged_model(const FigureMesh& mesh, const SampleParameters& parameters,
                   std::shared_ptr<const TensorTable> table) {
  Model model;
  model.tensor_table = std::move(table);
  for (std::size_t i = 0; i < mesh.positions.size(); i += 3) {
    model.file.x.push_back(mesh.positions[i]);
    model.file.y.push_back(mesh.positions[i + 1]);
    model.file.z.push_back(mesh.positions[i + 2]);
  }
  model.file.corners = mesh.faces;
  for (std::size_t f = 0; f <= mesh.faces.size(); f += 3)
    model.file.polygon_begin.push_back(static_cast<std::uint32_t>(f));
  run_stages(charting_stages(parameters), model);
  return model;
}

Row sampled_row(const Model& staged, SampleParameters parameters, std::uint32_t count, std::uint64_t seed,
                const EmbreeDevice& device) {
  set_samples(parameters, count);
  parameters.seed = seed;
  Model model = staged;
  model.key = make_random_key(seed, {});
  run_stages(placing_stages(parameters, &device), model);
  return std::move(model.row);
}

}  // namespace meander
