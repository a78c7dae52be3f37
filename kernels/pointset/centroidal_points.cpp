#include <array>
#include <cmath>
#include <limits>

#include "kernels/core/parallel.h"
#include "kernels/pointset/bucket_grid.h"
#include "kernels/pointset/iterative_points.h"

namespace meander {

namespace {

struct Corner {
  double x, y;
};

// A convex polygon round a point, coordinates relative to it.
struct Cell {
  std::vector<Corner> corners, spare;

  // Keeps the part that is nearer to the origin than to (dx, dy).
  void clip(double dx, double dy) {
    const double limit = 0.5 * (dx * dx + dy * dy);
    spare.clear();
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Corner& from = corners[i];
      const Corner& to = corners[i + 1 == corners.size() ? 0 : i + 1];
      const double d0 = limit - (dx * from.x + dy * from.y), d1 = limit - (dx * to.x + dy * to.y);
      if (d0 >= 0) spare.push_back(from);
      if ((d0 > 0 && d1 < 0) || (d0 < 0 && d1 > 0)) {
        const double t = d0 / (d0 - d1);
        spare.push_back({from.x + t * (to.x - from.x), from.y + t * (to.y - from.y)});
      }
    }
    corners.swap(spare);
  }
  double reach_squared() const {
    double most = 0;
    for (const Corner& c : corners) most = std::max(most, c.x * c.x + c.y * c.y);
    return most;
  }
  Corner centroid() const {
    double area = 0, x = 0, y = 0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Corner& a = corners[i];
      const Corner& b = corners[i + 1 == corners.size() ? 0 : i + 1];
      const double doubled = a.x * b.y - b.x * a.y;
      area += doubled;
      x += doubled * (a.x + b.x);
      y += doubled * (a.y + b.y);
    }
    if (!(area > 0)) return {0, 0};
    return {x / (3 * area), y / (3 * area)};
  }
};

// Clips by the points of the grid in rings of cells round the point's own until no further one can matter:
// a bisector cuts only if its point is nearer than twice the farthest corner.
void voronoi_cell(const BucketGrid& grid, std::span<const double> x, std::span<const double> y,
                  std::uint32_t i, Cell& cell) {
  const double px = x[i], py = y[i];
  cell.corners.assign({{-px, -py}, {1 - px, -py}, {1 - px, 1 - py}, {-px, 1 - py}});
  const auto side = static_cast<std::int64_t>(grid.side);
  const std::int64_t cx = grid.cell_of(px), cy = grid.cell_of(py);
  const double width = 1.0 / static_cast<double>(grid.side);
  for (std::int64_t ring = 0; ring < side; ++ring) {
    const double nearest = static_cast<double>(ring - 1) * width;  // at least, of any point of this ring
    if (ring > 1 && nearest * nearest > 4 * cell.reach_squared()) break;
    for (std::int64_t v = std::max<std::int64_t>(0, cy - ring); v <= std::min(side - 1, cy + ring); ++v) {
      const bool edge = v == cy - ring || v == cy + ring;
      for (std::int64_t u = cx - ring; u <= cx + ring; u += edge || ring == 0 ? 1 : 2 * ring) {
        if (u < 0 || u >= side) continue;
        const auto at = static_cast<std::size_t>(u + side * v);
        for (std::uint32_t k = grid.begin[at]; k < grid.begin[at + 1]; ++k) {
          const std::uint32_t j = grid.points[k];
          const double dx = x[j] - px, dy = y[j] - py;
          if (j != i && (dx != 0 || dy != 0)) cell.clip(dx, dy);
        }
      }
    }
  }
}

}  // namespace

PlanarPoints centroidal_points(PlanarPoints points, std::uint32_t iterations) {
  const auto count = static_cast<std::uint32_t>(points.count());
  PlanarPoints moved = points;
  for (std::uint32_t iteration = 0; iteration < iterations; ++iteration) {
    const BucketGrid grid =
        bucket_points(points.x, points.y, static_cast<std::uint32_t>(std::sqrt(0.5 * count)));
    const std::size_t blocks = (count + 255) / 256;
    parallel_tasks(blocks, [&](std::size_t block) {
      Cell cell;
      const auto end = static_cast<std::uint32_t>(std::min<std::size_t>(count, 256 * (block + 1)));
      for (auto i = static_cast<std::uint32_t>(256 * block); i < end; ++i) {
        voronoi_cell(grid, points.x, points.y, i, cell);
        const Corner centroid = cell.centroid();
        moved.x[i] = std::clamp(points.x[i] + centroid.x, 0.0, 1 - 0x1p-53);
        moved.y[i] = std::clamp(points.y[i] + centroid.y, 0.0, 1 - 0x1p-53);
      }
    });
    std::swap(points, moved);
  }
  return points;
}

}  // namespace meander
