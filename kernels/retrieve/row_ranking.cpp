#include "kernels/retrieve/row_ranking.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "kernels/core/parallel.h"
#include "kernels/core/portable_functions.h"
#include "kernels/retrieve/nearest_rows.h"

namespace meander {

namespace {

constexpr std::size_t least_candidates = 64, candidates_per_neighbor = 4;
constexpr double least_scale = 0.01;  // of the mean
constexpr double solved_to = 1e-6;

std::size_t candidates_of(std::size_t neighbors) {
  return std::max(least_candidates, candidates_per_neighbor * neighbors);
}

struct Neighbor {
  std::uint32_t row = 0;
  float distance = 0;  // scaled, not over the mean
};

// The `count` nearest by (scaled distance, row) of candidates.
std::vector<Neighbor> nearest_scaled(std::vector<Neighbor> candidates, std::size_t count) {
  count = std::min(count, candidates.size());
  const auto nearer = [](const Neighbor& a, const Neighbor& b) {
    return a.distance != b.distance ? a.distance < b.distance : a.row < b.row;
  };
  std::partial_sort(candidates.begin(), candidates.begin() + static_cast<std::ptrdiff_t>(count),
                    candidates.end(), nearer);
  candidates.resize(count);
  return candidates;
}

float weight_of(float distance) {
  const auto t = static_cast<double>(distance);
  return static_cast<float>(portable::exp(-std::min(80.0, t * t)));
}

float factor_of(double scale) { return static_cast<float>(1 / std::sqrt(scale)); }

// Of the nearest rows of every row, `kept` of each.
std::vector<float> scale_factors(std::span<const NearRow> nearest, std::size_t rows, std::size_t kept) {
  std::vector<float> factors(rows, 1.0f);
  if (kept == 0) return factors;
  const std::size_t last = std::min(scale_neighbor, kept) - 1;
  std::vector<double> scales(rows);
  for (std::size_t i = 0; i < rows; ++i) scales[i] = static_cast<double>(nearest[i * kept + last].distance);
  const double mean = blocked_sum(scales) / static_cast<double>(rows);
  if (!(mean > 0)) return factors;
  for (std::size_t i = 0; i < rows; ++i) factors[i] = factor_of(std::max(scales[i], least_scale * mean));
  return factors;
}

double mean_scaled(const DescriptorBase& base, std::span<const float> factors) {
  const auto pairs = scale_pairs(base.rows);
  std::vector<double> distances(pairs.size());
  parallel_blocks(pairs.size(), 1024, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      const auto [i, j] = pairs[p];
      distances[p] = static_cast<double>(descriptor_distance(base, i, j) * (factors[i] * factors[j]));
    }
  });
  const double mean = blocked_sum(distances) / static_cast<double>(std::max<std::size_t>(1, pairs.size()));
  return mean > 0 ? mean : 1;
}

// Each row's neighbors and the rows that have it as theirs, ascending, each once.
void join_neighbors(const std::vector<std::vector<Neighbor>>& neighbors, RowRanking& ranking) {
  struct Edge {
    std::uint32_t from, to;
    float distance;
  };
  const std::size_t rows = neighbors.size();
  std::vector<Edge> edges;
  std::size_t directed = 0;
  for (std::uint32_t i = 0; i < rows; ++i)
    for (const Neighbor& neighbor : neighbors[i]) {
      edges.push_back({i, neighbor.row, neighbor.distance});
      edges.push_back({neighbor.row, i, neighbor.distance});
      ++directed;
    }
  std::sort(edges.begin(), edges.end(),
            [](const Edge& a, const Edge& b) { return a.from != b.from ? a.from < b.from : a.to < b.to; });
  // An edge stands twice where both its rows have each other; their distance is the same.
  const auto last = std::unique(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) {
    return a.from == b.from && a.to == b.to;
  });
  edges.erase(last, edges.end());
  if (directed > 0)
    ranking.mutual_share = static_cast<double>(2 * directed - edges.size()) / static_cast<double>(directed);
  ranking.begin.assign(rows + 1, 0);
  for (const Edge& edge : edges) {
    ++ranking.begin[edge.from + 1];
    ranking.rows.push_back(edge.to);
    ranking.weights.push_back(weight_of(edge.distance));
  }
  std::partial_sum(ranking.begin.begin(), ranking.begin.end(), ranking.begin.begin());
  ranking.degrees.assign(rows, 0);
  for (std::size_t i = 0; i < rows; ++i)
    for (std::uint64_t e = ranking.begin[i]; e < ranking.begin[i + 1]; ++e)
      ranking.degrees[i] += static_cast<double>(ranking.weights[e]);
}

