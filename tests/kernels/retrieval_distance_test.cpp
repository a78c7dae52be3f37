#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <stdexcept>

#include "kernels/core/random.h"
#include "kernels/retrieve/descriptor_distance.h"
#include "kernels/retrieve/nearest_rows.h"
#include "support/catch.h"
#include "support/threads.h"

using namespace meander;

namespace {

constexpr DistanceKind kinds[] = {DistanceKind::l1, DistanceKind::l2, DistanceKind::emd, DistanceKind::chi2,
                                  DistanceKind::cosine};

// Rows of sum 1, many bins of them zero.
std::vector<float> random_histograms(std::size_t rows, std::uint32_t width, std::uint64_t seed) {
  const RandomKey key = make_random_key(seed, {});
  std::vector<float> values(rows * width);
  for (std::size_t i = 0; i < rows; ++i) {
    double sum = 0;
    for (std::size_t b = 0; b < width; ++b) {
      const double u = random_pair(key, Stream::sequence, i * width + b).first;
      const double value = b == i % width ? 1 : std::max(0.0, u - 0.3);
      values[i * width + b] = static_cast<float>(value);
      sum += value;
    }
    for (std::size_t b = 0; b < width; ++b)
      values[i * width + b] = static_cast<float>(static_cast<double>(values[i * width + b]) / sum);
  }
  return values;
}

DescriptorBase base_of(std::span<const float> values, std::uint32_t width, DistanceKind kind) {
  const DescriptorBlock block{values, width};
  return make_descriptor_base({&block, 1}, kind);
}

double of_pair(const std::vector<float>& a, const std::vector<float>& b, DistanceKind kind) {
  std::vector<float> both(a);
  both.insert(both.end(), b.begin(), b.end());
  return static_cast<double>(
      descriptor_distance(base_of(both, static_cast<std::uint32_t>(a.size()), kind), 0, 1));
}

// The definitions, in double.
double slow_distance(std::span<const float> a, std::span<const float> b, DistanceKind kind) {
  double l1 = 0, squares = 0, emd = 0, chi2 = 0, difference = 0, dot = 0, aa = 0, bb = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const auto x = static_cast<double>(a[i]), y = static_cast<double>(b[i]);
    l1 += std::abs(x - y);
    squares += (x - y) * (x - y);
    difference += x - y;
    emd += std::abs(difference);
    if (x != 0 || y != 0) chi2 += (x - y) * (x - y) / (std::abs(x) + std::abs(y)) / 2;
    dot += x * y;
    aa += x * x;
    bb += y * y;
  }
  switch (kind) {
    case DistanceKind::l1:
      return l1;
    case DistanceKind::l2:
      return std::sqrt(squares);
    case DistanceKind::emd:
      return emd;
    case DistanceKind::chi2:
      return chi2;
    case DistanceKind::cosine:
      return 1 - dot / std::sqrt(aa * bb);
  }
  return 0;
}

}  // namespace

TEST_CASE("descriptor distances: cases by hand") {
  CHECK(of_pair({1, 0, 0}, {0, 0, 1}, DistanceKind::l1) == 2);
  CHECK(of_pair({3, 0}, {0, 4}, DistanceKind::l2) == 5);
  CHECK(of_pair({1, 0, 0}, {0, 0, 1}, DistanceKind::emd) == 2);  // two bins to walk
  CHECK(of_pair({1, 0, 0}, {0, 1, 0}, DistanceKind::emd) == 1);  // one
  CHECK(of_pair({0.5f, 0.5f}, {0.5f, 0.5f}, DistanceKind::chi2) == 0);
  CHECK(of_pair({1, 0, 0}, {0, 1, 0}, DistanceKind::chi2) == 1);
  CHECK(of_pair({3, 1}, {1, 1}, DistanceKind::chi2) == 0.5);
  CHECK(of_pair({1, 0}, {0, 7}, DistanceKind::cosine) == Approx(1));
  CHECK(of_pair({1, 1}, {0, 5}, DistanceKind::cosine) == Approx(1 - std::sqrt(0.5)));
  CHECK(of_pair({0, 0}, {0, 5}, DistanceKind::cosine) == 0.5);
  CHECK(of_pair({0, 0}, {0, 0}, DistanceKind::cosine) == 0);
}

