// One model on its way from a mesh to a row, and the stages that take it there.
#pragma once

#include <functional>
#include <memory>
#include <string_view>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/core/model_sizes.h"
#include "kernels/core/random.h"
#include "kernels/curve/curve_tree.h"
#include "kernels/mesh/coarsen_mesh.h"
#include "kernels/mesh/polygon_mesh.h"
#include "kernels/mesh/prepared_mesh.h"
#include "kernels/model/sample_parameters.h"
#include "kernels/model/tensor_segments.h"
#include "kernels/partition/surface_regions.h"
#include "kernels/query/sharp_edges.h"
#include "kernels/sample/placed_sites.h"

namespace meander {

// What goes in, and what each stage has made of it. A stage makes its own members and reads earlier ones.
struct Model {
  PolygonMesh file;
  RandomKey key;
  CancelToken cancel;
  std::shared_ptr<const TensorTable> tensor_table;  // of the tensor kind table, where it comes with the model

  PreparedMesh surface;           // prepare_mesh
  MeshMeasure measure;            // prepare_mesh; without masses where samples follow a tensor, or rows_only
  CoarseMesh coarse;              // coarsen_mesh; empty where charts are those of the surface itself
  TensorSegments segments;        // follow_tensor, chart_segments
  std::vector<CutChart> cuts;     // cut_to_disk; flatten_chart takes them
  std::vector<FlatChart> charts;  // flatten_chart or chart_segments, by component
  std::vector<CurveTree> trees;   // build_curve; locate_vertices refines them
  SurfaceOrder order;             // locate_vertices
  PlacedSites sites;              // place_samples, in place of row.samples (leaves_sites)
  SharpEdges sharp_edges;         // sharp_edges; the last stage that needs them drops them
  Row row;  // its report is filled up to the stage that threw; place_samples, describe_shape
};

// An upper bound of the bytes that are alive at once while a stage runs, beside the file and the columns that
// are taken from it.
using StageBytes = double (*)(const SampleParameters& parameters, const ModelSizes& sizes);

// One step of a method. Throws ItemError, RunCanceled or std::bad_alloc.
struct ModelStage {
  std::string_view name;
  std::function<void(Model&)> run;
  StageBytes bytes = nullptr;  // null: no more than those of another stage
};

// All stages of the method, in order; no stage is idle. The parameters are copied. `device`: null unless
// casts_rays; it must outlive the stages.
ModelStages stages_of(const SampleParameters& parameters, const EmbreeDevice* device);

// The bounds of all stages that have one. Allocates as stages_of does: take them once for many models.
std::vector<StageBytes> stage_bytes(const SampleParameters& parameters);

// The stages up to the charts, and from there to the samples. The former do not depend on seed and sequence
// of the samples, so a model that is charted once can be sampled many times with parameters that differ in
// those, and with fewer samples. With more samples than coarse charts (CoarsenParameters) were made for, the
// order is worse; the samples are still correct.
ModelStages charting_stages(const SampleParameters& parameters);
ModelStages placing_stages(const SampleParameters& parameters, const EmbreeDevice* device);

void run_stages(const ModelStages& stages, Model& model);

// Samples [begin, end) of a model whose stages have left sites. Pure; O(end - begin).
Samples samples_at(const Model& model, const PlaceParameters& parameters, std::size_t begin, std::size_t end);

// Frees segments, charts, curves and elements: what samples are placed with. For stages that need the surface
// and the samples alone.
void release_charts(Model& model);

}  // namespace meander