// ---- the diffusion of a query ----------------------------------------------------------------------------

constexpr std::uint32_t not_reached = ~std::uint32_t{0};

// A symmetric sparse matrix S of the rows around a query, which is number 0.
struct Surroundings {
  std::vector<std::uint32_t> nodes;  // rows; that of a query outside of the base is the number of rows
  std::vector<std::size_t> begin;
  std::vector<std::uint32_t> columns;
  std::vector<double> values;
};

// An edge of a query outside of the base.
struct QueryEdge {
  std::uint32_t row;
  float weight;
};

// The rows that the fewest steps reach from the query, up to max_diffused_rows; of the last step, those that
// come first. outside: the edges of a query outside of the base, ascending by row, which the rows get too.
Surroundings surroundings_of(const RowRanking& ranking, std::size_t query,
                             std::span<const QueryEdge> outside) {
  const std::size_t rows = ranking.degrees.size();
  std::vector<std::uint32_t> place(rows + 1, not_reached);
  Surroundings around;
  const auto reach = [&](std::uint32_t row) {
    if (place[row] != not_reached || around.nodes.size() == max_diffused_rows) return;
    place[row] = static_cast<std::uint32_t>(around.nodes.size());
    around.nodes.push_back(row);
  };
  const auto for_each_edge = [&](std::uint32_t row, const auto& visit) {
    if (row == rows) {
      for (const QueryEdge& edge : outside) visit(edge.row, edge.weight);
      return;
    }
    for (std::uint64_t e = ranking.begin[row]; e < ranking.begin[row + 1]; ++e)
      visit(ranking.rows[e], ranking.weights[e]);
    const auto joined = std::lower_bound(outside.begin(), outside.end(), row,
                                         [](const QueryEdge& edge, std::uint32_t r) { return edge.row < r; });
    if (joined != outside.end() && joined->row == row)
      visit(static_cast<std::uint32_t>(rows), joined->weight);
  };
  reach(static_cast<std::uint32_t>(query));
  for (std::size_t next = 0; next < around.nodes.size() && around.nodes.size() < max_diffused_rows; ++next)
    for_each_edge(around.nodes[next], [&](std::uint32_t row, float) { reach(row); });
  std::vector<double> roots(around.nodes.size());
  for (std::size_t i = 0; i < roots.size(); ++i) {
    double degree = 0;
    for_each_edge(around.nodes[i],
                  [&](std::uint32_t, float weight) { degree += static_cast<double>(weight); });
    roots[i] = degree > 0 ? 1 / std::sqrt(degree) : 0;
  }
  around.begin.push_back(0);
  for (std::size_t i = 0; i < roots.size(); ++i) {
    for_each_edge(around.nodes[i], [&](std::uint32_t row, float weight) {
      if (place[row] == not_reached) return;
      around.columns.push_back(place[row]);
      around.values.push_back(static_cast<double>(weight) * (roots[i] * roots[place[row]]));
    });
    around.begin.push_back(around.columns.size());
  }
  return around;
}

