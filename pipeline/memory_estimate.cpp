#include "pipeline/memory_estimate.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "io/store/journal_store.h"
#include "kernels/core/portable_functions.h"
#include "kernels/density/density_pieces.h"
#include "kernels/density/formula_density.h"
#include "kernels/describe/heat_geodesics.h"
#include "kernels/describe/shape_dna.h"
#include "kernels/partition/element_cells.h"
#include "kernels/partition/surface_regions.h"
#include "kernels/sample/column_makers.h"
#include "kernels/sample/placed_sites.h"

namespace meander {

namespace {

constexpr double fixed_bytes = 1.0 * 1024 * 1024;  // arrays of a tiny model, one scene
constexpr double bytes_per_file_vertex = 40;       // three doubles, weld table
constexpr double bytes_per_file_triangle = 24;     // corners, offsets
// Texture coordinates for their own sake: of every corner one of its own, while parts are joined; of every
// vertex while an accessor is read.
constexpr double bytes_per_coordinate_triangle = 120, bytes_per_coordinate_vertex = 40;
// Of each number of an attribute that only a column asks for.
constexpr double bytes_per_asked_vertex = 32, bytes_per_attribute_sample = 12;
// Half-edges, slots, positions of half a vertex, areas, scratch.
constexpr double bytes_per_prepared_triangle = 150;
// Without topology: corners, slots, polygon, area, mass; and the working position of every vertex.
constexpr double bytes_per_soup_triangle = 54, bytes_per_soup_vertex = 30;
constexpr double bytes_per_chart_triangle = 180;  // cut, UV, distances
// While a chart is looked for: the best cut with its map, the next cut with its triangulation.
constexpr double bytes_per_tried_triangle = 300;
// Field, metric, steps, a second mesh while segments are cut.
constexpr double bytes_per_tensor_triangle = 450;
constexpr double bytes_per_factor_entry = 12;     // double and index
constexpr double bytes_per_factored_entry = 13;   // factor, or both of an LU, and the stack of updates
constexpr double bytes_per_scene_triangle = 150;  // Embree's buffers and tree
// Conflicts of triangles in a chart that covers itself.
constexpr double bytes_per_conflicting_triangle = 128, bytes_of_few_conflicts = 2.0 * 1024 * 1024;
constexpr double bytes_per_leaf = 64;
constexpr double bytes_per_element = 120;  // element, two sort arrays, result
// Balanced order: pieces, two arrays of items; leaves, nodes, their path and cells. Where pieces may be
// split: all pieces, what those that are split have beside it, and entries of cells while they grow.
constexpr double bytes_per_balanced_piece = 110, bytes_per_balanced_sample = 230;
constexpr double bytes_per_splittable_piece = 90, bytes_per_split = 70, bytes_per_entry = 30;
// Clipped triangles: pieces, polygons and lists of these, with room for a whole tree. Large nodes have less,
// but hold them twice while their halves are copied; most of the triangles may be in one of them.
constexpr double bytes_per_clipped_piece = 750, samples_of_copied_nodes = 4096, bytes_per_copied_piece = 430;
// Polygons that cells keep, with their corners; those of cells that are still cut are in vectors that grow.
constexpr double bytes_per_kept_polygon = 64, bytes_per_growing_polygon = 96, bytes_per_kept_cell = 72;
// A block of the balanced order has its own arrays of items, by pieces and by entries.
constexpr double samples_per_block = 64, bytes_per_block_item = 50;
// What is left of a prepared triangle, and of a working vertex, while the order is made. A vertex of the file
// may be several: one more a triangle, though never more than three of each.
constexpr double bytes_per_held_triangle = 56, bytes_per_held_vertex = 24;
constexpr double most_kept_distances = 1 << 25;     // of a geodesic histogram
constexpr double bytes_per_geodesic_part = 2048;    // small arrays of one component
constexpr double bytes_per_creased_triangle = 270;  // crease normals, their edges and sums
// Spaced samples: boxes, positions, names, cells of the grid, and what is chosen, of all strata and of the
// coarser ones; the places that strata offer; the lists of those around each (up to 192 in stacked sheets).
constexpr double bytes_per_spaced_sample = 250, bytes_per_place = 6, bytes_per_neighbour = 4, neighbours = 60;
constexpr double bytes_per_metric = 60;
constexpr double bytes_per_sample = 160;  // sequence, points twice, row, encoded row
// Large sets, whose surface is put in order region by region: their sites and the row, or the row and its
// encoded form.
constexpr double bytes_per_region_sample = 120;
// The same where the row is made block by block: sites, and hashes of the points or the order in the file;
// more while a sequence is sorted. Blocks that are made and encoded at a time, one a thread.
constexpr double bytes_per_site = 26, bytes_per_sorted_site = 34, bytes_per_vertex_mass = 8;
constexpr double bytes_per_block = 16 << 20, samples_per_written_block = 65536;
constexpr double bytes_per_region_piece = 32;  // in vectors that have grown

// Fill of the Cholesky factor of a planar mesh with n vertices under minimum degree: about 2 n log2 n
// entries.
double factor_entries(double vertices) {
  return 2.0 * vertices * std::max(4.0, portable::log2(vertices + 1));
}

constexpr std::uint64_t program_bytes = 30 << 20;      // measured: 25 MiB, with Embree 27
constexpr std::uint64_t bytes_per_thread = 512 << 10;  // stack, buffers, tables of the compressor
constexpr std::uint64_t bytes_per_item = 1 << 10;      // of the plan, the header and a block of item columns
constexpr std::uint64_t allocator_share =
    16;  // 1/16 of the budget may be free blocks that are not given back

// Heat geodesics and their histogram, without the mesh.
double geodesic_bytes(double triangles, double unknowns, const SampleParameters& parameters, int threads) {
  const double samples = parameters.samples;
  const double sources = parameters.describe.geodesic_sources == 0
                             ? samples
                             : std::min<double>(samples, parameters.describe.geodesic_sources);
  // Two factors, three with a boundary.
  const double factors = 3 * factor_entries(unknowns) * bytes_per_factor_entry +
                         triangles * bytes_per_chart_triangle +
                         std::min(triangles, sources) * bytes_per_geodesic_part;
  const auto vertices = static_cast<std::size_t>(unknowns);
  const double lanes = std::min({static_cast<double>(threads), static_cast<double>(geodesic_lanes(vertices)),
                                 std::ceil(sources / geodesic_batch)});
  return std::min(sources * samples, most_kept_distances) * sizeof(double) + factors +
         lanes * static_cast<double>(geodesic_batch_bytes(vertices));
}

// Shape DNA without the mesh: the surface while it is remeshed; of the remeshed one the factor and a basis of
// about a hundred vectors, of all components at most as many vertices as are allowed.
double shape_dna_bytes(double triangles) {
  constexpr double bytes_per_remeshed_triangle = 120, basis_vectors = 110;
  constexpr double vertices = shape_dna_most_vertices, vertices_per_triangle = 3;  // of soups
  return triangles * bytes_per_remeshed_triangle +
         std::min(vertices, shape_dna_samples + vertices_per_triangle * triangles) *
             (bytes_per_chart_triangle * 2 + basis_vectors * sizeof(double)) +
         factor_entries(std::min(vertices, shape_dna_samples + vertices_per_triangle * triangles)) *
             bytes_per_factor_entry;
}

// Of one sample, while it is placed.
double placed_bytes(const SampleParameters& parameters) {
  const SequenceKind sequence = parameters.sequence;
  if (leaves_sites(parameters))
    return (sequence == SequenceKind::owen || sequence == SequenceKind::random ? bytes_per_sorted_site
                                                                               : bytes_per_site) +
           (parameters.place == PlaceKind::vertex ? bytes_per_vertex_mass : 0.0);
  if (places_in_regions(parameters)) return bytes_per_region_sample;
  if (parameters.sequence != SequenceKind::spaced) return bytes_per_sample;
  const double places = spacing_parameters(parameters.spacing).candidates;
  return bytes_per_sample + bytes_per_spaced_sample + neighbours * bytes_per_neighbour +
         places * bytes_per_place + (method_of(parameters).follows_tensor ? bytes_per_metric : 0.0);
}

}  // namespace

std::uint64_t estimate_bytes(const MeshEstimate& mesh, const SampleParameters& parameters, int threads) {
  const SamplingMethod& method = method_of(parameters);
  const auto triangles = static_cast<double>(mesh.triangles), vertices = static_cast<double>(mesh.vertices);
  const auto samples = static_cast<double>(parameters.samples);
  const std::vector<Descriptor>& descriptors = parameters.describe.descriptors;
  double file = static_cast<double>(mesh.file_bytes + mesh.packed_bytes + mesh.decoding_bytes) +
                vertices * bytes_per_file_vertex + triangles * bytes_per_file_triangle;
  for (const ColumnMaker& maker : column_makers)
    if (parameters.columns[maker.column])
      file += maker.bytes.fixed + vertices * maker.bytes.per_vertex + triangles * maker.bytes.per_triangle +
              samples * maker.bytes.per_sample;
  if (reads_coordinates(parameters))
    file += vertices * bytes_per_coordinate_vertex + triangles * bytes_per_coordinate_triangle;
  for (const AttributeColumn& column : parameters.attributes)
    file += column.width * (vertices * bytes_per_asked_vertex + samples * bytes_per_attribute_sample);
  if (is_in_pieces(parameters.density)) file += piece_density_bytes(triangles);
  // Descriptors of queries find it for themselves.
  const bool topology =
      parameters.topology || std::any_of(descriptors.begin(), descriptors.end(), needs_mesh);
  const double prepared = topology ? triangles * (bytes_per_prepared_triangle +
                                                  (method.follows_tensor ? bytes_per_tensor_triangle : 0.0))
                                   : triangles * bytes_per_soup_triangle + vertices * bytes_per_soup_vertex;
  // Elements weigh half the limit at least, but for needles in a metric.
  const double spread = method.follows_tensor ? 4 : 2;
  double per_sample = elements_per_sample(parameters);
  if (method.makes_charts) per_sample = std::max(per_sample, coarse_elements_per_sample(parameters.samples));
  const bool is_split = order_of(parameters) == ElementOrder::balanced &&
                        splits_pieces(element_parameters(parameters), !method.makes_charts,
                                      parameters.density.kind == DensityKind::uniform);
  // Nearly all triangles may be in one block: those of a scan beside a few large ones, as its floor. Both
  // sizes of blocks then hold them, in part where the mesh was prepared.
  const double held = topology ? triangles * bytes_per_held_triangle +
                                     std::min(3 * triangles, vertices + triangles) * bytes_per_held_vertex
                               : prepared;
  const double in_one_block = std::max(0.0, held + 2 * triangles * bytes_per_block_item - prepared);
  // Of so many samples: for large sets coarse ones, and then those of the regions that are worked on.
  const auto elements_of = [&](double of_samples, double of_triangles, double of_each) {
    const double count = of_triangles + spread * of_each * of_samples;
    if (order_of(parameters) != ElementOrder::balanced) return count * bytes_per_element;
    // Where cells may be cut exactly: whether they are is known once the areas are, and where polygons are
    // kept, their number. Triangles may be fewer than estimated, and then be clipped.
    double exact = 0;
    if (cuts_exactly(element_parameters(parameters), !method.makes_charts,
                     parameters.density.kind == DensityKind::uniform)) {
      const double clipped =
          std::min(of_triangles, most_clipped_triangles(of_samples, places_in_regions(parameters)));
      exact = clipped * (bytes_per_clipped_piece +
                         (of_samples < samples_of_copied_nodes ? 0 : bytes_per_copied_piece)) +
              of_samples * bytes_per_balanced_sample;
      if (element_parameters(parameters).keep_polygons) {
        const double growing = std::min(1.0, threads * samples_of_copied_nodes / of_samples);
        exact += most_kept_polygons(clipped, of_samples) *
                     (bytes_per_kept_polygon + growing * bytes_per_growing_polygon) +
                 of_samples * bytes_per_kept_cell;
      } else if (of_triangles <= most_typical_triangles * of_samples) {
        return exact;
      }
    }
    if (!is_split) return count * bytes_per_balanced_piece + of_samples * bytes_per_balanced_sample;
    const double pieces = of_triangles + (count - of_triangles) / split_parts;
    // No more pieces than this weigh more than a part may.
    const double splits = of_each > 0 ? std::min(pieces, of_each * of_samples) : pieces;
    const double in_blocks = std::min(1.0, threads * samples_per_block / of_samples);
    return std::max(exact, pieces * bytes_per_splittable_piece + splits * bytes_per_split +
                               count * bytes_per_entry + in_blocks * (pieces + count) * bytes_per_block_item +
                               of_samples * bytes_per_balanced_sample + (of_each > 0 ? in_one_block : 0));
  };
  const double blocks = std::min<double>(threads, std::ceil(samples / samples_per_written_block));
  const double shared = std::min(triangles, samples / samples_per_shared_triangle) * sizeof(SharedBySamples);
  const double placed = samples * placed_bytes(parameters) + (places_in_regions(parameters) ? shared : 0.0) +
                        (leaves_sites(parameters) ? blocks * bytes_per_block : 0.0);
  double ordering = 0, placing = 0;  // while the order is made; while samples are placed by it
  if (places_in_regions(parameters)) {
    const auto region = static_cast<double>(samples_per_region(element_parameters(parameters)));
    const double regions = std::ceil(samples / region), at_once = std::min<double>(threads, regions);
    const double own_triangles = std::min(triangles, triangles * region / samples + spread * region);
    const double pieces = triangles + spread * samples / samples_per_piece;
    ordering = elements_of(regions, pieces, 0);
    placing =
        pieces * bytes_per_region_piece + at_once * elements_of(region, own_triangles, per_sample) + placed;
  } else {
    ordering = elements_of(samples, triangles, per_sample);
    placing = ordering + placed;
  }
  const double unknowns = std::max(vertices, 0.5 * triangles);
  double widest = std::max(ordering, placing);
  if (method.makes_charts) {
    const double chart = triangles * bytes_per_chart_triangle;
    const double flatten =
        triangles * bytes_per_tried_triangle + factor_entries(unknowns) * bytes_per_factored_entry;
    const double leaves = most_leaves_per_mass(curve_of(order_of(parameters))) *
                              parameters.locator.curve.leaves_per_sample * samples +
                          triangles;
    const double locate = casts_rays(parameters)
                              ? chart +
                                    triangles * (bytes_per_scene_triangle + bytes_per_conflicting_triangle) +
                                    bytes_of_few_conflicts + leaves * bytes_per_leaf
                              : chart;
    widest = std::max({flatten, locate + ordering, chart + placing});
  }
  if (parameters.curved) {  // while charts and elements are still there
    const double charts = method.makes_charts ? triangles * bytes_per_chart_triangle : 0;
    widest = std::max(widest, charts + placing + triangles * bytes_per_creased_triangle);
  }
  if (std::find(descriptors.begin(), descriptors.end(), Descriptor::geodesic) != descriptors.end())
    widest = std::max(widest, placed + geodesic_bytes(triangles, unknowns, parameters, threads));
  if (std::find(descriptors.begin(), descriptors.end(), Descriptor::shapedna) != descriptors.end())
    widest = std::max(widest, placed + shape_dna_bytes(triangles));
  return static_cast<std::uint64_t>(fixed_bytes + file + prepared + widest);
}

std::uint64_t process_bytes(std::uint64_t budget, const StoreHeader& header, int threads) {
  const std::uint64_t items = header.ids.size();
  return program_bytes + static_cast<std::uint64_t>(threads) * bytes_per_thread + items * bytes_per_item +
         store_writing_bytes(header) + budget / allocator_share;
}

}  // namespace meander
