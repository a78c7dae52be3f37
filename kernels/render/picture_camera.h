// The camera of a picture: the axes of an orthographic view, and the extent of a model along them.
#pragma once

#include <array>
#include <cstddef>

#include "kernels/core/vector3.h"

namespace meander {

// Orthonormal, in the model's frame: x of the picture to the right, y down, z towards the eye.
struct PictureAxes {
  Vector3 right{1, 0, 0}, down{0, -1, 0}, back{0, 0, 1};

  Vector3 direction(Vector3 v) const { return {dot(right, v), dot(down, v), dot(back, v)}; }
};

// towards: from the model to the eye, any length, not along `up`, which points up in the picture.
PictureAxes picture_axes(Vector3 towards, Vector3 up);

// The box of points given by their coordinates along three axes. Points that are not finite are left out.
class ViewBox {
 public:
  ViewBox();

  void add(Vector3 along);
  bool empty() const { return !(least_[0] <= most_[0]); }
  double size(std::size_t axis) const { return most_[axis] - least_[axis]; }
  // The middle in the model's frame; axes: those of the coordinates, unit vectors.
  Vector3 middle(const std::array<Vector3, 3>& axes) const;
  Vector3 middle(const PictureAxes& axes) const {
    return middle(std::array{axes.right, axes.down, axes.back});
  }

 private:
  std::array<double, 3> least_, most_;
};

}  // namespace meander
