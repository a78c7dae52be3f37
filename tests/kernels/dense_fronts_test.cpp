#include "kernels/solve/dense_fronts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "kernels/core/random.h"
#include "support/catch.h"

using namespace meander;

namespace {

// Entries in [-1, 1] and a heavy diagonal, by columns.
std::vector<double> heavy_matrix(std::size_t rows, bool symmetric) {
  std::vector<double> values(rows * rows);
  for (std::size_t j = 0; j < rows; ++j)
    for (std::size_t i = 0; i < rows; ++i) {
      const std::size_t index = symmetric ? std::max(i, j) * rows + std::min(i, j) : j * rows + i;
      values[j * rows + i] = 2 * random_pair({{13, 5}}, Stream::sequence, index).first - 1;
      if (i == j) values[j * rows + i] += static_cast<double>(rows);
    }
  return values;
}

// Column by column, as the textbook has it.
std::vector<double> eliminated(std::vector<double> a, std::size_t rows, std::size_t columns, bool symmetric) {
  for (std::size_t j = 0; j < columns; ++j) {
    const double divisor = symmetric ? std::sqrt(a[j * rows + j]) : a[j * rows + j];
    if (symmetric) a[j * rows + j] = divisor;
    for (std::size_t i = j + 1; i < rows; ++i) a[j * rows + i] /= divisor;
    for (std::size_t k = j + 1; k < rows; ++k) {
      const double factor = symmetric ? a[j * rows + k] : a[k * rows + j];
      for (std::size_t i = symmetric ? k : j + 1; i < rows; ++i) a[k * rows + i] -= a[j * rows + i] * factor;
    }
  }
  return a;
}

// Below each block width, at it and above it, with and without a part of a tile at the edge.
constexpr std::array<std::pair<std::size_t, std::size_t>, 16> sizes = {{{1, 1},
                                                                        {5, 2},
                                                                        {9, 9},
                                                                        {30, 23},
                                                                        {24, 24},
                                                                        {33, 24},
                                                                        {40, 32},
                                                                        {41, 32},
                                                                        {64, 40},
                                                                        {64, 60},
                                                                        {79, 64},
                                                                        {90, 90},
                                                                        {100, 33},
                                                                        {101, 1},
                                                                        {150, 57},
                                                                        {200, 130}}};

bool factorize(std::vector<double>& a, std::size_t rows, std::size_t columns, bool symmetric,
               InstructionSet set = InstructionSet::automatic) {
  return symmetric ? factorize_front(a.data(), rows, columns, set)
                   : eliminate_front(a.data(), rows, columns, set);
}

}  // namespace

TEST_CASE("dense fronts: factors and Schur complement equal those of plain elimination") {
  for (const bool symmetric : {true, false})
    for (const auto& [rows, columns] : sizes) {
      CAPTURE(symmetric, rows, columns);
      std::vector<double> a = heavy_matrix(rows, symmetric);
      const std::vector<double> expected = eliminated(a, rows, columns, symmetric);
      REQUIRE(factorize(a, rows, columns, symmetric));
      double largest = 0;
      for (std::size_t j = 0; j < rows; ++j)
        for (std::size_t i = symmetric ? j : 0; i < rows; ++i)
          largest = std::max(largest, std::abs(a[j * rows + i] - expected[j * rows + i]));
      CHECK(largest <= 1e-14 * static_cast<double>(rows));
    }
}

TEST_CASE("dense fronts: the same bits with every instruction set") {
  for (const bool symmetric : {true, false})
    for (const auto& [rows, columns] : sizes) {
      std::vector<double> expected = heavy_matrix(rows, symmetric);
      REQUIRE(factorize(expected, rows, columns, symmetric, InstructionSet::scalar));
      for (const InstructionSet set : {InstructionSet::avx2, InstructionSet::avx512}) {
        if (!is_available(set)) continue;
        CAPTURE(symmetric, rows, columns, name_of(set));
        std::vector<double> a = heavy_matrix(rows, symmetric);
        REQUIRE(factorize(a, rows, columns, symmetric, set));
        CHECK(a == expected);
      }
    }
}

// A library that divides its products by the size of a cache fails here: a leading part of the unknowns
// has the same factor alone as with others behind it.
TEST_CASE("dense fronts: leading columns do not depend on how many follow") {
  for (const bool symmetric : {true, false}) {
    std::vector<double> few = heavy_matrix(700, symmetric), many = few;
    REQUIRE(factorize(few, 700, 64, symmetric));
    REQUIRE(factorize(many, 700, 640, symmetric));
    CHECK(std::equal(few.begin(), few.begin() + 700 * 64, many.begin()));
  }
}

TEST_CASE("dense fronts: an unusable pivot is reported") {
  for (const auto& [rows, columns, at] : {std::array<std::size_t, 3>{6, 4, 3}, {120, 80, 70}, {120, 80, 0}}) {
    CAPTURE(rows, columns, at);
    for (const double pivot : {-1e9, std::numeric_limits<double>::quiet_NaN()}) {
      std::vector<double> a = heavy_matrix(rows, true);
      a[at * rows + at] = pivot;
      CHECK_FALSE(factorize_front(a.data(), rows, columns));
    }
    std::vector<double> empty = heavy_matrix(rows, false);
    for (std::size_t i = 0; i < rows; ++i) empty[at * rows + i] = 0;
    CHECK_FALSE(eliminate_front(empty.data(), rows, columns));
    std::vector<double> endless = heavy_matrix(rows, false);
    endless[at * rows + at] = std::numeric_limits<double>::infinity();
    CHECK_FALSE(eliminate_front(endless.data(), rows, columns));
    // A pivot behind the columns is nobody's.
    std::vector<double> behind = heavy_matrix(rows, true);
    behind[(rows - 1) * rows + rows - 1] = -1e9;
    CHECK(factorize_front(behind.data(), rows, columns));
  }
}
