// Internal to io/mesh: what the estimates of mesh sizes (peek_mesh) look at.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "io/mesh/mesh_reader.h"

namespace meander {

// A section of a file may begin anywhere in a stratum, and objects may come in turns: sampled counts are
// raised so that they are rarely too small.
inline constexpr double sampling_margin = 1.2;

// The beginning of a file, and what may be read of the rest.
struct MeshPeek {
  const ByteSource& file;
  MeshFormat format;
  std::string head;  // without the byte-order mark of a text
  bool whole;        // the head is the file

  MeshPeek(const ByteSource& opened, MeshFormat format_by_name);
};

// Elements of text.
struct ElementCounts {
  double vertices = 0, faces = 0, triangles = 0;

  void add(const ElementCounts& other, double factor) {
    vertices += factor * other.vertices;
    faces += factor * other.faces;
    triangles += factor * other.triangles;
  }
};

// Runs count_lines on whole lines: on a whole file that the head holds, else on the head and one spot in each
// of 48 equal strata, raised to the whole file. Nothing when no line was seen.
std::optional<ElementCounts> sampled(const MeshPeek& peek,
                                     const std::function<ElementCounts(std::string_view)>& count_lines);

// Vertex and face counts of a header, against faces seen in the text: `before` numbers, then n >= 3 and n
// vertex numbers.
MeshEstimate estimate_from_counts(const MeshPeek& peek, std::uint64_t vertices, std::uint64_t faces,
                                  std::size_t before, bool hash_comments);
// Runs the reader on a small file whose layout is unexpected.
MeshEstimate estimate_from_reader(const MeshPeek& peek);
// An upper bound for all but terse files.
MeshEstimate estimate_from_size(std::uint64_t bytes);
// A polygon has fewer triangles than corners, and a corner or a coordinate takes a digit and a separator.
MeshEstimate most_in_text(std::uint64_t bytes);

inline std::uint64_t rounded_up(double count) {
  return count <= 0 ? 0 : static_cast<std::uint64_t>(std::ceil(count));
}

}  // namespace meander
