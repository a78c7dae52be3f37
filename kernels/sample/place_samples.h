// Placing samples: the 1-D set, its order, and the point inside each element (docs/METHODS.md 7).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/core/notes.h"
#include "kernels/core/random.h"
#include "kernels/data/samples.h"
#include "kernels/density/density.h"
#include "kernels/mesh/box_frame.h"
#include "kernels/mesh/measured_mesh.h"
#include "kernels/partition/elements.h"
#include "kernels/sample/spaced_samples.h"

namespace meander {

// spaced: places, not positions along the path, are chosen (see space_samples); the others are 1-D sets.
enum class SequenceKind : std::uint8_t { shifted, stratified, owen, regular, random, spaced };
inline constexpr Word<SequenceKind> sequence_words[] = {
    {"shifted", SequenceKind::shifted}, {"stratified", SequenceKind::stratified},
    {"owen", SequenceKind::owen},       {"regular", SequenceKind::regular},
    {"random", SequenceKind::random},   {"spaced", SequenceKind::spaced}};
enum class OrderKind : std::uint8_t { progressive, curve };
inline constexpr Word<OrderKind> order_words[] = {{"progressive", OrderKind::progressive},
                                                  {"curve", OrderKind::curve}};
enum class PlaceKind : std::uint8_t { element, vertex };
inline constexpr Word<PlaceKind> place_words[] = {{"element", PlaceKind::element},
                                                  {"vertex", PlaceKind::vertex}};
enum class NormalizeKind : std::uint8_t { none, unit_sphere, unit_box, unit_diagonal, pointnet };
inline constexpr Word<NormalizeKind> normalize_words[] = {{"none", NormalizeKind::none},
                                                          {"unit-sphere", NormalizeKind::unit_sphere},
                                                          {"unit-box", NormalizeKind::unit_box},
                                                          {"unit-diagonal", NormalizeKind::unit_diagonal},
                                                          {"pointnet", NormalizeKind::pointnet}};

// What is done to the samples in the end. relax: they move over the surface (relaxed_samples.h).
enum class FinishKind : std::uint8_t { none, relax };
inline constexpr Word<FinishKind> finish_words[] = {{"none", FinishKind::none}, {"relax", FinishKind::relax}};

inline constexpr const char* finish_help =
    "relax: move the samples over the surface in the end, until they are nearly as even as they can be; "
    "those "
    "on sheets that lie on each other stay";
inline constexpr const char* sequence_help =
    "The sample set: 1-D sets along the order, or spaced, whose places in their strata keep samples apart";

struct PlaceParameters {
  std::uint32_t samples = 2048;  // N, 1..2^31
  SequenceKind sequence = SequenceKind::shifted;
  OrderKind order = OrderKind::progressive;
  PlaceKind place = PlaceKind::element;
  NormalizeKind normalize = NormalizeKind::none;
  double jitter = 0.25;                         // s of the shifted sequence, 0..1
  SpacingKind spacing = SpacingKind::standard;  // of the spaced sequence
  FinishKind finish = FinishKind::none;
};

// Samples of cells form a net in place of a shifted set along the path.
constexpr bool forms_net(const PlaceParameters& parameters) {
  return parameters.sequence == SequenceKind::shifted;
}

// Positions in [0, 1) of the N samples, ascending: t_i for i = 0 .. N - 1. Pure. O(N) (O(N log N) for random
// and owen). Throws std::invalid_argument for `spaced`, which is no 1-D set.
std::vector<double> sample_sequence(SequenceKind kind, std::uint32_t count, double jitter, RandomKey key);

// order[i] = curve rank of the i-th sample of the file: a permutation of 0 .. N - 1 in which every prefix is
// spread along the curve. For N = 2^k the bit-reversed index XOR a random mask, else a balanced tree. O(N).
std::vector<std::uint32_t> progressive_order(std::uint32_t count, RandomKey key);

// Loc and scale of the stored points: file coordinates = loc + scale * point.
struct OutputFrame {
  Vector3 loc;
  double scale = 1;
  friend bool operator==(const OutputFrame& a, const OutputFrame& b) {
    return a.loc.x == b.loc.x && a.loc.y == b.loc.y && a.loc.z == b.loc.z && a.scale == b.scale;
  }
};
// The frame that keeps points in the box apart in float32: loc 0 and scale 1 wherever that holds them. loc is
// the box center once max |coordinate| > 2^10 diagonal; scale is the box's unit, a power of two, where
// coordinates would come near the largest float32 (above 2^120) or the box is not large against the least one
// (unit below 2^-126).
OutputFrame float_frame(const std::array<double, 6>& bbox, const BoxFrame& box);
// none: float_frame. The others have the box center as loc and as scale: unit_box its longest side,
// unit_diagonal its diagonal, unit_sphere the largest distance of a used vertex from that center. The frame
// of pointnet follows from the samples: place_samples makes it, and is given that of unit_sphere, as here.
OutputFrame output_frame(const PreparedMesh& mesh, NormalizeKind kind);

// What samples are placed on, and how. A view; no hints of rays.
struct PlaceContext : SurfaceContext {
  const PolygonMesh& file;
  const PlaceParameters& parameters;
  MetricAt metric = {};  // of distances between spaced samples; empty: distances in space
};

// Exactly N distinct points (as stored in float32): the sample of rank i lies in the element that holds the
// share t_i of the mass, at a mu-uniform point of it. A duplicate is redrawn in its element from the next
// counter of the same stream; what stays equal after 64 redraws, or as many as a RedrawLimit allows, is
// counted in repairs[coincident_points]. Normals: the file's, interpolated, where it gives them, else
// geometric. The sequence `spaced` chooses the points by space_samples. O(N + E).
//
// frame: of the stored points. With the normalization pointnet it becomes that of the samples
// (sample_frame.h), and points that coincide in that frame are drawn again.
//
// In cells the sample of rank i lies in the entry that holds the share t_i N - floor(t_i N) of cell floor(t_i
// N) along the path: expected O(N P) for P entries a cell. In regions, made with the same key, the elements
// are made and forgotten one region after the other, several at a time by several threads; throws
// std::invalid_argument for `spaced`, whose places depend on each other.
//
// With a finish, samples are moved by relax_samples before duplicates are looked for; those that stay are a
// note.
Samples place_samples(const PlaceContext& context, const SurfaceOrder& order, OutputFrame& frame,
                      RepairCounts& repairs, Notes& notes);

// Counts samples that a finish left where they were, of so many, among what was asked for and not given.
void note_unrelaxed(std::size_t unrelaxed, std::size_t samples, Notes& notes);

// Upper bound of the bytes of the samples of a whole surface while they are placed, up to the encoded row.
double sample_bytes(const PlaceParameters& parameters, bool in_metric);

}  // namespace meander
