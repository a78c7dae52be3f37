// Places along the bisections of wide pieces, which are elements as wholes (docs/METHODS.md 6.8).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "kernels/density/pieces.h"
#include "kernels/mesh/measured_mesh.h"
#include "kernels/partition/elements.h"

namespace meander {

// How often an element that has a place is bisected for its parts to weigh at most elements.limit; 0 if it is
// no wide piece.
int bisections_of(const MeasuredMesh& surface, const CurveElements& elements, std::size_t element);

// A path through the parts of a wide piece, all of which weigh the same. The piece has a place that the path
// comes from, the centroid of the element before it, and one that it goes to, that of the element after it.
// The half comes first for which the sum of squared distances, from the first place to it and from the other
// half to the second place, is smaller; a half is then where the path of the other one
// comes from or goes to, and so on. Wide pieces are plain ones, of uniform density in space.
class BisectionWalk {
 public:
  // The mesh and the elements must outlive it.
  BisectionWalk(const MeasuredMesh& surface, const CurveElements& elements)
      : surface_(surface), elements_(elements) {}

  struct Part {
    std::uint32_t path;
    Piece weights;
  };
  // The part of the element, of at most elements.limit, that is reached after a share in [0, 1) of its mass;
  // the element itself if it is no wide piece. O(bisections) at first, and of the same element those that are
  // not in common with the last path: fastest for places that follow each other. Valid until the next call.
  const Part& part_at(std::size_t element, double share);

 private:
  struct Place {
    WorkPiece piece;
    Vector3 from, to;
  };
  void enter(std::size_t element);
  Vector3 place_of(std::size_t element) const;

  MeasuredMesh surface_;
  const CurveElements& elements_;
  std::array<Place, most_bisections + 1> held_;  // by bisections of the element
  std::size_t element_ = ~std::size_t{0};
  int bisections_ = 0;        // of the element, in all
  std::uint32_t number_ = 0;  // of the last part, in the order of the path
  Part part_{};
};

}  // namespace meander
