#include "kernels/solve/dense_fronts.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

namespace meander {

namespace {

constexpr std::size_t block_width = 32;  // columns that are eliminated before tiles update the rest
constexpr std::size_t panel_width = 8;   // columns that are eliminated before the block is updated
constexpr std::size_t min_tiled = 24;    // columns of a block from which on packing them pays
constexpr std::size_t strip = 8;         // rows, and columns, of a tile

// Computes c[j * stride + i] -= sum over k of a[strip * k + i] * b[strip * k + j] for a tile of strip x strip
// entries; each sum is made in the order of k, and rounded after each product and each addition.
using SubtractTile = void (*)(const double* a, const double* b, std::size_t depth, double* c,
                              std::size_t stride);

// As many entries of a column as a register holds.
using Pair = double __attribute__((vector_size(16)));
using Four = double __attribute__((vector_size(32)));

// Sums a part of the tile in eight registers at a time: four columns, and rows for two registers. It is
// inlined into functions that carry their target.
template <class Register>
__attribute__((always_inline)) inline void subtract_in_registers(const double* a, const double* b,
                                                                 std::size_t depth, double* c,
                                                                 std::size_t stride) {
  constexpr std::size_t width = sizeof(Register) / sizeof(double);
  for (std::size_t right = 0; right < strip; right += 4)
    for (std::size_t down = 0; down < strip; down += 2 * width) {
      Register upper[4] = {}, lower[4] = {};
      for (std::size_t k = 0; k < depth; ++k) {
        const double* factors = b + strip * k + right;
        Register first, second;
        std::memcpy(&first, a + strip * k + down, sizeof first);
        std::memcpy(&second, a + strip * k + down + width, sizeof second);
#pragma GCC unroll 4
        for (int j = 0; j < 4; ++j) {
          upper[j] += first * factors[j];
          lower[j] += second * factors[j];
        }
      }
#pragma GCC unroll 4
      for (int j = 0; j < 4; ++j) {
        double* column = c + (right + static_cast<std::size_t>(j)) * stride + down;
        Register first, second;
        std::memcpy(&first, column, sizeof first);
        std::memcpy(&second, column + width, sizeof second);
        first -= upper[j];
        second -= lower[j];
        std::memcpy(column, &first, sizeof first);
        std::memcpy(column + width, &second, sizeof second);
      }
    }
}

void subtract_tile_by_pairs(const double* a, const double* b, std::size_t depth, double* c,
                            std::size_t stride) {
  subtract_in_registers<Pair>(a, b, depth, c, stride);
}
MEANDER_TARGET("avx2")
void subtract_tile_avx2(const double* a, const double* b, std::size_t depth, double* c, std::size_t stride) {
  subtract_in_registers<Four>(a, b, depth, c, stride);
}

SubtractTile tile_of(InstructionSet set) {
  if (set == InstructionSet::automatic) set = best_instruction_set();
  return set == InstructionSet::scalar ? subtract_tile_by_pairs : subtract_tile_avx2;
}

std::size_t strips_of(std::size_t count) { return (count + strip - 1) / strip; }

// Packs a factor as the tiles read it: strip by strip, for each k the entries of the strip's rows, padded
// with zeros. entry(i, k) stands at from[i * row_step + k * depth_step].
void pack(const double* from, std::size_t row_step, std::size_t depth_step, std::size_t count,
          std::size_t depth, std::vector<double>& packed) {
  packed.assign(strips_of(count) * strip * depth, 0);
  double* to = packed.data();
  for (std::size_t begin = 0; begin < count; begin += strip) {
    const std::size_t rows = std::min(strip, count - begin);
    for (std::size_t k = 0; k < depth; ++k, to += strip)
      for (std::size_t i = 0; i < rows; ++i) to[i] = from[(begin + i) * row_step + k * depth_step];
  }
}

// Updates a tile at the edge of the matrix, where only `rows` x `columns` entries exist.
void subtract_part(SubtractTile subtract, const double* a, const double* b, std::size_t depth, double* c,
                   std::size_t stride, std::size_t rows, std::size_t columns) {
  double tile[strip * strip] = {};
  for (std::size_t j = 0; j < columns; ++j) std::copy_n(c + j * stride, rows, tile + j * strip);
  subtract(a, b, depth, tile, strip);
  for (std::size_t j = 0; j < columns; ++j) std::copy_n(tile + j * strip, rows, c + j * stride);
}

// Subtracts the product of two packed factors from a square matrix of `count` rows, or with `lower` from its
// lower triangle and the tiles on the diagonal.
void subtract_product(SubtractTile subtract, const double* a, const double* b, std::size_t depth, double* c,
                      std::size_t stride, std::size_t count, bool lower) {
  for (std::size_t j = 0; j < count; j += strip)
    for (std::size_t i = lower ? j : 0; i < count; i += strip) {
      const std::size_t rows = std::min(strip, count - i), columns = std::min(strip, count - j);
      double* tile = c + j * stride + i;
      if (rows == strip && columns == strip)
        subtract(a + i * depth, b + j * depth, depth, tile, stride);
      else
        subtract_part(subtract, a + i * depth, b + j * depth, depth, tile, stride, rows, columns);
    }
}

// target[i] -= sum over j of columns[j * rows + i] * factors[j * step] for i in [begin, rows), four j at a
// time.
void subtract_columns(const double* columns, std::size_t rows, std::size_t count, const double* factors,
                      std::size_t step, double* target, std::size_t begin) {
  std::size_t j = 0;
  for (; j + 3 < count; j += 4) {
    const double *a = columns + j * rows, *b = a + rows, *c = b + rows, *d = c + rows;
    const double fa = factors[j * step], fb = factors[(j + 1) * step], fc = factors[(j + 2) * step],
                 fd = factors[(j + 3) * step];
    for (std::size_t i = begin; i < rows; ++i) target[i] -= (fa * a[i] + fb * b[i]) + (fc * c[i] + fd * d[i]);
  }
  for (; j < count; ++j) {
    const double* a = columns + j * rows;
    const double fa = factors[j * step];
    for (std::size_t i = begin; i < rows; ++i) target[i] -= fa * a[i];
  }
}

// A front in progress: the columns [begin, end) of a block are done, and subtracted from [end, last).
class Front {
 public:
  Front(double* values, std::size_t rows) : values_(values), rows_(rows) {}