TEST_CASE("descriptor distances: match the definitions in double, for widths around the SIMD lanes") {
  for (const std::uint32_t width : {1u, 5u, 16u, 17u, 64u, 100u}) {
    const std::vector<float> values = random_histograms(12, width, width);
    for (const DistanceKind kind : kinds) {
      const DescriptorBase base = base_of(values, width, kind);
      for (std::size_t i = 0; i < 12; ++i)
        for (std::size_t j = 0; j < 12; ++j) {
          const auto row = [&](std::size_t r) {
            return std::span<const float>(values).subspan(r * width, width);
          };
          INFO("width " << width << " kind " << static_cast<int>(kind));
          CHECK(static_cast<double>(descriptor_distance(base, i, j)) ==
                Approx(slow_distance(row(i), row(j), kind)).margin(2e-6).epsilon(2e-5));
        }
    }
  }
}

TEST_CASE("descriptor distances: the metrics satisfy the axioms of a metric") {
  const std::uint32_t width = 32;
  const std::size_t n = 40;
  const std::vector<float> values = random_histograms(n, width, 3);
  for (const DistanceKind kind : kinds) {
    const DescriptorBase base = base_of(values, width, kind);
    const auto d = [&](std::size_t i, std::size_t j) {
      const auto value = static_cast<double>(descriptor_distance(base, i, j));
      return kind == DistanceKind::chi2 || kind == DistanceKind::cosine ? std::sqrt(value) : value;
    };
    for (std::size_t i = 0; i < n; ++i) {
      CHECK(d(i, i) == 0);
      for (std::size_t j = 0; j < n; ++j) {
        REQUIRE(descriptor_distance(base, i, j) == descriptor_distance(base, j, i));
        if (i != j) REQUIRE(d(i, j) > 0);
        for (std::size_t k = 0; k < n; ++k) REQUIRE(d(i, k) <= d(i, j) + d(j, k) + 1e-5);
      }
    }
  }
}

TEST_CASE("emd: the least cost of transporting one histogram to the other") {
  // Six grains each; all ways to match grains are tried.
  const RandomKey key = make_random_key(8, {});
  for (std::uint64_t trial = 0; trial < 30; ++trial) {
    const std::size_t grains = 6;
    const std::uint32_t width = 9;
    std::vector<int> from, to;
    std::vector<float> a(width), b(width);
    for (std::size_t g = 0; g < grains; ++g) {
      const UnitPair u = random_pair(key, Stream::sequence, trial * grains + g);
      from.push_back(static_cast<int>(u.first * width));
      to.push_back(static_cast<int>(u.second * width));
      a[static_cast<std::size_t>(from.back())] += 1;
      b[static_cast<std::size_t>(to.back())] += 1;
    }
    std::vector<std::size_t> match(grains);
    std::iota(match.begin(), match.end(), std::size_t{0});
    int least = 1000;
    do {
      int cost = 0;
      for (std::size_t g = 0; g < grains; ++g) cost += std::abs(from[g] - to[match[g]]);
      least = std::min(least, cost);
    } while (std::next_permutation(match.begin(), match.end()));
    CHECK(of_pair(a, b, DistanceKind::emd) == least);
  }
}

