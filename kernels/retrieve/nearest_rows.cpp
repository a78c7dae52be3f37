#include "kernels/retrieve/nearest_rows.h"

#include <algorithm>
#include <span>
#include <stdexcept>

#include "kernels/core/parallel.h"

namespace meander {

namespace {

bool nearer(const NearRow& a, const NearRow& b) {
  return a.distance != b.distance ? a.distance < b.distance : a.row < b.row;
}

constexpr std::size_t no_row = ~std::size_t{0};

// Row `query` is left out. out.size() is the number wanted, at most that of the other rows.
void pick_nearest(std::span<const float> distances, std::size_t query, std::span<NearRow> out) {
  if (out.empty()) return;
  // A heap of the best so far, the worst on top: most rows fail one comparison.
  std::size_t held = 0;
  for (std::size_t row = 0; row < distances.size(); ++row) {
    if (row == query) continue;
    const NearRow candidate{static_cast<std::uint32_t>(row), distances[row]};
    if (held < out.size()) {
      out[held++] = candidate;
      std::push_heap(out.begin(), out.begin() + static_cast<std::ptrdiff_t>(held), nearer);
    } else if (nearer(candidate, out.front())) {
      std::pop_heap(out.begin(), out.end(), nearer);
      out.back() = candidate;
      std::push_heap(out.begin(), out.end(), nearer);
    }
  }
  std::sort_heap(out.begin(), out.end(), nearer);
}

// query: the number of a row, or a row outside the base.
template <class Query>
std::vector<float> all_distances(const DescriptorBase& base, const Query& query) {
  std::vector<float> distances(base.rows);
  parallel_blocks(base.rows, 4096, [&](std::size_t begin, std::size_t end) {
    descriptor_distances(base, query, begin, std::span(distances).subspan(begin, end - begin));
  });
  return distances;
}

}  // namespace

std::vector<NearRow> nearest_rows(const DescriptorBase& base, std::size_t query, std::size_t k) {
  if (query >= base.rows) throw std::invalid_argument("there is no such row in the base");
  std::vector<NearRow> result(std::min(k, base.rows - 1));
  pick_nearest(all_distances(base, query), query, result);
  return result;
}

std::vector<NearRow> nearest_rows(const DescriptorBase& base, const DescriptorQuery& query, std::size_t k) {
  std::vector<NearRow> result(std::min(k, base.rows));
  pick_nearest(all_distances(base, query), no_row, result);
  return result;
}

std::vector<NearRow> nearest_rows_of(const DescriptorBase& base, std::size_t begin, std::size_t end,
                                     std::size_t k) {
  if (begin > end || end > base.rows) throw std::invalid_argument("there are no such rows in the base");
  const std::size_t n = base.rows, kept = n == 0 ? 0 : std::min(k, n - 1);
  std::vector<NearRow> result((end - begin) * kept);
  visit_distances(base, begin, end, [&](std::size_t first, std::span<const float> distances) {
    parallel_tasks(distances.size() / n, [&](std::size_t q) {
      pick_nearest(distances.subspan(q * n, n), first + q,
                   std::span(result).subspan((first - begin + q) * kept, kept));
    });
  });
  return result;
}

std::vector<NearRow> nearest_rows_of_all(const DescriptorBase& base, std::size_t k) {
  return nearest_rows_of(base, 0, base.rows, k);
}

}  // namespace meander