  // Computes the columns of L, each subtracted from those behind it in the block. False when a pivot is not
  // positive.
  bool factorize(std::size_t begin, std::size_t end) const {
    for (std::size_t j = begin; j < end; ++j) {
      double* left = column(j);
      if (!(left[j] > 0)) return false;
      left[j] = std::sqrt(left[j]);
      scale_below(left, j, 1 / left[j]);
      for (std::size_t k = j + 1; k < end; ++k) subtract_columns(left, rows_, 1, left + k, 0, column(k), k);
    }
    return true;
  }
  void update_lower(std::size_t begin, std::size_t end, std::size_t last) const {
    for (std::size_t k = end; k < last; ++k)
      subtract_columns(column(begin), rows_, end - begin, column(begin) + k, rows_, column(k), k);
  }

  // The same without symmetry; R stands in the rows of the block. False when a pivot is zero or not finite.
  bool eliminate(std::size_t begin, std::size_t end) const {
    for (std::size_t j = begin; j < end; ++j) {
      double* left = column(j);
      if (!(std::abs(left[j]) > 0) || !std::isfinite(left[j])) return false;
      scale_below(left, j, 1 / left[j]);
      for (std::size_t k = j + 1; k < end; ++k)
        subtract_columns(left, rows_, 1, column(k) + j, 0, column(k), j + 1);
    }
    return true;
  }
  void update(std::size_t begin, std::size_t end, std::size_t last) const {
    for (std::size_t k = end; k < last; ++k)
      subtract_columns(column(begin), rows_, end - begin, column(k) + begin, 1, column(k), end);
  }
  // Computes the rows of R behind the block, by solving with the triangle of L beside them.
  void solve_rows(std::size_t begin, std::size_t end, std::size_t last) const {
    for (std::size_t k = end; k < last; ++k) {
      double* right = column(k);
      for (std::size_t j = begin; j < end; ++j) {
        const double* left = column(j);
        const double factor = right[j];
        for (std::size_t i = j + 1; i < end; ++i) right[i] -= factor * left[i];
      }
    }
  }

  double* column(std::size_t k) const { return values_ + k * rows_; }

 private:
  void scale_below(double* left, std::size_t j, double factor) const {
    for (std::size_t i = j + 1; i < rows_; ++i) left[i] *= factor;
  }

  double* values_;
  std::size_t rows_;
};

// Calls body(begin, end) for [begin, end) in steps of `width` until it returns false.
template <class Body>
bool in_blocks(std::size_t begin, std::size_t end, std::size_t width, const Body& body) {
  for (; begin < end; begin += width)
    if (!body(begin, std::min(end, begin + width))) return false;
  return true;
}

}  // namespace

bool factorize_front(double* values, std::size_t rows, std::size_t columns, InstructionSet set) {
  const Front front(values, rows);
  const SubtractTile subtract = tile_of(set);
  std::vector<double> packed;
  return in_blocks(0, columns, block_width, [&](std::size_t first, std::size_t last) {
    const bool tiled = last - first >= min_tiled;
    if (!in_blocks(first, last, panel_width, [&](std::size_t begin, std::size_t end) {
          if (!front.factorize(begin, end)) return false;
          front.update_lower(begin, end, tiled ? last : rows);
          return true;
        }))
      return false;
    if (!tiled) return true;
    const std::size_t depth = last - first, count = rows - last;
    pack(front.column(first) + last, 1, rows, count, depth, packed);
    subtract_product(subtract, packed.data(), packed.data(), depth, front.column(last) + last, rows, count,
                     true);
    return true;
  });
}

bool eliminate_front(double* values, std::size_t rows, std::size_t columns, InstructionSet set) {
  const Front front(values, rows);
  const SubtractTile subtract = tile_of(set);
  std::vector<double> left, right;
  return in_blocks(0, columns, block_width, [&](std::size_t first, std::size_t last) {
    const bool tiled = last - first >= min_tiled;
    if (!in_blocks(first, last, panel_width, [&](std::size_t begin, std::size_t end) {
          if (!front.eliminate(begin, end)) return false;
          const std::size_t reach = tiled ? last : rows;
          front.solve_rows(begin, end, reach);
          front.update(begin, end, reach);
          return true;
        }))
      return false;
    if (!tiled) return true;
    const std::size_t depth = last - first, count = rows - last;
    front.solve_rows(first, last, rows);
    pack(front.column(first) + last, 1, rows, count, depth, left);
    pack(front.column(last) + first, rows, 1, count, depth, right);
    subtract_product(subtract, left.data(), right.data(), depth, front.column(last) + last, rows, count,
                     false);
    return true;
  });
}

}  // namespace meander
