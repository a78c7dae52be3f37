// The whole of Meander for one mesh in memory: no files, no store, no graph.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/density/density.h"
#include "kernels/describe/describe_samples.h"
#include "kernels/flatten/flatten_chart.h"
#include "kernels/locate/embree_locator.h"
#include "kernels/mesh/polygon_mesh.h"
#include "kernels/sample/place_samples.h"
#include "kernels/sample/samples.h"
#include "kernels/segment/segment_mesh.h"
#include "kernels/tensor/chart_alignment.h"
#include "kernels/tensor/make_tensor_field.h"

namespace meander {

enum class MethodChoice : std::uint8_t { conformal, direct, anisotropic };
enum class LocatorKind : std::uint8_t { embree, elements, first_hit };

// The least number of elements per sample of anisotropic sampling, whatever ElementParameters ask for:
// triangles that are round in space are needles in a metric, and unless elements are small relative to a
// sample's cell, samples are less anisotropic than requested (docs/ANISOTROPIC.md has the numbers).
inline constexpr double tensor_elements_per_sample = 16;

// How a tensor field is charted (docs/METHODS.md 9.4 and 9.6 to 9.8).
struct TensorChartParameters {
  AlignmentForm form = AlignmentForm::metric;  // conformal in the metric, or along the directions
  SegmentParameters segment = {1, 20, {}};
  std::uint32_t max_bisections = 6;  // rounds in which segments whose chart fails are halved; 0..16
  AlignmentLimits limits;
};

// What anisotropic sampling found; angles and ratios are means over the area.
struct AnisotropyReport {
  std::uint32_t segments = 0;
  double accepted_share = 0;      // of the area: charts within the limits, [0, 1]
  double mean_angle = 0;          // between a chart's axis and the primary direction, radians
  double mean_chart_ratio = 1;    // singular-value ratio of the chart in the metric, >= 1
  double mean_spacing_ratio = 1;  // s1 / s2 of the field, >= 1
  double clamped_share = 0;       // of the triangles: their ratio was cut to the largest allowed, [0, 1]
};

// Everything that decides the points of a model. The defaults are those of `meander run`.
struct SampleParameters {
  MethodChoice method = MethodChoice::conformal;
  LocatorKind locate = LocatorKind::embree;
  std::uint64_t seed = 1;
  CutParameters cut;
  FlattenParameters flatten;
  LocateParameters locator;
  ElementParameters elements;
  DensityParameters density;
  PlaceParameters place;
  bool curved = false;  // lift the samples off their triangles' planes (curved_samples.h)
  DescribeParameters describe;
  TensorParameters tensor;  // of the method anisotropic, as is the next one
  TensorChartParameters tensor_charts;
};

// Names of the descriptors that hold the fields of AnisotropyReport.
inline constexpr std::array<const char*, 6> anisotropy_names = {
    "segments", "accepted_share", "chart_angle", "chart_ratio", "spacing_ratio", "clamped_share"};

// All problems of the parameters, one sentence each; empty when they are valid.
std::vector<std::string> validate(const SampleParameters& parameters);

// Whether the parameters cast rays: only then do the stages need an Embree device.
bool casts_rays(const SampleParameters& parameters);

// elements.elements_per_sample, or tensor_elements_per_sample where that is more and the method is
// anisotropic.
double elements_per_sample(const SampleParameters& parameters);

// Sets the number of samples wherever the stages need it.
void set_samples(SampleParameters& parameters, std::uint32_t samples);

// One model on its way through the stages; the pipeline's nodes and sample_mesh call the same functions in
// this order. Each throws ItemError, RunCancelled or std::bad_alloc; `report` is filled up to the stage that
// threw.
struct ModelState {
  PolygonMesh file;
  RandomKey key;
  CancelToken cancel;
  PreparedMesh mesh;
  TensorField tensor;                               // of the method anisotropic
  std::shared_ptr<const TensorTable> tensor_table;  // of the tensor kind table, by the caller
  AnisotropyReport anisotropy;
  Density density;  // of the samples: the user's, over s1 s2 of the tensor
  std::vector<double> masses;
  std::vector<CutChart> cuts;
  std::vector<FlatChart> charts;
  std::vector<CurveTree> trees;
  CurveElements elements;
  Row row;
};
void prepare_model(ModelState& model, const SampleParameters& parameters);
// The tensor field, the density and the metric that follow from it; nothing for isotropic methods.
void follow_tensor_model(ModelState& model, const SampleParameters& parameters);
void cut_model(ModelState& model, const SampleParameters& parameters);
void flatten_model(ModelState& model, const SampleParameters& parameters);
void build_model_curves(ModelState& model, const SampleParameters& parameters);
void locate_model(ModelState& model, const SampleParameters& parameters, const EmbreeDevice* device);
void place_model(ModelState& model, const SampleParameters& parameters);
// The descriptors asked for, in their order, then those of anisotropy_names if the method is anisotropic.
void describe_model(ModelState& model, const SampleParameters& parameters);
// Frees what placing needed: charts, curves and elements. For stages after place_model.
void release_curves(ModelState& model);

// Samples a mesh given as arrays.
//   positions: V x 3, any units; faces: F x 3 vertex numbers; content: any bytes that name the model
//   (randomness is a pure function of (seed, content, index); pass the same bytes to get the same points).
// Returns the row that `meander run` would store. A mesh that cannot be sampled does not throw: the status of
// the row says why. Throws std::invalid_argument when `validate` finds a problem. Cost: see the README;
// deterministic, thread-safe.
Row sample_mesh(std::span<const double> positions, std::span<const std::uint32_t> faces,
                const SampleParameters& parameters, std::span<const std::uint8_t> content = {});

}  // namespace meander
