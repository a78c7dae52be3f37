// The strata of a mesh: intervals of its curve elements, or cells of balanced bisection.
#pragma once

#include "kernels/core/random.h"
#include "kernels/density/density.h"
#include "kernels/density/pieces.h"
#include "kernels/mesh/measured_mesh.h"
#include "kernels/partition/element_cells.h"
#include "kernels/sample/spaced_samples.h"

namespace meander {

// Points of elements of a mesh; what both kinds of strata share. The mesh and all other arguments must
// outlive it.
class MeshStrata : public Strata {
 public:
  MeshStrata(const MeasuredMesh& surface, const Density& density, RandomKey key, const MetricAt& metric)
      : surface_(surface), density_(density), key_(key), metric_(metric) {}

  bool is_isotropic() const override { return !metric_; }
  LocalMetric metric(const StratumPoint& point) const override {
    return metric_(point.triangle, point.first, point.second);
  }

 protected:
  // An element, ready for points to be drawn in it.
  struct OpenElement {
    std::uint32_t triangle = no_index, path = 0;
    TriangleSource source;
    Piece piece;
    double largest = 1;  // density at a corner of the piece
  };
  // Makes `element` that of this name, unless it is already. O(bisections).
  void open(std::uint32_t triangle, std::uint32_t path, OpenElement& element) const;
  // A point of the element, distributed by mass.
  StratumPoint point_in(const OpenElement& element, const PointDraw& draw) const;
  // A point of that polygon of a triangle, which has uniform density.
  StratumPoint point_in(const OpenElement& element, std::span<const std::array<float, 2>> polygon,
                        const PointDraw& draw) const;
  // Puts the origin of the points in the middle of the mass, where float is precise: in a file with stray
  // parts the rest may be small against its box. element(i): triangle of the i-th of `count` elements.
  template <class TriangleOf>
  void set_origin(std::size_t count, const TriangleOf& triangle_of);

  Vector3 origin_;
  MeasuredMesh surface_;
  const Density& density_;
  RandomKey key_;
  const MetricAt& metric_;
};

// n equal intervals of the mass along the curve, the first of them at a random place.
class CurveStrata : public MeshStrata {
 public:
  CurveStrata(const CurveElements& elements, std::uint32_t count, const MeasuredMesh& surface,
              const Density& density, RandomKey key, const MetricAt& metric);
  std::uint32_t count() const override { return count_; }
  double measure() const override { return elements_.total(); }
  void draw(std::span<const PointDraw> draws, std::span<StratumPoint> points) const override;

 private:
  const CurveElements& elements_;
  std::uint32_t count_;
  double shift_;      // of the first interval, in intervals
  std::size_t last_;  // element of positive mass
};

// The cells.
class CellStrata : public MeshStrata {
 public:
  CellStrata(const ElementCells& cells, const MeasuredMesh& surface, const Density& density, RandomKey key,
             const MetricAt& metric);
  std::uint32_t count() const override { return static_cast<std::uint32_t>(cells_.count()); }
  double measure() const override { return measure_; }
  void draw(std::span<const PointDraw> draws, std::span<StratumPoint> points) const override;

 private:
  const ElementCells& cells_;
  double measure_;
};

}  // namespace meander
