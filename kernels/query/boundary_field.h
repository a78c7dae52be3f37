// How the winding number of a surface with a boundary changes from place to place.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "kernels/core/instruction_set.h"
#include "kernels/core/vector3.h"

namespace meander {

// Open edges of a surface, four at a time: those of a block lie near each other, and count as one piece of a
// current from afar.
struct BoundaryField {
  static constexpr std::size_t lanes = 4;
  struct alignas(16) Edges {
    // Coordinates of start and end; how often they count, 0 where there is no edge; the length times that.
    std::array<std::array<double, lanes>, 6> end;
    std::array<double, lanes> times, length;
  };
  struct alignas(16) Blocks {
    // The middle, from which distance on they are far, squared, the current and the length.
    std::array<std::array<double, lanes>, 3> center, current;
    std::array<double, lanes> radius, far, length;
  };
  static constexpr std::size_t edges_in_block = 4;  // of four
  std::vector<Edges> edges;                         // edges_in_block of each block
  std::vector<Blocks> blocks;
};

// boundary: seven numbers for each edge, its start, its end and how much more often triangles pass it from
// start to end than the other way (OrientedSurface).
BoundaryField build_boundary_field(std::span<const double> boundary);

// Upper bound of its bytes while it is made.
constexpr double boundary_field_bytes(double edges) { return 150 * edges + 4096; }

// Where no triangle is crossed the winding number changes by the gradient times the way.
struct WindingChange {
  Vector3 gradient;
  double radius = 0;  // within it the change differs from that by less than the tolerance
};

// The gradient of the winding number, which is the field of a current along the edges (Biot and Savart;
// Maxwell 1873: a magnetic shell). Second derivatives of an edge of length l at the distance d are at most l
// / (2 pi d^3), and 1 / (pi d^2); the radius follows from their sum. Up to 5 ns for each edge that is near,
// and for each block of 16. The same with every instruction set.
WindingChange winding_change(const BoundaryField& field, Vector3 point, double tolerance,
                             InstructionSet set = InstructionSet::automatic);

}  // namespace meander
