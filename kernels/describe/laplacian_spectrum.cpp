#include "kernels/describe/laplacian_spectrum.h"

#include <Spectra/SymGEigsShiftSolver.h>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <span>

#include "kernels/core/parallel.h"
#include "kernels/core/vector3.h"
#include "kernels/solve/dense_fronts.h"
#include "kernels/solve/elimination_order.h"
#include "kernels/solve/sparse_cholesky.h"
#include "kernels/solve/surface_laplacian.h"

namespace meander {

namespace {

constexpr std::size_t dense_vertices = 64;  // dense matrices are as fast up to there
constexpr double tolerance = 1e-7;          // of a residual; that of its eigenvalue is about the square
constexpr int max_restarts = 300;
constexpr double mass_spread = 1e-3;  // see separate_masses

// K and M on one graph.
struct SurfaceMatrices {
  GraphMatrix stiffness;
  std::vector<double> mass, mass_diagonal;  // beside stiffness.graph.neighbors, and on the diagonal
  double area = 0;
};

SurfaceMatrices matrices_of(const IntrinsicSurface& surface) {
  SurfaceMatrices made;
  made.stiffness = surface_laplacian(surface, corner_geometry(surface.length).half_cotangent);
  // The mass of an edge goes through surface_laplacian() as its weight: a 24th of both triangles' areas.
  std::vector<double> weight(surface.length.size());
  made.mass_diagonal.assign(surface.vertex_count, 0);
  for (std::size_t t = 0; t < surface.triangle_count(); ++t) {
    const double* l = surface.length.data() + 3 * t;
    const double longest = std::max({l[0], l[1], l[2]});
    const double area = std::max(area_from_lengths(l[0], l[1], l[2]), 0.25e-12 * longest * longest);
    made.area += area;
    for (std::size_t h = 3 * t; h < 3 * t + 3; ++h) {
      weight[h] = area / 24;
      const std::uint32_t from = surface.triangles[h], to = surface.triangles[next_half_edge(h)];
      made.mass_diagonal[from] += area / 4;
      if (from == to) made.mass_diagonal[from] += area / 12;
    }
  }
  made.mass = surface_laplacian(surface, weight).values;
  for (double& m : made.mass) m = -m;
  return made;
}

// Changes every mass by its own small share. The Krylov space of one vector holds only one function of each
// eigenspace, so a multiple eigenvalue would be found once, or as often as rounding happens to split it; a
// surface without symmetries has no multiple eigenvalues. This moves eigenvalues by some 1e-3 / sqrt(V), far
// below the error of the elements.
void separate_masses(SurfaceMatrices& matrices) {
  double turn = 0;  // multiples of the golden ratio, modulo 1
  for (double& mass : matrices.mass_diagonal) {
    turn += std::numbers::phi - 1;
    turn -= std::floor(turn);
    mass *= 1 + mass_spread * (turn - 0.5);
  }
}

// The two operators that Spectra takes, with their sizes; this version of it does not call cols().
class ShiftedInverse {
 public:
  using Scalar = double;
  ShiftedInverse(const SparseCholesky& factor, std::size_t rows, const CancelToken& cancel)
      : factor_(factor), rows_(static_cast<Eigen::Index>(rows)), cancel_(cancel) {}
  Eigen::Index rows() const { return rows_; }
  [[maybe_unused]] Eigen::Index cols() const { return rows_; }
  void set_shift(double) {}  // the factor has it
  void perform_op(const double* x, double* y) const {
    cancel_.check();
    std::copy_n(x, rows_, y);
    factor_.solve({y, static_cast<std::size_t>(rows_)});
  }

 private:
  const SparseCholesky& factor_;
  Eigen::Index rows_;
  const CancelToken& cancel_;
};

class MassProduct {
 public:
  using Scalar = double;
  explicit MassProduct(const SurfaceMatrices& matrices) : matrices_(matrices) {}
  Eigen::Index rows() const { return static_cast<Eigen::Index>(matrices_.mass_diagonal.size()); }
  [[maybe_unused]] Eigen::Index cols() const { return rows(); }
  void perform_op(const double* x, double* y) const {
    const UnknownGraph& graph = matrices_.stiffness.graph;
    for (std::size_t v = 0; v < graph.count(); ++v) {
      double sum = matrices_.mass_diagonal[v] * x[v];
      for (std::uint32_t e = graph.begin[v]; e < graph.begin[v + 1]; ++e)
        sum += matrices_.mass[e] * x[graph.neighbors[e]];
      y[v] = sum;
    }
  }

