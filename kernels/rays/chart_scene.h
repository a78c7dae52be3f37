// One chart as an Embree scene: which of its triangles lie over points of the plane.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/rays/embree_device.h"

namespace meander {

// A ray that meets more triangles than this is on a collapsed spot of the chart, where hits carry no
// information: it is marked as crowded and its hits are dropped.
inline constexpr std::uint32_t most_hits_per_ray = 64;

// Hits of R rays: ray i met triangle[begin[i]] .. triangle[begin[i + 1] - 1], ascending, each once.
struct RayHits {
  std::vector<std::uint32_t> begin;  // R + 1
  std::vector<std::uint32_t> triangle;
  std::vector<std::uint8_t> crowded;  // R: 1 where the ray was given up; it then has no hits

  std::span<const std::uint32_t> of(std::size_t ray) const {
    return {triangle.data() + begin[ray], begin[ray + 1] - begin[ray]};
  }
};

// All triangles of a chart at z = 0 in one geometry, float32, borders closed (a point on an edge may meet
// both triangles, never none). Building: 70 ns a triangle. Throws what EmbreeDevice documents.
class ChartScene {
 public:
  // u, v: chart vertices; triangles: 3 T of them, which must stay where they are while the scene lives.
  ChartScene(const EmbreeDevice& device, std::span<const double> u, std::span<const double> v,
             std::span<const std::uint32_t> triangles);
  ~ChartScene();
  ChartScene(const ChartScene&) = delete;
  ChartScene& operator=(const ChartScene&) = delete;

  // Rays along z through the points (u[i], v[i]); neighbors in the arrays should be neighbors in the plane.
  // Thread-safe; deterministic for every thread count. About 100 ns a ray, 8 bytes a ray and hit.
  void cast(std::span<const float> u, std::span<const float> v, RayHits& hits,
            const CancelToken& cancel = {}) const;

 private:
  EmbreeDevice::Handle& handle_;
  void* scene_ = nullptr;
};

}  // namespace meander
