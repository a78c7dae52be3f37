// Exact geodesic distances on a polyhedron: the reference for approximate ones, and for small meshes.
#pragma once

#include <span>

#include "kernels/core/cancel.h"
#include "kernels/describe/heat_geodesics.h"

namespace meander {

// S x W: distance[s W + w] of the shortest path over the triangles from source s to working vertex w, file
// units; infinity on other components. Windows of straight paths are pushed across the triangles, nearest
// first, and dropped once a vertex of the triangle they came through gives every point of them a shorter path
// (Mitchell, Mount and Papadimitriou 1987, "The discrete geodesic problem"; Chen and Han 1990; the filter:
// Xin and Wang 2009, "Improving Chen and Han's algorithm"); vertices of more than 2 pi (+ 1e-11) and boundary
// vertices send out windows of their own. Error: rounding, about 1e-11 of the distance.
//
// Cost: windows are neither trimmed nor merged, so O(V^2) and more at worst; sources run in parallel (see
// tests and bench for times). Throws std::invalid_argument for sources as HeatGeodesics does, and for
// a source on a component with a triangle of no area; timeout / RunCanceled. Deterministic for every thread
// count.
void exact_geodesics(const PreparedMesh& mesh, PointsOnMesh sources, std::span<double> distance,
                     const CancelToken& cancel = {});

}  // namespace meander
