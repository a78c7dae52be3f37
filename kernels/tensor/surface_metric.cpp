#include "kernels/tensor/surface_metric.h"

#include <algorithm>

namespace meander {

namespace {

constexpr double margin = 1e-3;  // of the longest side
constexpr int max_rounds = 100;

}  // namespace

std::vector<double> surface_metric(const PreparedMesh& mesh, const TensorField& field,
                                   const CancelToken& cancel) {
  std::vector<double> length = metric_edge_lengths(mesh, field);
  // Triangles whose lengths have changed since their last test; the others need no further test.
  std::vector<std::uint8_t> changed(mesh.triangle_count(), 1);
  const auto change = [&](std::uint32_t h, double by) {
    length[h] += by;
    changed[h / 3] = 1;
    if (mesh.opposite[h] == no_index) return;
    length[mesh.opposite[h]] = length[h];
    changed[mesh.opposite[h] / 3] = 1;
  };
  bool broken = true;
  for (int round = 0; broken && round < max_rounds; ++round) {
    broken = false;
    cancel.check();
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
      if (!changed[t]) continue;
      changed[t] = 0;
      const std::uint32_t h = 3 * t;
      std::uint32_t longest = h;
      for (std::uint32_t k = h + 1; k < h + 3; ++k)
        if (length[k] > length[longest]) longest = k;
      const std::uint32_t b = next_half_edge(longest), c = previous_half_edge(longest);
      const double missing = length[longest] - length[b] - length[c];
      if (!(missing + margin * length[longest] > 0) || !(mesh.area[t] > 0)) continue;
      // A triangle that is a needle in space cannot get more slack than it has there.
      const double in_space =
          mesh.length_in_space(b) + mesh.length_in_space(c) - mesh.length_in_space(longest);
      const double slack = std::min(margin, 0.5 * in_space / mesh.length_in_space(longest)) * length[longest];
      const double excess = missing + slack;
      if (!(excess > 0) || !(slack > 0)) continue;
      broken = true;
      // The correction is slightly larger than needed, so that rounding does not cause another round.
      change(longest, -0.50001 * excess);
      change(b, 0.250005 * excess);
      change(c, 0.250005 * excess);
    }
  }
  return length;
}

}  // namespace meander
