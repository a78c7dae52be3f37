// Samples a mesh of polygons and writes the points with their normals and densities as PLY.
//
//   sample_mesh > points.ply
#include <meander/sampler.h>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <vector>

int main() {
  // A hill: 40 x 40 quadrilaterals over the square [-2, 2]^2.
  constexpr std::uint32_t side = 41;
  std::vector<double> positions;
  std::vector<std::uint32_t> corners;
  for (std::uint32_t i = 0; i < side; ++i)
    for (std::uint32_t j = 0; j < side; ++j) {
      const double x = 0.1 * i - 2, y = 0.1 * j - 2;
      positions.insert(positions.end(), {x, y, std::exp(-x * x - y * y)});
      const std::uint32_t v = i * side + j;
      if (i > 0 && j > 0) corners.insert(corners.end(), {v - side - 1, v - 1, v, v - side});
    }

  // Blue noise that is denser where the surface is bent more.
  const meander::Sampler sampler({{"samples", 2000}, {"sequence", "spaced"}, {"density", "mean"}});
  const meander::SampledModel model = sampler.sample({positions, corners, 4});
  if (model.report.status != meander::Status::ok) {
    std::fprintf(stderr, "%s\n", model.report.reason.c_str());
    return 1;
  }

  const meander::Samples& samples = model.samples;
  std::printf("ply\nformat ascii 1.0\nelement vertex %zu\n", samples.count());
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz", "density"})
    std::printf("property float %s\n", name);
  std::printf("end_header\n");
  for (std::size_t i = 0; i < samples.count(); ++i) {
    const float *p = &samples.points[3 * i], *n = &samples.normals[3 * i];
    std::printf("%g %g %g %g %g %g %g\n", p[0], p[1], p[2], n[0], n[1], n[2], samples.density[i]);
  }
}
