#include "io/store/hdf5_handles.h"

#include <fmt/format.h>

namespace meander::store {

namespace {

std::recursive_mutex& library_mutex() {
  static std::recursive_mutex mutex;
  return mutex;
}

herr_t take_description(unsigned, const H5E_error2_t* error, void* target) {
  auto& text = *static_cast<std::string*>(target);
  if (text.empty() && error->desc != nullptr) text = error->desc;
  return 0;
}

// HDF5 reports system errors with time, buffers and sizes over two lines; what failed and why is enough.
std::string in_short(const std::string& description) {
  constexpr std::string_view before = "error message = '";
  const std::size_t details = description.find(": time = "), why = description.find(before);
  if (details == std::string::npos || why == std::string::npos) return description;
  const std::size_t begin = why + before.size(), end = description.find('\'', begin);
  return description.substr(0, details) + ": " + description.substr(begin, end - begin);
}

}  // namespace

Hdf5Lock::Hdf5Lock() : lock_(library_mutex()) {
  // A file that a broken or full disk did not let the library close is still open when the process ends.
  // Closing it then, as the library would, crashes it (H5F__close_cb of 1.10); every other file has been
  // closed by its handle.
  static const herr_t left_open = H5dont_atexit();
  static_cast<void>(left_open);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

void throw_hdf5_error(std::string_view action) {
  std::string description;
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, take_description, &description);
  H5Eclear2(H5E_DEFAULT);
  throw Hdf5Error(fmt::format("cannot {}: {}", action,
                              description.empty() ? "unknown HDF5 error" : in_short(description)));
}

Hdf5Properties access_without_locks() {
  Hdf5Properties access(H5Pcreate(H5P_FILE_ACCESS), "make file properties");
  hdf5_check(H5Pset_file_locking(access.get(), false, true), "set file locking");
  return access;
}

}  // namespace meander::store
