// The inner loops of spaced samples: distances from places to samples, and mass around places.
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
inline constexpr float most_steps = 1023;
void unpack(std::span<const std::uint32_t> from, const std::array<float, 3>& corner, float step, float* to_x,
            float* to_y, float* to_z, InstructionSet set = InstructionSet::automatic);

// Lowers squared[k] to the squared distance of place k to its nearest point. O(places x points), 8 at a time.
void lower_to_nearest(const PointRows& places, const PointRows& points, std::span<float> squared,
                      InstructionSet set = InstructionSet::automatic);

// mass[k] = sum of the weights of the points nearer to place k than sqrt(squared[k]); weight: of the
// first points, which are those that count; their sum is below 2^32. The same cost.
void mass_within(const PointRows& places, const PointRows& points, std::span<const std::uint32_t> weight,
                 std::span<const float> squared, std::span<std::uint32_t> mass,
                 InstructionSet set = InstructionSet::automatic);

}  // namespace meander
