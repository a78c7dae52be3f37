// Points as an array of numpy, one a row, and as arrays of numpy in a zip archive.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "io/archive/zip_directory.h"
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

namespace {

constexpr std::string_view array_ending = ".npy";

// Returns what `read` returns; an ItemError that it throws then names the array.
template <class Read>
auto about_array(std::string_view name, const Read& read) {
  try {
    return read();
  } catch (const ItemError& error) {
    throw ItemError(error.status(), "the array `" + std::string(name) + "`: " + error.what());
  }
}

// The arrays of an .npz file.
class NumpyArchive {
 public:
  explicit NumpyArchive(std::string_view content) : source_(content) {
    if (!content.starts_with("PK"))
      throw ItemError(Status::unreadable,
                      "the file does not begin as .npz files, which are zip archives, do");
    ArchiveListing listing = read_zip_directory(source_);
    if (!listing.problem.empty()) throw ItemError(Status::unreadable, listing.problem);
    for (ArchiveMember& member : listing.members)
      if (member.name.ends_with(array_ending)) members_.push_back(std::move(member));
    refuse_duplicates(members_);
  }

  // The bytes of the array as an .npy file; empty where there is none of this name.
  std::string file(std::string_view name) const {
    for (const ArchiveMember& member : members_)
      if (name_of(member) == name) return unpack(member);
    return {};
  }

  std::string file_of_points() const {
    std::string file = this->file("points");
    if (!file.empty()) return file;
    if (members_.size() == 1) return unpack(members_.front());
    if (members_.empty()) throw ItemError(Status::unsupported_format, "the archive holds no array");
    constexpr std::size_t max_named = 10;
    std::string names;
    for (std::size_t i = 0; i < std::min(members_.size(), max_named); ++i)
      names += (i == 0 ? "`" : ", `") + std::string(name_of(members_[i])) + "`";
    if (members_.size() > max_named) names += " ...";
    throw ItemError(Status::unsupported_format,
                    "the archive holds several arrays and none is called `points`: " + names);
  }

  // The values of an array of real numbers; empty where there is none of this name. Throws ItemError where it
  // has another shape.
  std::vector<double> reals(std::string_view name, std::span<const std::uint64_t> shape) const {
    const std::string file = this->file(name);
    if (file.empty()) return {};
    return about_array(name, [&] {
      const NpyHeader header = read_npy_header(file);
      const RealType type = real_type(header);
      if (!std::equal(header.shape.begin(), header.shape.end(), shape.begin(), shape.end()))
        throw ItemError(Status::unsupported_format, "its shape is not that of the points");
      std::uint64_t count = 1, columns = 1;
      for (const std::uint64_t extent : shape) count *= extent;
      if (shape.size() == 2) columns = shape[1];
      if (count * type.bytes != file.size() - header.bytes)
        throw ItemError(Status::unreadable, "its values are not as many as its header promises");
      std::vector<double> values;
      values.reserve(count);
      for (std::uint64_t i = 0; i < count; ++i) {
        const std::uint64_t at = header.fortran_order ? i % columns * (count / columns) + i / columns : i;
        values.push_back(real_at(file.data() + header.bytes, at, type));
      }
      return values;
    });
  }

 private:
  static std::string_view name_of(const ArchiveMember& member) {
    return std::string_view(member.name).substr(0, member.name.size() - array_ending.size());
  }
  std::string unpack(const ArchiveMember& member) const {
    return about_array(name_of(member), [&] { return unpack_zip_member(source_, member); });
  }

  MemorySource source_;
  std::vector<ArchiveMember> members_;
};

// Whether the array holds this text, as UTF-32 of either byte order.
bool holds_text(const std::string& file, std::string_view expected) {
  if (file.empty()) return false;
  std::string text;
  for (const char c : std::string_view(file).substr(read_npy_header(file).bytes))
    if (c != '\0') text += c;
  return text == expected;
}

}  // namespace

PointCloud read_npz_points(std::string_view content, const CancelToken& cancel, const BlockRule& rule) {
  const NumpyArchive archive(content);
  PointCloud cloud = read_npy_points(archive.file_of_points(), cancel, rule);
  const std::uint64_t n = cloud.count();
  if (cloud.normals.empty()) {
    const std::vector<double> normals = archive.reals("normals", std::array<std::uint64_t, 2>{n, 3});
    cloud.normals.assign(normals.begin(), normals.end());
  }
  cloud.density = archive.reals("density", std::array<std::uint64_t, 1>{n});
  if (!holds_text(archive.file("frame"), "stored")) return cloud;
  const std::vector<double> loc = archive.reals("loc", std::array<std::uint64_t, 1>{3}),
                            scale = archive.reals("scale", {});
  if (loc.empty() || scale.empty())
    throw ItemError(Status::unreadable, "the points are in the frame `stored`, without `loc` and `scale`");
  std::size_t axis = 0;
  for (std::vector<double>* const values : {&cloud.x, &cloud.y, &cloud.z}) {
    for (double& value : *values) {
      value = loc[axis] + scale[0] * value;
      if (!std::isfinite(value))
        throw ItemError(Status::non_finite, "a point is not finite once `loc` and `scale` are applied");
    }
    ++axis;
  }
  return cloud;
}

}  // namespace meander
