#include "kernels/sample/place_samples.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <numeric>
#include <string>

#include "kernels/core/parallel.h"
#include "kernels/sample/cell_net.h"
#include "kernels/sample/mesh_strata.h"
#include "kernels/sample/placed_sites.h"
#include "kernels/sample/placer.h"
#include "kernels/sample/redraw_limit.h"
#include "kernels/sample/relaxed_samples.h"
#include "kernels/sample/sample_frame.h"
#include "kernels/sample/sample_sites.h"
#include "kernels/sample/seen_points.h"
#include "kernels/sample/sequence.h"

namespace meander {

namespace {

// float32 keeps 2^-14 of the diagonal up to this many diagonals from 0.
constexpr double float_headroom = 1024;
// Within these float32 has its full precision, and 2^8 times a coordinate (the spacing of few samples on a
// folded surface) is still finite.
constexpr double least_unit = 0x1p-126, largest_coordinate = 0x1p120;

}  // namespace

OutputFrame float_frame(const std::array<double, 6>& bbox, const BoxFrame& box) {
  OutputFrame frame;
  double largest = 0;
  for (const double c : bbox) largest = std::max(largest, std::abs(c));
  if (largest > float_headroom * box.diagonal) {
    frame.loc = box.center;
    largest = box.unit;
  }
  if (largest > largest_coordinate || box.unit < least_unit) frame.scale = box.unit;
  return frame;
}

OutputFrame output_frame(const PreparedMesh& mesh, NormalizeKind kind) {
  if (kind == NormalizeKind::none) return float_frame(mesh.bbox, {mesh.center, mesh.unit, mesh.diagonal});
  OutputFrame frame;
  frame.loc = mesh.center;
  if (kind == NormalizeKind::unit_box) {
    frame.scale =
        std::max({mesh.bbox[3] - mesh.bbox[0], mesh.bbox[4] - mesh.bbox[1], mesh.bbox[5] - mesh.bbox[2]});
  } else if (kind == NormalizeKind::unit_diagonal) {
    frame.scale = mesh.diagonal;
  } else {
    double radius = 0;
    // Over the faces that are sampled: others, and vertices of no face, bound nothing.
    for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
      if (mesh.area[t] == 0) continue;
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t v = mesh.triangles[3 * t + k];
        radius = std::max(radius, norm({mesh.x[v], mesh.y[v], mesh.z[v]}));
      }
    }
    frame.scale = radius * mesh.unit;
  }
  return frame;
}

