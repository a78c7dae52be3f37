// Everything that decides the samples of a model.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "kernels/core/notes.h"
#include "kernels/data/columns.h"
#include "kernels/density/density.h"
#include "kernels/describe/describe_samples.h"
#include "kernels/flatten/flatten_chart.h"
#include "kernels/mesh/coarsen_mesh.h"
#include "kernels/model/sampling_methods.h"
#include "kernels/rays/embree_locator.h"
#include "kernels/sample/place_samples.h"
#include "kernels/sample/query_points.h"
#include "kernels/sample/sharp_samples.h"
#include "kernels/segment/segment_mesh.h"
#include "kernels/tensor/chart_alignment.h"
#include "kernels/tensor/make_tensor_field.h"

namespace meander {

enum class LocatorKind : std::uint8_t { embree, elements, first_hit };

// The least number of elements per sample of anisotropic sampling, whatever ElementParameters ask for:
// triangles that are round in space are needles in a metric, and unless elements are small relative to a
// sample's cell, samples are less anisotropic than requested (docs/ANISOTROPIC.md has the numbers).
inline constexpr double tensor_elements_per_sample = 16;

// The least number of elements per sample of the balanced order: its cells follow the borders of elements,
// and coarse elements make ragged cells (docs/METHODS.md 6.5 has the numbers). Large sets have fewer to save
// time; more of them where only small cells split their pieces (may_split), which costs less.
constexpr double balanced_elements_per_sample(std::uint32_t samples, bool splits) {
  return samples <= most_whole_samples ? 12 : splits ? 6 : 4;
}

// The least number of elements per sample over a coarse mesh, whose charts have no rays to say which
// triangles need more: from 10,000 samples on 2 to 4 % less error than with 4 (bench/README.md has the
// numbers).
constexpr double coarse_elements_per_sample(std::uint64_t samples) {
  return samples <= most_whole_samples ? 6 : 4;
}

// FlattenParameters::max_mean_distortion of charts over a coarse mesh, whose larger triangles are distorted
// more by themselves: with 1.1 seams multiply, the error of the samples is the same.
inline constexpr double coarse_mean_distortion = 1.3;

// The same of charts in a metric. Fields vary from triangle to triangle, which no seam mends: with 1.1 a
// chart is tried six times over for samples that are no better.
inline constexpr double metric_mean_distortion = 1.5;

// AlignmentLimits::ratio of charts in a metric, for the same reason: halves of segments between 1.5 and 2 are
// no better, nor are their samples.
inline constexpr double metric_chart_ratio = 2;

// How a tensor field is charted (docs/METHODS.md 9.4 and 9.6 to 9.8).
struct TensorChartParameters {
  AlignmentForm form = AlignmentForm::metric;  // conformal in the metric, or along the directions
  SegmentParameters segment = {1, 20, {}};
  // Rounds in which segments whose chart fails are halved, and again as many for those without a chart in the
  // metric; 0..16.
  std::uint32_t max_bisections = 6;
  AlignmentLimits limits = {.ratio = metric_chart_ratio};
};

// Everything that decides the points of a model. The defaults are those of `meander run`.
struct SampleParameters {
  std::uint32_t samples = 2048;  // of a model, 1..2^31
  std::uint64_t seed = 1;
  MethodChoice method = MethodChoice::automatic;
  std::optional<ElementOrder> curve;  // the order of the elements; without a value that of the method
  LocatorKind locate = LocatorKind::embree;
  PlaceKind place = PlaceKind::element;
  SequenceKind sequence = SequenceKind::shifted;
  SpacingKind spacing = SpacingKind::standard;  // of the sequence spaced
  double jitter = 0.25;                         // of the sequence shifted: see PlaceParameters
  FinishKind finish = FinishKind::none;         // what is done to the samples in the end
  OrderKind order = OrderKind::progressive;     // of the samples in the file
  NormalizeKind normalize = NormalizeKind::none;
  CoarsenParameters coarsen;  // of the charts of the method conformal
  CutParameters cut;
  FlattenParameters flatten;
  // locate_parameters and element_parameters take what is set above in place of the same members of these.
  LocateParameters locator;
  ElementParameters elements;
  DensityParameters density;
  // Find neighbors, components and a common orientation of the triangles. Without it samples take the
  // normals of the file's winding, and components, genus and boundaries are not counted (prepare_soup). For
  // methods without charts.
  bool topology = true;
  bool curved = false;  // lift the samples off their triangles' planes (curved_samples.h)
  // Give the samples these, of the columns that have an option (column_makers.h), and these attributes.
  ColumnSet columns = {};
  std::vector<AttributeColumn> attributes = {};
  SharpParameters sharp = {};    // samples on sharp edges
  QueryParameters queries = {};  // points with signed distances
  // Models with a note of these kinds fail with the status incomplete.
  NoteSet strict = 0;
  DescribeParameters describe;
  TensorParameters tensor;  // of the method anisotropic, as is the next one
  TensorChartParameters tensor_charts;
  // Nothing but its row is wanted of a model. Samples of large sets are then left as sites, to be made block
  // by block (samples_at, model.h), where nothing needs them all (leaves_sites); the neighbors and polygons
  // of triangles are freed once they have served, and their masses are not kept. The same row.
  bool rows_only = false;
  // Sets of more samples than this are large in this sense: what few blocks they have would be made by few
  // threads.
  std::uint32_t most_kept_samples = 1 << 18;
};

// All problems of the parameters, one sentence each; empty when they are valid.
std::vector<std::string> validate(const SampleParameters& parameters);

constexpr const SamplingMethod& method_of(const SampleParameters& parameters) {
  return row_of(sampling_methods, parameters.method);
}
// The default parameters with the method of that name; std::invalid_argument when there is none.
SampleParameters parameters_for(std::string_view method);

// Whether texture coordinates of the file are needed: as a column, or in a formula.
bool reads_coordinates(const SampleParameters& parameters);
// Whether the parameters cast rays: only then do the stages need an Embree device.
bool casts_rays(const SampleParameters& parameters);

// The order of the elements: the one asked for, or that of the method.
ElementOrder order_of(const SampleParameters& parameters);

// elements.elements_per_sample, or what the method or the order needs at least where that is more.
double elements_per_sample(const SampleParameters& parameters);
// The parameters of the kernels that follow from these: of elements, of the locator, and of the places of
// samples.
ElementParameters element_parameters(const SampleParameters& parameters);
LocateParameters locate_parameters(const SampleParameters& parameters);
PlaceParameters place_parameters(const SampleParameters& parameters);

// Whether the surface is put in order region by region (surface_regions.h): large sets, but for spaced ones,
// whose places depend on each other, and the survey's point location.
bool places_in_regions(const SampleParameters& parameters);

// Whether the stages end with sites in place of samples: rows_only, for large sets on the surface itself
// without descriptors and without columns of the user's choice.
bool leaves_sites(const SampleParameters& parameters);

}  // namespace meander
