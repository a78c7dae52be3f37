// Internal to io/mesh: the header of an OFF file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace meander {

// [ST] [C] [N] [4] [n] OFF [BINARY], the number of dimensions behind an n, then the counts. Sizes are as the
// header states them, unchecked but not negative.
struct OffHeader {
  bool texture = false, colors = false, normals = false, homogeneous = false, binary = false;
  int dimensions = 3;  // 2: z is 0
  std::uint64_t vertices = 0, faces = 0;
  std::size_t body = 0;  // where the first vertex (binary: where the counts) may begin
};

// Comments and blank lines may stand anywhere; the counts may be glued to the keyword, on lines of their own,
// without the number of edges, or there without any keyword. The counts of a binary file are not read. Throws
// ItemError: unreadable; unsupported_format for nOFF of other than two or three dimensions; empty for a text
// of comments and blanks.
OffHeader parse_off_header(std::string_view text);

// How the numbers of one vertex of a text OFF file lie.
struct OffVertexLayout {
  int positions = 3;          // of the dimensions, and one more with a homogeneous coordinate
  int before_normal = 0;      // numbers between the position and the normal
  bool normals = false;       // three numbers of a normal follow
  bool rest_of_line = false;  // whatever else stands on the line (colors, texture) is skipped
};
// Decided on the first vertex line: colors come with one to four numbers, before or after the normal, and in
// the wild without being announced.
OffVertexLayout off_vertex_layout(std::string_view text, const OffHeader& header);

}  // namespace meander
