// HDF5 identifiers that close themselves, one lock for the whole library, and failures as exceptions.
// Included by the .cpp files of io/store only.
#pragma once

#include <hdf5.h>

#include <mutex>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

namespace meander::store {

// A failed HDF5 call: what was attempted and the innermost description of the library's error stack.
class Hdf5Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Held around every use of the library, whose builds are thread-safe on some systems only; silences its own
// error printing, which is a setting of the thread. Recursive: reading a row is made of smaller reads.
class Hdf5Lock {
 public:
  Hdf5Lock();

 private:
  std::scoped_lock<std::recursive_mutex> lock_;
};

[[noreturn]] void throw_hdf5_error(std::string_view action);

template <class Result>
Result hdf5_check(Result result, std::string_view action) {
  if (result < 0) throw_hdf5_error(action);
  return result;
}

template <herr_t (*Close)(hid_t)>
class Hdf5Handle {
 public:
  Hdf5Handle() = default;
  Hdf5Handle(hid_t id, std::string_view action) : id_(hdf5_check(id, action)) {}
  Hdf5Handle(Hdf5Handle&& other) noexcept : id_(std::exchange(other.id_, -1)) {}
  Hdf5Handle& operator=(Hdf5Handle&& other) noexcept {
    std::swap(id_, other.id_);
    return *this;
  }
  ~Hdf5Handle() { close(); }
  hid_t get() const { return id_; }
  explicit operator bool() const { return id_ >= 0; }
  // False when the library could not close it.
  bool close() { return id_ < 0 || Close(std::exchange(id_, -1)) >= 0; }

 private:
  hid_t id_ = -1;
};

using Hdf5File = Hdf5Handle<H5Fclose>;
using Hdf5Group = Hdf5Handle<H5Gclose>;
using Hdf5Dataset = Hdf5Handle<H5Dclose>;
using Hdf5Type = Hdf5Handle<H5Tclose>;
using Hdf5Space = Hdf5Handle<H5Sclose>;
using Hdf5Attribute = Hdf5Handle<H5Aclose>;
using Hdf5Properties = Hdf5Handle<H5Pclose>;

// File access without the library's locks. What is written here has a name of its own, or stands under a lock
// of ours, and what is read never changes: locks would only refuse read-only and network folders, and fail
// when a signal interrupts them.
Hdf5Properties access_without_locks();

}  // namespace meander::store
