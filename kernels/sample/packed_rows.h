// Internal to kernels/sample: rows of numbers in two bytes each.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace meander {

// Rows of `width` numbers, each rounded to 1/65535 of the range of its row. Different rows are written by any
// threads.
class PackedRows {
 public:
  PackedRows(std::size_t rows, std::size_t width)
      : width_(width), low_(rows), step_(rows), steps_(rows * width) {}

  void write(std::size_t row, std::span<const float> values) {
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    low_[row] = *low;
    step_[row] = (*high - *low) / most;
    const float per_step = step_[row] > 0 ? 1 / step_[row] : 0;
    for (std::size_t k = 0; k < width_; ++k)
      steps_[row * width_ + k] =
          static_cast<std::uint16_t>(std::min((values[k] - *low) * per_step + 0.5f, most));
  }
  void read(std::size_t row, std::span<float> values) const {
    for (std::size_t k = 0; k < width_; ++k)
      values[k] = low_[row] + step_[row] * static_cast<float>(steps_[row * width_ + k]);
  }

 private:
  static constexpr float most = 65535;
  std::size_t width_;
  std::vector<float> low_, step_;  // by row
  std::vector<std::uint16_t> steps_;
};

}  // namespace meander
