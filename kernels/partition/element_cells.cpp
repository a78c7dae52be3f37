#include "kernels/partition/element_cells.h"

#include <bit>
#include <cmath>
#include <utility>

#include "kernels/core/parallel.h"
#include "kernels/core/portable_functions.h"
#include "kernels/core/rotation.h"
#include "kernels/partition/element_source.h"
#include "kernels/partition/placed_pieces.h"

namespace meander {

namespace {

// Below 1 / sqrt(3): what is turned and shrunk stays in the cube [-1, 1]^3.
constexpr double shrink = 0.577;

// The axes that cells are cut across, over charts in their plane.
Rotation random_axes(RandomKey key, bool in_plane) {
  Rotation rotation = random_rotation(key, Stream::cell_axes);
  const double length = portable::hypot(rotation[0].x, rotation[0].y);
  if (in_plane && length > 0) {
    const double c = rotation[0].x / length, s = rotation[0].y / length;
    rotation = {Vector3{c, -s, 0}, Vector3{s, c, 0}, Vector3{0, 0, 1}};
  }
  return rotation;
}

// Turns everything that cells are cut by, and shrinks it.
void turn_axes(const Rotation& rotation, PlacedPieces& pieces, std::vector<float>& normals) {
  const auto turn = [&](float* v, double scale) {
    const Vector3 turned = scale * rotated(rotation, {v[0], v[1], v[2]});
    v[0] = static_cast<float>(turned.x);
    v[1] = static_cast<float>(turned.y);
    v[2] = static_cast<float>(turned.z);
  };
  parallel_blocks(pieces.point.size(), sum_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) turn(pieces.point[i].at, shrink);
  });
  parallel_blocks(pieces.split.size(), sum_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      for (float* const v : {pieces.split[i].half, pieces.split[i].quarter[0], pieces.split[i].quarter[1]})
        turn(v, shrink);
  });
  parallel_blocks(normals.size() / 3, sum_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) turn(&normals[3 * i], 1);
  });
}

// Corners of a whole triangle in the order of its weights, or of a piece of one.
std::array<Vector3, 3> corners_of(const PlacedPieces& pieces, const PreparedMesh& mesh, std::uint32_t e) {
  std::array<Vector3, 3> corner;
  if (pieces.path[e] == 1) {
    const std::size_t t = 3 * std::size_t{pieces.triangle[e]};
    for (std::size_t k = 0; k < 3; ++k) corner[k] = mesh.position(mesh.triangles[t + k]);
    return corner;
  }
  for (std::size_t k = 0; k < 3; ++k) {
    const float* const at = pieces.corners[e].at[k];
    corner[k] = {at[0], at[1], at[2]};
  }
  return corner;
}

// Whether triangles, or pieces of a region, are few enough for cells to be cut out of them.
bool has_few_triangles(const ElementSource& source, const SurfaceRegion* region, std::uint64_t cells) {
  const std::span<const double> area = source.surface.mesh().area;
  const auto n = static_cast<double>(cells);
  const auto count = static_cast<double>(region != nullptr ? region->piece.size() : area.size());
  if (count > most_clipped_triangles(n, region != nullptr)) return false;
  if (count <= most_typical_triangles * n) return true;
  double roots = 0, total = 0;
  for (const double mass : area) {
    roots += std::sqrt(mass);
    total += mass;
  }
  return roots * roots <= most_typical_triangles * total * n;
}

}  // namespace

std::uint32_t ElementCells::path_of(const CellEntry& entry) const {
  const int bisections = std::bit_width(entry.part()) - 1;
  return path[entry.element()] << bisections | (entry.part() - (1u << bisections));
}

ElementCells cells_from(const ElementSource& source, const SurfaceRegion* region, std::uint64_t cells,
                        std::uint64_t strata, std::uint64_t first_cell, double limit,
                        const ElementParameters& parameters, const CancelToken& cancel) {
  const bool in_space = source.hits.empty() && !source.places.any() && source.surface.in_space();
  const bool is_split = in_space && splits_pieces(parameters, true, source.density.uniform());
  // Triangles that will be clipped need no cutting.
  const bool is_exact = is_split && cells == strata &&
                        cuts_exactly(parameters, true, source.density.uniform()) &&
                        !(parameters.keep_polygons && region != nullptr) &&  // weights are of triangles
                        has_few_triangles(source, region, cells);
  const KeptOfPieces kept{parameters.keep_vertices, is_exact, is_split && !is_exact ? limit : 0};
  const double most = is_exact ? INFINITY : is_split ? limit * split_parts : limit;
  PlacedPieces pieces = cut_source(
      source, region, most, [&] { return PlacedPieces(source.places, source.key, kept); }, cancel);
  check_count(pieces.point.size(), most_balanced_elements);
  cancel.check();
  std::vector<float> turned;
  Rotation rotation;
  if (parameters.random_axes) {
    turned = source.normal;
    rotation = random_axes(source.key, source.places.any());
    turn_axes(rotation, pieces, turned);
  }
  ElementTraits traits{pieces.triangle,
                       {pieces.split_piece, pieces.split},
                       parameters.random_axes ? turned : source.normal,
                       source.group};
  ExactTriangles exact;
  if (is_exact) {
    const auto corners = [&](std::uint32_t e) {
      std::array<Vector3, 3> corner = corners_of(pieces, source.surface.mesh(), e);
      if (parameters.random_axes)
        for (Vector3& at : corner) at = shrink * rotated(rotation, at);
      return corner;
    };
    exact = {corners, source.key, first_cell};
    if (parameters.keep_polygons) {
      exact.keep_polygons = true;
      exact.most_polygons = static_cast<std::uint64_t>(
          most_kept_polygons(static_cast<double>(pieces.point.size()), static_cast<double>(cells)));
    }
    traits.exact = &exact;
  }
  ElementCells result;
  result.cells =
      balanced_order(std::move(pieces.point), static_cast<std::uint32_t>(cells), traits, cancel, strata);
  if (result.cells.cell.empty()) {
    ElementParameters of_elements = parameters;
    of_elements.net_points = of_elements.keep_polygons = false;
    pieces = PlacedPieces(source.places, source.key, {});
    return cells_from(source, region, cells, strata, first_cell, limit, of_elements, cancel);
  }
  result.triangle = std::move(pieces.triangle);
  result.path = std::move(pieces.path);
  result.vertex = std::move(pieces.vertex);
  return result;
}

ElementCells build_cells(const MeasuredMesh& surface, const MeshMeasure& measure, const ChartSet& charts,
                         const TriangleHints& hints, RandomKey key, const ElementParameters& parameters,
                         const CancelToken& cancel) {
  const ElementSource source(surface, measure.density, charts, hints.hits,
                             sheet_groups(surface.mesh(), charts.charts, hints.sheet), ElementOrder::balanced,
                             key);
  return cells_from(source, nullptr, parameters.samples, parameters.samples, 0,
                    element_limit(measure, parameters), parameters, cancel);
}

}  // namespace meander