// Solves (I - alpha S) f = e_0 by Chebyshev iterations: the eigenvalues lie within 1 - alpha and 1 + alpha.
std::vector<double> diffused(const Surroundings& around, double alpha) {
  const std::size_t n = around.nodes.size();
  const double rate = (1 - std::sqrt(1 - alpha * alpha)) / alpha;
  std::vector<double> f(n, 0), residual(n, 0), step(n, 0);
  residual[0] = step[0] = 1;
  double rho = alpha, error = 1;
  while (error > solved_to) {
    for (std::size_t i = 0; i < n; ++i) {
      double sum = 0;
      for (std::size_t e = around.begin[i]; e < around.begin[i + 1]; ++e)
        sum += around.values[e] * step[around.columns[e]];
      f[i] += step[i];
      residual[i] -= step[i] - alpha * sum;
    }
    const double next = 1 / (2 / alpha - rho);
    for (std::size_t i = 0; i < n; ++i) step[i] = next * rho * step[i] + 2 * next / alpha * residual[i];
    rho = next;
    error *= rate;
  }
  return f;
}

// mutual: the row that is nearest to the query and that the query is nearest to, or not_reached.
void add_diffusion(const RowRanking& ranking, std::size_t query, std::span<const QueryEdge> outside,
                   std::uint32_t mutual, std::span<float> distances) {
  const Surroundings around = surroundings_of(ranking, query, outside);
  const std::vector<double> f = diffused(around, ranking.alpha);
  for (float& distance : distances) distance += static_cast<float>(ranking.diffusion_weight);
  for (std::size_t i = 0; i < around.nodes.size(); ++i)
    if (around.nodes[i] < distances.size()) {
      const double share = around.nodes[i] == mutual ? 1 : std::sqrt(std::clamp(f[i] / f[0], 0.0, 1.0));
      float& distance = distances[around.nodes[i]];
      distance -= static_cast<float>(ranking.diffusion_weight * share);
      distance = std::max(distance, 0.0f);
    }
}

}  // namespace

std::uint32_t default_neighbors(std::size_t rows) {
  const auto log2 = static_cast<int>(std::bit_width(rows)) - 1;
  return static_cast<std::uint32_t>(std::clamp(log2 - 2, 3, 24));
}

RowRanking make_row_ranking(const DescriptorBase& base, const RankParameters& parameters) {
  if (parameters.neighbors > max_neighbors) throw std::invalid_argument("more neighbors than a graph has");
  if (!(parameters.alpha >= min_alpha && parameters.alpha <= max_alpha))
    throw std::invalid_argument("alpha is out of its range");
  RowRanking ranking;
  ranking.kind = parameters.kind;
  if (ranking.kind == RankKind::plain) return ranking;
  if (base.rows < min_diffused_rows) ranking.kind = RankKind::scaled;
  const std::uint32_t wanted = parameters.neighbors > 0 ? parameters.neighbors : default_neighbors(base.rows);
  const bool diffuses = ranking.kind == RankKind::diffusion;
  const std::size_t most = base.rows == 0 ? 0 : base.rows - 1;
  const std::size_t kept = std::min(most, diffuses ? candidates_of(wanted) : scale_neighbor);
  const std::vector<NearRow> nearest = nearest_rows_of_all(base, kept);
  ranking.factors = scale_factors(nearest, base.rows, kept);
  ranking.mean = mean_scaled(base, ranking.factors);
  if (!diffuses) return ranking;
  ranking.neighbors = static_cast<std::uint32_t>(std::min<std::size_t>(wanted, most));
  ranking.alpha = parameters.alpha;
  std::vector<std::vector<Neighbor>> neighbors(base.rows);
  ranking.reach.resize(base.rows);
  ranking.nearest.resize(base.rows);
  ranking.least.resize(base.rows);
  parallel_blocks(base.rows, 256, [&](std::size_t begin, std::size_t end) {
    std::vector<Neighbor> candidates;
    for (std::size_t i = begin; i < end; ++i) {
      candidates.clear();
      for (const NearRow& near : std::span(nearest).subspan(i * kept, kept))
        candidates.push_back({near.row, near.distance * (ranking.factors[i] * ranking.factors[near.row])});
      neighbors[i] = nearest_scaled(candidates, ranking.neighbors);
      ranking.reach[i] = neighbors[i].back().distance;
      ranking.nearest[i] = neighbors[i].front().row;
      ranking.least[i] = neighbors[i].front().distance;
    }
  });
  join_neighbors(neighbors, ranking);
  ranking.diffusion_weight = std::min(most_diffusion_weight, ranking.mutual_share);
  return ranking;
}

