#include "jobs/rows/run_header.h"

#include <filesystem>

#include "io/mesh/mesh_reader.h"
#include "jobs/cli/usage_error.h"
#include "jobs/inputs/input_options.h"
#include "jobs/rows/descriptor_choice.h"
#include "kernels/model/tensor_segments.h"

namespace meander {

namespace {

namespace fs = std::filesystem;

// Finds the tensors of each item of `--tensor file:PATH`: in one text file for all; in a folder in ID.txt (or
// with .txt instead of the extension of the mesh); in an HDF5 file (.h5, .hdf5) in the dataset with the id of
// the item.
void plan_tensor_files(const TensorParameters& tensor, std::vector<PlanItem>& items) {
  if (tensor.kind != TensorKind::table) return;
  const fs::path path = tensor.attribute;
  const bool folder = fs::is_directory(path);
  const bool hdf5 = path.extension() == ".h5" || path.extension() == ".hdf5";
  for (PlanItem& item : items) {
    item.tensor_path = folder ? path / (item.id + ".txt") : path;
    if (folder && !fs::exists(item.tensor_path))
      item.tensor_path = path / fs::path(item.id).replace_extension(".txt");
    if (hdf5 && !folder) item.tensor_dataset = item.id;
  }
}

}  // namespace

Inputs collect_run_inputs(const RunOptions& options) {
  Inputs inputs = collect_inputs(options.inputs, options.collect);
  print_unread(inputs.notes);
  plan_tensor_files(options.sample.tensor, inputs.items);
  if (inputs.items.empty()) throw UsageError("no mesh file (" + mesh_extensions() + ") in the input");
  return inputs;
}

StoreHeader run_header(const RunOptions& options, const Inputs& inputs, const Laboratory* laboratory) {
  StoreHeader header;
  header.samples = options.sample.samples;
  header.columns = columns_of(options);
  header.compression = options.compression;
  header.seed = options.sample.seed;
  header.order = options.sample.order == OrderKind::curve ? "curve" : "progressive";
  header.parameters_json = options.parameters_json;
  header.label_names = inputs.label_names;
  header.descriptors = schemas_of(options.sample.describe);
  if (method_of(options.sample).follows_tensor) {
    constexpr std::array<const char*, anisotropy_names.size()> meanings = {
        "segments that the surface was charted in",
        "share of the area whose chart follows the tensor within the limits",
        "mean angle between the chart's first axis and the primary direction, radians; charts in the metric "
        "are turned freely",
        "mean ratio of the chart's singular values in the tensor's metric; 1 is conformal",
        "mean ratio of the two wanted spacings",
        "share of the triangles whose ratio was cut to the largest allowed"};
    for (std::size_t i = 0; i < meanings.size(); ++i)
      header.descriptors.push_back({anisotropy_names[i], 1, {{"meaning", meanings[i]}}, "anisotropy"});
  }
  if (options.certify)
    for (DescriptorSchema& column : require_laboratory(laboratory, "--certify").certificate_columns())
      header.descriptors.push_back(std::move(column));
  for (const PlanItem& item : inputs.items) {
    header.ids.push_back(item.id);
    header.labels.push_back(item.label);
    header.splits.push_back(item.split);
  }
  return header;
}

}  // namespace meander
