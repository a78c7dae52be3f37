// Charts made by hand: planar meshes whose map into the unit square is a formula.
#pragma once

#include <functional>
#include <utility>

#include "kernels/flatten/flatten_chart.h"
#include "kernels/mesh/prepared_mesh.h"

namespace meander::test {

// A chart of one component without any cut; `map` takes the file coordinates of a vertex to (u, v).
using ChartMap = std::function<std::pair<double, double>(Vector3)>;
FlatChart hand_chart(const PreparedMesh& mesh, const Component& component, const ChartMap& map);

// grid_plane(nx, ny) with inner vertices moved by up to `jitter` of a cell; z = height(x, y).
PolygonMesh wavy_grid(std::uint32_t nx, std::uint32_t ny, double jitter,
                      const std::function<double(double, double)>& height);

}  // namespace meander::test
