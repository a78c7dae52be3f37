#include "io/store/file_checksum.h"

#include <fmt/format.h>
#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <span>
#include <system_error>
#include <thread>
#include <vector>

#include "io/store/crc32c.h"

namespace meander::store {

namespace {

constexpr std::uint64_t block_bytes = std::uint64_t{4} << 20;  // what a thread takes at a time
constexpr std::size_t read_bytes = std::size_t{256} << 10;     // stays in the second-level cache until summed
constexpr std::size_t most_threads = 8;                        // more only share the bandwidth of the memory

// Sums the blocks of one file. Blocks are handed out in order, so that a disk reads on.
class BlockSums {
 public:
  BlockSums(const FileDescriptor& file, std::uint64_t begin, std::uint64_t end,
            const std::filesystem::path& path)
      : file_(file),
        begin_(begin),
        end_(end),
        path_(path),
        sums_((end - begin + block_bytes - 1) / block_bytes) {}

  std::size_t blocks() const { return sums_.size(); }

  // Run by every thread until no block is left or one of them has failed.
  void work() noexcept {
    try {
      std::vector<std::byte> buffer(read_bytes);
      for (std::size_t block = next_++; block < sums_.size(); block = next_++)
        sums_[block] = sum(block, buffer);
    } catch (...) {
      const std::lock_guard lock(error_mutex_);
      error_ = std::current_exception();
      next_ = sums_.size();
    }
  }

  std::uint32_t joined() const {
    if (error_) std::rethrow_exception(error_);
    std::uint32_t total = 0;
    for (std::size_t block = 0; block < sums_.size(); ++block)
      total = crc32c_joined(total, sums_[block], bytes_of(block));
    return total;
  }

 private:
  std::uint64_t bytes_of(std::size_t block) const {
    return std::min(block_bytes, end_ - begin_ - block * block_bytes);
  }

  std::uint32_t sum(std::size_t block, std::vector<std::byte>& buffer) const {
    std::uint64_t offset = begin_ + block * block_bytes;
    std::uint32_t checksum = 0;
    for (std::uint64_t left = bytes_of(block); left > 0;) {
      const auto part = std::span(buffer).first(std::min<std::uint64_t>(left, buffer.size()));
      if (read_at(file_, part, offset, path_) < part.size())
        throw RunError(RunError::Kind::unusable,
                       fmt::format("{} became shorter while it was read", path_.string()));
      checksum = crc32c(std::span<const std::byte>(part), checksum);
      offset += part.size();
      left -= part.size();
    }
    return checksum;
  }

  const FileDescriptor& file_;
  const std::uint64_t begin_, end_;
  const std::filesystem::path& path_;
  std::vector<std::uint32_t> sums_;
  std::atomic<std::size_t> next_{0};
  std::mutex error_mutex_;
  std::exception_ptr error_;
};

}  // namespace

std::uint32_t checksum_of_file(const FileDescriptor& file, std::uint64_t begin,
                               const std::filesystem::path& path, std::size_t threads) {
  BlockSums sums(file, begin, std::max(begin, file_size(file, path)), path);
  {
    // Separate threads rather than the pool's: a job that tries items in forked children opens its store
    // first, and a process with a pool cannot fork.
    std::vector<std::jthread> helpers;
    try {
      for (std::size_t i = 1; i < std::min(threads, sums.blocks()); ++i)
        helpers.emplace_back([&sums] { sums.work(); });
    } catch (const std::system_error&) {  // no more threads to be had: those that are there do the work
    }
    sums.work();
  }
  return sums.joined();
}

std::uint32_t checksum_of_file(const FileDescriptor& file, std::uint64_t begin,
                               const std::filesystem::path& path) {
  using oneapi::tbb::global_control;
  const std::size_t allowed = global_control::active_value(global_control::max_allowed_parallelism);
  return checksum_of_file(file, begin, path, std::min(allowed, most_threads));
}

}  // namespace meander::store
