#include "kernels/analyse/quadric_collapse.h"

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Core/System/omstream.hh>
#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModQuadricT.hh>

namespace meander {

namespace {

struct DoubleTraits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  using Normal = OpenMesh::Vec3d;
};
using HalfEdgeMesh = OpenMesh::TriMesh_ArrayKernelT<DoubleTraits>;

HalfEdgeMesh half_edge_mesh(const PreparedMesh& mesh) {
  HalfEdgeMesh result;
  result.request_vertex_status();
  result.request_edge_status();
  result.request_halfedge_status();
  result.request_face_status();
  std::vector<HalfEdgeMesh::VertexHandle> handles;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
    handles.push_back(result.add_vertex({mesh.x[v], mesh.y[v], mesh.z[v]}));
  for (std::size_t h = 0; h < mesh.triangles.size(); h += 3)
    result.add_face(handles[mesh.triangles[h]], handles[mesh.triangles[h + 1]],
                    handles[mesh.triangles[h + 2]]);
  return result;
}

}  // namespace

SimplifiedMesh quadric_collapse(const PreparedMesh& mesh, std::size_t vertices) {
  omerr().disable();  // faces that it refuses
  HalfEdgeMesh half_edges = half_edge_mesh(mesh);
  OpenMesh::Decimater::DecimaterT<HalfEdgeMesh> decimater(half_edges);
  OpenMesh::Decimater::ModQuadricT<HalfEdgeMesh>::Handle quadrics;
  decimater.add(quadrics);
  decimater.module(quadrics).unset_max_err();
  decimater.initialize();
  decimater.decimate_to(vertices);
  half_edges.garbage_collection();
  SimplifiedMesh result;
  for (const auto vertex : half_edges.vertices()) {
    const OpenMesh::Vec3d at = half_edges.point(vertex);
    result.x.push_back(at[0]);
    result.y.push_back(at[1]);
    result.z.push_back(at[2]);
  }
  for (const auto face : half_edges.faces())
    for (auto corner = half_edges.cfv_begin(face); corner.is_valid(); ++corner)
      result.triangles.push_back(static_cast<std::uint32_t>(corner->idx()));
  return result;
}

}  // namespace meander
