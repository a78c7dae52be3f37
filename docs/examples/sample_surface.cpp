// Samples a Moebius strip, given as a function, with blue noise, and writes x y z of every sample.
//
//   sample_surface > strip.xyz
#include <meander/surface.h>

#include <cmath>
#include <cstdio>
#include <span>

void moebius_strip(std::span<const double> u, std::span<const double> v, std::span<double> positions) {
  for (std::size_t i = 0; i < u.size(); ++i) {
    const double angle = 2 * std::acos(-1.0) * u[i], across = v[i] - 0.5;
    const double radius = 1 + across * std::cos(angle / 2);
    positions[3 * i] = radius * std::cos(angle);
    positions[3 * i + 1] = radius * std::sin(angle);
    positions[3 * i + 2] = across * std::sin(angle / 2);
  }
}

int main() {
  const meander::SampledModel strip =
      meander::sample_surface(moebius_strip, {{"samples", 1500}, {"sequence", "spaced"}});
  if (strip.report.status != meander::Status::ok) {
    std::fprintf(stderr, "%s\n", strip.report.reason.c_str());
    return 1;
  }
  std::fprintf(stderr, "area %.4f\n", strip.report.area);
  for (std::size_t i = 0; i < strip.samples.count(); ++i) {
    const float* p = &strip.samples.points[3 * i];
    std::printf("%g %g %g\n", p[0], p[1], p[2]);
  }
}
