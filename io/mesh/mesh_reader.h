// Reading mesh files: lenient about what files in the wild look like, exact about what they say.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/file/byte_source.h"
#include "io/file/file_bytes.h"
#include "io/mesh/mesh_format.h"
#include "kernels/core/cancel.h"
#include "kernels/data/samples.h"
#include "kernels/mesh/polygon_mesh.h"

namespace meander {

// What a mesh of this format probably holds, from the first (and a few middle) kilobytes: for the memory
// reservation.
struct MeshEstimate {
  std::uint64_t file_bytes = 0;
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
  // The bytes of a packed member of an archive, in memory while it is unpacked.
  std::uint64_t packed_bytes = 0;
  // What the reader takes beside the file, vertices and faces: decoded streams of glTF, the values of all
  // properties of PLY.
  std::uint64_t decoding_bytes = 0;
  // The other files that the model consists of (CompanionFile::path), in the order in which it names them,
  // each once. Their bytes are not in file_bytes.
  std::vector<std::string> companions = {};
};
// Reads at most 256 KiB of the file, of glTF all JSON up to 16 MiB. Headers are believed only as far as the
// file's size allows. Exact for binary files that are whole and for text up to 256 KiB; larger OBJ text is
// sampled and raised by a fifth, so that the estimate is rarely too small. A guess (half to twice the truth)
// for binary polygons that are cut. Never throws for a malformed file (an upper bound from the size stands
// in; of glTF what its JSON may take); throws ItemError(unreadable) when it cannot be opened.
MeshEstimate peek_mesh(const std::filesystem::path& path, MeshFormat format);
// The same for bytes that may be anywhere. They are read in ascending order, but for the first 64 KiB.
MeshEstimate peek_mesh(const ByteSource& file, MeshFormat format);

// A file that a model names beside its own, by its path from the model's folder: names separated by /, `..`
// at its beginning alone.
struct CompanionFile {
  // Why a file has no bytes: it is not there; it leads out of what was given as input; anything else.
  enum class Loss : std::uint8_t { none, missing, outside, unreadable };

  std::string path;
  std::span<const std::byte> bytes = {};
  std::string problem = {};  // why it could not be read; empty: it was
  bool is_image = false;     // a texture: no reader takes it for anything else
  Loss loss = Loss::none;
};

// Values that a reader takes up only when it is asked to, beside colors.
struct MeshExtras {
  bool coordinates = false;  // fill PolygonMesh::coordinates
  // Fill PolygonMesh::asked_attributes with these, where the format has attributes that are not read anyway:
  // glTF, whose names begin with `_`, and of just this width. A vector NAME becomes NAME_0, NAME_1, ...; what
  // is wrong with one, or missing at some vertices, is NaN there. Also PolygonMesh::asked_face_attributes
  // with `group`, `object` and `material` of OBJ, `object` (the node) and `material` of glTF, and
  // PolygonMesh::names with the names behind these and behind `part`.
  std::span<const AttributeColumn> attributes = {};
};

// What a reader may need beside the bytes of the file. Only glTF does.
struct MeshSurroundings {
  std::span<const CompanionFile> companions;
  // Called before memory is taken for more than the file's own bytes account for, with what the file states
  // (file_bytes is 0); may throw.
  std::function<void(const MeshEstimate&)> admit;
  bool colors = false;  // fill PolygonMesh::colors; without it a reader does nothing for them
  MeshExtras extras = {};
};

// Parses the bytes of a file. Never trusts a count: every count is checked against the bytes that are there
// before memory is taken. Large files are parsed in parallel blocks (the result does not depend on it). Extra
// properties are skipped; vertex and corner normals and scalar vertex and face attributes are kept. Throws
// ItemError: unreadable or unsupported_format with a sentence that says what is wrong and where (line or
// byte); empty for a file without a face, and for one without anything. RunCanceled and bad_alloc pass.
//
// What is accepted, and the limits:
// * The name decides the format. Content that clearly is of another format is unreadable, and the sentence
//   names it: reading it silently would hide that a collection is mislabeled.
// * Byte-order marks, UTF-16 with a mark, CRLF and CR line ends, comments and numbers as nan, -nan(ind),
//   1.#INF or 1e400 (infinity) are read. 1,5 is not a number in any locale.
// * A face that cannot be read keeps its number and has no corners; a coordinate that is not a number makes
//   the file unreadable, because one decimal comma means thousands. Files whose faces all cannot be read are
//   unreadable.
// * A file that ends too early keeps the faces that are complete (missing_faces, missing_vertices). Where a
// text
//   ends without a line end and rows are missing, the last row counts as missing: its last number may be cut.
//   Without any face it is unreadable. Bytes behind the last promised element are counted as extra_data.
// * STL: the size decides if it is binary. Facet f has the vertices 3 f .. 3 f + 2 of its own; facet normals
//   are ignored. A count of 0 or 2^32 - 1 in a binary file with facets means that it was never filled in.
// * PLY: the triangles of `tristrips` follow the faces, numbered strip by strip.
// * glTF 2.0, .gltf and .glb (the content decides which of the two): the triangles, strips and fans of all
//   meshes of the scene, moved by the default weights of their morph targets, transformed by their nodes,
//   instances and, in rest pose, their skins, in the order of the scene; the first scene where none is
//   chosen, all roots where there is none. A node stands below each of its parents. A transform that mirrors
//   turns its faces, so that the outside stays outside. The face attribute `part` numbers the primitives from
//   0 in this order. Points and lines are left out and counted as short_faces. Normals are not read. An index
//   that names no vertex of its primitive becomes no_index.
// * OBJ: a vertex number that names no vertex becomes no_index; all objects and groups are one mesh.
// * Numbers of faces, when asked for, count what faces belong to in the order in which they first do, from 0.
//   OBJ: objects (`o`) and materials (`usemtl`) by name, groups (`g`) by all names of a line, apart by
//   blanks; faces before the first one belong to none, but to the group `default`, as those under a `g`
//   without name. glTF: materials and nodes by their entry in the file; a node without a name has that of its
//   mesh.
//
// Texture coordinates, when asked for: of corners, from OBJ (`vt`), PLY (`texcoord` of faces, or those of
// vertices) and glTF (TEXCOORD_0), v as the file has it: upwards in OBJ and PLY, downwards in glTF.
//
// Colors, when asked for: of vertices, faces, materials and textures, as docs/FORMATS.md lists them by
// format, with the rule by which numbers are bytes or fractions (scale_colors). Images (decode_color_image)
// are decoded as far as a polygon has them; one that is missing, damaged or beyond most_image_pixels is kept
// without pixels. A color that is not there or cannot be read is none, never an error.
//
// PolygonMesh::notes names what the file asks for and does not get: colors with `colors` alone.
PolygonMesh read_mesh(std::span<const std::byte> bytes, MeshFormat format, const CancelToken& cancel = {},
                      const MeshSurroundings& around = {});

}  // namespace meander