void rank_row(const RowRanking& ranking, std::size_t query, std::span<float> distances) {
  if (ranking.kind == RankKind::plain) return;
  const auto over_mean = static_cast<float>(1 / ranking.mean);
  for (std::size_t j = 0; j < distances.size(); ++j)
    distances[j] = distances[j] * (ranking.factors[query] * ranking.factors[j]) * over_mean;
  if (ranking.kind == RankKind::diffusion) {
    const std::uint32_t nearest = ranking.nearest[query];
    add_diffusion(ranking, query, {}, ranking.nearest[nearest] == query ? nearest : not_reached, distances);
  }
  distances[query] = 0;
}

void rank_outside(const RowRanking& ranking, std::span<float> distances) {
  if (ranking.kind == RankKind::plain) return;
  const std::size_t rows = distances.size();
  // The local scale of the query, as those of the rows.
  std::vector<float> nearest(distances.begin(), distances.end());
  const std::size_t last = std::min(scale_neighbor, rows) - 1;
  std::nth_element(nearest.begin(), nearest.begin() + static_cast<std::ptrdiff_t>(last), nearest.end());
  const float most = *std::max_element(ranking.factors.begin(), ranking.factors.end());
  const float factor =
      nearest[last] > 0 ? std::min(most, factor_of(static_cast<double>(nearest[last]))) : most;
  std::vector<QueryEdge> edges;
  std::uint32_t mutual = not_reached;
  std::vector<Neighbor> all(rows);
  for (std::size_t j = 0; j < rows; ++j) {
    distances[j] *= factor * ranking.factors[j];
    all[j] = {static_cast<std::uint32_t>(j), distances[j]};
  }
  if (ranking.kind == RankKind::diffusion) {
    for (std::uint32_t j = 0; j < rows; ++j)
      if (distances[j] < ranking.reach[j]) edges.push_back({j, weight_of(distances[j])});
    const std::vector<Neighbor> neighbors = nearest_scaled(std::move(all), ranking.neighbors);
    if (neighbors[0].distance <= ranking.least[neighbors[0].row]) mutual = neighbors[0].row;
    for (const Neighbor& near : neighbors)
      if (!(near.distance < ranking.reach[near.row])) edges.push_back({near.row, weight_of(near.distance)});
    std::sort(edges.begin(), edges.end(),
              [](const QueryEdge& a, const QueryEdge& b) { return a.row < b.row; });
  }
  const auto over_mean = static_cast<float>(1 / ranking.mean);
  for (float& distance : distances) distance *= over_mean;
  if (ranking.kind == RankKind::diffusion) add_diffusion(ranking, rows, edges, mutual, distances);
}

std::uint64_t row_ranking_bytes(const RankParameters& parameters, std::size_t rows) {
  if (parameters.kind == RankKind::plain) return 0;
  const std::uint64_t wanted = parameters.neighbors > 0 ? parameters.neighbors : default_neighbors(rows);
  const std::uint64_t nearest =
      parameters.kind == RankKind::diffusion ? candidates_of(wanted) : scale_neighbor;
  // The nearest rows; every edge as listed from both sides, and in the graph; what is kept of a row.
  constexpr std::uint64_t edge_bytes = 24, graph_bytes = 16, row_bytes = 72;
  return rows * (nearest * sizeof(NearRow) + wanted * (2 * edge_bytes + graph_bytes) + row_bytes);
}

}  // namespace meander
