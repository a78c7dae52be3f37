#include "kernels/query/open_holes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace meander {

namespace {

// Triangles of a hole from which on it has a tree, and holes near a point from which on its side is in doubt.
constexpr std::size_t large_hole = 8, max_holes = 64;
constexpr double cone_bound = 0.25;  // of errors; on cones they err by 500 times less

}  // namespace

OpenHoles::Own::Own(const ClosingCones& cones, std::span<const std::uint32_t> triangles)
    : tree(build_triangle_tree(cones.x, cones.y, cones.z, triangles)),
      winding(build_winding_tree(tree, {}, cone_bound)) {}

OpenHoles::OpenHoles(const OrientedSurface& oriented, std::size_t triangles) {
  if (oriented.open_edges == 0 || oriented.open_edges > max_open_edges * static_cast<double>(triangles))
    return;
  cones_ = closing_cones(oriented.boundary);
  all_.emplace(cones_, cones_.triangles);
  own_.resize(cones_.holes());
  std::vector<double> low, high;
  for (std::size_t h = 0; h < cones_.holes(); ++h) {
    if (triangles_of(h).size() > 3 * large_hole) own_[h] = std::make_unique<Own>(cones_, triangles_of(h));
    reach_.push_back(reach_of(h));
    for (const double x : {tip(h).x, tip(h).y, tip(h).z}) {
      low.push_back(x - reach_[h]);
      high.push_back(x + reach_[h]);
    }
  }
  near_ = build_bounds_tree(low, high);
}

bool OpenHoles::agree(Vector3 at, double winding) const {
  if (near_.count() == 0) return true;
  const double point[3] = {at.x, at.y, at.z};
  std::array<std::uint32_t, max_holes> near;
  std::size_t count = 0;
  const bool all = visit_near(near_, point, point, [&](std::uint32_t h) {
    if (distance(at, tip(h)) > reach_[h]) return true;
    if (count == near.size()) return false;
    near[count++] = h;
    return true;
  });
  if (!all) return false;
  if (count < 2) return true;
  // The winding number with all cones, and the least and the largest one where any of the holes are closed on
  // the other side of the point.
  const double closed = std::round(winding + winding_number(all_->winding, at));
  double low = closed, high = closed;
  for (std::size_t k = 0; k < count; ++k) {
    const double share = share_of(near[k], at);
    if (share >= doubtful_share) --low;
    if (share <= -doubtful_share) ++high;
  }
  const bool inside = std::abs(winding) >= 0.5;
  return inside ? low > 0 || high < 0 : low == 0 && high == 0;
}

std::span<const std::uint32_t> OpenHoles::triangles_of(std::size_t h) const {
  const std::size_t begin = cones_.hole_begin[h], end = cones_.hole_begin[h + 1];
  return std::span(cones_.triangles).subspan(3 * begin, 3 * (end - begin));
}

// The share of a cone is at most its area over 4 pi times the squared distance of the ball around it.
double OpenHoles::reach_of(std::size_t h) const {
  double radius = 0, area = 0;
  const std::span<const std::uint32_t> own = triangles_of(h);
  for (std::size_t c = 0; c < own.size(); c += 3) {
    const Vector3 a = corner(own[c]), b = corner(own[c + 1]);
    radius = std::max({radius, distance(tip(h), a), distance(tip(h), b)});
    area += triangle_area(a, b, tip(h));
  }
  return radius + std::sqrt(area / (4 * std::numbers::pi * doubtful_share));
}

double OpenHoles::share_of(std::size_t h, Vector3 at) const {
  return own_[h] ? winding_number(own_[h]->winding, at)
                 : short_winding_number(cones_.x, cones_.y, cones_.z, triangles_of(h), at);
}

}  // namespace meander
