// The device that Embree's scenes belong to.
#pragma once

#include <memory>

namespace meander {

// One Embree device for the process, with a fixed instruction set and no thread settings of its own.
// Thread-safe. Errors of Embree become exceptions: ItemError(out_of_memory) or std::logic_error.
class EmbreeDevice {
 public:
  EmbreeDevice();
  ~EmbreeDevice();
  EmbreeDevice(const EmbreeDevice&) = delete;
  EmbreeDevice& operator=(const EmbreeDevice&) = delete;
  struct Handle;
  Handle& handle() const { return *handle_; }

 private:
  std::unique_ptr<Handle> handle_;
};

}  // namespace meander
