// Long work away from the interpreter, which Ctrl-C can end.
#pragma once

#include <pybind11/pybind11.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>

namespace meander {

// A thread that runs work(cancelled) while Python stays free. To be used with the GIL held.
class BackgroundWork {
 public:
  template <class Work>
  explicit BackgroundWork(Work work)
      : thread_([this, work = std::move(work)] {
          try {
            work(cancelled_);
          } catch (...) {
            error_ = std::current_exception();
          }
          const std::lock_guard lock(mutex_);
          ended_ = true;
          changed_.notify_all();
        }) {}
  // Cancels what has not been waited for.
  ~BackgroundWork() {
    if (!thread_.joinable()) return;
    const pybind11::gil_scoped_release released;
    stop();
  }
  BackgroundWork(const BackgroundWork&) = delete;
  BackgroundWork& operator=(const BackgroundWork&) = delete;

  // Returns when the work has ended, rethrowing what it threw; handlers of signals run meanwhile, and what
  // they raise (KeyboardInterrupt) cancels the work.
  void wait() {
    while (!ended_within(std::chrono::milliseconds(50)))
      if (PyErr_CheckSignals() != 0) {
        const pybind11::error_already_set raised;
        {
          const pybind11::gil_scoped_release released;
          stop();
        }
        throw raised;
      }
    {
      const pybind11::gil_scoped_release released;
      thread_.join();
    }
    if (error_) std::rethrow_exception(error_);
  }

 private:
  bool ended_within(std::chrono::milliseconds time) {
    const pybind11::gil_scoped_release released;
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, time, [this] { return ended_; });
  }
  void stop() {
    cancelled_ = true;
    thread_.join();
  }

  std::atomic<bool> cancelled_{false};
  std::mutex mutex_;
  std::condition_variable changed_;
  bool ended_ = false;
  std::exception_ptr error_;
  std::thread thread_;  // last: it uses the others
};

}  // namespace meander
