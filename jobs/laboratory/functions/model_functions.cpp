// Models that are staged once and sampled many times, and the results of their stages.
#include <stdexcept>

#include "jobs/laboratory/functions/laboratory_functions.h"
#include "jobs/rows/stored_parameters.h"
#include "kernels/rays/embree_locator.h"
#include "kernels/sample/point_frames.h"

namespace meander {

SampleParameters parameters_of(const LaboratoryArguments& given) {
  SampleParameters parameters = parameters_of_run(given.words("run"));
  parameters.samples = static_cast<std::uint32_t>(given.whole("n", parameters.samples));
  parameters.seed = given.whole("seed", parameters.seed);
  parameters.locator.curve.leaves_per_sample =
      given.real("leaves_per_sample", parameters.locator.curve.leaves_per_sample);
  return parameters;
}

namespace {

Model charted_model(const LaboratoryArguments& given, SampleParameters parameters) {
  Model model;
  model.file = given.mesh();
  if (given.has("tensors")) {
    auto table = std::make_shared<TensorTable>();
    table->columns = given.whole("tensor_columns");
    const std::span<const double> values = given.reals("tensors", table->columns);
    table->values.assign(values.begin(), values.end());
    model.tensor_table = table;
    parameters.tensor.kind = TensorKind::table;
    parameters.tensor.table = table;
  }
  run_stages(charting_stages(parameters), model);
  return model;
}

}  // namespace

Model sampled_model(const LaboratoryArguments& given) {
  const SampleParameters parameters = parameters_of(given);
  Model model = given.has_mesh() ? charted_model(given, parameters) : given.staged();
  if (parameters.tensor.kind == TensorKind::table && !model.tensor_table)
    throw std::invalid_argument("the model was staged without tensors");
  model.key = make_random_key(parameters.seed, {});
  const EmbreeDevice device;
  run_stages(placing_stages(parameters, &device), model);
  return model;
}

namespace {

// Takes vertices (V, 3), faces (T, 3), optional tensors (V, 3 or 6), and run, options of `meander run`.
// Returns a model up to its charts, made for n samples.
LaboratoryResult stage(const LaboratoryArguments& given) {
  auto model = std::make_shared<Model>(charted_model(given, parameters_of(given)));
  LaboratoryResult result;
  result.add("area", model->surface.total_area * model->surface.unit * model->surface.unit);
  result.add("charts", static_cast<double>(model->charts.size()));
  result.staged = std::move(model);
  return result;
}

// Takes a staged model. Returns n samples by the same options except n, seed, sequence and order, in units of
// the file.
LaboratoryResult samples(const LaboratoryArguments& given) {
  Model model = sampled_model(given);
  Row& row = model.row;
  LaboratoryResult result;
  std::vector<double> points;
  for (std::size_t i = 0; i < row.samples.count(); ++i) {
    const Vector3 p = file_point(row.report, row.samples.points, i);
    points.insert(points.end(), {p.x, p.y, p.z});
  }
  result.add("area", row.report.area);
  result.add("measure", row.report.measure);
  result.add("points", std::move(points), 3);
  result.add("normals", std::vector<double>(row.samples.normals.begin(), row.samples.normals.end()), 3);
  result.add("face", std::move(row.samples.face));
  result.add("triangle", std::move(row.samples.triangle));
  result.add("barycentric", std::move(row.samples.barycentric), 2);
  if (!row.samples.density.empty()) result.add("density", std::move(row.samples.density));
  if (row.samples.tensor_direction.empty()) return result;
  for (float& spacing : row.samples.tensor_spacing) spacing *= static_cast<float>(row.report.scale);
  result.add("tensor_direction", std::move(row.samples.tensor_direction), 3);
  result.add("tensor_spacing", std::move(row.samples.tensor_spacing), 2);
  return result;
}

constexpr LaboratoryFunction model_table[] = {{"stage", stage}, {"samples", samples}};

}  // namespace

const std::span<const LaboratoryFunction> model_functions = model_table;

}  // namespace meander
