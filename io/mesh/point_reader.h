// Reading point sets that other programs wrote.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "kernels/core/cancel.h"

namespace meander {

// N points in the order of the file, in its coordinates, all finite. Two-dimensional files have z = 0.
struct PointCloud {
  std::vector<double> x, y, z;  // N each
  std::vector<float> normals;   // 3 N, or empty. As the file has them: zero, not unit and NaN are possible

  std::vector<double> density;  // N, or empty: the property `density` of a PLY file

  std::size_t count() const { return x.size(); }
};

// Reads all points of a file; the extension (any case) decides the format:
// * .ply: ascii and both binary orders; x y z, nx ny nz when there are all three, and density of the element
// vertex.
//   Anything else is skipped, faces need not be there.
// * .off: text and binary with every prefix. Faces need not be there and are not read, but nothing may follow
//   the last vertex on its line.
// * .xyz .txt .csv .pts: one point a line. 2 numbers are x y; 3 are x y z; 6 and more are x y z, three of a
//   normal, and anything. 4 and 5 are refused. Every line is of the kind of the first.
// * .npy: an array of numpy of shape (n, 2), (n, 3) or (n, 6 and more), columns as above; float32 or float64
// in
//   either byte order, C or Fortran order, versions 1 to 3 of the format. An array of more columns than rows
//   is refused from 7 columns on: it is transposed.
// * .npz: a zip archive of such arrays, packed or not. `points` is read as .npy, or the only array; `normals`
//   of shape (n, 3) and `density` of shape (n,) beside it. Where `frame` is `stored`, as `meander export`
//   writes it, the coordinates are loc + scale * points.
// Text of points, more exactly:
// * Numbers are separated by blanks and tabs, or by single commas with or without blanks around them. Commas
//   and blanks that both separate numbers of one line are refused: the comma may be a decimal mark.
// * # begins a comment up to the end of its line; blank lines are skipped.
// * The first line with anything on it may be a header: words of which none begins like a number. If one
//   of them is `x`, they must begin x y or x y z: other orders of columns are refused.
// * That line may, instead, be one number: the count of the points, which must be right.
// * The numbers 4 to 6 are normals when the header calls them nx ny nz. Without a header they are
//   normals when every three have length 1 within 1 %, are zero or are not finite, and some have length 1;
//   otherwise they are skipped: they may be colors.
//
// Stricter than read_mesh, because a point set with a point less is another one: a file that ends too early,
// data behind the last promised point (where no faces are promised), a coordinate that is not a number and,
// in ascii PLY, a row that is not on one line make it unreadable. Byte-order marks, UTF-16 with a mark, CRLF
// and CR line ends are read. No count is trusted: all are checked against the bytes that are there before
// memory is taken.
//
// Throws ItemError with a sentence (with the line in text, the byte or the point in binary files):
// unreadable; empty for no point; non_finite for a coordinate that is NaN or infinite; unsupported_format for
// another extension, columns or types of values that are not understood, and 2^32 - 1 points and more.
// RunCanceled and bad_alloc pass. Cost: linear in the file; large ascii PLY and OFF files and binary PLY
// files are read in parallel blocks.
PointCloud read_points(const std::filesystem::path& path, const CancelToken& cancel = {});

// The extensions of point files, for messages: ".ply .off .xyz ...".
std::string point_extensions();

}  // namespace meander
