// Points as an array of numpy, one a row.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <optional>
#include <string>

#include "io/mesh/byte_order.h"
#include "io/mesh/format_readers.h"
#include "io/mesh/text_cursor.h"
#include "io/table/npy_header.h"

namespace meander {

namespace {

struct RealType {
  std::size_t bytes;
  bool swap;  // the other byte order than this machine's
};

RealType real_type(const NpyHeader& header) {
  if (header.type.empty())
    throw ItemError(Status::unsupported_format,
                    "the array has fields; points are a plain array of float32 or float64");
  const bool is_real = header.type.size() == 3 && (header.type[0] == '<' || header.type[0] == '>') &&
                       header.type[1] == 'f' && (header.type[2] == '4' || header.type[2] == '8');
  if (!is_real)
    throw ItemError(Status::unsupported_format,
                    "the array has values of the type " + text::quoted(header.type, header.type.data()) +
                        "; points are float32 or float64: save array.astype('<f8')");
  const bool is_little = header.type[0] == '<';
  return {header.type[2] == '4' ? std::size_t{4} : std::size_t{8},
          is_little != (std::endian::native == std::endian::little)};
}

// Rows and columns, of which the values fill `bytes` exactly.
std::array<std::size_t, 2> extents(const NpyHeader& header, std::size_t value_bytes, std::size_t bytes) {
  if (header.shape.size() != 2)
    throw ItemError(
        Status::unsupported_format,
        fmt::format("the array has {} dimensions; points have two: a row for each", header.shape.size()));
  const std::uint64_t rows = header.shape[0], columns = header.shape[1];
  if (rows == 0) throw ItemError(Status::empty, "the array has no row");
  if (columns < 2 || columns == 4 || columns == 5)
    throw ItemError(
        Status::unsupported_format,
        fmt::format("the array has the shape ({}, {}), but a point has 2, 3 or 6 and more numbers", rows,
                    columns));
  if (columns > 6 && rows < columns)
    throw ItemError(
        Status::unsupported_format,
        fmt::format("the array has the shape ({}, {}): a point is a row; is it transposed?", rows, columns));
  const std::uint64_t held = bytes / value_bytes;
  if (columns > held || rows > held / columns)
    throw ItemError(Status::unreadable,
                    fmt::format("the header promises {} x {} values of {} bytes, but only {} bytes follow it",
                                rows, columns, value_bytes, bytes));
  if (rows * columns * value_bytes != bytes)
    throw ItemError(Status::unreadable, fmt::format("{} bytes follow the values that the header promises",
                                                    bytes - rows * columns * value_bytes));
  check_count(rows, "points");
  return {static_cast<std::size_t>(rows), static_cast<std::size_t>(columns)};
}

double real_at(const char* data, std::size_t number, RealType type) {
  const char* const at = data + number * type.bytes;
  return type.bytes == 4 ? double{load<float>(at, type.swap)} : load<double>(at, type.swap);
}

}  // namespace

PointCloud read_npy_points(std::string_view content, const CancelToken& cancel, const BlockRule&) {
  const NpyHeader header = read_npy_header(content);
  const RealType type = real_type(header);
  const auto [rows, columns] = extents(header, type.bytes, content.size() - header.bytes);
  const char* const data = content.data() + header.bytes;
  const std::size_t next_row = header.fortran_order ? 1 : columns,
                    next_column = header.fortran_order ? rows : 1;
  PointCloud cloud;
  for (std::vector<double>* const axis : {&cloud.x, &cloud.y, &cloud.z}) axis->reserve(rows);
  TrailingNormals normals;
  for (std::size_t row = 0; row < rows; ++row) {
    if (row % rows_between_checks == 0) cancel.check();
    std::array<double, 6> values{};
    const std::size_t used = std::min(columns, values.size());
    for (std::size_t k = 0; k < used; ++k) values[k] = real_at(data, row * next_row + k * next_column, type);
    if (!std::isfinite(values[0]) || !std::isfinite(values[1]) || !std::isfinite(values[2]))
      throw ItemError(Status::non_finite, fmt::format("point {} of {} is not finite", row, rows));
    cloud.x.push_back(values[0]);
    cloud.y.push_back(values[1]);
    cloud.z.push_back(values[2]);
    if (used == values.size()) normals.add(values[3], values[4], values[5], cloud.normals);
  }
  normals.finish(cloud.normals);
  return cloud;
}

}  // namespace meander
