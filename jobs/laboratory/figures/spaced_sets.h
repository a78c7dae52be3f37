// The sets of samples that spaced ones are compared with, on one mesh.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "jobs/laboratory/figures/figure_set.h"
#include "jobs/laboratory/figures/staged_model.h"
#include "kernels/analyse/box_discrepancy.h"
#include "kernels/locate/embree_locator.h"

namespace meander {

struct ComparedMethod {
  const char* name;
  SequenceKind sequence;
  OrderKind order = OrderKind::curve;
  SpacingKind spacing = SpacingKind::standard;
  bool eliminated = false;  // from five times as many samples (kernels/pointset/sample_elimination.h)
};
inline constexpr std::array<ComparedMethod, 8> compared_methods = {{
    {"random", SequenceKind::random},
    {"stratified", SequenceKind::stratified},
    {"shifted", SequenceKind::shifted},
    {"sample elimination", SequenceKind::random, OrderKind::curve, SpacingKind::standard, true},
    {"spaced fast", SequenceKind::spaced, OrderKind::curve, SpacingKind::fast},
    {"spaced", SequenceKind::spaced},
    {"spaced best", SequenceKind::spaced, OrderKind::curve, SpacingKind::best},
    {"spaced progressive", SequenceKind::spaced, OrderKind::progressive},
}};
inline constexpr std::size_t random_method = 0, eliminated_method = 3, spaced_method = 5;

struct ComparedSet {
  std::vector<double> points, normals;  // 3 n, working units of the mesh
  double seconds = 0;                   // of locating and placing
};

// A mesh prepared once for many sets by the method `auto`.
class ComparedModel {
 public:
  // most: points of the largest set. Throws ItemError.
  ComparedModel(const FigureMesh& mesh, std::uint32_t most);
  ComparedSet set(const ComparedMethod& method, std::uint32_t count, std::uint64_t seed) const;
  const PreparedMesh& surface() const { return staged_.surface; }
  // Throws ItemError(zero_area) where hardly any box holds a share of the surface.
  std::vector<RotatedBox> boxes(std::uint32_t count, std::uint64_t seed) const;

 private:
  SampleParameters parameters_;
  Model staged_;
  EmbreeDevice device_;
};

// Over the sets added, of one number of points each.
struct SetMeasures {
  std::uint32_t sets = 0;
  double squared_error = 0;                          // of box_error_ratio, sum
  double rho = 0, least_rho = 1, mean_distance = 0;  // sums; mean distance over that of the hexagonal lattice
  double seconds = 0;

  void add(const ComparedModel& model, std::span<const RotatedBox> boxes, const ComparedSet& set);
  double error() const;
  double mean_rho() const { return rho / sets; }
};

}  // namespace meander
