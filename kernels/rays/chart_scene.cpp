#include "kernels/rays/chart_scene.h"

#include <algorithm>
#include <array>
#include <memory>

#include "kernels/core/parallel.h"
#include "kernels/rays/embree_adapter.h"

namespace meander {

namespace {

constexpr std::size_t ray_block = 2048;

RTCScene as_scene(void* scene) { return static_cast<RTCScene>(scene); }

// The hits of one packet, by lane. One more than the limit marks a crowded ray.
struct PacketRecord {
  std::array<std::uint32_t, packet_width> count;
  std::array<std::array<std::uint32_t, most_hits_per_ray>, packet_width> triangle;
};

// Records every hit and rejects it, so that the ray goes on. A full ray accepts the hit, which ends it; the
// hits recorded by then depend on the order of traversal and are dropped later.
void record_hits(const RTCFilterFunctionNArguments* arguments) {
  auto& record = *static_cast<PacketRecord*>(record_of(arguments));
  const unsigned lanes = arguments->N;
  for (unsigned i = 0; i < lanes; ++i) {
    if (arguments->valid[i] == 0) continue;
    const unsigned ray = RTCRayN_id(arguments->ray, lanes, i);
    std::uint32_t& count = record.count[ray];
    if (count < most_hits_per_ray) {
      record.triangle[ray][count++] = RTCHitN_primID(arguments->hit, lanes, i);
      arguments->valid[i] = 0;
    } else {
      count = most_hits_per_ray + 1;
    }
  }
}

void load_packet(std::span<const float> u, std::span<const float> v, std::size_t first, unsigned lanes,
                 RayPacket& rays, int* valid) {
  for (unsigned i = 0; i < packet_width; ++i) {
    const std::size_t at = first + std::min(i, lanes - 1);
    valid[i] = i < lanes ? -1 : 0;
    rays.org_x[i] = u[at];
    rays.org_y[i] = v[at];
    rays.org_z[i] = -1;
    rays.tnear[i] = 0;
    rays.dir_x[i] = 0;
    rays.dir_y[i] = 0;
    rays.dir_z[i] = 1;
    rays.time[i] = 0;
    rays.tfar[i] = 2;
    rays.mask[i] = ~0u;
    rays.id[i] = i;
    rays.flags[i] = 0;
  }
}

// Output of one block of rays, appended ray by ray.
struct BlockHits {
  std::vector<std::uint32_t> count, triangle;
  std::vector<std::uint8_t> crowded;
};

void cast_block(RTCScene scene, std::span<const float> u, std::span<const float> v, BlockHits& out) {
  out.count.reserve(u.size());
  out.crowded.reserve(u.size());
  out.triangle.reserve(u.size() + u.size() / 8);
  const auto record = std::make_unique_for_overwrite<PacketRecord>();
  RayPacket rays;
  alignas(64) std::array<int, packet_width> valid;
  for (std::size_t first = 0; first < u.size(); first += packet_width) {
    const auto lanes = static_cast<unsigned>(std::min<std::size_t>(packet_width, u.size() - first));
    load_packet(u, v, first, lanes, rays, valid.data());
    record->count.fill(0);
    trace_packet(valid.data(), scene, record.get(), rays);
    for (unsigned i = 0; i < lanes; ++i) {
      const bool crowded = record->count[i] > most_hits_per_ray;
      const std::uint32_t count = crowded ? 0 : record->count[i];
      const auto begin = record->triangle[i].begin();
      if (count > 1) std::sort(begin, begin + count);
      out.count.push_back(count);
      out.crowded.push_back(crowded);
      out.triangle.insert(out.triangle.end(), begin, begin + count);
    }
  }
}

}  // namespace

ChartScene::ChartScene(const EmbreeDevice& device, std::span<const double> u, std::span<const double> v,
                       std::span<const std::uint32_t> triangles)
    : handle_(device.handle()) {
  RTCScene scene = rtcNewScene(handle_.device);
  if (scene == nullptr) throw_embree_error(handle_, "making a scene");
  scene_ = scene;
  try {
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_LOW);
    RTCGeometry geometry = rtcNewGeometry(handle_.device, RTC_GEOMETRY_TYPE_TRIANGLE);
    if (geometry == nullptr) throw_embree_error(handle_, "making a geometry");
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);  // the scene holds it from here on
    rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_LOW);
    auto* vertex = static_cast<float*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), u.size()));
    throw_embree_error(handle_, "making the vertex buffer of a chart");
    for (std::size_t i = 0; i < u.size(); ++i) {
      vertex[3 * i] = static_cast<float>(u[i]);
      vertex[3 * i + 1] = static_cast<float>(v[i]);
      vertex[3 * i + 2] = 0;
    }
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, triangles.data(), 0,
                               3 * sizeof(std::uint32_t), triangles.size() / 3);
    rtcSetGeometryOccludedFilterFunction(geometry, record_hits);
    rtcCommitGeometry(geometry);
    // Embree builds with TBB: isolated, so that the waiting thread does not run a task of the enclosing flow
    // graph.
    oneapi::tbb::this_task_arena::isolate([&] { rtcCommitScene(scene); });
    throw_embree_error(handle_, "building the hierarchy of a chart");
  } catch (...) {
    rtcReleaseScene(scene);
    throw;
  }
}

ChartScene::~ChartScene() { rtcReleaseScene(as_scene(scene_)); }

void ChartScene::cast(std::span<const float> u, std::span<const float> v, RayHits& hits,
                      const CancelToken& cancel) const {
  std::vector<BlockHits> blocks((u.size() + ray_block - 1) / ray_block);
  parallel_blocks(u.size(), ray_block, [&](std::size_t begin, std::size_t end) {
    cancel.check();
    cast_block(as_scene(scene_), u.subspan(begin, end - begin), v.subspan(begin, end - begin),
               blocks[begin / ray_block]);
  });
  throw_embree_error(handle_, "casting rays");
  std::size_t total = 0;
  for (const BlockHits& block : blocks) total += block.triangle.size();
  hits.begin.clear();
  hits.begin.reserve(u.size() + 1);
  hits.triangle.clear();
  hits.triangle.reserve(total);
  hits.crowded.clear();
  hits.crowded.reserve(u.size());
  std::uint32_t at = 0;
  for (const BlockHits& block : blocks) {
    for (const std::uint32_t count : block.count) {
      hits.begin.push_back(at);
      at += count;
    }
    hits.triangle.insert(hits.triangle.end(), block.triangle.begin(), block.triangle.end());
    hits.crowded.insert(hits.crowded.end(), block.crowded.begin(), block.crowded.end());
  }
  hits.begin.push_back(at);
}

}  // namespace meander
