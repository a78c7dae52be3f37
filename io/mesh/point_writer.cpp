#include "io/mesh/point_writer.h"

#include <array>
#include <string>

#include "io/mesh/append_numbers.h"
#include "kernels/sample/point_frames.h"

namespace meander {

namespace {

std::string header(PointFormat format, const Samples& samples) {
  const std::string n = std::to_string(samples.count());
  switch (format) {
    case PointFormat::off:
      return "OFF\n" + n + " 0 0\n";
    case PointFormat::ply:
      return "ply\nformat binary_little_endian 1.0\nelement vertex " + n +
             "\nproperty double x\nproperty double y\nproperty double z\nproperty float nx\nproperty float "
             "ny\nproperty float nz\n" +
             (samples.uv.empty() ? "property uint face\n" : "property float u\nproperty float v\n") +
             "property float density\n" +
             (samples.rgb.empty() ? "" : "property uchar red\nproperty uchar green\nproperty uchar blue\n") +
             "end_header\n";
    case PointFormat::xyz:
      break;
  }
  return {};
}

void append_row(std::string& data, PointFormat format, const Samples& samples, const ItemReport& report,
                std::size_t i) {
  const Vector3 at = file_point(report, samples.points, i);
  const std::array<double, 3> point = {at.x, at.y, at.z};
  const float* const normal = samples.normals.data() + 3 * i;
  if (format == PointFormat::ply) {
    for (const double value : point) append_little_endian(data, value);
    for (std::size_t k = 0; k < 3; ++k) append_little_endian(data, normal[k]);
    if (samples.uv.empty()) {
      append_little_endian(data, samples.face[i]);
    } else {
      append_little_endian(data, samples.uv[2 * i]);
      append_little_endian(data, samples.uv[2 * i + 1]);
    }
    append_little_endian(data, samples.density[i]);
    for (std::size_t k = 3 * i; k < 3 * i + 3 && !samples.rgb.empty(); ++k)
      append_little_endian(data, samples.rgb[k]);
    return;
  }
  const bool normals = format == PointFormat::xyz;
  for (std::size_t k = 0; k < 3; ++k) append_decimal(data, point[k], k < 2 || normals ? ' ' : '\n');
  for (std::size_t k = 0; normals && k < 3; ++k) append_decimal(data, normal[k], k < 2 ? ' ' : '\n');
}

}  // namespace

void write_points(const std::function<void(std::string_view)>& put, PointFormat format,
                  const Samples& samples, const ItemReport& report) {
  constexpr std::size_t buffer_bytes = std::size_t{1} << 20;
  std::string data = header(format, samples);
  for (std::size_t i = 0; i < samples.count(); ++i) {
    append_row(data, format, samples, report, i);
    if (data.size() < buffer_bytes) continue;
    put(data);
    data.clear();
  }
  put(data);
}

}  // namespace meander
