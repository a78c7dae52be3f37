// Writing samples as files that other programs read.
#pragma once

#include <filesystem>
#include <functional>
#include <string_view>

#include "io/file_kind.h"
#include "kernels/data/samples.h"

namespace meander {

enum class PointFormat : std::uint8_t { ply, off, xyz };
inline constexpr PointFormat point_formats[] = {PointFormat::ply, PointFormat::off, PointFormat::xyz};
constexpr FileKind kind_of(PointFormat format) {
  switch (format) {
    case PointFormat::ply:
      return FileKind::ply_points;
    case PointFormat::off:
      return FileKind::off_points;
    case PointFormat::xyz:
      break;
  }
  return FileKind::xyz;
}

// PLY: binary little-endian with x y z nx ny nz, face (u v for parametric surfaces), density and, where
// there are colors, red green blue; OFF:
// vertices only (COFF-free, zero faces); XYZ: one `x y z nx ny nz` a line, shortest round-trip decimals. Of
// the frame `file` loc and scale are applied, and coordinates are double; of `stored` they are the float32 of
// the samples. The file says which: `frame file`, or `frame stored loc X Y Z scale S`, as a comment in the
// header of PLY and in the last line of the others (`# frame file`), where readers have taken all rows that
// they count on. The bytes come in pieces of about 1 MB.
void write_points(const std::function<void(std::string_view)>& put, PointFormat format,
                  const Samples& samples, const ItemReport& report, PointFrame frame = PointFrame::file);

// Whether write_points made this PLY or OFF file, by its first bytes and, of OFF without faces, its last
// line. False for other files, and where it cannot be read. Cost: a read of 128 bytes or two.
bool is_written_points(const std::filesystem::path& path);

}  // namespace meander
