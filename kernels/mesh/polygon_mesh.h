// A mesh as its file gives it: every vertex and every polygon under the file's own number.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "kernels/core/notes.h"
#include "kernels/core/status.h"

namespace meander {

inline constexpr std::uint32_t no_index = 0xFFFFFFFFu;

// One number per vertex or per face, under the name that the file gives it.
struct ScalarAttribute {
  std::string name;
  std::vector<double> values;
  bool integers = false;  // the file declares whole numbers, which stand for classes
};

// Texture coordinates by the corners of polygons, as the file gives them. Both arrays are empty unless the
// reader was asked for them and the file has some.
struct CornerCoordinates {
  std::vector<float> values;          // 2 per texture coordinate
  std::vector<std::uint32_t> corner;  // K indices of coordinates; no_index: none
};

struct SurfaceTextures;  // kernels/mesh/surface_textures.h

// Colors of a surface, three numbers each (red, green, blue) in [0, 1]; NaN where there is none. Both arrays
// are empty unless the reader was asked for colors.
struct SurfaceColors {
  std::vector<float> vertex;  // V x 3
  std::vector<float> face;    // P x 3: of the polygon or of its material
  bool of_materials = false;  // `face` holds colors of materials
  // Linear light, where the color of a point is the product of both arrays (glTF). Otherwise values are as
  // displayed, and the color of a vertex takes precedence over that of a face.
  bool linear = false;
  // Images on polygons, with the coordinates of their corners; null where no polygon has one. Their colors
  // are multiplied by `face`, where it has one.
  std::shared_ptr<const SurfaceTextures> textures;
};

// V vertices, P polygons, K corners in all. Nothing is checked here: corners may name vertices that do not
// exist (values >= V, and no_index for numbers that do not fit into 32 bits), positions may be NaN, polygons
// may have 0..2 corners. A polygon that could not be read keeps its number (with no corners), so that numbers
// never shift.
struct PolygonMesh {
  std::vector<double> x, y, z;  // V each, file coordinates
  // P + 1 offsets into `corners`, ascending, the first 0; empty when P = 0.
  std::vector<std::uint32_t> polygon_begin;
  std::vector<std::uint32_t> corners;  // K vertex numbers, zero-based
  std::vector<float> normals;          // 3 per normal; empty when the file gives none
  // K indices of normals (no_index: none); empty: normal i belongs to vertex i.
  std::vector<std::uint32_t> corner_normals;
  std::vector<ScalarAttribute> vertex_attributes;  // V values each
  std::vector<ScalarAttribute> face_attributes;    // P values each
  // V values each, read only because the reader was asked for them by name. Neither densities nor tensors
  // look here, so that points do not depend on the columns that are stored with them.
  std::vector<ScalarAttribute> asked_attributes;
  std::vector<ScalarAttribute> asked_face_attributes;  // the same for faces, P values each
  // The names behind the numbers of asked_face_attributes and `part`, as one JSON object of lists by the name
  // of the attribute, {"object":["seat","leg"]}: class i is entry i. Lists are shorter or left out where they
  // would take more than most_name_bytes (kernels/data/samples.h). Empty: there are none.
  std::string names;
  CornerCoordinates coordinates;
  SurfaceColors colors;
  RepairCounts repairs;  // what the reader repaired
  Notes notes;           // what the file asks for and the reader did not give

  std::size_t vertex_count() const { return x.size(); }
  std::size_t polygon_count() const { return polygon_begin.empty() ? 0 : polygon_begin.size() - 1; }
  // Memory of the attributes that the reader always reads.
  std::uint64_t attribute_bytes() const {
    return sizeof(double) *
           (vertex_attributes.size() * vertex_count() + face_attributes.size() * polygon_count());
  }
};

}  // namespace meander
