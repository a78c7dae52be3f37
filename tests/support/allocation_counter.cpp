#include "support/allocation_counter.h"

#include <dlfcn.h>
#include <malloc.h>
#include <sys/mman.h>

#include <atomic>
#include <cerrno>
#include <cstddef>

namespace {

std::atomic<std::int64_t> held{0}, most{0};

[[maybe_unused]] void add(std::int64_t bytes) {
  const std::int64_t now = held.fetch_add(bytes, std::memory_order_relaxed) + bytes;
  std::int64_t before = most.load(std::memory_order_relaxed);
  while (now > before && !most.compare_exchange_weak(before, now, std::memory_order_relaxed)) {
  }
}

}  // namespace

namespace meander::test {

bool counts_allocations() {
#ifdef MEANDER_COUNTS_ALLOCATIONS
  return true;
#else
  return false;
#endif
}

std::int64_t allocated_bytes() { return held.load(); }
std::int64_t peak_allocated_bytes() { return most.load(); }
void reset_peak() { most.store(held.load()); }

}  // namespace meander::test

#ifdef MEANDER_COUNTS_ALLOCATIONS

// glibc's own functions under the names that it keeps for programs with a malloc of their own.
extern "C" {

void* __libc_malloc(std::size_t);
void __libc_free(void*);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);

static void* counted(void* block) {
  if (block != nullptr) add(static_cast<std::int64_t>(malloc_usable_size(block)));
  return block;
}

void* malloc(std::size_t bytes) { return counted(__libc_malloc(bytes)); }
void* calloc(std::size_t count, std::size_t bytes) { return counted(__libc_calloc(count, bytes)); }
void* memalign(std::size_t alignment, std::size_t bytes) {
  return counted(__libc_memalign(alignment, bytes));
}
void* aligned_alloc(std::size_t alignment, std::size_t bytes) { return memalign(alignment, bytes); }
int posix_memalign(void** block, std::size_t alignment, std::size_t bytes) {
  *block = memalign(alignment, bytes);
  return *block == nullptr ? ENOMEM : 0;
}
void free(void* block) {
  if (block != nullptr) add(-static_cast<std::int64_t>(malloc_usable_size(block)));
  __libc_free(block);
}
void* realloc(void* block, std::size_t bytes) {
  const auto before = block == nullptr ? 0 : static_cast<std::int64_t>(malloc_usable_size(block));
  void* const moved = __libc_realloc(block, bytes);
  if (moved != nullptr || bytes == 0) add(-before);
  return counted(moved);
}

// Files that are mapped and what libraries map themselves. malloc's own maps do not pass here.
void* mmap(void* address, std::size_t bytes, int protection, int flags, int file, off_t offset) {
  using Map = void* (*)(void*, std::size_t, int, int, int, off_t);
  static const Map next = reinterpret_cast<Map>(dlsym(RTLD_NEXT, "mmap"));
  void* const mapped = next(address, bytes, protection, flags, file, offset);
  if (mapped != MAP_FAILED) add(static_cast<std::int64_t>(bytes));
  return mapped;
}
int munmap(void* address, std::size_t bytes) {
  using Unmap = int (*)(void*, std::size_t);
  static const Unmap next = reinterpret_cast<Unmap>(dlsym(RTLD_NEXT, "munmap"));
  const int result = next(address, bytes);
  if (result == 0) add(-static_cast<std::int64_t>(bytes));
  return result;
}

}  // extern "C"

#endif
