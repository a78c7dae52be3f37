#include <algorithm>
#include <cmath>
#include <vector>

#include "kernels/sample/place_samples.h"
#include "support/catch.h"
#include "support/sanitized.h"

using namespace meander;
using namespace meander::test;

namespace {

// How far the number of ranks of a prefix in any stretch of the curve is from the stretch's share: the
// largest |members - length x prefix / n| over all stretches of up to `longest` ranks.
double worst_stretch(const std::vector<std::uint32_t>& order, std::size_t prefix, std::size_t longest) {
  const std::size_t n = order.size();
  std::vector<int> before(n + 1, 0);
  for (std::size_t i = 0; i < prefix; ++i) before[order[i] + 1] = 1;
  for (std::size_t r = 0; r < n; ++r) before[r + 1] += before[r];
  const double share = static_cast<double>(prefix) / static_cast<double>(n);
  double worst = 0;
  for (std::size_t begin = 0; begin < n; ++begin)
    for (std::size_t end = begin + 1; end <= std::min(n, begin + longest); ++end)
      worst =
          std::max(worst, std::abs(before[end] - before[begin] - share * static_cast<double>(end - begin)));
  return worst;
}

}  // namespace

TEST_CASE("progressive_order: prefixes are even along the curve at every length, for any count",
          "[statistics]") {
  for (const std::uint32_t n : {1000u, 2048u, 3000u, 5000u, 33000u, 60000u, 100000u})
    for (const double share : {0.2, 0.4, 0.5, 0.55, 0.6, 0.68, 0.75, 0.8, 0.9, 0.97}) {
      const auto prefix = static_cast<std::size_t>(share * n);
      double worst = 0;
      for (std::uint64_t seed = 0; seed < (sanitized ? 1 : 3); ++seed)  // release builds try all
        worst = std::max(worst, worst_stretch(progressive_order(n, make_random_key(seed, {})), prefix, 64));
      INFO("the first " << prefix << " of " << n);
      // Bit reversal deviates by up to log2(64) / 3 + 1 on stretches of this length, and a level that is only
      // begun adds to it; members in clusters deviate by 4 to 6.
      CHECK(worst < 3.5);
    }
}
