#include "kernels/sample/placed_sites.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "kernels/core/parallel.h"
#include "kernels/partition/element_source.h"
#include "kernels/sample/distinct_points.h"
#include "kernels/sample/placer.h"
#include "kernels/sample/sample_frame.h"
#include "kernels/sample/sequence.h"

namespace meander {

namespace {

std::array<float, 3> stored_point_at(const Placer& placer, const SampleSite& site) {
  return placer.stored_point(site.triangle, site.b1, site.b2);
}

// The site with the weights of a draw.
SampleSite drawn_site(SampleSite site, const Draw& draw) {
  site.b1 = static_cast<float>(draw.b1);
  site.b2 = static_cast<float>(draw.b2);
  return site;
}

Draw draw_again(const Placer& placer, std::uint32_t rank, std::uint32_t counter) {
  const Piece piece = placer.redraw_piece(rank);
  return placer.parameters.place == PlaceKind::vertex
             ? placer.draw(placer.sites.site[rank].triangle, piece, rank, counter)
             : placer.draw_in_element(rank, piece, counter);
}

// The counter of the first redraw.
std::uint32_t redraw_counter(const Placer& placer, std::uint32_t rank) {
  if (placer.parameters.place == PlaceKind::vertex) return 0;
  return placer.draw_in_element(rank, placer.piece(rank), 0).next_counter;
}

// Draws those samples again that are not at a place of their own.
Redrawn redraw_sites(const Placer& placer, SampleSites& sites) {
  const Redraws redraws = find_redraws(
      sites.count(), [&](std::uint32_t rank) { return stored_point_at(placer, sites.site[rank]); },
      [&](std::uint32_t rank) { return redraw_counter(placer, rank); },
      [&](std::uint32_t rank, std::uint32_t counter) {
        const Draw draw = draw_again(placer, rank, counter);
        return DrawnPoint{stored_point_at(placer, drawn_site(sites.site[rank], draw)), draw.next_counter};
      },
      max_redraws, placer.cancel);
  Redrawn redrawn;
  redrawn.coincident = redraws.coincident;
  for (const Redraw& redraw : redraws.redraw) {
    SampleSite& site = sites.site[redraw.rank];
    if (placer.frame_follows()) redrawn.first.emplace_back(redraw.rank, site);
    site = drawn_site(site, draw_again(placer, redraw.rank, redraw.counter));
  }
  return redrawn;
}

// Draws every sample in its element, unless that is done or it lies at the curve vertex, and then those again
// that are not at a place of their own. Returns the frame of the points (draw_in_frame).
OutputFrame draw_sites(const Placer& placer, SampleSites& sites, RepairCounts& repairs) {
  if (placer.parameters.place == PlaceKind::element && !sites.drawn)
    parallel_blocks(sites.count(), sum_block, [&](std::size_t begin, std::size_t end) {
      placer.cancel.check();
      PieceWalk walk(placer.surface);
      for (std::size_t r = begin; r < end; ++r)
        sites.site[r] = drawn_site(sites.site[r], placer.first_draw(static_cast<std::uint32_t>(r), walk));
    });
  return draw_in_frame(placer, sites, repairs,
                       [&](const Placer& framed) { return redraw_sites(framed, sites); });
}

// Empty where triangles are not so few, or where samples have normals of their own.
std::vector<SharedBySamples> shared_by_samples(const Placer& placer) {
  const std::size_t count = placer.mesh.triangle_count();
  std::vector<SharedBySamples> shared;
  if (count * samples_per_shared_triangle > placer.sites.count() || !placer.file.normals.empty())
    return shared;
  shared.resize(count);
  parallel_blocks(count, sum_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const auto triangle = static_cast<std::uint32_t>(t);
      shared[t] = {
          placer.corner_frame(triangle),
          {to_float(placer.geometric_normal(triangle)), placer.corners(triangle), placer.mesh.polygon[t]}};
    }
  });
  return shared;
}

}  // namespace

