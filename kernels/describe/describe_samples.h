// The descriptors of one sampled model, by name.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/core/random.h"
#include "kernels/describe/distance_histogram.h"
#include "kernels/describe/shape_moments.h"
#include "kernels/mesh/prepared_mesh.h"
#include "kernels/sample/samples.h"

namespace meander {

// d2: distances of all pairs of samples. a3, d1, d3, d4: Osada's other shape functions. geodesic: distances
// along the surface, from the first samples to all. basics: area, volume, moments and box of the mesh, not a
// histogram.
enum class Descriptor : std::uint8_t { d2, a3, d1, d3, d4, geodesic, basics };
inline constexpr std::array<std::string_view, 7> descriptor_names = {"d2", "a3",       "d1",    "d3",
                                                                     "d4", "geodesic", "basics"};
constexpr std::string_view name_of(Descriptor descriptor) {
  return descriptor_names[static_cast<std::size_t>(descriptor)];
}

// The row of one value that comes after geodesic: the share of the pairs of samples, [0, 1], that no path
// joins and that are therefore in no bin.
inline constexpr std::string_view geodesic_disconnected_name = "geodesic_disconnected";
// Whether a row of that name comes with the descriptor.
constexpr bool makes_row(Descriptor descriptor, std::string_view name) {
  return name == name_of(descriptor) ||
         (descriptor == Descriptor::geodesic && name == geodesic_disconnected_name);
}

// What needs the mesh besides the samples.
constexpr bool needs_mesh(Descriptor descriptor) {
  return descriptor == Descriptor::geodesic || descriptor == Descriptor::basics;
}

// What DescribeParameters::bins and ::scale shape.
constexpr bool has_bins(Descriptor descriptor) { return descriptor != Descriptor::basics; }
constexpr bool takes_scale(Descriptor descriptor) {
  return descriptor == Descriptor::d2 || descriptor == Descriptor::geodesic;
}

// basics: the values of shape_basics and whether the mesh is closed, all finite. What only a closed surface
// has is 0 where it is not; the volume has no sign (the model turned inside out is the same solid).
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

// The working triangle of every sample that was read back from a store: the one of its polygon that has its
// corners. Throws
// std::invalid_argument when a sample's polygon is not in the mesh. O(T + N).
std::vector<std::uint32_t> sample_triangles(const PolygonMesh& file, const PreparedMesh& mesh,
                                            const Samples& samples);

// The rows of the descriptors asked for, in that order (geodesic has a second one): basics, or a histogram of
// `bins` shares of sum 1 (a geodesic one without any connected pair is all 0). The mesh may be
// empty unless a descriptor needs_mesh; geodesic needs Samples::triangle too. Randomness is a pure function
// of the key. Cost: see the kernels. Needs at least 4 samples. Throws what they throw; deterministic for
// every thread count.
std::vector<DescriptorRow> describe_samples(const PreparedMesh& mesh, const Samples& samples, RandomKey key,
                                            const DescribeParameters& parameters,
                                            const CancelToken& cancel = {});

}  // namespace meander
