#include "kernels/retrieve/nearest_rows.h"

#include <algorithm>
#include <span>
#include <stdexcept>
#include <utility>

#include "kernels/core/parallel.h"

namespace meander {

namespace {

bool nearer(const NearRow& a, const NearRow& b) {
  return a.distance != b.distance ? a.distance < b.distance : a.row < b.row;
}

constexpr std::size_t no_row = NearestSearch::no_row;

// Puts rows number(0), number(1), ... at these distances, except for row `own`, into a heap of at most `k`,
// the farthest on top: most rows fail one comparison.
template <class Number>
void keep_nearest(std::span<const float> distances, const Number& number, std::size_t own, std::size_t k,
                  std::vector<NearRow>& heap) {
  if (k == 0) return;
  for (std::size_t i = 0; i < distances.size(); ++i) {
    if (number(i) == own) continue;
    const NearRow candidate{static_cast<std::uint32_t>(number(i)), distances[i]};
    if (heap.size() < k) {
      heap.push_back(candidate);
      std::push_heap(heap.begin(), heap.end(), nearer);
    } else if (nearer(candidate, heap.front())) {
      std::pop_heap(heap.begin(), heap.end(), nearer);
      heap.back() = candidate;
      std::push_heap(heap.begin(), heap.end(), nearer);
    }
  }
}

// query: the index of a row, or a row outside of the base.
template <class Query>
std::vector<float> all_distances(const DescriptorBase& base, const Query& query) {
  std::vector<float> distances(base.rows);
  parallel_blocks(base.rows, 4096, [&](std::size_t begin, std::size_t end) {
    descriptor_distances(base, query, begin, std::span(distances).subspan(begin, end - begin));
  });
  return distances;
}

}  // namespace

std::vector<NearRow> nearest_of(std::span<const float> distances, std::size_t own, std::size_t k) {
  std::vector<NearRow> heap;
  heap.reserve(std::min(k, distances.size()));
  keep_nearest(
      distances, [](std::size_t i) { return i; }, own, k, heap);
  std::sort_heap(heap.begin(), heap.end(), nearer);
  return heap;
}

std::vector<NearRow> nearest_rows(const DescriptorBase& base, std::size_t query, std::size_t k) {
  if (query >= base.rows) throw std::invalid_argument("there is no such row in the base");
  return nearest_of(all_distances(base, query), query, k);
}

std::vector<NearRow> nearest_rows(const DescriptorBase& base, const DescriptorQuery& query, std::size_t k) {
  return nearest_of(all_distances(base, query), no_row, k);
}

void NearestSearch::add_query(DescriptorQuery query, std::size_t own) {
  wanted_.push_back({std::move(query), own, {}});
}

void NearestSearch::search(const DescriptorBase& part, std::span<const std::uint32_t> numbers) {
  if (numbers.size() != part.rows) throw std::invalid_argument("not one number for each row of a part");
  constexpr std::size_t queries_at_once = 256, tile = 64;
  for (std::size_t begin = 0; begin < wanted_.size(); begin += queries_at_once) {
    const std::size_t count = std::min(queries_at_once, wanted_.size() - begin), n = part.rows;
    distances_.resize(count * n);
    // A tile of rows meets all queries while it is in the cache.
    parallel_tasks((n + tile - 1) / tile, [&](std::size_t t) {
      const std::size_t row = t * tile, rows = std::min(tile, n - row);
      for (std::size_t q = 0; q < count; ++q)
        descriptor_distances(part, wanted_[begin + q].query, row, {distances_.data() + q * n + row, rows});
    });
    parallel_tasks(count, [&](std::size_t q) {
      Wanted& wanted = wanted_[begin + q];
      keep_nearest(
          std::span(distances_).subspan(q * n, n), [&](std::size_t i) { return numbers[i]; }, wanted.own, k_,
          wanted.heap);
    });
  }
}

std::vector<NearRow> NearestSearch::found(std::size_t query) {
  std::vector<NearRow> heap = std::move(wanted_[query].heap);
  std::sort_heap(heap.begin(), heap.end(), nearer);
  return heap;
}

std::vector<NearRow> nearest_rows_of(const DescriptorBase& base, std::size_t begin, std::size_t end,
                                     std::size_t k) {
  if (begin > end || end > base.rows) throw std::invalid_argument("there are no such rows in the base");
  const std::size_t n = base.rows, kept = n == 0 ? 0 : std::min(k, n - 1);
  std::vector<NearRow> result((end - begin) * kept);
  visit_distances(base, begin, end, [&](std::size_t first, std::span<const float> distances) {
    parallel_tasks(distances.size() / n, [&](std::size_t q) {
      const std::vector<NearRow> found = nearest_of(distances.subspan(q * n, n), first + q, kept);
      std::copy(found.begin(), found.end(),
                result.begin() + static_cast<std::ptrdiff_t>((first - begin + q) * kept));
    });
  });
  return result;
}

std::vector<NearRow> nearest_rows_of_all(const DescriptorBase& base, std::size_t k) {
  return nearest_rows_of(base, 0, base.rows, k);
}

}  // namespace meander
