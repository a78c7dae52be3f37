// Ranking by what lies around the rows of a base: distances over the local scale, and diffusion over the
// graph of nearest neighbors. No classes take part.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "kernels/retrieve/descriptor_distance.h"

namespace meander {

// plain: by the distance of descriptors. scaled: over the roots of both rows' local scales. diffusion: scaled
// distances and diffusion together.
enum class RankKind : std::uint8_t { plain, scaled, diffusion };

struct RankParameters {
  RankKind kind = RankKind::plain;
  std::uint32_t neighbors = 0;  // of a row in the graph, up to max_neighbors; 0: see default_neighbors
  double alpha = 0.85;          // share that a step of diffusion passes on, in [min_alpha, max_alpha]
};
inline constexpr std::uint32_t max_neighbors = 64;
inline constexpr double min_alpha = 0.05, max_alpha = 0.99;

// The local scale of a row is its distance to this nearest other row (Zelnik-Manor and Perona 2004).
inline constexpr std::size_t scale_neighbor = 7;
// The weight of diffusion beside scaled distances, of mean 1, where the share of mutual neighbors is as
// large.
inline constexpr double most_diffusion_weight = 0.5;
// Bases of fewer rows are ranked by scaled distances alone.
inline constexpr std::size_t min_diffused_rows = 16;
// The bound on the work of a query: its diffusion stays within as many rows, those that the fewest steps
// reach.
inline constexpr std::size_t max_diffused_rows = 8192;

// log2(rows) - 2, rounded down, within 3 and 24: as the base grows, a class that grows with it keeps
// together.
std::uint32_t default_neighbors(std::size_t rows);

// What ranking knows of a base. Where diffusion was asked for and does not run (few rows), kind is scaled.
struct RowRanking {
  RankKind kind = RankKind::plain;
  std::uint32_t neighbors = 0;
  double alpha = 0;
  double mutual_share = 0;  // of the neighbors that are mutual
  double diffusion_weight = 0;
  double mean = 1;             // of scaled distances, over scale_pairs
  std::vector<float> factors;  // of rows: 1 / root of the local scale
  std::vector<float> reach;    // of rows: scaled distance to the last neighbor
  // Of rows: the nearest other by scaled distance, and how far it is. Two rows that are each other's nearest
  // are as near as diffusion makes any.
  std::vector<std::uint32_t> nearest;
  std::vector<float> least;
  // The graph: the neighbors of row i are those from begin[i] to begin[i + 1], ascending by row; each edge
  // stands at both its rows. weights: exp(-t^2) at scaled distance t; degrees: their sums.
  std::vector<std::uint64_t> begin;
  std::vector<std::uint32_t> rows;
  std::vector<float> weights;
  std::vector<double> degrees;
};

// Scale and graph of a base. The neighbors of a row are the nearest by scaled distance among the 4 x
// neighbors (at least 64) nearest by distance; an edge joins rows of which one has the other as a neighbor.
// Local scales below 1 % of their mean count as that. Throws std::invalid_argument for parameters out of
// their range. O(rows^2 x width) time, in parallel; memory: 8 bytes for each of these nearest rows and what
// nearest_rows_of_all takes. The same bits for every thread count.
RowRanking make_row_ranking(const DescriptorBase& base, const RankParameters& parameters);

// Replaces the distances of row `query` to every row by what they are ranked by: plain: nothing changes;
// scaled: d / (s_i s_j)^(1/2) over the mean of such; diffusion: to this is added the weight x (1 - (f_j /
// f_i)^(1/2)), where f solves (I - alpha S) f = e_i, S = D^(-1/2) W D^(-1/2) (Zhou et al. 2004; Donoser and
// Bischof 2013), by Chebyshev iterations to about 1e-6. The row itself gets 0. O(rows + edges x iterations);
// O(rows) memory. distances.size() is the number of rows.
void rank_row(const RowRanking& ranking, std::size_t query, std::span<float> distances);

// The same for a row outside of the base, which joins the graph for the time of its query: with its nearest
// rows, and those that it lies nearer to than their last neighbor.
void rank_outside(const RowRanking& ranking, std::span<float> distances);

// Bytes that ranking a base of `rows` takes at most beside it, and while it is made.
std::uint64_t row_ranking_bytes(const RankParameters& parameters, std::size_t rows);

}  // namespace meander
