// Spaced samples: one for each of n strata of equal mass, at the places where all of them together represent
// the surface best (docs/METHODS.md 7.5).
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/core/random.h"
#include "kernels/core/words.h"

namespace meander {

// Spacing of the hexagonal lattice, in spacings sqrt(area of a sample): sqrt(2 / sqrt(3)).
inline constexpr double hexagonal_distance = 1.0745699318235418;

// How much is spent on the places.
struct SpacingParameters {
  std::uint32_t candidates = 16;         // places that every stratum offers: 8, 16, .. 64
  std::uint32_t sweeps = 4;              // over all samples, 0..64
  std::uint32_t repairs = 16;            // passes over samples that are too near to another one, 0..64
  std::uint32_t repair_candidates = 32;  // new places that each is offered, 1..256
  // What is too near, in spacings of the hexagonal lattice, .1..1, along the path and in progressive order;
  // but no more than this share of all samples, the nearest ones, are moved; 0..1
  double repair_below = 0.69, progressive_repair_below = 0.62, repair_share = 0.2;
  // Rounds in which samples that are still too near, at most one in 64 each time, may leave their strata, and
  // those around them settle, 0..8; unless there are none, as many as possible for the first 512 samples of a
  // larger progressive set
  std::uint32_t leave_rounds = 4;
  // Rounds in which samples beside the largest holes, at most one in 64, move into these, 0..4
  std::uint32_t hole_rounds = 1;
};

// fast: half to two thirds of the time of standard; best: less than twice the time, and the lowest error
// (docs/METHODS.md 7.5 has the numbers).
enum class SpacingKind : std::uint8_t { fast, standard, best };
inline constexpr Word<SpacingKind> spacing_words[] = {
    {"fast", SpacingKind::fast}, {"default", SpacingKind::standard}, {"best", SpacingKind::best}};
inline constexpr const char* spacing_help = "Effort of the sequence spaced";
inline constexpr const char* spacing_applies_to = "applies to the sequence spaced only";
SpacingParameters spacing_parameters(SpacingKind kind);

// All problems of the parameters, one sentence each; empty when they are valid.
std::vector<std::string> validate(const SpacingParameters& parameters);

// A random point of a stratum, and what names it there.
struct StratumPoint {
  std::array<float, 3> at{};             // in [-4, 4]
  float density = 1;                     // > 0
  std::uint32_t triangle = 0, path = 0;  // on meshes: the element that it lies in,
  double first = 0, second = 0;          // and its weights of corners 1 and 2; on parametric surfaces (u, v)
};

// Which point is wanted: `at` is a stratum plus a share of its mass, and the rest is random.
struct PointDraw {
  double at = 0;            // [0, n)
  std::uint64_t index = 0;  // with `number` and a key, of all random numbers
  std::uint32_t number = 0;
  PhiloxBlock words{};  // the first of them; words[0] has made `at`
};

// Distances near a point: rows by which differences are multiplied to have round neighborhoods of the same
// mass, and the factor by which these are longer in space than round ones.
struct LocalMetric {
  std::array<std::array<float, 3>, 3> rows{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  float stretch = 1;  // >= 1
};

// The metric at weights (of corners 1 and 2) of a triangle. Thread-safe. Empty: distances are those in space.
using MetricAt = std::function<LocalMetric(std::uint32_t triangle, double b1, double b2)>;

// A surface in n strata of equal mass, one after the other along a path.
class Strata {
 public:
  virtual ~Strata() = default;
  virtual std::uint32_t count() const = 0;  // n >= 1
  virtual double measure() const = 0;       // area x density, in squared units of StratumPoint::at
  // Points distributed by mass within the piece of the surface that each `at` names, a pure function of the
  // draw. draws: ascending `at`; points: as many. Thread-safe.
  virtual void draw(std::span<const PointDraw> draws, std::span<StratumPoint> points) const = 0;
  virtual bool is_isotropic() const { return true; }
  virtual LocalMetric metric(const StratumPoint&) const { return {}; }
};

// The n samples by stratum, and their order.
struct SpacedSamples {
  std::vector<StratumPoint> point;           // n, of each stratum, in it but for those that left it
  std::vector<std::uint32_t> rank_of_index;  // order in the file: stratum of the i-th sample
};

// Chooses the places by matched energy (in the plane: Schmaltz et al. 2010, "Electrostatic halftoning"; as a
// measure of sets: Szekely and Rizzo 2013, "Energy statistics"). The energy of a sample is the sum of a
// positive definite kernel over its distances to the other samples, minus the same sum over the surface.
// Every stratum offers `candidates` random points of its own; the strata are visited in random groups,
// `sweeps` times, and each time the sample moves to the place of least energy. Beyond the reach of the kernel
// several strata together count by how far their samples are from their means. Then `repairs` passes offer
// new places, anywhere in the stratum, to samples that are too near to another one. What finds no room there
// takes a place of another stratum nearby: few do, where a stratum is narrow, bent or torn (with leave_rounds
// = 0 none).
//
// progressive: the order of progressive_order, and the same is done for the first 64, 128, ... samples in as
// many coarser strata; those of before stay, and each stratum's empty half gets a new one. Else the samples
// are in the order of the strata.
//
// Pure in (strata, key, parameters), the same for every number of threads: the samples of a group are chosen
// before any of them moves. Cost: about 9 us a sample (16 where progressive) on one core, several times as
// much where sheets are stacked; 473 bytes a sample at the peak, with what is given and returned. Throws
// std::invalid_argument for parameters that `validate` refuses.
SpacedSamples space_samples(const Strata& strata, bool progressive, RandomKey key,
                            const SpacingParameters& parameters, const CancelToken& cancel = {});

}  // namespace meander
