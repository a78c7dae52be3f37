// The frame that a set of points defines: the normalization of PointNet.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "kernels/core/parallel.h"
#include "kernels/core/vector3.h"
#include "kernels/mesh/prepared_mesh.h"
#include "kernels/sample/placer.h"
#include "kernels/sample/point_frames.h"
#include "kernels/sample/sample_sites.h"

namespace meander {

// pc_normalize of PointNet: loc is the mean of the points, scale the distance of the farthest of them from
// loc. Both are computed in double, the mean in the order of the points, before any is rounded to float32: of
// the points that are then stored the mean is 0 to the rounding of float32 (and of loc, where the model lies
// far from the origin), and the farthest has distance 1 within 2^-24. A single point, or points all at one
// place, have no such scale: it is that of `otherwise`.
//   from(loc, i): point i less loc, a place of the file, in units of the mesh; pure.
// count: 1 and more. O(n), parallel; the same bits for every number of threads.
template <class From>
OutputFrame frame_of_points(const PreparedMesh& mesh, std::size_t count, const From& from,
                            const OutputFrame& otherwise) {
  const std::size_t blocks = (count + sum_block - 1) / sum_block;
  std::vector<Vector3> sums(blocks);
  parallel_blocks(count, sum_block, [&](std::size_t begin, std::size_t end) {
    Vector3 sum;
    for (std::size_t i = begin; i < end; ++i) sum = sum + from(mesh.center, i);
    sums[begin / sum_block] = sum;
  });
  Vector3 total;
  for (const Vector3& sum : sums) total = total + sum;
  const auto n = static_cast<double>(count);
  OutputFrame frame = otherwise;
  frame.loc = to_file(mesh, {total.x / n, total.y / n, total.z / n});
  std::vector<double> farthest(blocks, 0.0);
  parallel_blocks(count, sum_block, [&](std::size_t begin, std::size_t end) {
    double& largest = farthest[begin / sum_block];
    for (std::size_t i = begin; i < end; ++i) largest = std::max(largest, norm(from(frame.loc, i)));
  });
  const double radius = *std::max_element(farthest.begin(), farthest.end()) * mesh.unit;
  if (count > 1 && radius > 0) frame.scale = radius;
  return frame;
}

// The redrawn samples. `first`: their ranks and the sites of their first draws, kept where the frame depends
// on them. `coincident`: how many still share a point with another one.
struct Redrawn {
  std::vector<std::pair<std::uint32_t, SampleSite>> first;
  std::uint32_t coincident = 0;
};

// Draws again what coincides in the frame of the stored points, which is returned: that of the placer, or of
// pointnet that of the samples. Where other samples than those that define it are left once repeated ones are
// drawn again, these define the next one, and so on until nothing changes; after few rounds, where float32
// cannot tell the samples apart, the frame is off by less than their distances.
//   redraw(placer): makes the samples distinct in the frame of that placer; returns Redrawn.
template <class Redraw>
OutputFrame draw_in_frame(const Placer& placer, SampleSites& sites, RepairCounts& repairs,
                          const Redraw& redraw) {
  constexpr int most_rounds = 4;
  const auto frame_of_sites = [&] {
    return frame_of_points(
        placer.mesh, sites.count(),
        [&](const Vector3& from, std::size_t rank) { return placer.place_from(from, rank); }, placer.frame);
  };
  OutputFrame frame = placer.frame_follows() ? frame_of_sites() : placer.frame;
  for (int round = 1;; ++round) {
    const Redrawn redrawn = redraw(in_frame(placer, frame));
    OutputFrame next = frame;
    if (!redrawn.first.empty() && round < most_rounds) next = frame_of_sites();
    if (next == frame) {
      repairs[Repair::coincident_points] += redrawn.coincident;
      return frame;
    }
    frame = next;
    for (const auto& [rank, site] : redrawn.first) sites.site[rank] = site;
  }
}

}  // namespace meander
