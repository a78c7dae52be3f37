#include "io/mesh/point_writer.h"

#include <array>
#include <string>

#include "io/mesh/append_numbers.h"
#include "kernels/sample/point_frames.h"

namespace meander {

namespace {

// The coordinates that the file has, in words.
std::string frame_text(const ItemReport& report, PointFrame frame) {
  std::string text = "frame " + std::string(name_of(frame));
  if (frame == PointFrame::file) return text;
  text += " loc ";
  for (const double value : report.loc) append_decimal(text, value, ' ');
  text += "scale ";
  append_decimal(text, report.scale, '\n');
  text.pop_back();
  return text;
}

std::string header(PointFormat format, const Samples& samples, const ItemReport& report, PointFrame frame) {
  const std::string n = std::to_string(samples.count());
  const std::string real = frame == PointFrame::file ? "property double " : "property float ";
  switch (format) {
    case PointFormat::off:
      return "OFF\n" + n + " 0 0\n";
    case PointFormat::ply:
      return "ply\nformat binary_little_endian 1.0\ncomment " + frame_text(report, frame) +
             "\nelement vertex " + n + "\n" + real + "x\n" + real + "y\n" + real + "z\n" +
             (samples.normals.empty() ? "" : "property float nx\nproperty float ny\nproperty float nz\n") +
             (samples.face.empty() ? "" : "property uint face\n") +
             (samples.uv.empty() ? "" : "property float u\nproperty float v\n") +
             (samples.density.empty() ? "" : "property float density\n") +
             (samples.rgb.empty() ? "" : "property uchar red\nproperty uchar green\nproperty uchar blue\n") +
             "end_header\n";
    case PointFormat::xyz:
      break;
  }
  return {};
}

template <class Real>
void append_row(std::string& data, PointFormat format, const std::array<Real, 3>& point,
                const Samples& samples, std::size_t i) {
  if (format == PointFormat::ply) {
    const auto append = [&](const auto& values, std::size_t width) {
      for (std::size_t k = width * i; k < width * (i + 1) && !values.empty(); ++k)
        append_little_endian(data, values[k]);
    };
    for (const Real value : point) append_little_endian(data, value);
    append(samples.normals, 3);
    append(samples.face, 1);
    append(samples.uv, 2);
    append(samples.density, 1);
    append(samples.rgb, 3);
    return;
  }
  const bool normals = format == PointFormat::xyz;
  for (std::size_t k = 0; k < 3; ++k) append_decimal(data, point[k], k < 2 || normals ? ' ' : '\n');
  for (std::size_t k = 0; normals && k < 3; ++k)
    append_decimal(data, samples.normals[3 * i + k], k < 2 ? ' ' : '\n');
}

void append_row(std::string& data, PointFormat format, const Samples& samples, const ItemReport& report,
                PointFrame frame, std::size_t i) {
  if (frame == PointFrame::file) {
    const Vector3 at = file_point(report, samples.points, i);
    append_row(data, format, std::array{at.x, at.y, at.z}, samples, i);
  } else {
    const float* const at = &samples.points[3 * i];
    append_row(data, format, std::array{at[0], at[1], at[2]}, samples, i);
  }
}

}  // namespace

void write_points(const std::function<void(std::string_view)>& put, PointFormat format,
                  const Samples& samples, const ItemReport& report, PointFrame frame) {
  constexpr std::size_t buffer_bytes = std::size_t{1} << 20;
  std::string data = header(format, samples, report, frame);
  for (std::size_t i = 0; i < samples.count(); ++i) {
    append_row(data, format, samples, report, frame, i);
    if (data.size() < buffer_bytes) continue;
    put(data);
    data.clear();
  }
  if (format != PointFormat::ply) data += "# " + frame_text(report, frame) + "\n";
  put(data);
}

}  // namespace meander
