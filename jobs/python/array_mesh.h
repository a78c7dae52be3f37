// Meshes given as numpy arrays.
#pragma once

#include <pybind11/numpy.h>

#include <array>
#include <cstdint>
#include <vector>

#include "kernels/mesh/polygon_mesh.h"

namespace meander {

// A mesh and what its randomness is keyed by.
struct ContentMesh {
  PolygonMesh mesh;
  std::array<std::uint8_t, 32> content{};
};

// Arrays as Python gives them; None where they are left out.
struct MeshArrays {
  pybind11::object vertices;  // (V, 3) real numbers
  pybind11::object faces;     // (F, k) whole numbers, k >= 3
  pybind11::object normals;   // (V, 3), of the vertices
  pybind11::object density;   // (V,) or (F,)
  bool density_of_faces = false;
  pybind11::object content;  // 32 bytes; the digest of vertices and faces where it is left out
  bool check = true;         // refuse numbers of vertices out of range, and vertices that are not finite
};

// Copies the arrays. Throws pybind11::type_error (no array of numbers, faces that are not whole numbers) and
// pybind11::value_error (shapes; with `check` what stands where). Without `check` such faces are dropped and
// counted when the mesh is prepared, as those of files. The GIL must be held; it is released for the copy.
ContentMesh mesh_of_arrays(const MeshArrays& arrays);

// 32 bytes; throws pybind11::value_error for another length.
std::array<std::uint8_t, 32> content_of_bytes(const pybind11::object& content);

// (n, 3) real numbers as 3 n doubles, all finite. Throws as above; `name` is that of the argument.
std::vector<double> finite_triples(const pybind11::object& array, const char* name);

}  // namespace meander
