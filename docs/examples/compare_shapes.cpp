// Describes shapes by histograms of distances (Osada's D2) and prints which are alike.
#include <meander/descriptors.h>
#include <meander/sampler.h>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <vector>

// The histogram of a torus of radii 1 and `tube`, stretched along z.
std::vector<float> describe_torus(const meander::Sampler& sampler, double tube, double stretch) {
  constexpr std::uint32_t side = 48;
  std::vector<double> positions;
  std::vector<std::uint32_t> corners;
  for (std::uint32_t i = 0; i < side; ++i)
    for (std::uint32_t j = 0; j < side; ++j) {
      const double a = 2 * std::acos(-1.0) * i / side, b = 2 * std::acos(-1.0) * j / side;
      const double radius = 1 + tube * std::cos(b);
      positions.insert(positions.end(),
                       {radius * std::cos(a), radius * std::sin(a), stretch * tube * std::sin(b)});
      const std::uint32_t i1 = (i + 1) % side, j1 = (j + 1) % side;
      corners.insert(corners.end(), {i * side + j, i1 * side + j, i1 * side + j1, i * side + j1});
    }
  return sampler.sample({positions, corners, 4}).descriptors.at(0).values;
}

int main() {
  const meander::Sampler sampler({{"samples", 1024}, {"describe", "d2"}});
  const char* const names[] = {"thin", "thick", "thin and tall", "thick and tall"};
  const std::vector<std::vector<float>> rows = {
      describe_torus(sampler, 0.2, 1), describe_torus(sampler, 0.5, 1), describe_torus(sampler, 0.2, 3),
      describe_torus(sampler, 0.5, 3)};
  const std::vector<float> distances =
      meander::descriptor_distances(rows, meander::DistanceKind::emd);  // 4 x 4
  for (std::size_t i = 0; i < rows.size(); ++i) {
    std::printf("%-15s", names[i]);
    for (std::size_t j = 0; j < rows.size(); ++j) std::printf(" %6.3f", distances[i * rows.size() + j]);
    std::printf("\n");
  }
}
