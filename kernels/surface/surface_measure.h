// The measure area x density of a parametric surface, as a function on the curve's square.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/core/expression.h"
#include "kernels/surface/sample_surface.h"
#include "kernels/surface/surface.h"

namespace meander {

// A continuous map of the unit square onto itself that spreads a measure about evenly: u by its marginal, v
// by its conditional distribution (the inverse transform in two steps; "histogram equalisation" of Quinn et
// al. 2006). It is bilinear on a grid whose lines are lines of the curve's tree, so that the Jacobian is
// smooth inside every node from that depth on.
struct SquareWarp {
  std::size_t cells = 0;  // a power of the tree's branching
  std::vector<double> u;  // cells + 1, ascending from 0 to 1
  std::vector<double> v;  // (cells + 1)^2: row k is the ascending map at u[k]

  struct Image {
    double u, v, jacobian;
  };
  Image operator()(double s, double t) const;
};

// Values at a batch of points, and scratch that is kept between batches.
struct MeasureBatch {
  std::vector<double> u, v;     // parameters of the surface
  std::vector<double> value;    // area element x density, per unit of the curve's square
  std::vector<double> area;     // area element, per unit of the curve's square
  std::vector<double> density;  // 0 where the area element is 0
  std::vector<Vector3> position;
  std::vector<Vector3> du_cross_dv;

  std::vector<SurfaceTangents> tangents;
  std::vector<SurfaceJet> jets;
  std::vector<double> x, y, z;
};

class SurfaceMeasure {
 public:
  // Finds the curvature that gets density 1, and the warp, on fixed grids. Throws as sample_surface. The
  // surface must outlive the object.
  SurfaceMeasure(const ParametricSurface& surface, const SurfaceSampleParameters& parameters,
                 const CancelToken& cancel);

  // Evaluates at the points (s, t) of the curve's square. Throws ItemError: non_finite, unreadable. Pure.
  void evaluate(std::span<const double> s, std::span<const double> t, MeasureBatch& batch) const;

  // The Hilbert levels from which on the warp is smooth inside a node; 0 without a warp.
  int warp_depth() const;
  // The box around a grid of points of the surface (min x, y, z, max x, y, z) and its diagonal.
  const std::array<double, 6>& box() const { return box_; }
  double diagonal() const { return diagonal_; }

 private:
  double curvature(const SurfaceJet& jet) const;
  void find_reference_curvature(const CancelToken& cancel);
  void find_diagonal();
  SquareWarp make_warp(std::size_t cells, const CancelToken& cancel) const;
  void evaluate_density(MeasureBatch& batch) const;

  const ParametricSurface& surface_;
  SurfaceDensity density_;
  std::optional<Expression> expression_;
  double reference_ = 0;  // of the curvature kinds
  std::array<double, 6> box_{};
  double diagonal_ = 0;
  std::optional<SquareWarp> warp_;
};

}  // namespace meander
