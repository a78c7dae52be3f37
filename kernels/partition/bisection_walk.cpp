#include "kernels/partition/bisection_walk.h"

#include <algorithm>
#include <bit>

namespace meander {

int bisections_of(const MeasuredMesh& surface, const CurveElements& elements, std::size_t element) {
  const std::uint32_t path = elements.path[element];
  double mass = surface.mesh().area[elements.triangle[element]] * share_after(std::bit_width(path) - 1);
  return bisections_to(path, elements.limit, mass);
}

Vector3 BisectionWalk::place_of(std::size_t element) const {
  const float* const at = &elements_.place[3 * element];
  return {at[0], at[1], at[2]};
}

void BisectionWalk::enter(std::size_t element) {
  const std::uint32_t triangle = elements_.triangle[element], path = elements_.path[element];
  element_ = element;
  bisections_ = bisections_of(surface_, elements_, element);
  const WorkPiece whole = followed(whole_triangle(bisection_corners(surface_, triangle)), path);
  if (bisections_ == 0) {
    part_ = {path, whole.weights};
    return;
  }
  held_[0] = {whole, place_of(element > 0 ? element - 1 : element),
              place_of(element + 1 < elements_.count() ? element + 1 : element)};
}

const BisectionWalk::Part& BisectionWalk::part_at(std::size_t element, double share) {
  const bool entered = element != element_;
  if (entered) enter(element);
  if (bisections_ == 0) return part_;
  const std::uint32_t parts = 1u << bisections_;
  const std::uint32_t number = std::min(static_cast<std::uint32_t>(share * parts), parts - 1);
  // The halves of a piece are held if they have been told apart by the last path.
  const auto differing = static_cast<int>(std::bit_width(number ^ number_));
  const int common = entered ? 0 : std::min(bisections_ - differing, bisections_ - 1);
  number_ = number;
  for (int level = common; level < bisections_; ++level) {
    const Place& now = held_[static_cast<std::size_t>(level)];
    at_longest_edge(now.piece, [&](auto edge) {
      // From the centroid of the piece to that of its first half it is a sixth of this edge.
      const Vector3 way = way_to_first_half(now.piece, edge);
      const bool second_first = dot(way, now.to - now.from) > 0;
      const bool goes_on = (number >> (bisections_ - 1 - level) & 1u) != 0;  // to the half that comes later
      const bool second = goes_on != second_first;
      if (level + 1 == bisections_) {
        part_.path = now.piece.path << 1 | (second ? 1u : 0u);
        part_.weights = half_of<edge>(now.piece.weights, second);
        return;
      }
      Place& half = held_[static_cast<std::size_t>(level) + 1];
      take_half<edge>(now.piece, second, half.piece);
      const Vector3 other = centroid(now.piece.corner) + (second ? 1.0 : -1.0) * way;
      half.from = goes_on ? other : now.from;
      half.to = goes_on ? now.to : other;
    });
  }
  return part_;
}

}  // namespace meander
