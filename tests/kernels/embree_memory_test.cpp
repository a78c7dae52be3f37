// Embree without memory: its functions are replaced by ones that fail on demand.
#include <dlfcn.h>

#include "kernels/model/model_sampler.h"
#include "kernels/rays/embree_adapter.h"
#include "kernels/rays/embree_locator.h"
#include "support/catch.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

enum class Fails { nothing, device, commit };
Fails fails = Fails::nothing;
bool failed = false;

template <class Function>
Function next(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

Row sampled() {
  const PolygonMesh mesh = icosphere(2);
  std::vector<double> positions;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
    positions.insert(positions.end(), {mesh.x[v], mesh.y[v], mesh.z[v]});
  SampleParameters parameters = parameters_for("conformal");
  parameters.samples = 64;
  return ModelSampler(parameters).sample(polygon_mesh_of({positions, triangles_of(mesh)}));
}

}  // namespace

extern "C" {

RTCDevice rtcNewDevice(const char* settings) {
  failed = fails == Fails::device;
  return failed ? nullptr : next<RTCDevice (*)(const char*)>("rtcNewDevice")(settings);
}

void rtcCommitScene(RTCScene scene) {
  failed = fails == Fails::commit;
  if (!failed) next<void (*)(RTCScene)>("rtcCommitScene")(scene);
}

RTCError rtcGetDeviceError(RTCDevice device) {
  const bool now = failed;
  failed = false;
  return now ? RTC_ERROR_OUT_OF_MEMORY : next<RTCError (*)(RTCDevice)>("rtcGetDeviceError")(device);
}

}  // extern "C"

TEST_CASE("Embree out of memory: a scene fails its model, a device fails the Sampler") {
  CHECK(sampled().report.status == Status::ok);
  fails = Fails::commit;
  const Row row = sampled();
  fails = Fails::nothing;
  INFO(row.report.reason);
  CHECK(row.report.status == Status::out_of_memory);
  CHECK(row.report.reason.find("Embree") != std::string::npos);
  CHECK(row.samples.count() == 0);

  fails = Fails::device;
  try {
    sampled();
    FAIL("a sampler without a device");
  } catch (const ItemError& error) {
    CHECK(error.status() == Status::out_of_memory);
    CHECK(std::string(error.what()).find("Embree") != std::string::npos);
  }
  fails = Fails::nothing;
  CHECK(sampled().report.status == Status::ok);
}
