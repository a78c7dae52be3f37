// Files with more elements than 32 bits can number: refused before memory is taken for them. Their bytes are
// pages that are never touched.
#include <cstring>

#include "io/reading.h"
#include "support/catch.h"
#include "support/sparse_memory.h"

using namespace meander;
using namespace meander::test;

TEST_CASE("count limit: the largest count that fits is accepted, the next one is refused") {
  CHECK_NOTHROW(check_count(0xFFFFFFFEu, "corners"));
  CHECK_THROWS_WITH(check_count(0xFFFFFFFFu, "corners"),
                    "4294967295 corners are more than 32 bits can number");
  CHECK_THROWS_AS(check_count(std::uint64_t{1} << 33, "corners"), ItemError);
}

TEST_CASE("STL: more corners than 32 bits can number are refused") {
  constexpr std::uint32_t facets = 1431655766;  // 3 x as many corners exceed 2^32
  const SparseMemory memory(84 + std::size_t{50} * facets);
  if (!memory) {
    WARN("skipped: no address space");
    return;
  }
  std::memcpy(memory.data() + 80, &facets, sizeof facets);
  CHECK(outcome(memory.text(), MeshFormat::stl) ==
        "unsupported_format: 4294967298 corners are more than 32 bits can number");
}

TEST_CASE("PLY: more vertices or corners than 32 bits can number are refused") {
  const std::string vertices =
      "ply\nformat binary_little_endian 1.0\nelement vertex 4294967295\nproperty uchar x\nproperty uchar "
      "y\nproperty uchar z\nelement face 1\nproperty list uchar uchar vertex_indices\nend_header\n";
  const SparseMemory many(vertices.size() + std::size_t{3} * 4294967295u + 4);
  if (!many) {
    WARN("skipped: no address space");
    return;
  }
  std::memcpy(many.data(), vertices.data(), vertices.size());
  CHECK(outcome(many.text(), MeshFormat::ply) ==
        "unsupported_format: 4294967295 vertices are more than 32 bits can number");

  // Faces of different sizes are read one after the other; the second one is too large.
  const std::string faces =
      "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty uchar x\nproperty uchar y\nproperty "
      "uchar z\nelement face 2\nproperty list uint uchar vertex_indices\nend_header\n";
  const std::uint32_t three = 3, large = 0xFFFFFFFEu;
  const SparseMemory wide(faces.size() + 9 + 4 + three + 4 + std::size_t{large});
  if (!wide) {
    WARN("skipped: no address space");
    return;
  }
  char* at = wide.data();
  std::memcpy(at, faces.data(), faces.size());
  at += faces.size() + 9;
  std::memcpy(at, &three, sizeof three);
  std::memcpy(at + sizeof three + three, &large, sizeof large);
  CHECK(outcome(wide.text(), MeshFormat::ply) ==
        "unsupported_format: 4294967297 corners are more than 32 bits can number");
}