TEST_CASE("combined descriptors: every block has the same weight, whatever its unit") {
  const std::size_t n = 50;
  std::vector<float> a = random_histograms(n, 20, 1);
  const std::vector<float> b = random_histograms(n, 7, 2);
  const DescriptorBlock blocks[] = {{a, 20}, {b, 7}};
  const DescriptorBase together = make_descriptor_base(blocks, DistanceKind::l1);
  double sum = 0;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < i; ++j) sum += static_cast<double>(descriptor_distance(together, i, j));
  CHECK(sum / (n * (n - 1) / 2) == Approx(2).epsilon(1e-5));  // each block has mean 1
  const DescriptorBase only_a = base_of(a, 20, DistanceKind::l1), only_b = base_of(b, 7, DistanceKind::l1);
  CHECK(static_cast<double>(descriptor_distance(together, 3, 9)) ==
        Approx(static_cast<double>(descriptor_distance(only_a, 3, 9)) / together.blocks[0].scale +
               static_cast<double>(descriptor_distance(only_b, 3, 9)) / together.blocks[1].scale));
  for (float& v : a) v *= 1024;
  const DescriptorBlock scaled[] = {{a, 20}, {b, 7}};
  const DescriptorBase other = make_descriptor_base(scaled, DistanceKind::l1);
  CHECK(descriptor_distance(other, 3, 9) == Approx(descriptor_distance(together, 3, 9)).epsilon(1e-6));
  // A block of equal rows says nothing.
  const std::vector<float> flat(n * 3, 0.25f);
  const DescriptorBlock with_flat[] = {{b, 7}, {flat, 3}};
  const DescriptorBase half = make_descriptor_base(with_flat, DistanceKind::l1);
  CHECK(static_cast<double>(descriptor_distance(half, 3, 9)) ==
        Approx(static_cast<double>(descriptor_distance(only_b, 3, 9)) / half.blocks[0].scale));
}

TEST_CASE("combined descriptors: the scale from sampled pairs is near that of all pairs") {
  const std::size_t n = 400;  // 79800 pairs: more than are used
  const std::vector<float> a = random_histograms(n, 12, 5);
  const DescriptorBlock blocks[] = {{a, 12}, {a, 12}};
  const DescriptorBase base = make_descriptor_base(blocks, DistanceKind::l2);
  const DescriptorBase single = base_of(a, 12, DistanceKind::l2);
  double sum = 0;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < i; ++j) sum += static_cast<double>(descriptor_distance(single, i, j));
  CHECK(base.blocks[0].scale == Approx(sum / (n * (n - 1) / 2)).epsilon(0.01));
}

TEST_CASE("descriptor distances: every instruction set gives the same bits") {
  const std::size_t n = 103;  // no multiple of the rows that go abreast
  for (const std::uint32_t width : {1u, 16u, 40u, 64u}) {
    std::vector<float> a = random_histograms(n, width, 11);
    for (std::size_t i = 0; i < a.size(); i += 3) a[i] = -a[i];  // chi2 takes magnitudes
    const std::vector<float> b = random_histograms(n, 24, 12);
    const DescriptorBlock blocks[] = {{a, width}, {b, 24}};
    for (const DistanceKind kind : kinds)
      for (const std::size_t parts : {1u, 2u}) {
        const auto all = [&](InstructionSet set) {
          const DescriptorBase base = make_descriptor_base(std::span(blocks).first(parts), kind, set);
          std::vector<float> found(n * n);
          for (std::size_t q = 0; q < n; ++q)  // rows that begin anywhere
            for (std::size_t begin = 0; begin < n; begin += 1 + q)
              descriptor_distances(base, q, begin,
                                   std::span(found).subspan(q * n + begin, std::min(1 + q, n - begin)));
          return found;
        };
        const std::vector<float> expected = all(InstructionSet::scalar);
        for (const InstructionSet set : {InstructionSet::avx2, InstructionSet::avx512})
          if (is_available(set)) CHECK(all(set) == expected);
        CHECK(all(InstructionSet::automatic) == expected);
      }
  }
}

