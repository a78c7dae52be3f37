// Internal to kernels/sample: the places that strata offer to spaced samples (docs/METHODS.md 7.5).
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/core/random.h"
#include "kernels/sample/kernel_sums.h"
#include "kernels/sample/spaced_samples.h"
#include "kernels/sample/stratum_grid.h"

namespace meander::spaced {

// Samples farther apart than this do not know of each other, in spacings: sqrt(area of a stratum).
inline constexpr double kernel_reach = 2.5;
// Cells in which neighbors are looked for are at least so large, in mean reaches.
inline constexpr double min_cell = 1.0 / 1024;
// Strata that one task draws.
inline constexpr std::size_t draw_block = 256;

// The strata of one level: equal runs of leaves, which are the strata of the whole set.
struct LeafBlocks {
  std::uint32_t leaves, count;
  std::uint32_t begin(std::uint32_t block) const {
    return static_cast<std::uint32_t>(std::uint64_t{block} * leaves / count);
  }
  std::uint32_t size(std::uint32_t block) const { return begin(block + 1) - begin(block); }
  std::uint32_t block_of(std::uint32_t leaf) const {
    return static_cast<std::uint32_t>(((std::uint64_t{leaf} + 1) * count - 1) / leaves);
  }
};

// The blocks of a level: 2^level, on the last level the leaves.
struct Levels {
  std::uint32_t leaves;
  int last;
  explicit Levels(std::uint32_t count) : leaves(count), last(count > 1 ? std::bit_width(count - 1) : 0) {}
  LeafBlocks blocks(int level) const { return {leaves, level < last ? std::uint32_t{1} << level : leaves}; }
};

// A place that a stratum offers: with the key, it decides the point.
struct PlaceName {
  std::uint32_t level = 0, stratum = 0, number = 0;
};

// Counter of random numbers of a stratum: of the shift of its net.
inline constexpr std::uint32_t net_shift = 0x10000u;

// What every choice of places follows from.
struct Offer {
  RandomKey key;
  const SpacingParameters& parameters;
  Levels levels;

  // A leaf is divided into `candidates` equal shares and offers one place in each; a repair does the same
  // with `repair_candidates`.
  // The first places of coarser strata are such places of their leaves.
  PlaceName in_leaf(const PlaceName& name) const {
    if (static_cast<int>(name.level) == levels.last || name.number >= parameters.candidates) return name;
    const LeafBlocks blocks = levels.blocks(static_cast<int>(name.level));
    const PhiloxBlock words = words_of(name);
    const std::uint32_t size = blocks.size(name.stratum);
    const double at = (name.number + words[0] * 0x1p-32) / parameters.candidates * size;
    // Different places where a leaf gives several: the stride has no divisor in common with their number.
    constexpr std::uint32_t stride = 11;
    const PhiloxBlock shift = random_words(key, Stream::stratum_start, index_of(name), 1);
    return {static_cast<std::uint32_t>(levels.last),
            blocks.begin(name.stratum) + std::min(static_cast<std::uint32_t>(at), size - 1),
            (shift[0] % parameters.candidates + stride * name.number) % parameters.candidates};
  }

  PointDraw draw(const PlaceName& offered) const {
    const PlaceName name = in_leaf(offered);
    PointDraw draw;
    draw.index = index_of(name);
    draw.number = name.number;
    draw.words = words_of(name);
    if (name.number < parameters.candidates) spread(name, draw.words);
    const LeafBlocks blocks = levels.blocks(static_cast<int>(name.level));
    const std::uint32_t begin = blocks.begin(name.stratum), size = blocks.size(name.stratum);
    const double random = draw.words[0] * 0x1p-32;
    const bool first = name.number < parameters.candidates;
    const std::uint32_t among = first ? parameters.candidates : parameters.repair_candidates;
    const std::uint32_t share = first ? name.number : (name.number - parameters.candidates) % among;
    const double in_stratum = (share + random) / among;
    draw.at = std::min(begin + in_stratum * size, std::nextafter(double(begin + size), 0.0));
    return draw;
  }

  static std::uint64_t index_of(const PlaceName& name) {
    return std::uint64_t{name.level} << 32 | name.stratum;
  }

