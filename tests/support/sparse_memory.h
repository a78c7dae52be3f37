// Address space for input far larger than memory: zero pages that take no memory until they are touched.
#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <string_view>

namespace meander::test {

class SparseMemory {
 public:
  explicit SparseMemory(std::size_t bytes)
      : data_(::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1,
                     0)),
        size_(bytes) {}
  ~SparseMemory() {
    if (*this) ::munmap(data_, size_);
  }
  SparseMemory(const SparseMemory&) = delete;
  SparseMemory& operator=(const SparseMemory&) = delete;

  explicit operator bool() const { return data_ != MAP_FAILED; }  // false: the system gives no such space
  char* data() const { return static_cast<char*>(data_); }
  std::string_view text() const { return {data(), size_}; }

 private:
  void* data_;
  std::size_t size_;
};

}  // namespace meander::test
