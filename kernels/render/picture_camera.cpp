#include "kernels/render/picture_camera.h"

#include <algorithm>
#include <limits>

#include "kernels/render/shading.h"

namespace meander {

PictureAxes picture_axes(Vector3 towards, Vector3 up) {
  PictureAxes axes;
  axes.back = unit_vector(towards);
  axes.right = unit_vector(cross(up, axes.back));
  axes.down = -1.0 * cross(axes.back, axes.right);
  return axes;
}

ViewBox::ViewBox() {
  least_.fill(std::numeric_limits<double>::infinity());
  most_.fill(-std::numeric_limits<double>::infinity());
}

void ViewBox::add(Vector3 along) {
  if (!finite_vector(along)) return;
  const std::array<double, 3> own = {along.x, along.y, along.z};
  for (std::size_t k = 0; k < 3; ++k) {
    least_[k] = std::min(least_[k], own[k]);
    most_[k] = std::max(most_[k], own[k]);
  }
}

Vector3 ViewBox::middle(const std::array<Vector3, 3>& axes) const {
  // Halves before the sum: what two large coordinates add up to need not be finite.
  Vector3 middle;
  for (std::size_t k = 0; k < 3; ++k) middle = middle + (0.5 * least_[k] + 0.5 * most_[k]) * axes[k];
  return middle;
}

}  // namespace meander
