// A mesh with its measure of lengths: those in space, or those of a metric on it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/mesh/prepared_mesh.h"

namespace meander {

// Seams, charts and curve elements are measured by these lengths; areas, masses and points are always those
// in space. A view: mesh and lengths must outlive it.
class MeasuredMesh {
 public:
  // Measures in space. Implicit, so that functions of a MeasuredMesh take a PreparedMesh too.
  MeasuredMesh(const PreparedMesh& surface) : mesh_(&surface) {}
  MeasuredMesh(PreparedMesh&&) = delete;
  // metric_length: 3 T lengths of half-edges, equal on both sides of an edge; empty: in space.
  MeasuredMesh(const PreparedMesh& surface, const std::vector<double>& metric_length)
      : mesh_(&surface), metric_length_(metric_length) {}
  MeasuredMesh(PreparedMesh&&, const std::vector<double>&) = delete;
  MeasuredMesh(const PreparedMesh&, std::vector<double>&&) = delete;

  const PreparedMesh& mesh() const { return *mesh_; }
  bool in_space() const { return metric_length_.empty(); }
  double length(std::uint32_t half_edge) const {
    return in_space() ? mesh_->length_in_space(half_edge) : metric_length_[half_edge];
  }

 private:
  const PreparedMesh* mesh_;
  std::span<const double> metric_length_;
};

}  // namespace meander
