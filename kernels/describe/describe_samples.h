// The descriptors of one sampled model, by name.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/core/model_sizes.h"
#include "kernels/core/random.h"
#include "kernels/data/samples.h"
#include "kernels/describe/depth_views.h"
#include "kernels/describe/distance_histogram.h"
#include "kernels/describe/oriented_pairs.h"
#include "kernels/describe/shape_dna.h"
#include "kernels/describe/shape_moments.h"
#include "kernels/describe/shell_harmonics.h"
#include "kernels/mesh/prepared_mesh.h"

namespace meander {

// d2: distances of all pairs of samples. a3, d1, d3, d4: Osada's other shape functions. geodesic: distances
// along the surface, from the first samples to all. basics: area, volume, moments and box of the mesh, not a
// histogram. pairs: distances and angles of all pairs of samples with outward normals; pairs_unsigned: with
// the stored normals, whatever their sense. harmonics: power spectra of the samples on shells. views: depth
// images along the principal axes. shapedna: eigenvalues of the Laplacian of the surface. The numbers are
// indices into descriptor_groups.
enum class Descriptor : std::uint8_t {
  d2,
  a3,
  d1,
  d3,
  d4,
  geodesic,
  basics,
  pairs,
  pairs_unsigned,
  harmonics,
  views,
  shapedna
};

// basics: the values of shape_basics and whether the mesh is closed, all finite. Values that only a closed
// surface has are 0 elsewhere; the volume has no sign (the model turned inside out is the same solid).
inline constexpr std::size_t basics_count = shape_basics_count + 1;
inline constexpr std::array<std::string_view, basics_count> basics_names = [] {
  std::array<std::string_view, basics_count> names{};
  for (std::size_t i = 0; i < shape_basics_count; ++i) names[i] = shape_basics_names[i];
  names[shape_basics_count] = "closed";  // 1 or 0
  return names;
}();

struct DescribeParameters {
  std::vector<Descriptor> descriptors;
  std::uint32_t bins = 32;                      // of every histogram, 8..1024
  HistogramScale scale = HistogramScale::mean;  // of d2 and geodesic; the others are scaled by their mean
  std::uint32_t tuples = 1 << 17;               // of a3, d3, d4: see ShapeFunctionParameters
  std::uint32_t geodesic_sources = 64;          // 0: all samples
};

// The input of makers. The mesh may be empty unless the group needs_mesh.
struct DescriptorInput {
  const PreparedMesh& mesh;
  const Samples& samples;
  RandomKey key;
  const DescribeParameters& parameters;
  const CancelToken& cancel;
};

// A row of values that a descriptor has after its own.
struct CompanionRow {
  std::string_view name, value;               // `value` says what the values are
  std::span<const std::string_view> columns;  // the names of the values
};

// Bins that no parameter changes.
struct FixedBins {
  std::uint32_t count = 0;
  std::string_view text;         // the help: what the bins are
  std::uint32_t dimensions = 1;  // quantities that they divide at once
};

// The properties of a descriptor, from which all its forms follow.
struct DescriptorGroup {
  Descriptor descriptor;
  std::string_view name;         // on the command line and in stores
  std::string_view value;        // what its values are, or what its histogram counts
  bool has_bins = true;          // a histogram with DescribeParameters::bins
  FixedBins fixed_bins = {};     // a histogram of other bins; separate values where it has neither
  bool takes_scale = false;      // DescribeParameters::scale ends the bins; else `range`, or 3 x the mean
  std::string_view range = {};   // a fixed range
  bool takes_sources = false;    // takes DescribeParameters::geodesic_sources
  bool needs_mesh = false;       // besides the samples
  bool needs_triangles = false;  // Samples::triangle too
  bool may_be_zero = false;      // a valid row may be all zeros
  std::span<const std::string_view> columns = {};  // the names of values that are not a histogram
  std::span<const CompanionRow> companions = {};
  std::uint32_t version = 1;  // raised whenever the same samples give other values
  // Makes its own row and those of its companions, in order.
  std::vector<std::vector<float>> (*make)(const DescriptorInput& input) = nullptr;
  // Upper bound of its bytes beside mesh and samples, where they may be more than what was freed before.
  double (*bytes)(const DescribeParameters& parameters, const ModelSizes& sizes) = nullptr;
};

namespace descriptor_makers {
std::vector<std::vector<float>> d2(const DescriptorInput& input);
std::vector<std::vector<float>> a3(const DescriptorInput& input);
std::vector<std::vector<float>> d1(const DescriptorInput& input);
std::vector<std::vector<float>> d3(const DescriptorInput& input);
std::vector<std::vector<float>> d4(const DescriptorInput& input);
std::vector<std::vector<float>> geodesic(const DescriptorInput& input);
std::vector<std::vector<float>> basics(const DescriptorInput& input);
std::vector<std::vector<float>> pairs(const DescriptorInput& input);
std::vector<std::vector<float>> pairs_unsigned(const DescriptorInput& input);
std::vector<std::vector<float>> harmonics(const DescriptorInput& input);
std::vector<std::vector<float>> views(const DescriptorInput& input);
std::vector<std::vector<float>> shapedna(const DescriptorInput& input);
}  // namespace descriptor_makers
namespace descriptor_bytes {
double geodesic(const DescribeParameters& parameters, const ModelSizes& sizes);
double shapedna(const DescribeParameters& parameters, const ModelSizes& sizes);
}  // namespace descriptor_bytes

inline constexpr std::array<std::string_view, 1> disconnected_columns = {"share"};
inline constexpr std::array<CompanionRow, 1> geodesic_companions = {
    {{"geodesic_disconnected", "share of the pairs of samples that no path along the surface joins",
      disconnected_columns}}};

inline constexpr std::array<std::string_view, 1> unoriented_columns = {"share"};
inline constexpr std::array<CompanionRow, 1> pairs_companions = {
    {{"pairs_unoriented",
      "share of the samples on components with a boundary, which have no outside: they face away from the "
      "centroid of the surface",
      unoriented_columns}}};

// The one table of descriptors: a new one is a maker and a line here.
inline constexpr auto descriptor_groups = std::to_array<DescriptorGroup>(
    {{.descriptor = Descriptor::d2,
      .name = "d2",
      .value = "distance of all pairs of samples (Osada et al. 2002, D2)",
      .takes_scale = true,
      .make = descriptor_makers::d2},
     {.descriptor = Descriptor::a3,
      .name = "a3",
      .value = "angle at three random samples (A3)",
      .range = "pi",
      .make = descriptor_makers::a3},
     {.descriptor = Descriptor::d1,
      .name = "d1",
      .value = "distance of the samples from their centroid (D1)",
      .make = descriptor_makers::d1},
     {.descriptor = Descriptor::d3,
      .name = "d3",
      .value = "square root of the area of three random samples' triangle (D3)",
      .make = descriptor_makers::d3},
     {.descriptor = Descriptor::d4,
      .name = "d4",
      .value = "cube root of the volume of four random samples' tetrahedron (D4)",
      .make = descriptor_makers::d4},
     {.descriptor = Descriptor::geodesic,
      .name = "geodesic",
      .value = "distance along the surface from the first samples to all (heat method)",
      .takes_scale = true,
      .takes_sources = true,
      .needs_mesh = true,
      .needs_triangles = true,
      .may_be_zero = true,
      .companions = geodesic_companions,
      .make = descriptor_makers::geodesic,
      .bytes = descriptor_bytes::geodesic},
     {.descriptor = Descriptor::basics,
      .name = "basics",
      .value = "area, volume, moments and bounding box of the mesh, lengths over the diagonal of the box",
      .has_bins = false,
      .needs_mesh = true,
      .columns = basics_names,
      .make = descriptor_makers::basics},
     {.descriptor = Descriptor::pairs,
      .name = "pairs",
      .value = "all pairs of samples with outward normals: distance, angles of the normals with the line "
               "between the samples, angle between the normals",
      .has_bins = false,
      .fixed_bins =
          {oriented_pair_bins,
           "square roots of shares; 8 equal bins of distance from 0 to 2.5 x the mean (larger ones "
           "count in the last) x 4 of the lesser and 4 of the greater angle with the line (edges 84, "
           "96, 126 degrees) x 4 of the angle between the normals (33, 83, 128), the last fastest",
           4},
      .needs_mesh = true,
      .needs_triangles = true,
      .companions = pairs_companions,
      .make = descriptor_makers::pairs},
     {.descriptor = Descriptor::pairs_unsigned,
      .name = "pairs-unsigned",
      .value =
          "all pairs of samples, their normals without a sense: distance, angles of the normals with the "
          "line between the samples, angle between the normals",
      .has_bins = false,
      .fixed_bins =
          {oriented_pair_bins,
           "square roots of shares; 8 equal bins of distance from 0 to 2.5 x the mean (larger ones "
           "count in the last) x 4 of the lesser and 4 of the greater angle with the line (edges 36, "
           "60, 84 degrees) x 4 of the angle between the normals (33, 57, 83), the last fastest",
           4},
      .make = descriptor_makers::pairs_unsigned},
     {.descriptor = Descriptor::harmonics,
      .name = "harmonics",
      .value = "norms of the spherical harmonics of the samples on shells around their centroid (Kazhdan, "
               "Funkhouser and Rusinkiewicz 2003)",
      .has_bins = false,
      .fixed_bins =
          {shell_harmonic_values,
           "8 shells of equal steps of radius up to 2.5 x the mean distance from the centroid (linear "
           "weights; larger distances are in the last) x degrees 0 to 16, the last fastest",
           2},
      .make = descriptor_makers::harmonics},
     {.descriptor = Descriptor::views,
      .name = "views",
      .value = "Fourier coefficients of depth images of the surface along its principal axes",
      .has_bins = false,
      .fixed_bins =
          {depth_view_values,
           "of each axis, that of the least moment of inertia first: mean and half difference of both "
           "views' roots of magnitudes, frequencies up to 8; roots of mean and half difference of their "
           "parts, frequencies up to 3",
           2},
      .needs_mesh = true,
      .make = descriptor_makers::views},
     {.descriptor = Descriptor::shapedna,
      .name = "shapedna",
      .value = "lowest eigenvalues of the Laplacian of the surface (Reuter, Wolter and Peinecke 2006)",
      .has_bins = false,
      .fixed_bins =
          {shape_dna_values,
           "roots of lambda_i x area / (4 pi i), i = 1 to 40; lambda: the positive eigenvalues of all "
           "components, ascending",
           2},
      .needs_mesh = true,
      .needs_triangles = true,
      .make = descriptor_makers::shapedna,
      .bytes = descriptor_bytes::shapedna}});

static_assert([] {
  for (std::size_t i = 0; i < descriptor_groups.size(); ++i)
    if (static_cast<std::size_t>(descriptor_groups[i].descriptor) != i) return false;
  return true;
}());
constexpr const DescriptorGroup& group_of(Descriptor descriptor) {
  return descriptor_groups[static_cast<std::size_t>(descriptor)];
}
inline constexpr auto descriptor_names = [] {
  std::array<std::string_view, descriptor_groups.size()> names{};
  for (std::size_t i = 0; i < names.size(); ++i) names[i] = descriptor_groups[i].name;
  return names;
}();
constexpr std::string_view name_of(Descriptor descriptor) { return group_of(descriptor).name; }
// Takes the descriptors of a text: "none", or names with commas between them, each taken once. Returns what
// is wrong with the text, or "".
std::string take_descriptors(std::string_view text, std::vector<Descriptor>& descriptors);
constexpr bool needs_mesh(Descriptor descriptor) { return group_of(descriptor).needs_mesh; }

// Whether a row of that name is a companion of a descriptor.
constexpr bool is_companion(std::string_view name) {
  for (const DescriptorGroup& group : descriptor_groups)
    for (const CompanionRow& row : group.companions)
      if (row.name == name) return true;
  return false;
}
// Whether a row of that name comes with the descriptor.
constexpr bool makes_row(Descriptor descriptor, std::string_view name) {
  for (const CompanionRow& row : group_of(descriptor).companions)
    if (row.name == name) return true;
  return name == name_of(descriptor);
}

// Finds the working triangle of every sample that was read back from a store: the triangle of its polygon
// that has its corners, in either winding. Throws std::invalid_argument when a sample's polygon is not in the
// mesh, RunCanceled and ItemError(timeout) from `cancel`. O(T + N), with a factor log K for polygons of K >
// 16 triangles.
std::vector<std::uint32_t> sample_triangles(const PolygonMesh& file, const PreparedMesh& mesh,
                                            const Samples& samples, const CancelToken& cancel = {});
// Sets Samples::triangle to these triangles, and puts corners and weights in the order of the mesh's corners:
// samples taken without topology lie on triangles as the file winds them, which the mesh may have turned.
void locate_on_mesh(const PolygonMesh& file, const PreparedMesh& mesh, Samples& samples,
                    const CancelToken& cancel = {});

// Returns the rows of the requested descriptors, in that order, each followed by its companions: basics; a
// histogram of `bins` shares of sum 1 (a geodesic one without any connected pair is all 0); for pairs, the
// roots of shares; or the norms of harmonics. The mesh may be empty unless a descriptor needs_mesh; some need
// Samples::triangle too. Randomness is a pure function of the key. Needs at least 4 samples. Cost and
// exceptions: see the kernels. Deterministic for every thread count.
std::vector<DescriptorRow> describe_samples(const PreparedMesh& mesh, const Samples& samples, RandomKey key,
                                            const DescribeParameters& parameters,
                                            const CancelToken& cancel = {});

}  // namespace meander
