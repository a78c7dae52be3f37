// The inner loops of spaced and relaxed samples: sums of kernels over points.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/instruction_set.h"

namespace meander {

// Points in space as three rows of coordinates.
struct PointRows {
  std::vector<float> x, y, z;
  std::size_t size() const { return x.size(); }
  void resize(std::size_t count) {
    x.resize(count);
    y.resize(count);
    z.resize(count);
  }
  void push_back(float to_x, float to_y, float to_z) {
    x.push_back(to_x);
    y.push_back(to_y);
    z.push_back(to_z);
  }
};

// Places as steps of 10 bits along x, y and z from a corner: to_x[i] = corner[0] + step x (from[i] & 1023),
// and so on. Their number is a multiple of 8.
inline constexpr float max_steps = 1023;
void unpack(std::span<const std::uint32_t> from, const std::array<float, 3>& corner, float step, float* to_x,
            float* to_y, float* to_z, InstructionSet set = InstructionSet::automatic);

// Boxes as rows of their corners and of margins around them; rows end in anything up to a multiple of 8.
struct BoxRows {
  std::array<std::vector<float>, 3> low, high;
  std::vector<float> margin;
  void resize(std::size_t count);
};
// beyond[i] = g^2 - (distance + margin of box i)^2, where g is the gap between that box and [low, high]: no
// more than 0 where one may touch the other grown by `distance`. beyond: as long as the rows. O(boxes), 8 at
// a time.
void find_gaps(const BoxRows& boxes, const std::array<float, 3>& low, const std::array<float, 3>& high,
               float distance, std::vector<float>& beyond, InstructionSet set = InstructionSet::automatic);

// Askey's kernel (1 - d / reach)^2 at distances d < reach, else 0: positive definite, and near 0 that of the
// energy distance. The short one has the same form and keeps points apart.
struct KernelScale {
  float per_reach = 1, per_short = 0;  // 1 / reach of either, > 0
  float weight = 1, short_weight = 0;  // the short kernel is left out at 0
};

// sum[k] += the kernels at the distances between place k and the points [first, first + count). The same
// cost.
void add_kernel(const PointRows& places, const PointRows& points, std::size_t first, std::size_t count,
                const KernelScale& scale, std::span<float> sum,
                InstructionSet set = InstructionSet::automatic);

// least[k] = the squared distance between place k and the nearest of these points, where that is less. The
// same cost.
void find_nearest(const PointRows& places, const PointRows& points, std::size_t count, std::span<float> least,
                  InstructionSet set = InstructionSet::automatic);

// Mean and second central moments of points.
struct PointMoments {
  std::array<float, 3> mean{};
  std::array<float, 6> central{};  // xx, yy, zz, yz, xz, xy
  float per_extent = 0;            // 1 / sqrt(2 (xx + yy + zz))
};
// Points by their moments and their mass.
struct PointGroup : PointMoments {
  float mass = 0;
};

// The long kernel of weight 1 over the points of groups, to the second order in their extent: no group has
// its mean at a place. Groups that the reach divides count by the share of a normal distribution within it,
// about. O(places x groups), 8 places at a time.
void add_group_kernel(const PointRows& places, std::span<const PointGroup> groups, float per_reach,
                      std::span<float> sum, InstructionSet set = InstructionSet::automatic);

// Dipoles: pairs of points of opposite mass 1, by where they are and the way from the negative one to the
// other.
struct DipoleRows {
  std::vector<float> x, y, z, way_x, way_y, way_z;  // as long as a multiple of 8
  // Those behind the first `count` are 0.
  void resize(std::size_t count);
  void set(std::size_t i, const std::array<float, 3>& at, const std::array<float, 3>& way) {
    x[i] = at[0];
    y[i] = at[1];
    z[i] = at[2];
    way_x[i] = way[0];
    way_y[i] = way[1];
    way_z[i] = way[2];
  }
};

// The kernel f with the slope of Askey's of reach `near` at 0, but of reach `far`, minus that one: smooth
// at 0, and bend x d^2 up to a constant where d < near. Both end within `ramp` about their reaches, for what
// stands for more than a point. Distances are in spacings.
struct FarScale {
  float per_spacing = 1;                 // 1 / spacing, > 0
  float near = 1, far = 2, ramp = 0.5f;  // 0 < ramp <= near <= far
  // Within `near` f falls by this times the square of the distance.
  float bend() const { return (1 / near - 1 / far) / near; }
};
// The slope of f over dipoles at `at`, per spacing. O(dipoles), 8 at a time.
std::array<float, 3> sum_dipoles(const DipoleRows& dipoles, const std::array<float, 3>& at,
                                 const FarScale& scale, InstructionSet set = InstructionSet::automatic);

// Points of a surface with their masses and normals; rows end in anything of mass 0 up to a multiple of 8.
struct SurfaceRows {
  std::vector<float> x, y, z, mass, normal_x, normal_y, normal_z;
  // The first `count` points are to be set, those behind them have no mass.
  void resize(std::size_t count);
  std::size_t size() const { return x.size(); }
};

// Sums over points at a place of a unit normal: with the way d from there in spacings, the kernel is
// k(d) = (1 - d^2 / 4)^8 for |d| < 2, else 0: nearly a normal distribution of the standard deviation 1/2.
struct Pull {
  std::array<float, 3> way{};    // of mass d (1 - d^2 / 4)^7: a quarter of the gradient of `all`
  std::array<float, 6> slope{};  // its derivative with the place, in spacings: xx, xy, xz, yy, yz, zz
  float all = 0;                 // of mass k
  float facing = 0;              // of mass k (1 + cosine between the normals) / 2
};
// Pull::way of points of mass 1. points: rows as long as a multiple of 8, those that count for nothing at
// `at`. O(points), 8 at a time.
std::array<float, 3> sum_ways(const PointRows& points, const std::array<float, 3>& at, float per_spacing,
                              InstructionSet set = InstructionSet::automatic);
// O(points), 8 at a time.
Pull sum_pull(const SurfaceRows& points, const std::array<float, 3>& at, const std::array<float, 3>& normal,
              float per_spacing, InstructionSet set = InstructionSet::automatic);

}  // namespace meander