namespace {

// Points by curve rank, 3 numbers each, and their frame.
struct RankedPoints {
  std::vector<float> points;
  OutputFrame frame;
};

void set_point(const Placer& placer, std::size_t rank, std::vector<float>& points) {
  const SampleSite& site = placer.sites.site[rank];
  const auto p = placer.stored_point(site.triangle, site.b1, site.b2);
  std::copy(p.begin(), p.end(), points.begin() + 3 * static_cast<std::ptrdiff_t>(rank));
}

// Draws again what coincides with a sample of lower rank. counter: of the draw after the first, by rank.
Redrawn redraw_repeated(const Placer& placer, SampleSites& sites, std::span<const std::uint8_t> counter,
                        std::vector<float>& points) {
  const auto count = static_cast<std::uint32_t>(sites.count());
  const bool at_vertices = placer.parameters.place == PlaceKind::vertex;
  Redrawn redrawn;
  SeenPoints seen(count);
  RedrawLimit limit(max_redraws);
  for (std::uint32_t rank = 0; rank < count; ++rank) {
    if (rank % sum_block == 0) placer.cancel.check();
    if (seen.insert(points, rank)) continue;
    if (placer.frame_follows()) redrawn.first.emplace_back(rank, sites.site[rank]);
    const Piece piece = placer.redraw_piece(rank);
    bool distinct = false;
    std::uint32_t next_counter = counter[rank];
    for (int redraw = 0; redraw < limit.now() && !distinct; ++redraw) {
      const Draw draw = at_vertices ? placer.draw(sites.site[rank].triangle, piece, rank, next_counter)
                                    : placer.draw_in_element(rank, piece, next_counter);
      next_counter = draw.next_counter;
      sites.set_point(rank, {draw.b1, draw.b2});
      set_point(placer, rank, points);
      distinct = seen.insert(points, rank);
    }
    if (distinct) {
      limit.found();
    } else {
      limit.exhausted();
      ++redrawn.coincident;
    }
  }
  return redrawn;
}

// Sites of samples, and what else is known of the samples.
struct ChosenSites {
  SampleSites sites;
  std::vector<std::uint32_t> rank_of_index = {};  // the order in the file, if the sequence has one of its own
  std::vector<StratumPoint> point = {};           // by rank, if none are to be drawn
  const BalancedCells* net = nullptr;             // cells whose samples form a net
};

// Moves the samples at their sites.
void relax(const Placer& placer, SampleSites& sites, Notes& notes) {
  std::vector<SurfacePlace> places(sites.count());
  for (std::size_t r = 0; r < places.size(); ++r)
    places[r] = {sites.site[r].triangle, sites.site[r].b1, sites.site[r].b2};
  note_unrelaxed(relax_samples(placer.mesh, placer.measure, places, placer.cancel), places.size(), notes);
  constexpr std::uint32_t whole_triangle = 1;
  for (std::size_t r = 0; r < places.size(); ++r) {
    sites.set(r, places[r].triangle, whole_triangle);
    sites.set_point(r, {places[r].b1, places[r].b2});
  }
}

// Draws the samples at their sites. The points are by curve rank: duplicates must be found in one fixed
// order.
RankedPoints place_by_rank(const Placer& placer, ChosenSites& chosen, RepairCounts& repairs, Notes& notes) {
  const std::uint32_t count = placer.parameters.samples;
  const bool at_vertices = placer.parameters.place == PlaceKind::vertex;
  SampleSites& sites = chosen.sites;
  std::vector<float> points(3 * std::size_t{count});
  const auto set = [&](std::size_t rank, double b1, double b2) {
    sites.set_point(rank, {b1, b2});
    set_point(placer, rank, points);
  };
  std::vector<std::uint8_t> counter(count, 0);  // of the next draw: at most 2 max_draws
  parallel_blocks(count, sum_block, [&](std::size_t begin, std::size_t end) {
    placer.cancel.check();
    PieceWalk walk(placer.surface);
    for (std::size_t r = begin; r < end; ++r) {
      if (!chosen.point.empty()) {
        set(r, chosen.point[r].first, chosen.point[r].second);
        continue;
      }
      if (at_vertices) {
        set(r, sites.site[r].b1, sites.site[r].b2);
        continue;
      }
      const Draw draw = placer.first_draw(static_cast<std::uint32_t>(r), walk);
      counter[r] = static_cast<std::uint8_t>(draw.next_counter);
      set(r, draw.b1, draw.b2);
    }
  });
  if (placer.parameters.finish == FinishKind::relax) {
    relax(placer, sites, notes);
    parallel_blocks(count, sum_block, [&](std::size_t begin, std::size_t end) {
      for (std::size_t r = begin; r < end; ++r) set_point(placer, r, points);
    });
  }
  const OutputFrame frame = draw_in_frame(placer, sites, repairs, [&](const Placer& framed) {
    if (framed.frame_follows())
      parallel_blocks(count, sum_block, [&](std::size_t begin, std::size_t end) {
        placer.cancel.check();
        for (std::size_t r = begin; r < end; ++r) set_point(framed, r, points);
      });
    return redraw_repeated(framed, sites, counter, points);
  });
  return {std::move(points), frame};
}

Samples place(const PlaceContext& context, ChosenSites chosen, OutputFrame& frame, RepairCounts& repairs,
              Notes& notes) {
  const std::uint32_t count = context.parameters.samples;
  const Placer placer{context, chosen.sites, frame};
  context.cancel.check();
  const RankedPoints placed = place_by_rank(placer, chosen, repairs, notes);
  context.cancel.check();

  std::vector<std::uint32_t> order;
  if (context.parameters.order == OrderKind::curve) {
    order.resize(count);
    std::iota(order.begin(), order.end(), 0u);
  } else if (chosen.net != nullptr) {
    order = cell_net_order(*chosen.net, context.key,
                           [&](std::uint32_t rank) { return placer.place_in_mesh(rank); });
  } else {
    order = chosen.rank_of_index.empty() ? progressive_order(count, context.key)
                                         : std::move(chosen.rank_of_index);
  }
  repairs[Repair::bad_normals] += count_bad_normals(context.file);
  Samples samples = room_for_samples(count);
  // By rank, as neighbors along the curve read the same triangles: writing in any order waits less than
  // reading.
  std::vector<std::uint32_t> index_of_rank(count);
  for (std::uint32_t i = 0; i < count; ++i) index_of_rank[order[i]] = i;
  parallel_blocks(count, sum_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t r = begin; r < end; ++r) {
      const float* const p = &placed.points[3 * r];
      set_sample(placer, r, {p[0], p[1], p[2]}, index_of_rank[r], samples);
    }
  });
  samples.curve_rank = std::move(order);
  frame = placed.frame;
  return samples;
}

