#include "kernels/partition/element_cells.h"

#include <bit>
#include <cmath>
#include <optional>
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

namespace {

// The pieces of a part and the normals of the surface, as cells are cut: about random axes for
// ElementUse::places, as fixed axes would prefer the same parts of the surface for every seed
// (docs/METHODS.md 7.5).
struct CellPieces {
  PlacedPieces pieces;
  std::vector<float> turned_normal;  // empty where nothing is turned
  Rotation rotation;

  CellPieces(const ElementSource& source, const SurfacePart& part, ElementUse use, double limit,
             const KeptOfPieces& kept)
      : pieces(
            cut_source(source, part, limit, [&] { return PlacedPieces(source.places, source.key, kept); })) {
    check_elements(pieces.point.size(), most_balanced_elements);
    source.cancel.check();
    if (use != ElementUse::places) return;
    turned_normal = source.normal;
    rotation = random_axes(source.key, source.places.any());
    turn_axes(rotation, pieces, turned_normal);
    is_turned_ = true;
  }

  Vector3 turned(const Vector3& at) const { return is_turned_ ? shrink * rotated(rotation, at) : at; }
  ElementTraits traits(const ElementSource& source) const {
    return {pieces.triangle,
            {pieces.split_piece, pieces.split},
            is_turned_ ? turned_normal : source.normal,
            source.group};
  }
  ElementCells with(BalancedCells cells) {
    return {std::move(cells), std::move(pieces.triangle), std::move(pieces.path), std::move(pieces.vertex)};
  }

 private:
  bool is_turned_ = false;
};

// Cells that are cut exactly out of triangles; nullopt where they would keep too many polygons.
std::optional<ElementCells> exact_cells(const ElementSource& source, const SurfacePart& part,
                                        ElementUse use) {
  // Triangles that will be clipped need no cutting.
  CellPieces cut(source, part, use, INFINITY, {.corners = true});
  ExactTriangles exact;
  exact.corners = [&](std::uint32_t e) {
    std::array<Vector3, 3> corner = corners_of(cut.pieces, source.surface.mesh(), e);
    for (Vector3& at : corner) at = cut.turned(at);
    return corner;
  };
  exact.key = source.key;
  exact.first_cell = part.first_cell;
  if (use == ElementUse::places)
    exact.max_polygons = static_cast<std::uint64_t>(
        most_kept_polygons(static_cast<double>(cut.pieces.point.size()), static_cast<double>(part.cells)));
  std::optional<BalancedCells> cells = exact_order(cut.pieces.point, static_cast<std::uint32_t>(part.cells),
                                                   cut.traits(source), exact, source.cancel);
  if (!cells) return std::nullopt;
  return cut.with(*std::move(cells));
}

}  // namespace

ElementCells cells_from(const ElementSource& source, const SurfacePart& part,
                        const ElementParameters& parameters) {
  const ElementUse use = parameters.use;
  const bool in_space = source.hints.hits.empty() && !source.places.any() && source.surface.in_space();
  const CellForm form = cell_form(parameters, in_space, source.density().uniform());
  // Polygons have weights of whole triangles, which the pieces of regions are not.
  const bool keeps_polygons_of_region = use == ElementUse::places && part.region != nullptr;
  if (form == CellForm::exact && part.cells == part.strata && !keeps_polygons_of_region &&
      has_few_triangles(source, part.region, part.cells))
    if (std::optional<ElementCells> cells = exact_cells(source, part, use)) return *std::move(cells);
  const bool splits = form != CellForm::whole;
  CellPieces cut(source, part, use, splits ? part.limit * split_parts : part.limit,
                 {.vertices = use == ElementUse::vertices, .split_limit = splits ? part.limit : 0});
  const ElementTraits traits = cut.traits(source);
  return cut.with(balanced_order(std::move(cut.pieces.point), static_cast<std::uint32_t>(part.cells), traits,
                                 source.cancel, part.strata));
}

ElementCells build_cells(const SurfaceContext& context, const ElementParameters& parameters) {
  return cells_from(ElementSource(context, ElementOrder::balanced),
                    {.limit = element_limit(context.measure, parameters),
                     .cells = parameters.samples,
                     .strata = parameters.samples},
                    parameters);
}

double cell_bytes(const OrderSizes& sizes, const ElementParameters& parameters, double samples,
                  double triangles, double per_sample) {
  // Pieces, two arrays of items; leaves, nodes, their path and cells.
  constexpr double bytes_per_piece = 110, bytes_per_sample = 230;
  // Where pieces may be split: all pieces, what those that are split have beside it, and entries of cells
  // while they grow.
  constexpr double bytes_per_splittable_piece = 90, bytes_per_split = 70, bytes_per_entry = 30;
  // Clipped triangles: pieces, polygons and lists of these, with room for a whole tree. Large nodes have
  // less, but hold them twice while their halves are copied; most of the triangles may be in one of them.
  constexpr double bytes_per_clipped_piece = 750, samples_of_copied_nodes = 4096,
                   bytes_per_copied_piece = 430;
  // Polygons that cells keep, with their corners; those of cells that are still cut are in vectors that grow.
  constexpr double bytes_per_kept_polygon = 64, bytes_per_growing_polygon = 96, bytes_per_kept_cell = 72;
  // A block of small cells has its own arrays of items, by pieces and by entries.
  constexpr double samples_per_block = 64, bytes_per_block_item = 50;

  const double count = elements_at_most(sizes, samples, triangles, per_sample);
  const CellForm form = cell_form(parameters, sizes.in_space, sizes.uniform);
  if (form == CellForm::whole) return count * bytes_per_piece + samples * bytes_per_sample;
  // Whether cells are cut exactly is known once the areas are, and where polygons are kept, their number.
  // Triangles may be fewer than estimated, and then be clipped.
  double exact = 0;
  if (form == CellForm::exact) {
    const double clipped = std::min(triangles, most_clipped_triangles(samples, sizes.in_regions));
    exact = clipped *
                (bytes_per_clipped_piece + (samples < samples_of_copied_nodes ? 0 : bytes_per_copied_piece)) +
            samples * bytes_per_sample;
    if (parameters.use == ElementUse::places) {
      const double growing = std::min(1.0, sizes.threads * samples_of_copied_nodes / samples);
      exact += most_kept_polygons(clipped, samples) *
                   (bytes_per_kept_polygon + growing * bytes_per_growing_polygon) +
               samples * bytes_per_kept_cell;
    } else if (triangles <= most_typical_triangles * samples) {
      return exact;
    }
  }
  const double pieces = triangles + (count - triangles) / split_parts;
  // No more pieces than this weigh more than a part may.
  const double splits = per_sample > 0 ? std::min(pieces, per_sample * samples) : pieces;
  const double in_blocks = std::min(1.0, sizes.threads * samples_per_block / samples);
  // Nearly all triangles may be in one block: those of a scan beside a few large ones, as its floor. Both
  // sizes of blocks then hold them, in part where the mesh was prepared.
  const double in_one_block =
      per_sample > 0 ? std::max(0.0, 2 * sizes.triangles * bytes_per_block_item - sizes.freed_bytes) : 0;
  return std::max(exact, pieces * bytes_per_splittable_piece + splits * bytes_per_split +
                             count * bytes_per_entry + in_blocks * (pieces + count) * bytes_per_block_item +
                             samples * bytes_per_sample + in_one_block);
}

}  // namespace meander
