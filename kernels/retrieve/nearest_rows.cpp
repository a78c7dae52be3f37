#include "kernels/retrieve/nearest_rows.h"

#include <algorithm>
#include <limits>
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
constexpr std::size_t searched_at_once = 256;

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

// The nearest rows so far of every row: heaps of at most `kept` in one array, the farthest on top.
struct Heaps {
  std::span<NearRow> rows;
  std::size_t kept;
  std::vector<std::uint32_t> sizes;
  std::vector<float> reach;  // the distance of the farthest; infinite while there is room

  void put(std::size_t heap, std::size_t row, float distance) {
    const NearRow candidate{static_cast<std::uint32_t>(row), distance};
    const auto begin = rows.begin() + static_cast<std::ptrdiff_t>(heap * kept);
    std::uint32_t& size = sizes[heap];
    if (size == kept) {
      if (!nearer(candidate, *begin)) return;
      std::pop_heap(begin, begin + size, nearer);
      --size;
    }
    begin[size++] = candidate;
    std::push_heap(begin, begin + size, nearer);
    if (size == kept) reach[heap] = begin->distance;
  }
};

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
  const std::size_t tile = rows_of_tile(part);
  for (std::size_t begin = 0; begin < wanted_.size(); begin += searched_at_once) {
    const std::size_t count = std::min(searched_at_once, wanted_.size() - begin), n = part.rows;
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

std::vector<NearRow> nearest_rows_of_all(const DescriptorBase& base, std::size_t k) {
  const std::size_t n = base.rows, kept = n == 0 ? 0 : std::min(k, n - 1);
  std::vector<NearRow> result(n * kept);
  if (kept == 0) return result;
  Heaps heaps{result, kept, std::vector<std::uint32_t>(n, 0),
              std::vector<float>(n, std::numeric_limits<float>::infinity())};
  constexpr std::size_t panel_rows = 4096;
  const std::size_t tile = rows_of_tile(base);
  std::vector<float> distances(searched_at_once * std::min(n, panel_rows));
  for (std::size_t first = 0; first < n; first += searched_at_once) {
    const std::size_t count = std::min(searched_at_once, n - first);
    // Rows before the block have met its queries as queries themselves.
    for (std::size_t panel = first; panel < n; panel += panel_rows) {
      const std::size_t width = std::min(panel_rows, n - panel);
      // No two tasks change one heap: first each tile has those of its rows, then each query its own.
      parallel_tasks((width + tile - 1) / tile, [&](std::size_t t) {
        const std::size_t begin = t * tile, rows = std::min(tile, width - begin);
        for (std::size_t q = 0; q < count; ++q) {
          float* const of_query = distances.data() + q * width + begin;
          descriptor_distances(base, first + q, panel + begin, {of_query, rows});
          for (std::size_t i = 0; i < rows; ++i) {
            const std::size_t row = panel + begin + i;
            if (of_query[i] <= heaps.reach[row] && first + q < row) heaps.put(row, first + q, of_query[i]);
          }
        }
      });
      parallel_tasks(count, [&](std::size_t q) {
        const std::size_t query = first + q, begin = std::max(panel, query + 1);
        const float* const of_query = distances.data() + q * width;
        for (std::size_t row = begin; row < panel + width; ++row)
          if (of_query[row - panel] <= heaps.reach[query]) heaps.put(query, row, of_query[row - panel]);
      });
    }
  }
  parallel_blocks(n, 1024, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const std::span<NearRow> heap = std::span(result).subspan(i * kept, kept);
      std::sort_heap(heap.begin(), heap.end(), nearer);
    }
  });
  return result;
}

}  // namespace meander