CurveStrata strata_of(const CurveElements& elements, const PlaceContext& context) {
  return {elements,      context.parameters.samples, context.surface, context.measure.density, context.key,
          context.metric};
}
CellStrata strata_of(const ElementCells& cells, const PlaceContext& context) {
  return {cells, context.surface, context.measure.density, context.key, context.metric};
}

template <class Order>
ChosenSites spaced_sites(const PlaceContext& context, const Order& order) {
  const PlaceParameters& parameters = context.parameters;
  SpacedSamples spaced = space_samples(strata_of(order, context), parameters.order == OrderKind::progressive,
                                       context.key, spacing_parameters(parameters.spacing), context.cancel);
  SampleSites sites(parameters.samples, false);
  for (std::size_t r = 0; r < parameters.samples; ++r)
    sites.set(r, spaced.point[r].triangle, spaced.point[r].path);
  return {std::move(sites), std::move(spaced.rank_of_index), std::move(spaced.point)};
}

template <class Order>
ChosenSites sites_at_positions(const PlaceContext& context, const Order& order) {
  const PlaceParameters& parameters = context.parameters;
  SampleSequence sequence =
      make_sequence(parameters.sequence, parameters.samples, parameters.jitter, context.key);
  return {elements_at(order, sequence.position, parameters.place == PlaceKind::vertex, context.cancel),
          std::move(sequence.rank_of_index)};
}

template <class Order>
Samples place_in(const PlaceContext& context, const Order& order, OutputFrame& frame, RepairCounts& repairs,
                 Notes& notes) {
  if (order.count() == 0) throw ItemError(Status::zero_density, "no curve element has any mass");
  if constexpr (std::same_as<Order, SurfaceRegions>) {
    const PlacedSites placed = place_sites(context, order, frame, repairs);
    return samples_at(placed, context, frame, 0, placed.count());
  } else {
    if constexpr (std::same_as<Order, ElementCells>)
      if (forms_net(context.parameters)) {
        const bool vertices = context.parameters.place == PlaceKind::vertex;
        ChosenSites chosen{elements_in_net(order, context.key, vertices, context.cancel)};
        chosen.net = &order.cells;
        return place(context, std::move(chosen), frame, repairs, notes);
      }
    return place(context,
                 context.parameters.sequence == SequenceKind::spaced ? spaced_sites(context, order)
                                                                     : sites_at_positions(context, order),
                 frame, repairs, notes);
  }
}

}  // namespace

Samples place_samples(const PlaceContext& context, const SurfaceOrder& order, OutputFrame& frame,
                      RepairCounts& repairs, Notes& notes) {
  return std::visit([&](const auto& kind) { return place_in(context, kind, frame, repairs, notes); }, order);
}

void note_unrelaxed(std::size_t unrelaxed, std::size_t samples, Notes& notes) {
  notes.add(Note::feature_ignored,
            "finish relax: sheets of the surface lie on each other around " + std::to_string(unrelaxed) +
                " of " + std::to_string(samples) + " samples, which stay where they were",
            unrelaxed);
}

double sample_bytes(const PlaceParameters& parameters, bool in_metric) {
  constexpr double bytes_per_sample = 160;  // sequence, points twice, row, encoded row
  // Spaced samples have boxes, moments, positions, names, cells of the grid and chosen places, for all strata
  // and for the coarser ones; the places that strata offer and the attraction there; and lists of neighbors
  // (up to 384 in stacked sheets).
  constexpr double bytes_per_spaced_sample = 250, bytes_per_place = 6, bytes_per_neighbor = 4, neighbors = 60;
  constexpr double bytes_per_metric = 60;
  double bytes = bytes_per_sample;
  if (parameters.sequence == SequenceKind::spaced)
    bytes += bytes_per_spaced_sample + neighbors * bytes_per_neighbor +
             spacing_parameters(parameters.spacing).candidates * bytes_per_place +
             (in_metric ? bytes_per_metric : 0.0);
  return parameters.samples * bytes;
}

}  // namespace meander
