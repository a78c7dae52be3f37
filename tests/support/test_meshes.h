// Named shapes built in code, and the shared real meshes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "kernels/mesh/polygon_mesh.h"
#include "support/catch.h"

namespace meander::test {

// Closed forms, unit scale unless said otherwise; faces are counter-clockwise seen from outside.
PolygonMesh tetrahedron();  // vertices (1,1,1), (1,-1,-1), (-1,1,-1), (-1,-1,1)
PolygonMesh cube();         // [-1, 1]^3, 6 quads
PolygonMesh icosphere(int subdivisions, double radius = 1);  // 20 * 4^s triangles
PolygonMesh torus(std::uint32_t around, std::uint32_t across, double major = 1,
                  double minor = 0.4);  // 2 a b triangles
PolygonMesh grid_plane(std::uint32_t nx, std::uint32_t ny, double width = 1,
                       double height = 1);        // 2 nx ny triangles
PolygonMesh moebius_strip(std::uint32_t around);  // 2 a triangles, not orientable
PolygonMesh two_sided_plate(std::uint32_t n,
                            double thickness);  // closed thin box 1 x 1 x thickness, 4 n^2 triangles + rim
// grid_plane(folds * n, n, folds, 1) folded up like an accordion: the same vertices and faces, in `folds`
// layers of 1 x 1 that lie about `gap` above each other
PolygonMesh folded_sheet(std::uint32_t folds, std::uint32_t n, double gap);
// a slab of unit cells with `holes` square tunnels: a closed surface of that genus
PolygonMesh slab_with_tunnels(std::uint32_t holes);
PolygonMesh plate_with_holes(
    std::uint32_t holes);  // holes^2 squares of 1 out of one of 3 holes, 8 holes^2 quads
// cube and tetrahedron with vertex normals, the attribute `quality` of vertices and `label` of faces: what
// files can hold
PolygonMesh mesh_with_attributes();
std::vector<std::uint32_t> triangles_of(const PolygonMesh& mesh);  // corners of its polygons as fans
PolygonMesh polygon_mesh(std::vector<double> xyz, std::vector<std::vector<std::uint32_t>> faces);
PolygonMesh merged(const PolygonMesh& a, const PolygonMesh& b);  // vertices and faces of b after those of a
PolygonMesh inside_out(PolygonMesh mesh);                        // every face the other way round
// xyz -> rotation (fixed, generic) * scale + shift
PolygonMesh moved(const PolygonMesh& mesh, double scale, double shift_x, double shift_y, double shift_z);

inline bool have_shared_data() { return std::filesystem::is_directory(MEANDER_SHARED_DATA); }
inline std::filesystem::path shared_data(const std::string& relative) {
  return std::filesystem::path(MEANDER_SHARED_DATA) / relative;
}

}  // namespace meander::test

// Ends a test case as "skipped" on a clone without the shared meshes.
#define MEANDER_NEEDS_SHARED_DATA()                               \
  if (!meander::test::have_shared_data()) {                       \
    WARN("skipped: the shared meshes are not beside this clone"); \
    return;                                                       \
  }