TEST_CASE("visit_distances: blocks of every size and every thread count give the same bits") {
  const std::size_t n = 700;
  const std::vector<float> values = random_histograms(n, 24, 6);
  for (const DistanceKind kind : {DistanceKind::l1, DistanceKind::chi2}) {
    const DescriptorBase base = base_of(values, 24, kind);
    std::vector<float> expected(n * n);
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j) expected[i * n + j] = descriptor_distance(base, i, j);
    for (const std::size_t threads : {1u, 2u, 4u})
      for (const std::size_t block : {0u, 1u, 33u, 10000u}) {
        std::vector<float> found;
        const auto add = [&](std::size_t first, std::span<const float> distances) {
          REQUIRE(found.size() == first * n);
          found.insert(found.end(), distances.begin(), distances.end());
        };
        test::on_threads(threads, [&] { visit_distances(base, add, block); });
        CHECK(found == expected);
      }
  }
}

TEST_CASE("nearest_rows: the front of the sorted list, ties by row number") {
  const std::size_t n = 300;
  std::vector<float> values = random_histograms(n, 8, 7);
  for (std::size_t i = 100; i < 200; ++i)  // many equal rows
    std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(8 * (i % 3)), 8,
                values.begin() + static_cast<std::ptrdiff_t>(8 * i));
  const DescriptorBase base = base_of(values, 8, DistanceKind::l1);
  for (const std::size_t k : {0u, 1u, 10u, 60u, 299u, 1000u}) {
    const std::vector<NearRow> all = nearest_rows_of_all(base, k);
    const std::size_t kept = std::min<std::size_t>(k, n - 1);
    REQUIRE(all.size() == n * kept);
    for (std::size_t query = 0; query < n; query += 7) {
      std::vector<NearRow> sorted;
      for (std::size_t j = 0; j < n; ++j)
        if (j != query)
          sorted.push_back({static_cast<std::uint32_t>(j), descriptor_distance(base, query, j)});
      std::stable_sort(sorted.begin(), sorted.end(),
                       [](const NearRow& a, const NearRow& b) { return a.distance < b.distance; });
      sorted.resize(kept);
      CHECK(nearest_rows(base, query, k) == sorted);
      CHECK(
          std::equal(sorted.begin(), sorted.end(), all.begin() + static_cast<std::ptrdiff_t>(query * kept)));
    }
  }
  CHECK_THROWS_AS(nearest_rows(base, n, 3), std::invalid_argument);
}

TEST_CASE("nearest_rows_of_all: the same as a search for each row, over several panels and thread counts") {
  const std::size_t n = 4700, k = 6;  // more rows than a panel has; equal distances are frequent
  std::vector<float> values = random_histograms(n, 4, 11);
  for (float& v : values) v = std::round(8 * v);
  const DescriptorBase base = base_of(values, 4, DistanceKind::l1);
  const std::vector<NearRow> all = nearest_rows_of_all(base, k);
  for (const std::size_t query : {0u, 1u, 255u, 256u, 2000u, 4095u, 4096u, 4351u, 4352u, 4699u}) {
    const auto own = all.begin() + static_cast<std::ptrdiff_t>(query * k);
    CHECK(nearest_rows(base, query, k) == std::vector<NearRow>(own, own + k));
  }
  for (const int threads : {1, 2, 5})
    test::on_threads(threads, [&] { CHECK(nearest_rows_of_all(base, k) == all); });
}

