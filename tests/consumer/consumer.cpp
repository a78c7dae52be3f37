// Samples a tetrahedron given as arrays, with nothing but the installed headers and libraries.
#include <meander/row.h>
#include <meander/sample_parameters.h>
#include <meander/sampler.h>

#include <cmath>
#include <cstdio>
#include <vector>

int main() {
  const std::vector<double> positions = {1, 1, 1, 1, -1, -1, -1, 1, -1, -1, -1, 1};
  const std::vector<std::uint32_t> faces = {0, 1, 2, 0, 3, 1, 0, 2, 3, 1, 3, 2};
  meander::SampleParameters parameters;
  parameters.samples = 1000;
  const meander::Row row = meander::Sampler(parameters).sample(positions, faces);
  const double area = 4 * std::sqrt(3.0) / 4 * 8;
  std::printf("%s by the method %s, %zu points, area %.6f\n",
              std::string(meander::name_of(row.report.status)).c_str(),
              std::string(meander::name_of(row.report.method)).c_str(), row.samples.count(), row.report.area);
  return row.report.status == meander::Status::ok && row.samples.count() == 1000 &&
                 std::abs(row.report.area - area) < 1e-9
             ? 0
             : 1;
}
