#include "kernels/sample/surface_points.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

#include "kernels/core/parallel.h"
#include "kernels/density/pieces.h"
#include "kernels/mesh/surface_walk.h"

namespace meander {

namespace {

// In spacings: the longest edge of a piece, and the cells in which light pieces are put together.
constexpr double piece_edge = 0.9, bin_edge = 0.5;
// In units of mass: lighter pieces are not divided; lighter ones are put together.
constexpr double min_mass = 1.0 / 64, light_mass = 1.0 / 32;
// Of cells, in working units: their numbers are 32 bits long.
constexpr double min_edge = 0x1p-29;

// What light pieces add up to, by their cell, the way that they face, and the scale of their spacing.
struct Bin {
  std::array<std::int32_t, 3> cell{};
  std::int32_t kind = 0;
  double mass = 0;  // 0: free
  Vector3 sum, normal;
};

class Bins {
 public:
  void add(const std::array<std::int32_t, 3>& cell, std::int32_t kind, double mass, const Vector3& at,
           const Vector3& normal) {
    std::size_t slot = slot_of(cell, kind);
    if (bins_[slot].mass == 0) {
      if (2 * ++used_ > bins_.size()) {
        grow();
        slot = slot_of(cell, kind);
      }
      bins_[slot].cell = cell;
      bins_[slot].kind = kind;
    }
    Bin& bin = bins_[slot];
    bin.mass += mass;
    bin.sum = bin.sum + mass * at;
    bin.normal = bin.normal + mass * normal;
  }
  // In the order of their slots, which follows from what was added.
  std::vector<Bin> take() {
    std::erase_if(bins_, [](const Bin& bin) { return bin.mass == 0; });
    return std::move(bins_);
  }

 private:
  std::size_t slot_of(const std::array<std::int32_t, 3>& cell, std::int32_t kind) const {
    std::uint64_t hash = static_cast<std::uint32_t>(kind);
    for (const std::int32_t c : cell) hash = (hash ^ static_cast<std::uint32_t>(c)) * 0x9E3779B97F4A7C15u;
    std::size_t slot = (hash ^ hash >> 32) & (bins_.size() - 1);
    while (bins_[slot].mass > 0 && (bins_[slot].cell != cell || bins_[slot].kind != kind))
      slot = (slot + 1) & (bins_.size() - 1);
    return slot;
  }
  void grow() {
    std::vector<Bin> old(2 * bins_.size());
    old.swap(bins_);
    for (const Bin& bin : old)
      if (bin.mass > 0) bins_[slot_of(bin.cell, bin.kind)] = bin;
  }

  std::vector<Bin> bins_ = std::vector<Bin>(1024);
  std::size_t used_ = 0;
};

// The axis that a normal is nearest to, and its sign.
std::int32_t side_of(const Vector3& n) {
  const double x = std::abs(n.x), y = std::abs(n.y), z = std::abs(n.z);
  const std::int32_t axis = x >= y ? (x >= z ? 0 : 2) : (y >= z ? 1 : 2);
  return 2 * axis + ((axis == 0 ? n.x : axis == 1 ? n.y : n.z) < 0 ? 1 : 0);
}

class SurfacePoints {
 public:
  SurfacePoints(const PreparedMesh& mesh, const Density& density, double unit, const Vector3& origin)
      : mesh_(mesh), density_(density), unit_(unit), origin_(origin) {}

  SurfaceRows make(const CancelToken& cancel) {
    for (std::uint32_t t = 0; t < mesh_.triangle_count(); ++t) {
      if (t % sum_block == 0) cancel.check();
      if (mesh_.area[t] > 0) add_triangle(t);
    }
    for (const Bin& bin : bins_.take())
      add_point((1 / bin.mass) * bin.sum, (1 / bin.mass) * bin.normal, bin.mass);
    SurfaceRows rows;
    rows.resize(points_.size());
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const Point& p = points_[i];
      rows.x[i] = p[0];
      rows.y[i] = p[1];
      rows.z[i] = p[2];
      rows.mass[i] = p[3];
      rows.normal_x[i] = p[4];
      rows.normal_y[i] = p[5];
      rows.normal_z[i] = p[6];
    }
    return rows;
  }

 private:
  using Point = std::array<float, 7>;

  void add_point(const Vector3& at, const Vector3& normal, double mass) {
    const Vector3 p = at - origin_;
    points_.push_back({static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z),
                       static_cast<float>(mass), static_cast<float>(normal.x), static_cast<float>(normal.y),
                       static_cast<float>(normal.z)});
  }

  void add_triangle(std::uint32_t triangle) {
    const Vector3 normal = triangle_normal(mesh_, triangle);
    const TriangleSource source = source_of(mesh_, density_, triangle);
    pieces_.assign(1, whole_triangle(source.corner));
    while (!pieces_.empty()) {
      const WorkPiece piece = pieces_.back();
      pieces_.pop_back();
      const auto& [b1, b2] = piece.weights;
      const double density =
          source.uniform ? 1.0 : source.density_at((b1[0] + b1[1] + b1[2]) / 3, (b2[0] + b2[1] + b2[2]) / 3);
      const double mass = mesh_.area[triangle] *
                          share_after(static_cast<int>(std::bit_width(piece.path)) - 1) * density / unit_;
      const double squared_spacing = unit_ / std::max(density, min_density);
      if (mass > min_mass && piece.path < deepest_path &&
          piece.squared_edge[longest_edge(piece)] > piece_edge * piece_edge * squared_spacing) {
        const auto children = bisect(piece);
        pieces_.insert(pieces_.end(), children.rbegin(), children.rend());
        continue;
      }
      if (!(mass > 0)) continue;
      const Vector3 at = (1.0 / 3) * (piece.corner[0] + piece.corner[1] + piece.corner[2]);
      if (mass < light_mass)
        add_light(at, normal, mass, std::sqrt(squared_spacing));
      else
        add_point(at, normal, mass);
    }
  }

  void add_light(const Vector3& at, const Vector3& normal, double mass, double spacing) {
    // Where the density varies, cells are of sizes that are powers of two.
    int exponent = 0;
    double edge = std::max(bin_edge * spacing, min_edge);
    if (!density_.uniform()) edge = std::ldexp(2.0 / 3, (std::frexp(edge, &exponent), exponent));
    const auto cell = [&](double c) { return static_cast<std::int32_t>(std::floor(c / edge)); };
    bins_.add({cell(at.x), cell(at.y), cell(at.z)}, 8 * exponent + side_of(normal), mass, at, normal);
  }

  const PreparedMesh& mesh_;
  const Density& density_;
  double unit_;
  Vector3 origin_;
  std::vector<WorkPiece> pieces_;
  Bins bins_;
  std::vector<Point> points_;
};

}  // namespace

SurfaceRows surface_points(const PreparedMesh& mesh, const Density& density, double unit,
                           const Vector3& origin, const CancelToken& cancel) {
  return SurfacePoints(mesh, density, unit, origin).make(cancel);
}

}  // namespace meander
