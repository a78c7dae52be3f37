#include "io/file/file_bytes.h"

#include <signal.h>
#include <sys/mman.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstdint>
#include <mutex>
#include <utility>

#include "io/file/input_file.h"

namespace meander {

namespace {

// The mappings of the process, for the handler of SIGBUS.
struct Mapping {
  std::atomic<bool> is_taken = false, is_cut = false;
  std::atomic<std::uintptr_t> begin = 0, end = 0;
};
// A model may have 1,024 images; files beyond this number are read instead of mapped.
std::array<Mapping, 16384> mappings;
struct sigaction handler_before;

void fill_what_is_gone(int, siginfo_t* info, void*) {
  const int error = errno;
  const auto at = reinterpret_cast<std::uintptr_t>(info->si_addr);
  for (Mapping& mapping : mappings) {
    if (at < mapping.begin || at >= mapping.end) continue;
    const auto page_bytes = static_cast<std::uintptr_t>(::sysconf(_SC_PAGESIZE));
    const std::uintptr_t page = at / page_bytes * page_bytes;
    if (::mmap(reinterpret_cast<void*>(page), mapping.end - page, PROT_READ,
               MAP_PRIVATE | MAP_ANONYMOUS | MAP_FIXED, -1, 0) == MAP_FAILED)
      break;
    mapping.is_cut = true;
    errno = error;
    return;
  }
  ::sigaction(SIGBUS, &handler_before, nullptr);  // it gets the signal when the instruction is retried
  errno = error;
}

void watch_mappings() {
  static std::once_flag once;
  std::call_once(once, [] {
    struct sigaction action {};
    action.sa_sigaction = fill_what_is_gone;
    action.sa_flags = SA_SIGINFO | SA_ONSTACK;
    ::sigaction(SIGBUS, &action, &handler_before);
  });
}

// The index of a free mapping, or mappings.size().
std::size_t take_mapping() {
  for (std::size_t i = 0; i < mappings.size(); ++i)
    if (!mappings[i].is_taken && !mappings[i].is_taken.exchange(true)) return i;
  return mappings.size();
}

}  // namespace

bool FileBytes::is_cut() const { return data_ != nullptr && !read_ && mappings[mapping_].is_cut; }

FileBytes::FileBytes(const std::filesystem::path& path, std::size_t max_read_bytes) {
  const InputFile file(path);
  const auto size = static_cast<std::size_t>(file.bytes());
  if (size == 0) return;
  if (size > max_read_bytes) mapping_ = take_mapping();
  if (size <= max_read_bytes || mapping_ == mappings.size()) {
    read_ = std::make_unique_for_overwrite<std::byte[]>(size);
    const Transfer done = try_read(file.descriptor(), std::span(read_.get(), size), 0);
    if (done.error != 0) throw_unreadable("read", done.error);
    data_ = read_.get();
    size_ = done.bytes;
    return;
  }
  void* const map = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file.descriptor().get(), 0);
  Mapping& mapping = mappings[mapping_];
  if (map == MAP_FAILED) {
    mapping.is_taken = false;
    throw_unreadable("mapped", errno);
  }
  watch_mappings();
  mapping.is_cut = false;
  mapping.end = reinterpret_cast<std::uintptr_t>(map) + size;
  mapping.begin = reinterpret_cast<std::uintptr_t>(map);
  ::madvise(map, size, MADV_SEQUENTIAL);
  ::madvise(map, size, MADV_WILLNEED);
  data_ = static_cast<const std::byte*>(map);
  size_ = size;
}

FileBytes::FileBytes(FileBytes&& other) noexcept
    : read_(std::move(other.read_)),
      mapping_(other.mapping_),
      data_(std::exchange(other.data_, nullptr)),
      size_(std::exchange(other.size_, 0)) {}

FileBytes::~FileBytes() {
  if (data_ == nullptr || read_) return;
  Mapping& mapping = mappings[mapping_];
  mapping.end = 0;
  mapping.begin = 0;
  // munmap takes a pointer to non-const; the mapping is private to this object.
  ::munmap(const_cast<std::byte*>(data_), size_);
  mapping.is_taken = false;
}

}  // namespace meander
