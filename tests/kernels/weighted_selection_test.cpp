// Selection by mass against sorting: the same entry and the same mass before it, for rows that are random, in
// order or equal but for their numbers, and where what is left is sorted early.
#include "kernels/partition/weighted_selection.h"

#include <algorithm>
#include <cstdint>
#include <random>
#include <vector>

#include "support/catch.h"

using namespace meander;

namespace {

// By sorting.
SelectedEntry selected_slowly(std::vector<std::uint64_t> row, std::uint64_t target,
                              const std::vector<std::uint64_t>& mass) {
  std::sort(row.begin(), row.end());
  std::uint64_t below = 0;
  for (std::size_t i = 0; i + 1 < row.size(); ++i) {
    const std::uint64_t next = mass[row[i] & 0xFFFFFFFFu];
    if (target < below + next) return {i, below};
    below += next;
  }
  return {row.size() - 1, below};
}

// Returns how many entries were looked at.
std::uint64_t check_row(const std::vector<std::uint64_t>& row, const std::vector<std::uint64_t>& mass,
                        std::uint64_t target, int most_rounds = -1) {
  const SelectedEntry wanted = selected_slowly(row, target, mass);
  std::vector<std::uint64_t> found_row = row;
  std::uint64_t looked_at = 0;
  const auto mass_of = [&](std::uint64_t entry) {
    ++looked_at;
    return mass[entry & 0xFFFFFFFFu];
  };
  const SelectedEntry found = most_rounds < 0 ? select_by_mass(found_row, target, mass_of)
                                              : select_by_mass(found_row, target, mass_of, most_rounds);
  REQUIRE(found.place == wanted.place);
  REQUIRE(found.below == wanted.below);
  const auto place = found_row.begin() + static_cast<std::ptrdiff_t>(found.place);
  const auto is_lower = [&](std::uint64_t entry) { return entry < *place; };
  REQUIRE(std::all_of(found_row.begin(), place, is_lower));
  REQUIRE(std::none_of(place, found_row.end(), is_lower));
  std::vector<std::uint64_t> sorted = row;
  std::sort(sorted.begin(), sorted.end());
  std::sort(found_row.begin(), found_row.end());
  REQUIRE(found_row == sorted);
  return looked_at;
}

}  // namespace

TEST_CASE("select_by_mass: random rows give the selection of sorted ones", "[order]") {
  std::mt19937_64 random(5);
  for (std::size_t size = 1; size < 200; size += size < 20 ? 1 : 23) {
    for (int repeat = 0; repeat < 20; ++repeat) {
      std::vector<std::uint64_t> row(size), mass(size);
      std::uint64_t total = 0;
      for (std::size_t i = 0; i < size; ++i) {
        row[i] = (random() % 16) << 32 | i;  // many equal coordinates
        mass[i] = random() % 4 == 0 ? 0 : random() % 100;
        total += mass[i];
      }
      for (const std::uint64_t target : {std::uint64_t{0}, total / 3, total / 2, total, total + 7})
        check_row(row, mass, target);
    }
  }
}

TEST_CASE("select_by_mass: sorted rows cost as much as random ones, and any row is sorted in the end") {
  constexpr std::size_t size = 4096;
  const std::vector<std::uint64_t> mass(size, 1);
  std::vector<std::uint64_t> ascending(size), descending(size), pipes(size);
  for (std::size_t i = 0; i < size; ++i) {
    ascending[i] = std::uint64_t{i} << 32 | i;
    descending[i] = std::uint64_t{size - i} << 32 | i;
    pipes[i] = std::uint64_t{std::min(i, size - i)} << 32 | i;
  }
  for (const auto& row : {ascending, descending, pipes})
    for (const std::uint64_t target : {0u, 1u, 1000u, 2047u, 3000u, 4000u, 4095u, 5000u}) {
      CHECK(check_row(row, mass, target) <= 5 * size);  // 3 of random rows
      for (const int rounds : {0, 1, 3}) check_row(row, mass, target, rounds);
    }
}
