// The lowest eigenvalues of the Laplacian of a surface.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <stdexcept>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/solve/intrinsic_disk.h"

namespace meander {

// Thrown where iterations do not converge, as for a component with one vertex a million times as far away as
// the others.
class SpectrumNotFound : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// The lowest `count` eigenvalues of the Laplacian of a connected surface, ascending, without the zero of the
// constant function; fewer where there are fewer than count + 1 vertices. At boundaries the normal derivative
// is 0 (Neumann). Unit: 1 / length^2.
//
// Linear finite elements: K x = lambda M x with the cotangent Laplacian K. The consistent mass matrix makes
// eigenvalues too large and the lumped one too small, at the same order of the edge length; M is the mean of
// both, in which the errors cancel (Goudreau and Taylor 1972, "Evaluation of numerical integration methods in
// elastodynamics": exactly so on regular grids). docs/RETRIEVAL.md has the errors of the first 40.
//
// Shift and invert with sparse Cholesky factors and restarted Lanczos iterations (Spectra; Sorensen 1992);
// small surfaces by dense matrices. Surfaces of few vertices and multiple eigenvalues are handled.
//
// The triangles should be those of make_intrinsic_delaunay, the lengths mollified. O(V^1.5 + count V) time.
// Deterministic. Throws SpectrumNotFound when the iterations do not converge, ItemError(internal) when the
// matrix cannot be factorized, and timeout / RunCanceled from `cancel`.
std::vector<double> laplacian_spectrum(const IntrinsicSurface& surface, std::size_t count,
                                       const CancelToken& cancel = {});

// The same with their eigenfunctions.
struct LaplacianModes {
  std::vector<double> values;                  // ascending
  std::vector<std::vector<double>> functions;  // one an eigenvalue: of the V vertices, in no unit
};
// Cost and errors as above, and `count` V numbers of memory. Of a multiple eigenvalue the functions span the
// eigenspace.
LaplacianModes laplacian_modes(const IntrinsicSurface& surface, std::size_t count,
                               const CancelToken& cancel = {});

// The area by edge lengths. O(T).
double area_of(const IntrinsicSurface& surface);

// The lowest `count` positive eigenvalues of a surface of several components, ascending: those of all
// components together, without the zero of each. A component is asked for the number expected by its share of
// the area (Weyl 1911: the number below lambda is area lambda / (4 pi) to first order), and for twice as many
// while its largest is among the lowest of all. Throws as laplacian_spectrum.
std::vector<double> joint_spectrum(std::span<const IntrinsicSurface> components, std::size_t count,
                                   const CancelToken& cancel = {});

// The same by what find(component, n) returns, the lowest n positive eigenvalues of a component, ascending;
// it is called again for a component with a larger n. area: of the components.
struct JointEigenvalue {
  double value = 0;
  std::uint32_t component = 0;
  std::size_t number = 0;  // among those of the component, from 0
};
std::vector<JointEigenvalue> joint_eigenvalues(
    std::span<const double> area, std::size_t count,
    const std::function<std::vector<double>(std::size_t component, std::size_t n)>& find);

}  // namespace meander