 private:
  PhiloxBlock words_of(const PlaceName& name) const {
    return random_words(key, Stream::stratum_point, index_of(name), name.number);
  }
  // The first places of a stratum lie within their element by a (0, m, 2)-net, shifted at random, and at
  // random in its parts: their sums are the surface's integral, and with as many independent places would
  // miss it by more.
  void spread(const PlaceName& name, PhiloxBlock& words) const {
    const PhiloxBlock shift = random_words(key, Stream::stratum_start, index_of(name), net_shift);
    const auto net = std::uint32_t{0xFFFFFFFFu} << (32 - std::bit_width(parameters.candidates - 1));
    std::uint32_t first = shift[0], second = shift[1], in_first = 1u << 31, in_second = 1u << 31;
    for (std::uint32_t k = name.number; k != 0; k >>= 1) {
      if ((k & 1) != 0) {
        first ^= in_first;
        second ^= in_second;
      }
      in_first >>= 1;
      in_second ^= in_second >> 1;
    }
    words[1] = (first & net) | (words[1] & ~net);
    words[2] = (second & net) | (words[2] & ~net);
  }
};

struct Point {
  float x = 0, y = 0, z = 0;
};
inline Point point_at(const StratumPoint& point) { return {point.at[0], point.at[1], point.at[2]}; }

inline PointBox box_of(const PointRows& points) {
  PointBox box;
  const auto enclose = [&](std::size_t k, const std::vector<float>& row) {
    const auto [low, high] = std::minmax_element(row.begin(), row.end());
    box.low[k] = *low;
    box.high[k] = *high;
  };
  enclose(0, points.x);
  enclose(1, points.y);
  enclose(2, points.z);
  return box;
}

inline bool contains(const PointBox& box, const Point& at) {
  return at.x >= box.low[0] && at.x <= box.high[0] && at.y >= box.low[1] && at.y <= box.high[1] &&
         at.z >= box.low[2] && at.z <= box.high[2];
}
inline void enclose(PointBox& box, const Point& at) {
  const std::array<float, 3> c = {at.x, at.y, at.z};
  for (std::size_t k = 0; k < 3; ++k) {
    box.low[k] = std::min(box.low[k], c[k]);
    box.high[k] = std::max(box.high[k], c[k]);
  }
}
// Between the nearest points of two boxes.
inline float squared_gap(const PointBox& a, const PointBox& b) {
  float sum = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const float gap = std::max({a.low[k] - b.high[k], b.low[k] - a.high[k], 0.0f});
    sum += gap * gap;
  }
  return sum;
}
inline bool is_within(const PointBox& box, const Point& at, float distance) {
  return squared_gap(box, {{at.x, at.y, at.z}, {at.x, at.y, at.z}}) <= distance * distance;
}
inline PointBox grown(PointBox box, float by) {
  for (std::size_t k = 0; k < 3; ++k) {
    box.low[k] -= by;
    box.high[k] += by;
  }
  return box;
}

// Places offered by strata, to 1/1023 of the largest extent of its box.
class OfferedPlaces {
 public:
  OfferedPlaces(std::size_t strata, std::size_t places)
      : places_(places), box_(strata), packed_(places * strata) {}

  std::size_t places() const { return places_; }

  void store(std::size_t stratum, std::span<const std::array<float, 3>> points) {
    PointBox& box = box_[stratum];
    box = {points[0], points[0]};
    for (const std::array<float, 3>& at : points)
      for (std::size_t k = 0; k < 3; ++k) {
        box.low[k] = std::min(box.low[k], at[k]);
        box.high[k] = std::max(box.high[k], at[k]);
      }
    const float step = step_of(stratum), per_step = step > 1e-30f ? 1 / step : 0;
    for (std::size_t i = 0; i < places_; ++i) {
      std::uint32_t packed = 0;
      for (std::size_t k = 3; k-- > 0;) {
        const float steps = std::min((points[i][k] - box.low[k]) * per_step + 0.5f, max_steps);
        packed = packed << 10 | static_cast<std::uint32_t>(steps);
      }
      packed_[stratum * places_ + i] = packed;
    }
  }

  // Writes all places of a stratum to rows from `to` on.
  void load(std::size_t stratum, PointRows& rows, std::size_t to) const {
    unpack(std::span(packed_).subspan(stratum * places_, places_), box_[stratum].low, step_of(stratum),
           &rows.x[to], &rows.y[to], &rows.z[to]);
  }

  const PointBox& box(std::size_t stratum) const { return box_[stratum]; }
  float extent(std::size_t stratum) const {
    const PointBox& box = box_[stratum];
    return std::max({box.high[0] - box.low[0], box.high[1] - box.low[1], box.high[2] - box.low[2]});
  }

  Point place(std::size_t stratum, std::size_t i) const {
    const std::array<float, 3>& low = box_[stratum].low;
    const float step = step_of(stratum);
    const std::uint32_t packed = packed_[stratum * places_ + i];
    return {low[0] + step * static_cast<float>(packed & 1023),
            low[1] + step * static_cast<float>(packed >> 10 & 1023),
            low[2] + step * static_cast<float>(packed >> 20 & 1023)};
  }

 private:
  float step_of(std::size_t stratum) const { return extent(stratum) / max_steps; }

  std::size_t places_;
  std::vector<PointBox> box_;
  std::vector<std::uint32_t> packed_;
};

// The strata of a level, as they are sampled.
struct OfferedStrata {
  OfferedPlaces places;
  std::vector<float> spacing;       // in units of the points, or of the metric
  std::vector<LocalMetric> metric;  // empty in isotropic sets
  OfferedStrata(std::size_t strata, std::size_t candidates, bool isotropic)
      : places(strata, candidates), spacing(strata), metric(isotropic ? 0 : strata) {}
};

// All leaves: their places are drawn.
OfferedStrata offer_leaves(const Strata& strata, const Offer& offer, const CancelToken& cancel);
// Coarser strata: their places are some of their leaves'.
OfferedStrata offer_blocks(const OfferedStrata& leaves, int level, const Offer& offer,
                           const CancelToken& cancel);

}  // namespace meander::spaced
