#include "kernels/rays/embree_device.h"

#include <stdexcept>

#include "kernels/core/instruction_set.h"
#include "kernels/core/status.h"
#include "kernels/rays/embree_adapter.h"

namespace meander {

namespace {

// SSE4.2 is what the project's baseline (x86-64-v2) guarantees. A fixed instruction set keeps the hits the
// same on every machine: wider ones contract products and sums, which moves the borders of triangles by a
// rounding. No `threads=`: it would throttle the TBB of the whole process.
constexpr const char* device_settings = is_x86 ? "isa=sse4.2" : "";

void remember_error(void* user, RTCError, const char* message) {
  auto* handle = static_cast<EmbreeDevice::Handle*>(user);
  const std::lock_guard lock(handle->mutex);
  handle->last_message = message == nullptr ? "" : message;
}

}  // namespace

void throw_embree_error(EmbreeDevice::Handle& handle, const char* doing) {
  const RTCError code = rtcGetDeviceError(handle.device);
  if (code == RTC_ERROR_NONE) return;
  if (code == RTC_ERROR_OUT_OF_MEMORY)
    throw ItemError(Status::out_of_memory, std::string("Embree ran out of memory while ") + doing);
  const std::lock_guard lock(handle.mutex);
  throw std::logic_error(std::string("Embree error ") + std::to_string(static_cast<int>(code)) + " while " +
                         doing + ": " + handle.last_message);
}

EmbreeDevice::EmbreeDevice() : handle_(std::make_unique<Handle>()) {
  handle_->device = rtcNewDevice(device_settings);
  if (handle_->device == nullptr) {
    const RTCError code = rtcGetDeviceError(nullptr);
    if (code == RTC_ERROR_OUT_OF_MEMORY)
      throw ItemError(Status::out_of_memory, "Embree ran out of memory while it was started");
    throw std::logic_error("Embree gives no device with " + std::string(device_settings) + ": error " +
                           std::to_string(static_cast<int>(code)));
  }
  rtcSetDeviceErrorFunction(handle_->device, remember_error, handle_.get());
}

EmbreeDevice::~EmbreeDevice() { rtcReleaseDevice(handle_->device); }

}  // namespace meander
