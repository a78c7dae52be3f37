#include "kernels/model/remesh_model.h"

#include <vector>

#include "kernels/core/vector3.h"
#include "kernels/sample/point_frames.h"

namespace meander {

namespace {

// Vertices that are neither moved nor made here are, bit by bit, where the samples and the file have them.
void to_file_coordinates(const Model& model, const std::vector<double>& samples, RemeshedSurface& mesh) {
  const PreparedMesh& surface = model.surface;
  const std::size_t n = samples.size() / 3;
  std::vector<std::uint32_t> slot;  // a corner in the file, of the vertices of the surface
  if (mesh.x.size() > n) {
    slot.assign(surface.vertex_count(), no_index);
    for (std::size_t h = 0; h < surface.triangles.size(); ++h)
      slot[surface.triangles[h]] = surface.corner_slot[h];
  }
  for (std::size_t v = 0; v < mesh.x.size(); ++v) {
    const Vector3 working{mesh.x[v], mesh.y[v], mesh.z[v]};
    const std::uint32_t origin = v < n ? no_index : mesh.origin[v - n];
    Vector3 at = to_file(surface, working);
    if (origin != no_index) {
      const std::uint32_t corner = model.file.corners[slot[origin]];
      at = {model.file.x[corner], model.file.y[corner], model.file.z[corner]};
    } else if (v < n && working.x == samples[3 * v] && working.y == samples[3 * v + 1] &&
               working.z == samples[3 * v + 2]) {
      at = file_point(model.row.report, model.row.samples.points, v);
    }
    mesh.x[v] = at.x;
    mesh.y[v] = at.y;
    mesh.z[v] = at.z;
  }
}

}  // namespace

RemeshedSurface remesh_model(Model& model, const RemeshParameters& parameters) {
  release_charts(model);
  const Samples& samples = model.row.samples;
  const std::vector<double> places = working_points(model.row.report, samples.points, model.surface);
  RemeshedSurface mesh =
      remesh_surface(model.surface, {samples.triangle, samples.barycentric, places, samples.curve_rank},
                     model.measure.masses, parameters, model.cancel);
  to_file_coordinates(model, places, mesh);
  return mesh;
}

const SettingList<RemeshParameters>& remesh_settings() {
  static const SettingList<RemeshParameters> list = [] {
    SettingList<RemeshParameters> made;
    made.under("Mesh");
    made.number(
            "crease_angle", "--crease-angle", [](auto& mesh) -> auto& { return mesh.lines.crease_angle; }, 1,
            180,
            "Edges with this angle or more between their triangles stay edges, 1 to 180 degrees; 180: none")
        .in_python("crease_angle");
    made.flag(
            "fit", "--fit", [](auto& mesh) -> auto& { return mesh.fit; },
            "Flip edges and move the samples along their normals, so that the mesh is nearer to the surface, "
            "and onto creases beside them")
        .in_python("fit")
        .common();
    return made;
  }();
  return list;
}

}  // namespace meander
