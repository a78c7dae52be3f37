#include "io/mesh/point_writer.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <bit>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "io/file/file_descriptor.h"
#include "io/mesh/append_numbers.h"
#include "kernels/data/columns.h"
#include "kernels/sample/point_frames.h"

namespace meander {

namespace {

constexpr std::string_view ply_begin = "ply\nformat binary_little_endian 1.0\ncomment ", off_begin = "OFF\n",
                           off_count_end = " 0 0\n", comment_begin = "# ";

// The coordinates that the file has, in words; those that do not depend on the item.
std::string frame_begin(PointFrame frame) {
  return "frame " + std::string(name_of(frame)) + (frame == PointFrame::file ? "" : " loc ");
}
std::string frame_text(const ItemReport& report, PointFrame frame) {
  std::string text = frame_begin(frame);
  if (frame == PointFrame::file) return text;
  for (const double value : report.loc) append_decimal(text, value, ' ');
  text += "scale ";
  append_decimal(text, report.scale, '\n');
  text.pop_back();
  return text;
}

template <class Number>
constexpr const char* ply_type = std::is_same_v<Number, float>          ? "float"
                                 : std::is_same_v<Number, std::uint8_t> ? "uchar"
                                                                        : "uint";

// The properties of the samples behind their coordinates, as far as they have such.
std::string ply_properties(const Samples& samples) {
  std::string text;
  for (const SampleColumn& column : sample_columns)
    with_array(column, samples, [&]<class Number>(const std::vector<Number>& values) {
      for (std::string_view names = column.ply; !values.empty() && !names.empty();) {
        const std::string_view name = names.substr(0, names.find(' '));
        text.append("property ").append(ply_type<Number>).append(" ").append(name) += '\n';
        names.remove_prefix(std::min(names.size(), name.size() + 1));
      }
    });
  return text;
}

std::string header(PointFormat format, const Samples& samples, const ItemReport& report, PointFrame frame) {
  const std::string n = std::to_string(samples.count());
  const std::string real = frame == PointFrame::file ? "property double " : "property float ";
  switch (format) {
    case PointFormat::off:
      return std::string(off_begin) + n + std::string(off_count_end);
    case PointFormat::ply:
      return std::string(ply_begin) + frame_text(report, frame) + "\nelement vertex " + n + "\n" + real +
             "x\n" + real + "y\n" + real + "z\n" + ply_properties(samples) + "end_header\n";
    case PointFormat::xyz:
      break;
  }
  return {};
}

// The values of a property, or of some, as they stand in memory and in files: one sample after the other.
struct PlyValues {
  static_assert(std::endian::native == std::endian::little);
  const char* first;
  std::size_t bytes_each;
};
std::vector<PlyValues> ply_values(const Samples& samples) {
  std::vector<PlyValues> all;
  for (const SampleColumn& column : sample_columns)
    with_array(column, samples, [&](const auto& values) {
      if (!column.ply.empty() && !values.empty())
        all.push_back(
            {reinterpret_cast<const char*>(values.data()), column.values_each() * sizeof values.front()});
    });
  return all;
}

template <class Real>
void append_row(std::string& data, PointFormat format, const std::array<Real, 3>& point,
                const Samples& samples, std::span<const PlyValues> behind, std::size_t i) {
  if (format == PointFormat::ply) {
    for (const Real value : point) append_little_endian(data, value);
    for (const PlyValues& values : behind)
      data.append(values.first + i * values.bytes_each, values.bytes_each);
    return;
  }
  const bool normals = format == PointFormat::xyz;
  for (std::size_t k = 0; k < 3; ++k) append_decimal(data, point[k], k < 2 || normals ? ' ' : '\n');
  for (std::size_t k = 0; normals && k < 3; ++k)
    append_decimal(data, samples.normals[3 * i + k], k < 2 ? ' ' : '\n');
}

void append_row(std::string& data, PointFormat format, const Samples& samples, const ItemReport& report,
                PointFrame frame, std::span<const PlyValues> behind, std::size_t i) {
  if (frame == PointFrame::file) {
    const Vector3 at = file_point(report, samples.points, i);
    append_row(data, format, std::array{at.x, at.y, at.z}, samples, behind, i);
  } else {
    const float* const at = &samples.points[3 * i];
    append_row(data, format, std::array{at[0], at[1], at[2]}, samples, behind, i);
  }
}

}  // namespace

void write_points(const std::function<void(std::string_view)>& put, PointFormat format,
                  const Samples& samples, const ItemReport& report, PointFrame frame) {
  constexpr std::size_t buffer_bytes = std::size_t{1} << 20;
  std::string data = header(format, samples, report, frame);
  const std::vector<PlyValues> behind = ply_values(samples);
  for (std::size_t i = 0; i < samples.count(); ++i) {
    append_row(data, format, samples, report, frame, behind, i);
    if (data.size() < buffer_bytes) continue;
    put(data);
    data.clear();
  }
  if (format != PointFormat::ply) data += std::string(comment_begin) + frame_text(report, frame) + "\n";
  put(data);
}

bool is_written_points(const std::filesystem::path& path) {
  const FileDescriptor file = try_open(path, O_RDONLY | O_NONBLOCK);
  if (!file) return false;
  constexpr std::size_t read_bytes = 128;
  std::array<char, read_bytes> bytes{};
  const auto text_at = [&](std::uint64_t offset) {
    return std::string_view(bytes.data(),
                            try_read(file, std::as_writable_bytes(std::span(bytes)), offset).bytes);
  };
  const auto begins_with_frame = [](std::string_view text) {
    return text.starts_with(frame_begin(PointFrame::file) + "\n") ||
           text.starts_with(frame_begin(PointFrame::stored));
  };
  std::string_view text = text_at(0);
  if (text.starts_with(ply_begin)) return begins_with_frame(text.substr(ply_begin.size()));
  if (!text.starts_with(off_begin)) return false;
  text.remove_prefix(off_begin.size());
  text.remove_prefix(std::min(text.find_first_not_of("0123456789"), text.size()));
  if (!text.starts_with(off_count_end)) return false;
  struct stat facts {};
  if (::fstat(file.get(), &facts) != 0) return false;
  const auto size = static_cast<std::uint64_t>(facts.st_size);
  text = text_at(size - std::min<std::uint64_t>(size, read_bytes));
  if (!text.ends_with('\n')) return false;
  text.remove_suffix(1);
  text.remove_prefix(text.find_last_of('\n') + 1);  // npos + 1 is 0: a line that is longer than what was read
  return text.starts_with(comment_begin) &&
         begins_with_frame(std::string(text.substr(comment_begin.size())) + "\n");
}

}  // namespace meander
