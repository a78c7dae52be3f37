// Sample elimination by its author's own code, for poisson_disk_peers.py --yuksel:
//   yuksel_elimination CANDIDATES KEPT COUNT AREA
// CANDIDATES: n x 3 float32; writes COUNT x 3 of them to KEPT and prints the seconds of the elimination. AREA is that of
// the surface, in squared units of the points. Compiled with the folder of cyCodeBase (MIT license) as include path.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "cySampleElim.h"
#include "cyVector.h"

int main(int argc, char** argv) {
  if (argc != 5) return 2;
  std::vector<cy::Vec3f> candidates, kept(std::strtoul(argv[3], nullptr, 10));
  std::FILE* file = std::fopen(argv[1], "rb");
  if (file == nullptr) return 1;
  for (cy::Vec3f p; std::fread(&p, sizeof p, 1, file) == 1;) candidates.push_back(p);
  std::fclose(file);
  const auto start = std::chrono::steady_clock::now();
  cy::WeightedSampleElimination<cy::Vec3f, float, 3> elimination;
  const float radius =
      2 * elimination.GetMaxPoissonDiskRadius(2, kept.size(), static_cast<float>(std::atof(argv[4])));
  elimination.Eliminate(candidates.data(), candidates.size(), kept.data(), kept.size(), false, radius, 2);
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  file = std::fopen(argv[2], "wb");
  if (file == nullptr || std::fwrite(kept.data(), sizeof(cy::Vec3f), kept.size(), file) != kept.size()) return 1;
  std::fclose(file);
  std::printf("%.6f\n", seconds.count());
}
