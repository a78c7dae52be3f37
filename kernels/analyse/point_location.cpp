#include "kernels/analyse/point_location.h"

#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "kernels/analyse/unit_frame.h"
#include "kernels/core/nearest_on_triangle.h"
#include "kernels/core/parallel.h"
#include "kernels/rays/embree_adapter.h"

namespace meander {

namespace {

constexpr std::size_t query_block = 256;
constexpr double farthest_query = 1e15;  // working units: beyond, float squares could overflow

// The nearest point of one triangle, in working units.
struct Candidate : TrianglePlace {
  std::uint32_t triangle = 0;

  // Order of preference; no two triangles are equal in it.
  bool better_than(const Candidate& other) const {
    return squared < other.squared || (squared == other.squared && triangle < other.triangle);
  }
};

float rounded_down(double value) {
  const auto f = static_cast<float>(value);
  return static_cast<double>(f) > value ? std::nextafter(f, -std::numeric_limits<float>::infinity()) : f;
}
float rounded_up(double value) { return -rounded_down(-value); }

}  // namespace

struct SurfaceLocator::Scene {
  EmbreeDevice::Handle& handle;
  UnitFrame frame;
  std::vector<double> corners;  // 9 a triangle, working units
  RTCScene scene = nullptr;

  explicit Scene(EmbreeDevice::Handle& device) : handle(device) {}
  ~Scene() {
    if (scene != nullptr) rtcReleaseScene(scene);
  }
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  std::uint32_t count() const { return static_cast<std::uint32_t>(corners.size() / 9); }
  Vector3 corner(std::size_t triangle, std::size_t k) const {
    const double* at = corners.data() + 9 * triangle + 3 * k;
    return {at[0], at[1], at[2]};
  }
  Candidate nearest_on(std::uint32_t triangle, Vector3 p) const {
    return {nearest_on_triangle(p, corner(triangle, 0), corner(triangle, 1), corner(triangle, 2)), triangle};
  }
};

namespace {

template <class Scene>
void bounds_of(const RTCBoundsFunctionArguments* arguments) {
  const auto& scene = *static_cast<const Scene*>(arguments->geometryUserPtr);
  const Vector3 a = scene.corner(arguments->primID, 0), b = scene.corner(arguments->primID, 1),
                c = scene.corner(arguments->primID, 2);
  RTCBounds& bounds = *arguments->bounds_o;
  bounds.lower_x = rounded_down(std::min({a.x, b.x, c.x}));
  bounds.lower_y = rounded_down(std::min({a.y, b.y, c.y}));
  bounds.lower_z = rounded_down(std::min({a.z, b.z, c.z}));
  bounds.upper_x = rounded_up(std::max({a.x, b.x, c.x}));
  bounds.upper_y = rounded_up(std::max({a.y, b.y, c.y}));
  bounds.upper_z = rounded_up(std::max({a.z, b.z, c.z}));
}

// One search: the exact query point, the distance by which rounding to float moved it, and the best so far.
template <class Scene>
struct Search {
  const Scene* scene = nullptr;
  Vector3 point;
  double moved = 0;
  Candidate best;

  // Boxes of triangles as near as the best one lie within this of the rounded point. Embree's own distances
  // have a few roundings of float, 6e-8 each.
  float radius() const { return rounded_up((std::sqrt(best.squared) + moved) * (1 + 2e-6) + 1e-30); }
};

template <class Scene>
bool look_at(RTCPointQueryFunctionArguments* arguments) {
  auto& search = *static_cast<Search<Scene>*>(arguments->userPtr);
  const Candidate candidate = search.scene->nearest_on(arguments->primID, search.point);
  if (!candidate.better_than(search.best)) return false;
  search.best = candidate;
  const float radius = search.radius();
  if (!(radius < arguments->query->radius)) return false;
  arguments->query->radius = radius;
  return true;
}

}  // namespace

SurfaceLocator::SurfaceLocator(const EmbreeDevice& device, std::span<const double> x,
                               std::span<const double> y, std::span<const double> z,
                               std::span<const std::uint32_t> triangles)
    : scene_(std::make_unique<Scene>(device.handle())) {
  Scene& scene = *scene_;
  scene.frame = unit_frame(x, y, z, triangles);
  scene.corners.resize(3 * triangles.size());
  for (std::size_t c = 0; c < triangles.size(); ++c) {
    const std::uint32_t v = triangles[c];
    const Vector3 w = scene.frame.to_unit({x[v], y[v], z[v]});
    scene.corners[3 * c] = w.x;
    scene.corners[3 * c + 1] = w.y;
    scene.corners[3 * c + 2] = w.z;
  }
  scene.scene = rtcNewScene(scene.handle.device);
  RTCGeometry geometry = rtcNewGeometry(scene.handle.device, RTC_GEOMETRY_TYPE_USER);
  if (scene.scene == nullptr || geometry == nullptr) {
    if (geometry != nullptr) rtcReleaseGeometry(geometry);
    throw_embree_error(scene.handle, "making a scene of a surface");
    throw std::logic_error("Embree gives no scene");
  }
  rtcSetGeometryUserPrimitiveCount(geometry, scene.count());
  rtcSetGeometryUserData(geometry, &scene);
  rtcSetGeometryBoundsFunction(geometry, bounds_of<Scene>, nullptr);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene.scene, geometry);
  rtcReleaseGeometry(geometry);
  oneapi::tbb::this_task_arena::isolate([&] { rtcCommitScene(scene.scene); });
  throw_embree_error(scene.handle, "building the tree of a surface");
}

SurfaceLocator::~SurfaceLocator() = default;

SurfacePoint SurfaceLocator::nearest(Vector3 p) const {
  const Scene& scene = *scene_;
  Search<Scene> search;
  search.scene = &scene;
  search.point = scene.frame.to_unit(p);
  const Vector3 at = search.point;
  if (std::max({std::abs(at.x), std::abs(at.y), std::abs(at.z)}) > farthest_query) {
    for (std::uint32_t t = 0; t < scene.count(); ++t) {
      const Candidate candidate = scene.nearest_on(t, at);
      if (candidate.better_than(search.best)) search.best = candidate;
    }
  } else {
    RTCPointQuery query;
    query.x = static_cast<float>(at.x);
    query.y = static_cast<float>(at.y);
    query.z = static_cast<float>(at.z);
    query.time = 0;
    query.radius = std::numeric_limits<float>::infinity();
    search.moved = distance(at, {query.x, query.y, query.z});
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(scene.scene, &query, &context, look_at<Scene>, &search);
  }
  const Candidate& best = search.best;
  return {scene.frame.from_unit(best.point), scene.frame.unit * std::sqrt(best.squared), best.triangle,
          best.weight1, best.weight2};
}

SurfaceLocations locate_points(const SurfaceLocator& surface, std::span<const double> points) {
  if (points.size() % 3 != 0) throw std::invalid_argument("locate_points: three coordinates a point");
  for (const double c : points)
    if (!std::isfinite(c)) throw std::invalid_argument("locate_points: points must be finite");
  const std::size_t count = points.size() / 3;
  SurfaceLocations out;
  out.triangle.resize(count);
  out.barycentric.resize(2 * count);
  out.distance.resize(count);
  parallel_blocks(count, query_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const SurfacePoint found = surface.nearest({points[3 * i], points[3 * i + 1], points[3 * i + 2]});
      out.triangle[i] = found.triangle;
      out.barycentric[2 * i] = found.weight1;
      out.barycentric[2 * i + 1] = found.weight2;
      out.distance[i] = found.distance;
    }
  });
  return out;
}

}  // namespace meander