TEST_CASE("descriptor distances: a query outside the base equals an equal row, alone and combined") {
  const std::size_t n = 130;
  const std::vector<float> narrow = random_histograms(n, 9, 3), wide = random_histograms(n, 40, 4);
  const DescriptorBlock blocks[] = {{narrow, 9}, {wide, 40}};
  for (const DistanceKind kind : kinds)
    for (const std::size_t number : {1u, 2u}) {
      const DescriptorBase base = make_descriptor_base(std::span(blocks).first(number), kind);
      for (const std::size_t row : {0u, 64u, 129u}) {
        std::vector<float> values(narrow.begin() + static_cast<std::ptrdiff_t>(9 * row),
                                  narrow.begin() + static_cast<std::ptrdiff_t>(9 * row + 9));
        if (number == 2)
          values.insert(values.end(), wide.begin() + static_cast<std::ptrdiff_t>(40 * row),
                        wide.begin() + static_cast<std::ptrdiff_t>(40 * row + 40));
        const DescriptorQuery query = make_descriptor_query(base, values);
        std::vector<float> own(n), outside(n);
        descriptor_distances(base, row, 0, own);
        descriptor_distances(base, query, 0, outside);
        CHECK(outside == own);
        const std::vector<NearRow> found = nearest_rows(base, query, 5);
        REQUIRE(found.size() == 5);
        CHECK(found[0] == NearRow{static_cast<std::uint32_t>(row), 0.0f});
        CHECK(std::vector<NearRow>(found.begin() + 1, found.end()) == nearest_rows(base, row, 4));
        values.pop_back();
        CHECK_THROWS_AS(make_descriptor_query(base, values), std::invalid_argument);
        values.resize(values.size() + 2);
        CHECK_THROWS_AS(make_descriptor_query(base, values), std::invalid_argument);
        values.pop_back();
        values[0] = std::numeric_limits<float>::quiet_NaN();
        CHECK_THROWS_AS(make_descriptor_query(base, values), std::invalid_argument);
      }
      CHECK(nearest_rows(base, make_descriptor_query(base, std::vector<float>(number == 2 ? 49 : 9)), 1000)
                .size() == n);
    }
}

TEST_CASE("NearestSearch: parts of any size, in any order, find what the whole base finds") {
  const std::size_t n = 700;
  std::vector<float> a = random_histograms(n, 9, 3);
  const std::vector<float> b = random_histograms(n, 40, 4);
  for (std::size_t i = 300; i < 400; ++i)  // many equal rows
    std::copy_n(a.begin() + static_cast<std::ptrdiff_t>(9 * (i % 3)), 9,
                a.begin() + static_cast<std::ptrdiff_t>(9 * i));
  const DescriptorBlock blocks[] = {{a, 9, 2}, {b, 40, 0.5}};
  for (const std::size_t number : {1u, 2u}) {
    const std::span<const DescriptorBlock> used(blocks, number);
    const DescriptorBase whole = make_descriptor_base(used, DistanceKind::l1);
    for (const std::size_t part_rows : {1u, 64u, 129u, 700u})
      for (const std::size_t k : {0u, 3u, 250u, 1000u}) {
        if (part_rows == 1 && k != 3) continue;
        const auto search_all = [&] {
          NearestSearch search(k);
          for (const std::size_t query : {0u, 350u, 699u}) {
            std::vector<float> values(a.begin() + static_cast<std::ptrdiff_t>(9 * query),
                                      a.begin() + static_cast<std::ptrdiff_t>(9 * query + 9));
            if (number == 2)
              values.insert(values.end(), b.begin() + static_cast<std::ptrdiff_t>(40 * query),
                            b.begin() + static_cast<std::ptrdiff_t>(40 * query + 40));
            search.add_query(make_descriptor_query(whole, values), query);
            search.add_query(make_descriptor_query(whole, values));
          }
          for (std::size_t end = n; end > 0;) {  // the last part first
            const std::size_t begin = end - std::min(end, part_rows);
            DescriptorBase part = empty_descriptor_base(used, DistanceKind::l1);
            resize_descriptor_base(part, end - begin);
            std::vector<std::uint32_t> numbers;
            for (std::size_t row = begin; row < end; ++row) {
              numbers.push_back(static_cast<std::uint32_t>(row));
              for (std::size_t t = 0; t < number; ++t)
                set_descriptor_row(part, t, row - begin,
                                   blocks[t].values.subspan(row * blocks[t].width, blocks[t].width));
            }
            for (std::size_t t = 0; t < number; ++t) part.blocks[t].scale = whole.blocks[t].scale;
            search.search(part, numbers);
            end = begin;
          }
          std::vector<std::vector<NearRow>> found;
          for (std::size_t q = 0; q < 6; ++q) found.push_back(search.found(q));
          return found;
        };
        const std::vector<std::vector<NearRow>> found = search_all();
        for (std::size_t q = 0; q < 3; ++q) {
          const std::size_t query = q == 0 ? 0 : q == 1 ? 350 : 699;
          CHECK(found[2 * q] == nearest_rows(whole, query, k));
          CHECK(found[2 * q + 1].size() == std::min(k, n));
        }
        CHECK(test::on_threads(3, search_all) == found);
      }
  }
}

