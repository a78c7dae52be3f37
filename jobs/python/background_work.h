// Long work in a thread of its own, which its caller looks at from time to time and may end.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>

namespace meander {

// A thread that runs work(canceled).
class BackgroundWork {
 public:
  template <class Work>
  explicit BackgroundWork(Work work)
      : thread_([this, work = std::move(work)] {
          try {
            work(canceled_);
          } catch (...) {
            error_ = std::current_exception();
          }
          const std::lock_guard lock(mutex_);
          ended_ = true;
          changed_.notify_all();
        }) {}
  // Cancels what has not ended.
  ~BackgroundWork() {
    canceled_ = true;
    thread_.join();
  }
  BackgroundWork(const BackgroundWork&) = delete;
  BackgroundWork& operator=(const BackgroundWork&) = delete;

  // Whether the work has ended, within that time; rethrows what it threw.
  bool ended_within(std::chrono::milliseconds time) {
    {
      std::unique_lock lock(mutex_);
      if (!changed_.wait_for(lock, time, [this] { return ended_; })) return false;
    }
    if (error_) std::rethrow_exception(error_);
    return true;
  }

 private:
  std::atomic<bool> canceled_{false};
  std::mutex mutex_;
  std::condition_variable changed_;
  bool ended_ = false;
  std::exception_ptr error_;
  std::thread thread_;  // last: it uses the others
};

}  // namespace meander
