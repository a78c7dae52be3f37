#include "kernels/pointset/curve_point.h"

#include <algorithm>

#include "kernels/curve/curve_frames.h"

namespace meander {

namespace {

// Digits of a rank, the one of the coarsest level first.
template <std::uint64_t children>
std::array<std::uint8_t, 32> digits_of(std::uint64_t rank, int level) {
  std::array<std::uint8_t, 32> digits{};
  for (int l = level - 1; l >= 0; --l) {
    digits[static_cast<std::size_t>(l)] = static_cast<std::uint8_t>(rank % children);
    rank /= children;
  }
  return digits;
}

template <std::uint64_t branching>
CurvePoint cell_center(const FrameTable& table, std::uint64_t rank, int level) {
  const auto digits = digits_of<branching * branching>(rank, level);
  std::uint64_t x = 0, y = 0, cells = 1;
  std::uint8_t frame = 0;
  for (int l = 0; l < level; ++l) {
    const std::uint8_t digit = digits[static_cast<std::size_t>(l)];
    const std::uint8_t cell = table.cell_of_digit[frame][digit];
    x = branching * x + cell % branching;
    y = branching * y + cell / branching;
    cells *= branching;
    frame = table.child_frame[frame][digit];
  }
  const auto side = static_cast<double>(cells);
  return {(static_cast<double>(x) + 0.5) / side, (static_cast<double>(y) + 0.5) / side};
}

}  // namespace

CurvePoint curve_cell_center(CurveKind kind, std::uint64_t rank, int level) {
  const FrameTable& table = frame_table(kind);
  return kind == CurveKind::hilbert ? cell_center<2>(table, rank, level) : cell_center<3>(table, rank, level);
}

CurvePoint curve_point(CurveKind kind, double t) {
  t = std::clamp(t, 0.0, 1.0 - 0x1p-53);
  if (kind == CurveKind::hilbert) return curve_cell_center(kind, static_cast<std::uint64_t>(t * 0x1p52), 26);
  constexpr double cells = 1853020188851841.0;  // 9^16 < 2^53
  // Rounding can carry a t just below 1 up to the number of cells.
  return curve_cell_center(kind, static_cast<std::uint64_t>(std::min(t * cells, cells - 1)), 16);
}

}  // namespace meander
