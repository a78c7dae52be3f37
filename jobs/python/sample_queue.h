// From the thread that has the meshes to the threads that sample them, and back.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "jobs/python/array_mesh.h"
#include "kernels/data/samples.h"

namespace meander {

using SharedMesh = std::shared_ptr<ContentMesh>;

struct SampledRow {
  std::uint64_t index = 0;
  Content content{};
  Row row;
  std::vector<AttributeColumn> attributes = {};  // what the attributes of row.samples are called
};

class SampleQueue {
 public:
  struct Entry {
    std::uint64_t index = 0;
    SharedMesh mesh;
  };

  void set_room(std::size_t meshes) {
    const std::lock_guard lock(mutex_);
    room_ = meshes;
  }
  // False when there is no room yet.
  bool offer(Entry entry, std::chrono::milliseconds patience) {
    std::unique_lock lock(mutex_);
    if (!changed_.wait_for(lock, patience, [this] { return waiting_.size() < room_; })) return false;
    waiting_.push_back(std::move(entry));
    changed_.notify_all();
    return true;
  }
  void close() {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    changed_.notify_all();
  }
  // Blocks; none once the queue is closed and empty.
  std::optional<Entry> take() {
    std::unique_lock lock(mutex_);
    // wait() is of a later library than all else here, and would keep the wheel from older systems.
    while (!changed_.wait_for(lock, std::chrono::hours(1), [this] { return closed_ || !waiting_.empty(); })) {
    }
    if (waiting_.empty()) return std::nullopt;
    Entry entry = std::move(waiting_.front());
    waiting_.pop_front();
    changed_.notify_all();
    return entry;
  }
  void put(SampledRow row) {
    const std::lock_guard lock(mutex_);
    done_.push_back(std::move(row));
    changed_.notify_all();
  }
  // None when there is none within that time.
  std::optional<SampledRow> take_done(std::chrono::milliseconds patience) {
    std::unique_lock lock(mutex_);
    if (!changed_.wait_for(lock, patience, [this] { return !done_.empty(); })) return std::nullopt;
    SampledRow row = std::move(done_.front());
    done_.pop_front();
    return row;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Entry> waiting_;
  std::deque<SampledRow> done_;
  std::size_t room_ = 0;
  bool closed_ = false;
};

}  // namespace meander