 private:
  const SurfaceMatrices& matrices_;
};

// Computes L^-1 m by substitution, L the lower triangle; the order of the sums is fixed, see dense_fronts.h.
void divide_by_lower(const Eigen::MatrixXd& lower, Eigen::MatrixXd& m) {
  for (Eigen::Index c = 0; c < m.cols(); ++c)
    for (Eigen::Index j = 0; j < m.rows(); ++j) {
      m(j, c) /= lower(j, j);
      for (Eigen::Index i = j + 1; i < m.rows(); ++i) m(i, c) -= lower(i, j) * m(j, c);
    }
}

// Computes L^-T m likewise.
void divide_by_transposed(const Eigen::MatrixXd& lower, Eigen::MatrixXd& m) {
  for (Eigen::Index c = 0; c < m.cols(); ++c)
    for (Eigen::Index j = m.rows(); j-- > 0;) {
      for (Eigen::Index i = j + 1; i < m.rows(); ++i) m(j, c) -= lower(i, j) * m(i, c);
      m(j, c) /= lower(j, j);
    }
}

// Solves K x = lambda M x, which with M = L L^T is the problem of L^-1 K L^-T. functions: where the x go, a
// column each; nullptr: nowhere.
std::vector<double> by_dense_matrices(const SurfaceMatrices& matrices, Eigen::MatrixXd* functions) {
  const UnknownGraph& graph = matrices.stiffness.graph;
  const auto count = static_cast<Eigen::Index>(graph.count());
  Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(count, count), mass = stiffness;
  for (Eigen::Index v = 0; v < count; ++v) {
    const auto at = static_cast<std::size_t>(v);
    stiffness(v, v) = matrices.stiffness.diagonal[at];
    mass(v, v) = matrices.mass_diagonal[at];
    for (std::uint32_t e = graph.begin[at]; e < graph.begin[at + 1]; ++e) {
      stiffness(v, graph.neighbors[e]) += matrices.stiffness.values[e];
      mass(v, graph.neighbors[e]) += matrices.mass[e];
    }
  }
  constexpr const char* failure = "the eigenvalues of a small component could not be found";
  if (!factorize_front(mass.data(), graph.count(), graph.count())) throw SpectrumNotFound(failure);
  divide_by_lower(mass, stiffness);
  stiffness.transposeInPlace();
  divide_by_lower(mass, stiffness);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(
      stiffness, functions != nullptr ? Eigen::ComputeEigenvectors : Eigen::EigenvaluesOnly);
  if (solver.info() != Eigen::Success) throw SpectrumNotFound(failure);
  if (functions != nullptr) {
    *functions = solver.eigenvectors();
    divide_by_transposed(mass, *functions);
  }
  return {solver.eigenvalues().begin(), solver.eigenvalues().end()};
}

std::vector<double> by_iteration(const SurfaceMatrices& matrices, std::size_t count,
                                 Eigen::MatrixXd* functions, const CancelToken& cancel) {
  const GraphMatrix& stiffness = matrices.stiffness;
  const std::size_t vertices = stiffness.graph.count();
  // The shift is below zero, so that the shifted matrix is definite, and of the first eigenvalue's order of
  // magnitude.
  const double shift = -4 * std::numbers::pi / matrices.area;
  GraphMatrix shifted = stiffness;
  for (std::size_t e = 0; e < shifted.values.size(); ++e) shifted.values[e] -= shift * matrices.mass[e];
  for (std::size_t v = 0; v < vertices; ++v) shifted.diagonal[v] -= shift * matrices.mass_diagonal[v];
  const std::vector<std::uint32_t> order = elimination_order(shifted.graph);
  SparseCholesky factor;
  factorize_laplacian(factor, shifted.graph, shifted.values, shifted.diagonal, order, cancel);
  ShiftedInverse inverse(factor, vertices, cancel);
  MassProduct mass(matrices);
  const auto wanted = static_cast<Eigen::Index>(count);
  const auto basis = static_cast<Eigen::Index>(std::min(vertices, 2 * count + 20));
  Spectra::SymGEigsShiftSolver<ShiftedInverse, MassProduct, Spectra::GEigsMode::ShiftInvert> solver(
      inverse, mass, wanted, basis, shift);
  solver.init();
  solver.compute(Spectra::SortRule::LargestMagn, max_restarts, tolerance, Spectra::SortRule::SmallestAlge);
  if (solver.info() != Spectra::CompInfo::Successful)
    throw SpectrumNotFound("the eigenvalues of a component could not be found");
  if (functions != nullptr) *functions = solver.eigenvectors();
  const Eigen::VectorXd values = solver.eigenvalues();
  return {values.begin(), values.end()};
}

// The eigenvalues with the zero, `count` or more where there are as many, in no order.
std::vector<double> eigenvalues_of(const IntrinsicSurface& surface, std::size_t count,
                                   Eigen::MatrixXd* functions, const CancelToken& cancel) {
  SurfaceMatrices matrices = matrices_of(surface);
  if (surface.vertex_count <= std::max(dense_vertices, count + 1))
    return by_dense_matrices(matrices, functions);
  separate_masses(matrices);
  return by_iteration(matrices, count, functions, cancel);
}

}  // namespace

std::vector<double> laplacian_spectrum(const IntrinsicSurface& surface, std::size_t count,
                                       const CancelToken& cancel) {
  if (surface.vertex_count < 2 || count == 0) return {};
  std::vector<double> values = eigenvalues_of(surface, count + 1, nullptr, cancel);
  std::sort(values.begin(), values.end());
  values.erase(values.begin());
  values.resize(std::min(values.size(), count));
  for (double& value : values) value = std::max(value, 0.0);
  return values;
}

LaplacianModes laplacian_modes(const IntrinsicSurface& surface, std::size_t count,
                               const CancelToken& cancel) {
  LaplacianModes modes;
  if (surface.vertex_count < 2 || count == 0) return modes;
  Eigen::MatrixXd functions;
  const std::vector<double> values = eigenvalues_of(surface, count + 1, &functions, cancel);
  std::vector<Eigen::Index> order(values.size());
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  const auto value = [&](Eigen::Index k) { return values[static_cast<std::size_t>(k)]; };
  std::stable_sort(order.begin(), order.end(),
                   [&](Eigen::Index a, Eigen::Index b) { return value(a) < value(b); });
  for (std::size_t k = 1; k < std::min(order.size(), count + 1); ++k) {
    modes.values.push_back(std::max(value(order[k]), 0.0));
    const auto column = functions.col(order[k]);
    modes.functions.emplace_back(column.begin(), column.end());
  }
  return modes;
}

double area_of(const IntrinsicSurface& surface) {
  double area = 0;
  for (std::size_t h = 0; h < surface.length.size(); h += 3)
    area += area_from_lengths(surface.length[h], surface.length[h + 1], surface.length[h + 2]);
  return area;
}

std::vector<JointEigenvalue> joint_eigenvalues(
    std::span<const double> area, std::size_t count,
    const std::function<std::vector<double>(std::size_t component, std::size_t n)>& find) {
  constexpr std::size_t margin = 3;  // about the deviation of components from their expectation
  const double total = blocked_sum(area);
  std::vector<std::vector<double>> spectra(area.size());
  std::vector<std::size_t> asked(area.size());
  const auto ask = [&](std::size_t c, std::size_t wanted) {
    asked[c] = std::min(wanted, count);
    spectra[c] = find(c, asked[c]);
  };
  for (std::size_t c = 0; c < area.size(); ++c)
    ask(c, margin + static_cast<std::size_t>(static_cast<double>(count) * area[c] / total));
  while (true) {
    std::vector<JointEigenvalue> lowest;
    for (std::size_t c = 0; c < area.size(); ++c)
      for (std::size_t k = 0; k < spectra[c].size(); ++k)
        lowest.push_back({spectra[c][k], static_cast<std::uint32_t>(c), k});
    std::stable_sort(lowest.begin(), lowest.end(),
                     [](const JointEigenvalue& a, const JointEigenvalue& b) { return a.value < b.value; });
    lowest.resize(std::min(lowest.size(), count));
    bool is_complete = true;
    for (std::size_t c = 0; c < area.size(); ++c) {
      // The component has no more eigenvalues, or no more that can matter.
      if (asked[c] == count || spectra[c].size() < asked[c]) continue;
      if (lowest.size() == count && spectra[c].back() >= lowest.back().value) continue;
      ask(c, 2 * asked[c]);
      is_complete = false;
    }
    if (is_complete) return lowest;
  }
}

std::vector<double> joint_spectrum(std::span<const IntrinsicSurface> components, std::size_t count,
                                   const CancelToken& cancel) {
  std::vector<double> area;
  for (const IntrinsicSurface& component : components) area.push_back(area_of(component));
  std::vector<double> values;
  for (const JointEigenvalue& found : joint_eigenvalues(area, count, [&](std::size_t c, std::size_t n) {
         return laplacian_spectrum(components[c], n, cancel);
       }))
    values.push_back(found.value);
  return values;
}

}  // namespace meander
