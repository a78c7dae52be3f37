// Internal to io/mesh: triangles of a Draco stream (KHR_draco_mesh_compression).
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "io/mesh/gltf_document.h"

namespace meander {

struct DracoAttribute {
  std::uint32_t id = 0;     // in the stream
  std::uint32_t width = 3;  // numbers per vertex
  bool optional = false;    // where the stream lacks it, or has it otherwise, there are no values
  // The type of the accessor that the values stand for: integers of the stream become fractions where it is
  // normalized.
  GltfComponent component = GltfComponent::float32;
  bool normalized = false;
};

struct DracoMesh {
  std::vector<std::uint32_t> corners;       // three vertex numbers per triangle
  std::vector<std::vector<double>> values;  // of each attribute asked for, `width` numbers per vertex
  std::uint32_t vertices = 0;
};

// Throws ItemError(unreadable) when the stream is damaged, or has more than these vertices or triangles, or
// lacks one of the attributes: before memory is taken for what it states. Memory: about 200 bytes a triangle
// and at most 640 bytes a vertex. Time: that of the stream; it cannot be stopped half-way.
DracoMesh decode_draco(std::string_view stream, std::span<const DracoAttribute> attributes,
                       std::uint64_t most_vertices, std::uint64_t most_triangles);

}  // namespace meander
