// Nodes of balanced bisection that are cut by planes: triangles are clipped to convex polygons, of which
// every part weighs what its area says (docs/METHODS.md 6.5, "Exact cells").
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "kernels/core/vector3.h"
#include "kernels/core/vector_instructions.h"

namespace meander {

// A point of a named triangle, by the weights of its corners 1 and 2.
struct CellPoint {
  std::uint32_t name = 0;
  float first = 0, second = 0;
};

// The triangles of one node and of the nodes below it, which are visited depth first. An object is reused
// from node to node by one thread. Coordinates are those of space but for a small fixed rotation, so that
// faces across a coordinate axis are cut like others, and an offset.
class ClippedPieces {
 public:
  using Point = std::array<float, 3>;

  // The polygons of a node: a range of numbers.
  struct List {
    std::size_t first = 0, count = 0;
  };
  // What they are together.
  struct Extent {
    alignas(16) float low[4], high[4];  // their box
    alignas(16) float moment[4];        // twice that of mass, roughly
    double mass = 0;
    std::size_t axis = 0;  // along which they extend farthest
  };
  // Where what is added from here on can be forgotten again.
  struct Mark {
    std::size_t items, polygons;
  };

  // What there is room for: one cut, or a whole tree of them, which holds the polygons of all nodes above
  // one.
  enum class Room { one_cut, tree };
  // Forgets everything. Places are kept relative to `origin`, which should lie near the next ones, of which
  // so many are expected.
  void begin(const Vector3& origin, std::size_t triangles, Room room = Room::tree);
  // Mass, spread evenly over a triangle. O(1).
  void add(const std::array<Vector3, 3>& corner, double mass, std::uint32_t name);
  // What has been added since begin().
  List all() const { return {0, item_.size()}; }
  // A list of another object; begins with it.
  void take(const ClippedPieces& other, List list, Room room);

  Mark mark() const { return {item_.size(), polygon_.size()}; }
  void release(const Mark& mark) {
    item_.resize(mark.items);
    polygon_.resize(mark.polygons);
  }

  // O(P).
  Extent extent_of(List list) const;
  // Where their mass lies, roughly; in space.
  Point center(const Extent& extent) const;

  // Both sides of the plane across the axis of the extent that has `target` of the mass below it, to 2^-14 of
  // a `cell`'s mass times the root of the number of cells; the rest of the mass is taken from the polygons
  // next to the plane. Where there is no room in a tree for what the plane would part, it parts nothing. The
  // list
  // itself must not be used any more. O(P), and O(P log P) where mass goes over.
  std::pair<List, List> cut(List list, const Extent& extent, double target, double cell);
  // A polygon: the mean of its corners, in space, and these by their weights.
  struct Part {
    std::uint32_t name;
    double mass;
    Point at;
    std::span<const float> first, second;
  };
  // visit(part) for every one. O(P).
  template <class Visit>
  void visit(List list, const Visit& visit) const;
  // Those that `is_second(place, name)` selects, behind the others. The list itself must not be used any
  // more.
  template <class IsSecond>
  std::pair<List, List> part(List list, const IsSecond& is_second);
  // Both in one. O(P).
  List joined(List first, List second);

  // Calls visit(place, triangle) for one place in each of `probes` equal shares of the mass. Places are those
  // of part(). O(P).
  template <class Visit>
  void probe(List list, double mass, std::size_t probes, const Visit& visit) const;
  // A direction of space as it is here.
  static Point turned(const Point& direction);

  // The plane across that axis with `share` of the mass below it, to 2^-12 unless that lies in a face along
  // the plane, cuts the polygons in a cross-section; returns the axis along which it extends farthest. It is
  // forgotten with the next one. O(P log P).
  std::size_t cross(List list, const Extent& extent, double share);
  // The point of the cross-section with that share of it below, by the mass that it sweeps over. Shares that
  // are uniform give points that are distributed by mass. `spare`: another number in [0, 1), for a
  // cross-section that meets nothing, whose point lies in the polygon next to it.
  CellPoint point(double share, double spare) const;

