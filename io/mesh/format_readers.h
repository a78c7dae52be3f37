// Internal to io/mesh: one reader per format over the bytes of a whole file, and what they share.
//
// Each throws ItemError as read_mesh does. `text` is UTF-8 or binary, without a byte-order mark.
#pragma once

#include <string>
#include <string_view>

#include "io/mesh/mesh_reader.h"
#include "io/mesh/polygon_parts.h"

namespace meander {

PolygonMesh read_off(std::string_view text, const CancelToken& cancel, const BlockRule& rule);
PolygonMesh read_obj(std::string_view text, const CancelToken& cancel, const BlockRule& rule);
PolygonMesh read_ply(std::string_view text, const CancelToken& cancel, const BlockRule& rule);
PolygonMesh read_stl(std::string_view text, const CancelToken& cancel, const BlockRule& rule);

// read_mesh with block sizes of the caller's choice.
PolygonMesh read_mesh_in_blocks(std::span<const std::byte> bytes, MeshFormat format,
                                const CancelToken& cancel, const BlockRule& rule);

// What the content clearly is when it is not `format` ("a PLY file", "a gzip archive", ...); empty when in
// doubt. Looks at the first 64 KiB.
std::string foreign_content(std::string_view text, MeshFormat format);
// Whether the size is that of a binary STL file with the facet count it states.
bool is_exact_binary_stl(std::string_view text);
// Whether the beginning is that of an ascii STL file: `solid`, then a facet or the end.
bool looks_like_ascii_stl(std::string_view text);

}  // namespace meander
