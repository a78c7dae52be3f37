// Where the triangles of a surface lie in its charts.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "kernels/flatten/flatten_chart.h"
#include "kernels/mesh/coarsen_mesh.h"
#include "kernels/mesh/prepared_mesh.h"

namespace meander {

// The charts of a surface, by component: of itself, or of a coarse mesh under it. A view. Empty: none.
struct ChartSet {
  ChartSet() = default;
  ChartSet(std::span<const FlatChart> flat_charts) : charts(flat_charts) {}
  ChartSet(const std::vector<FlatChart>& flat_charts) : charts(flat_charts) {}
  ChartSet(const std::vector<FlatChart>& flat_charts, const CoarseMesh* coarse_mesh)
      : charts(flat_charts), coarse(coarse_mesh) {}

  std::span<const FlatChart> charts;
  const CoarseMesh* coarse = nullptr;  // null: they are charts of the surface itself
  bool empty() const { return charts.empty(); }
};

// Corners of triangles in the charts. Over a coarse mesh the chart of the coarse triangle is continued beyond
// it as the affine map that it is on its plane: a fine triangle lies where its corners' feet on that plane
// are taken, hence not exactly beside its neighbors; what would leave the unit square lies on its border.
class ChartPlaces {
 public:
  // O(charts), O(T) for charts of the surface itself. Mesh and charts must outlive it.
  ChartPlaces(const PreparedMesh& mesh, const ChartSet& charts);

  bool any() const { return !charts_.empty(); }
  // The corners' (u, v) in [0, 1]^2, or false where the triangle's component has no chart.
  bool find(std::size_t triangle, std::array<double, 3>& u, std::array<double, 3>& v) const;

 private:
  // (u, v) = (u0 + du . p, v0 + dv . p)
  struct PlaneMap {
    Vector3 du, dv;
    double u0 = 0, v0 = 0;
    bool has_chart = false;
  };
  void map_planes();

  const PreparedMesh& mesh_;
  std::span<const FlatChart> charts_;
  const CoarseMesh* coarse_;
  std::vector<std::uint32_t> chart_of_;  // by triangle, no_index without
  std::vector<PlaneMap> planes_;         // by coarse triangle
};

// Component and sheet of every triangle, as one number; empty without charts.
std::vector<std::uint32_t> sheet_groups(const PreparedMesh& mesh, std::span<const FlatChart> charts,
                                        std::span<const std::uint8_t> sheet);

}  // namespace meander
