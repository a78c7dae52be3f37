// Internal to kernels/render: the samples that a picture shows, their light, and averages around them.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/vector3.h"
#include "kernels/render/depth_picture.h"
#include "kernels/render/stroke_picture.h"

namespace meander {

// A sample that is seen, in the camera's frame.
struct SeenSample {
  std::uint32_t index;
  Vector3 at, normal;   // pixels; a unit vector that faces the eye
  Vector3 along;        // the primary direction, a unit vector
  double light;         // 0..1
  double shine;         // how near its mirrored light comes to the eye, 0..1
  std::uint8_t length;  // bin of its primary spacing
};

// The light and the parts that it reaches.
class Lighting {
 public:
  // The mesh as the light sees it decides what lies in shadow (Williams 1978, "Casting curved shadows on
  // curved surfaces").
  Lighting(const StrokeModel& model, const StrokePictureParameters& parameters, const PictureView& view);

  // Unit vectors towards the light: in the camera's frame, and in that of the model.
  Vector3 towards() const { return towards_; }
  Vector3 world() const { return world_; }

  // Share of the light that arrives at a point of the model with this cosine against it.
  double arriving(Vector3 point, double facing) const;
  // The light of a surface that faces along `normal` (camera's frame), 0..1: key light and the reflection of
  // the ground, less in hollows.
  double on(Vector3 normal, double arrives, double hollow) const;
  // How near the mirrored light comes to the eye, 0..1.
  double shine(Vector3 normal, double arrives) const;

 private:
  Vector3 towards_, world_;
  PictureView view_;
  DepthPicture seen_;
};

// The samples whose points are seen, in their order. O(n + pixels).
std::vector<SeenSample> seen_samples(const StrokeModel& model, const PictureView& view,
                                     const DepthPicture& depth, const Lighting& lighting);

// Averages of the seen samples in square cells: directions without a sign, along which strokes bend, and
// light.
class SeenGrid {
 public:
  // `contours`: directions along the silhouette instead of the primary ones.
  SeenGrid(std::span<const SeenSample> seen, std::uint32_t width, std::uint32_t height, double cell,
           bool contours = false);

  // The angle of the directions around (x, y) to (cosine, sine), at most a quarter turn; 0 if there are none.
  double turn(double x, double y, double cosine, double sine) const;
  // The mean light around (x, y); `own` if there is none.
  double light(double x, double y, double own) const;

 private:
  std::size_t index(double x, double y) const;

  double cell_;
  std::int64_t columns_, rows_;
  std::vector<std::array<double, 2>> directions_;  // sums of the cosine and sine of the doubled angle
  std::vector<std::array<double, 2>> lights_;      // sum and number
};

}  // namespace meander