PlacedSites place_sites(const PlaceContext& context, const SurfaceRegions& regions, OutputFrame& frame,
                        RepairCounts& repairs) {
  const PlaceParameters& parameters = context.parameters;
  if (regions.count() == 0) throw ItemError(Status::zero_density, "no curve element has any mass");
  PlacedSites placed;
  {
    const ElementSource source(context, regions.parameters.order, regions.group);
    const bool vertices = parameters.place == PlaceKind::vertex;
    if (forms_net(parameters) && regions.parameters.order == ElementOrder::balanced) {
      placed.sites = elements_in_net(regions, source, vertices);
    } else {
      SampleSequence sequence =
          make_sequence(parameters.sequence, parameters.samples, parameters.jitter, context.key);
      placed.sites = elements_at(regions, source, sequence.position, vertices);
      placed.order = std::move(sequence.rank_of_index);
    }
  }
  context.cancel.check();
  frame = draw_sites(Placer{context, placed.sites, frame}, placed.sites, repairs);
  placed.sites.mass = std::vector<double>();
  placed.shared = shared_by_samples(Placer{context, placed.sites, frame});
  repairs[Repair::bad_normals] += count_bad_normals(context.file);
  if (parameters.order == OrderKind::curve)
    placed.order = std::vector<std::uint32_t>();
  else if (placed.order.empty())
    placed.order = progressive_order(parameters.samples, context.key);
  return placed;
}

Samples samples_at(const PlacedSites& placed, const PlaceContext& context, const OutputFrame& frame,
                   std::size_t begin, std::size_t end) {
  const Placer placer{context, placed.sites, frame};
  Samples samples = room_for_samples(end - begin);
  samples.curve_rank.resize(end - begin);
  parallel_blocks(end - begin, sum_block, [&](std::size_t from, std::size_t to) {
    // Sites that follow each other in the file are far apart in memory, and so are their triangles.
    constexpr std::size_t ahead = 16, near = 8;
    for (std::size_t i = from; i < to; ++i) {
      if (i + ahead < to) __builtin_prefetch(&placed.sites.site[placed.rank(begin + i + ahead)]);
      const std::uint32_t rank = placed.rank(begin + i);
      const SampleSite& site = placed.sites.site[rank];
      samples.curve_rank[i] = rank;
      if (placed.shared.empty()) {
        set_sample(placer, rank, stored_point_at(placer, site), i, samples);
        continue;
      }
      if (i + near < to) {
        const std::uint32_t next = placed.sites.site[placed.rank(begin + i + near)].triangle;
        const auto* const bytes = reinterpret_cast<const std::byte*>(&placed.shared[next]);
        __builtin_prefetch(bytes);
        __builtin_prefetch(bytes + 64);
        __builtin_prefetch(bytes + sizeof(SharedBySamples) - 1);
      }
      const SharedBySamples& shared = placed.shared[site.triangle];
      set_sample(placer, rank, placer.stored_point(shared.frame, site.b1, site.b2), shared.record, i,
                 samples);
    }
  });
  return samples;
}

double region_sample_bytes(const PlaceParameters& parameters, bool as_sites, double triangles, int threads) {
  constexpr double bytes_per_sample = 120;  // sites and the row, or the row and its encoded form
  // Sites, and hashes of the points or the order in the file; more while a sequence is sorted.
  constexpr double bytes_per_site = 26, bytes_per_sorted_site = 34, bytes_per_vertex_mass = 8;
  constexpr double bytes_per_block = 16 << 20, samples_per_block = 65536;
  const double samples = parameters.samples;
  const double shared = std::min(triangles, samples / samples_per_shared_triangle) * sizeof(SharedBySamples);
  if (!as_sites) return samples * bytes_per_sample + shared;
  const bool sorts = parameters.sequence == SequenceKind::owen || parameters.sequence == SequenceKind::random;
  const double site = (sorts ? bytes_per_sorted_site : bytes_per_site) +
                      (parameters.place == PlaceKind::vertex ? bytes_per_vertex_mass : 0.0);
  const double blocks = std::min<double>(threads, std::ceil(samples / samples_per_block));
  return samples * site + shared + blocks * bytes_per_block;
}

}  // namespace meander
