// Samples a tetrahedron given as arrays, with nothing but the installed headers and libraries.
#include <meander/sampler.h>

#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <vector>

int main() {
  const std::vector<double> positions = {1, 1, 1, 1, -1, -1, -1, 1, -1, -1, -1, 1};
  const std::vector<std::uint32_t> faces = {0, 1, 2, 0, 3, 1, 0, 2, 3, 1, 3, 2};
  const meander::SampledModel model = meander::Sampler({{"samples", 1000}}).sample({positions, faces});
  const double area = 4 * std::sqrt(3.0) / 4 * 8;
  std::printf("%s by the method %s, %zu points, area %.6f\n",
              std::string(meander::name_of(model.report.status)).c_str(),
              std::string(meander::name_of(model.report.method)).c_str(), model.samples.count(),
              model.report.area);
  // An exception of the library is caught by its type.
  try {
    meander::Sampler({{"sampels", 1000}});
    return 2;
  } catch (const std::invalid_argument& error) {
    std::printf("%s\n", error.what());
  }
  return model.report.status == meander::Status::ok && model.samples.count() == 1000 &&
                 std::abs(model.report.area - area) < 1e-9
             ? 0
             : 1;
}