TEST_CASE("make_descriptor_base: a base made in steps equals that of its blocks, and weights scale them") {
  const std::size_t n = 300;  // more pairs than are used for the scales
  const std::vector<float> a = random_histograms(n, 20, 1), b = random_histograms(n, 7, 2);
  const DescriptorBlock blocks[] = {{a, 20, 3}, {b, 7}}, plain[] = {{a, 20}, {b, 7}};
  for (const DistanceKind kind : kinds) {
    const DescriptorBase whole = make_descriptor_base(blocks, kind), even = make_descriptor_base(plain, kind);
    DescriptorBase steps = empty_descriptor_base(blocks, kind);
    resize_descriptor_base(steps, n);
    for (std::size_t row = n; row-- > 0;) {
      set_descriptor_row(steps, 1, row, std::span(b).subspan(7 * row, 7));
      set_descriptor_row(steps, 0, row, std::span(a).subspan(20 * row, 20));
    }
    set_descriptor_scales(steps, scale_pairs(n));
    for (std::size_t t = 0; t < 2; ++t) {
      CHECK(steps.blocks[t].scale == whole.blocks[t].scale);
      CHECK(steps.blocks[t].scale == even.blocks[t].scale);
      CHECK(steps.blocks[t].values == whole.blocks[t].values);
    }
    for (std::size_t j = 1; j < 40; ++j) {
      std::vector<float> of_a(1), of_b(1);
      block_distances(even, 0, 0, j, of_a);
      block_distances(even, 1, 0, j, of_b);
      CHECK(static_cast<double>(descriptor_distance(whole, 0, j)) ==
            Approx(3 * static_cast<double>(of_a[0]) / even.blocks[0].scale +
                   static_cast<double>(of_b[0]) / even.blocks[1].scale)
                .epsilon(1e-5));
    }
  }
  CHECK_THROWS_AS(set_descriptor_row(*std::make_unique<DescriptorBase>(empty_descriptor_base(plain, {})), 0,
                                     0, std::span(a).first(20)),
                  std::invalid_argument);
}

TEST_CASE("make_descriptor_base: descriptors that cannot be compared are refused") {
  const std::vector<float> six(6, 1.0f), five(5, 1.0f),
      bad{1.0f, std::numeric_limits<float>::quiet_NaN(), 0.0f};
  const DescriptorBlock uneven[] = {{six, 2}, {six, 3}}, cut[] = {{five, 2}}, broken[] = {{bad, 3}};
  CHECK_THROWS_AS(make_descriptor_base(uneven, DistanceKind::l1), std::invalid_argument);
  CHECK_THROWS_AS(make_descriptor_base(cut, DistanceKind::l1), std::invalid_argument);
  CHECK_THROWS_AS(make_descriptor_base(broken, DistanceKind::l1), std::invalid_argument);
  CHECK_THROWS_AS(make_descriptor_base({}, DistanceKind::l1), std::invalid_argument);
  const DescriptorBlock weightless[] = {{six, 2, 0.0}}, negative[] = {{six, 2, -1.0}};
  CHECK_THROWS_AS(make_descriptor_base(weightless, DistanceKind::l1), std::invalid_argument);
  CHECK_THROWS_AS(make_descriptor_base(negative, DistanceKind::l1), std::invalid_argument);
}