 private:
  // A triangle clipped by planes of three directions has no more than 9 corners, but for rounding.
  static constexpr std::uint32_t most_corners = 12;

  // What a polygon is from outside.
  struct Item {
    float low[3];  // its box
    std::uint32_t name;
    float high[3];
    std::uint32_t polygon;
    double mass;
  };
  // Corners by their weights in the triangle, the first one again behind the last, so that lanes need no
  // mask.
  struct Polygon {
    float first[most_corners + 4], second[most_corners + 4];
    float corner[4], edge[2][4];  // of the triangle: corner 0; from it to corners 1 and 2
    float area;                   // of weights
    float density;                // mass over it
    std::uint32_t corners;
    Polygon() {}  // leaves them as they are
  };
  // A polygon in a cross-section.
  struct Segment {
    std::uint32_t name;
    float end[2][2];    // weights
    float place[2][2];  // along the other axes
    double rate;        // mass swept over
  };

  // Nodes without it are those of soups of long thin triangles, which many planes part again and again.
  bool has_room_to_clip(List list) const;
  void close(Polygon& polygon, Item& item) const;
  static float area_of(const Polygon& polygon);
  static __m128 below(const Polygon& polygon, std::size_t axis, float at);
  void lay_out(List list, const Extent& extent);
  float plane(List list, const Extent& extent, double target, double cell, double near);
  bool clip(Item& item, std::size_t axis, float at, Item& above);
  void even_out(List& from, List& to, bool upwards, std::size_t axis, float at, double amount,
                double tolerance);
  Point place_of(const Item& item) const;
  // scale * at, in space.
  Point in_space(const Point& at, double scale) const;
  static std::array<float, 2> probe_weights(const Polygon& polygon, std::size_t number);
  static std::array<float, 2> weights_in(const Polygon& polygon, double first, double second);
  static Point place_at(const Polygon& polygon, const std::array<float, 2>& weights);

  Vector3 origin_;
  Room room_ = Room::tree;
  std::vector<Item> item_;
  std::vector<Polygon> polygon_;
  std::vector<float> from_, density_, mass_;  // by item of a list, along an axis: as if it were a ramp
  std::vector<Segment> section_;
  Item nearest_{};  // to a section that meets nothing
};

template <class IsSecond>
std::pair<ClippedPieces::List, ClippedPieces::List> ClippedPieces::part(List list,
                                                                        const IsSecond& is_second) {
  const auto begin = item_.begin() + static_cast<std::ptrdiff_t>(list.first);
  const auto middle =
      std::stable_partition(begin, begin + static_cast<std::ptrdiff_t>(list.count),
                            [&](const Item& item) { return !is_second(place_of(item), item.name); });
  const auto count = static_cast<std::size_t>(middle - begin);
  return {{list.first, count}, {list.first + count, list.count - count}};
}

template <class Visit>
void ClippedPieces::visit(List list, const Visit& visit) const {
  for (std::size_t i = 0; i < list.count; ++i) {
    const Item& item = item_[list.first + i];
    const Polygon& polygon = polygon_[item.polygon];
    visit(Part{item.name,
               item.mass,
               in_space(place_of(item), 1),
               {polygon.first, polygon.corners},
               {polygon.second, polygon.corners}});
  }
}

template <class Visit>
void ClippedPieces::probe(List list, double mass, std::size_t probes, const Visit& visit) const {
  double below = 0;
  std::size_t i = 0;
  for (std::size_t p = 0; p < probes; ++p) {
    // Anywhere in its share: sides may alternate.
    const double within = static_cast<double>(static_cast<std::uint32_t>(p + 1) * 2654435761u >> 7) * 0x1p-25;
    const double target = (static_cast<double>(p) + within) / static_cast<double>(probes) * mass;
    while (i + 1 < list.count && below + item_[list.first + i].mass <= target)
      below += item_[list.first + i++].mass;
    const Item& item = item_[list.first + i];
    const Polygon& polygon = polygon_[item.polygon];
    visit(place_at(polygon, probe_weights(polygon, p)), item.name);
  }
}

}  // namespace meander
