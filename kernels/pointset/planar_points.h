// Point sets in the unit square by the methods that samplings are compared with (docs/METHODS.md 14).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "kernels/pointset/plain_points.h"

namespace meander {

// "Deterministic" sets do not depend on the seed: one run is all there is.
enum class PlanarMethod : std::uint8_t {
  random,              // independent
  jittered,            // one random point in each cell of a grid; see below for counts without a root
  halton,              // radical inverses 2 and 3 of 1 .. N (Halton 1960); deterministic
  hammersley,          // ((i + 1/2) / N, radical inverse 2 of i) (Hammersley 1960); deterministic
  sobol,               // Joe and Kuo 2008, in Gray-code order from index 0, (0, 0); deterministic
  sobol_owen,          // the same under nested uniform scrambling (Owen 1995)
  r2,                  // frac(1/2 + i (1/g, 1/g^2)), i = 1 .. N, g^3 = g + 1 (Roberts 2018); deterministic
  hilbert_stratified,  // H(t_i) of the 1-D set of that name (sample_sequence), continuous Hilbert curve
  hilbert_shifted,     //   jitter 0.25
  hilbert_regular,     //   t_i = (i + 1/2) / N: a grid for N = 4^k; deterministic
  hilbert_owen,        //   Owen-scrambled van der Corput
  peano_stratified,    // the stratified set on the Peano curve
  peano_meander_stratified,  // and on the Peano-meander curve
  hilbert_vertex,  // the stratified set moved to centers of curve leaves: the survey's own placement
  poisson_disk,    // weighted sample elimination (Yuksel 2015) of 5 N random points
  lloyd,           // centroidal Voronoi: Lloyd's iteration (Lloyd 1982) from the jittered set
};
inline constexpr std::array<std::string_view, 16> planar_method_names = {"random",
                                                                         "jittered",
                                                                         "halton",
                                                                         "hammersley",
                                                                         "sobol",
                                                                         "sobol-owen",
                                                                         "r2",
                                                                         "hilbert-stratified",
                                                                         "hilbert-shifted",
                                                                         "hilbert-regular",
                                                                         "hilbert-owen",
                                                                         "peano-stratified",
                                                                         "peano-meander-stratified",
                                                                         "hilbert-vertex",
                                                                         "poisson-disk",
                                                                         "lloyd"};
constexpr std::string_view name_of(PlanarMethod method) {
  return planar_method_names[static_cast<std::size_t>(method)];
}
// By name; empty when there is no such method.
std::optional<PlanarMethod> planar_method(std::string_view name);
// Does the set not depend on the seed?
bool is_deterministic(PlanarMethod method);

struct PlanarParameters {
  double leaves_per_point = 1;  // hilbert_vertex: smallest 4^m >= leaves_per_point x N leaves; 1 .. 4096
  std::uint32_t lloyd_iterations = 40;  // 0 .. 10^4
};

// `count` points of the method; none for count 0. Every method takes every count:
// - jittered: floor(sqrt(N) + 1/2) columns whose numbers of cells are equal or differ by one, each column as
//   wide as its share of the cells: every cell has area 1/N, and N = m^2 gives the m x m grid.
// - the others by their formula. Powers of two are what Sobol sets are best at.
// Pure in (method, count, seed, parameters), for every thread count. Order: of drawing (random), by rank
// along the curve (hilbert_*, peano_*), by index (halton .. r2, whose prefixes are the smaller sets,
// Hammersley apart), none (jittered by columns, poisson_disk, lloyd). Cost a point, one core: 10 - 200 ns;
// poisson_disk 25 us, lloyd 0.7 us an iteration (N log N and N in all; use them up to 2^14 or so). Memory 16
// N bytes and up to 40 N scratch (poisson_disk 250 N). Throws std::invalid_argument when a parameter is out
// of its range.
PlanarPoints planar_points(PlanarMethod method, std::uint32_t count, std::uint64_t seed,
                           const PlanarParameters& parameters = {});

// Digits of `index` in `base` >= 2 mirrored at the radix point (van der Corput 1935). Pure; O(log index).
double radical_inverse(std::uint32_t base, std::uint32_t index);

// Point `index` of the 2-D Sobol sequence in Gray-code order, each coordinate x 2^32 (Joe and Kuo 2008).
// Pure.
std::array<std::uint32_t, 2> sobol_words(std::uint32_t index);

}  // namespace meander
