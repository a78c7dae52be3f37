// Internal to io/mesh: what readers share.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/mesh/mesh_peek.h"
#include "io/mesh/mesh_reader.h"
#include "io/mesh/peek_attributes.h"
#include "io/mesh/point_reader.h"
#include "io/mesh/polygon_parts.h"
#include "io/utf8.h"

namespace meander {

// How often loops over rows look whether they are to stop.
inline constexpr std::size_t rows_between_checks = 65536;

// read_mesh with block sizes of the caller's choice.
PolygonMesh read_mesh_in_blocks(std::span<const std::byte> bytes, MeshFormat format,
                                const CancelToken& cancel, const BlockRule& rule,
                                const MeshSurroundings& around = {});

// A component of a color that is not there.
inline constexpr float no_color = std::numeric_limits<float>::quiet_NaN();
// The kind of the numbers of colors: whole by their declared type or as they are written, or real.
enum class ColorNumbers : std::uint8_t { whole, real };
// Brings the colors of all vertices, or of all faces, of a file to [0, 1] (docs/FORMATS.md has the table).
// Whole numbers are of 255, or where one is larger of 65,535. Real ones are in [0, 1], or of 255 where more
// than half of those that are not 0 are above 1: one that rounding or a highlight carries above 1 says
// nothing. Values without a color are NaN, before and after. O(values).
void scale_colors(std::vector<float>& values, ColorNumbers numbers);
// The path from the model's folder (CompanionFile::path), backslashes taken as slashes; empty with the reason
// set where it is absolute or none.
std::string path_from_model(std::string_view path, std::string& reason);

// The same for point sets; each throws ItemError as read_points does. Of OFF the vertices and normals are
// read, the faces are not: the mesh has none.
PointCloud read_ply_points(std::string_view text, const CancelToken& cancel, const BlockRule& rule);
PolygonMesh read_off_vertices(std::string_view text, const CancelToken& cancel, const BlockRule& rule);
PointCloud read_text_points(std::string_view text, const CancelToken& cancel, const BlockRule& rule);
PointCloud read_npy_points(std::string_view content, const CancelToken& cancel, const BlockRule& rule);
PointCloud read_npz_points(std::string_view content, const CancelToken& cancel, const BlockRule& rule);

// The numbers behind x y z in the rows of files that may not say what they are.
struct TrailingNormals {
  enum class Kind : std::uint8_t { unnamed, named, none };
  Kind kind = Kind::unnamed;
  bool any_unit = false;

  // Three numbers of the next point, unless `kind` is none. Unnamed ones that cannot be a normal end all
  // normals.
  void add(double x, double y, double z, std::vector<float>& normals);
  // Behind the last point: unnamed ones of which none has length 1 are no normals.
  void finish(std::vector<float>& normals) const {
    if (kind == Kind::unnamed && !any_unit) normals.clear();
  }
};

// read_points of the bytes of a file of this name, with block sizes of the caller's choice.
PointCloud read_points_in_blocks(std::string_view content, const std::filesystem::path& name,
                                 const CancelToken& cancel, const BlockRule& rule);

// "vertex 3 of 10 is not finite".
std::string not_finite(std::uint64_t vertex, std::uint64_t count);

// The text of a file: without a byte-order mark, and in UTF-8 with LF or CRLF at the end of every line, also
// where the file is UTF-16, or has line ends of old Macintosh programs, in some of its lines or all. A file
// that is not UTF-16 is left alone where `keeps_line_ends` says so.
class DecodedText {
 public:
  explicit DecodedText(std::string_view content, bool (*keeps_line_ends)(std::string_view) = nullptr);
  explicit DecodedText(std::span<const std::byte> bytes) : DecodedText(text_of(bytes)) {}
  std::string_view text() const { return converted_ ? std::string_view(*converted_) : text_; }

 private:
  std::string_view text_;
  std::optional<std::string> converted_;
};

// Throws ItemError(empty) for nothing but blanks, unreadable for foreign content; `called` is what the file
// is by its name, with its article.
void check_text(std::string_view text, std::string_view called, std::optional<MeshFormat> format);
// What the content clearly is when it is not `format` ("a PLY file", "a gzip archive", ...), or of any format
// when there is none; empty when in doubt. Looks at the first 64 KiB.
std::string foreign_content(std::string_view text, std::optional<MeshFormat> format);

}  // namespace meander
