#include "jobs/rows/run_header.h"

#include "jobs/rows/descriptor_choice.h"
#include "kernels/model/tensor_segments.h"

namespace meander {

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
