#include "kernels/sample/far_field.h"

#include <algorithm>
#include <cmath>

#include "kernels/core/parallel.h"
#include "kernels/sample/stratum_grid.h"

namespace meander::spaced {

namespace {

// Strata of a run have their means within so many spacings of its own.
constexpr float max_run_radius = 4;
// Cells in which runs are looked for: so many to the reach.
constexpr float cells_in_reach = 4;
// The field does not reach runs with more others around them, as in heaps of sheets.
constexpr std::size_t max_runs = 384;

}  // namespace

FarField::FarField(std::span<const PointMoments> moments, std::span<const float> spacing,
                   const std::function<bool(std::uint32_t)>& takes_part, const CancelToken& cancel) {
  const auto strata = static_cast<std::uint32_t>(moments.size());
  const std::uint32_t runs = (strata + run_strata - 1) / run_strata;
  dipoles_.resize(runs + StratumLists::max_run);
  takes_part_.assign(runs, 1);
  std::vector<float> reach(runs);
  double sum = 0, least = INFINITY;
  for (std::uint32_t run = 0; run < runs; ++run) {
    const std::uint32_t begin = run * run_strata, end = std::min(begin + run_strata, strata);
    const float share = 1 / static_cast<float>(end - begin);
    std::array<float, 3> at{};
    for (std::uint32_t s = begin; s < end; ++s) {
      for (std::size_t k = 0; k < 3; ++k) at[k] += share * moments[s].mean[k];
      reach[run] = std::max(reach[run], (far_reach + ramp) * spacing[s]);
    }
    dipoles_.set(run, at, {});
    sum += reach[run];
    least = std::min(least, static_cast<double>(reach[run]));
    for (std::uint32_t s = begin; s < end; ++s) {
      const std::array<float, 3>& mean = moments[s].mean;
      const float x = mean[0] - at[0], y = mean[1] - at[1], z = mean[2] - at[2];
      const float radius = max_run_radius * spacing[s];
      if (!takes_part(s) || !(x * x + y * y + z * z <= radius * radius)) takes_part_[run] = 0;
    }
  }
  StratumGrid grid(std::max(least, min_cell * sum / runs) / cells_in_reach);
  std::vector<std::uint32_t> run_at;  // of what is in the grid
  for (std::uint32_t run = 0; run < runs; ++run) {
    if (takes_part_[run] == 0) continue;
    grid.add({middle(run), middle(run)}, reach[run] / cells_in_reach);
    run_at.push_back(run);
  }
  grid.build();
  near_ = StratumLists(runs, draw_block);
  parallel_tasks((runs + draw_block - 1) / draw_block, [&](std::size_t block) {
    cancel.check();
    std::vector<std::uint32_t> found;
    const auto end = static_cast<std::uint32_t>(std::min<std::size_t>((block + 1) * draw_block, runs));
    for (auto run = static_cast<std::uint32_t>(block * draw_block); run < end; ++run) {
      found.clear();
      const std::array<float, 3> at = middle(run);
      const auto is_near = [&](std::uint32_t i) {
        const std::uint32_t other = run_at[i];
        const float x = dipoles_.x[other] - at[0], y = dipoles_.y[other] - at[1],
                    z = dipoles_.z[other] - at[2];
        return x * x + y * y + z * z < reach[run] * reach[run];
      };
      if (takes_part_[run] != 0 && !grid.find_around({at, at}, reach[run], max_runs, is_near, found)) {
        takes_part_[run] = 0;
        found.clear();
      }
      for (std::uint32_t& i : found) i = run_at[i];
      near_.write(run, found);
    }
    near_.close(block);
  });
}

void FarField::add(std::uint32_t stratum, const PointMoments& moments, float spacing,
                   const std::array<float, 3>& own, float share, const PointRows& places, DipoleRows& scratch,
                   std::span<float> energy) const {
  const std::uint32_t run = stratum / run_strata;
  const std::size_t count = near_.size(run);
  scratch.resize(count + StratumLists::max_run);
  near_.gather(run, {{dipoles_.x.data(), scratch.x.data()},
                     {dipoles_.y.data(), scratch.y.data()},
                     {dipoles_.z.data(), scratch.z.data()},
                     {dipoles_.way_x.data(), scratch.way_x.data()},
                     {dipoles_.way_y.data(), scratch.way_y.data()},
                     {dipoles_.way_z.data(), scratch.way_z.data()}});
  scratch.resize(count + 1);
  scratch.set(count, middle(run), {-own[0], -own[1], -own[2]});
  const float per_spacing = 1 / spacing;
  const FarScale scale{per_spacing, static_cast<float>(kernel_reach), far_reach, ramp};
  const std::array<float, 3>& mean = moments.mean;
  const std::array<float, 3> slope = sum_dipoles(scratch, mean, scale);
  const float bend = share * scale.bend();
  for (std::size_t k = 0; k < places.size(); ++k) {
    const float x = per_spacing * (places.x[k] - mean[0]), y = per_spacing * (places.y[k] - mean[1]),
                z = per_spacing * (places.z[k] - mean[2]);
    energy[k] += slope[0] * x + slope[1] * y + slope[2] * z + bend * (x * x + y * y + z * z);
  }
}

}  // namespace meander::spaced
