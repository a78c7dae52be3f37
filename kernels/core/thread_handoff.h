// Annotates for ThreadSanitizer the hand-offs between threads that it cannot see. The distribution's TBB is
// not instrumented: its task queues order what one thread wrote before spawning and another reads in the
// task, but the sanitizer does not see that. Only ordering that TBB guarantees is annotated; everything else
// stays checked. In other builds these functions are empty.
#pragma once

#if defined(__SANITIZE_THREAD__)
#define MEANDER_THREAD_SANITIZER 1
#elif defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define MEANDER_THREAD_SANITIZER 1
#endif
#endif

#include <cstddef>
#include <cstdint>

#ifdef MEANDER_THREAD_SANITIZER
#include <sanitizer/tsan_interface.h>
#endif

// For the function that TBB calls: it finds its captures and arguments in memory that another thread wrote,
// before it can take anything over, so its own accesses are not looked at. It must do no more than take over
// and call on.
#ifdef MEANDER_THREAD_SANITIZER
#define MEANDER_CALLED_BY_TBB __attribute__((no_sanitize("thread")))
#else
#define MEANDER_CALLED_BY_TBB
#endif

namespace meander {

// Publishes what this thread has written to the thread that later calls take_over with the same address.
inline void hand_over([[maybe_unused]] const void* address) {
#ifdef MEANDER_THREAD_SANITIZER
  __tsan_release(const_cast<void*>(address));
#endif
}

inline void take_over([[maybe_unused]] const void* address) {
#ifdef MEANDER_THREAD_SANITIZER
  __tsan_acquire(const_cast<void*>(address));
#endif
}

// take_over for every address of a range of memory in which TBB may keep the counters that it waits on. The
// last step of a worker updates such a counter, and the sanitizer does not see the wait for it.
inline void take_over_all([[maybe_unused]] const void* begin, [[maybe_unused]] std::size_t bytes) {
#ifdef MEANDER_THREAD_SANITIZER
  for (std::size_t at = 0; at < bytes; at += 4) take_over(static_cast<const char*>(begin) + at);
#endif
}

// Scope of one piece of work on the object at `address`: it sees what earlier scopes on it wrote, and later
// scopes see what it writes. For the bodies of a flow graph, which TBB runs one after the other for one item
// or serial node.
class Turn {
 public:
  explicit Turn(const void* address) : address_(address) { take_over(address_); }
  Turn(const Turn&) = delete;
  Turn& operator=(const Turn&) = delete;
  ~Turn() { hand_over(address_); }

 private:
  const void* address_;
};

// The two synchronisation edges of a parallel loop: from the thread that starts it to every task, and from
// every task to the end of the loop. Not from task to task.
class LoopHandoff {
 public:
  LoopHandoff() { hand_over(&begin_); }
  LoopHandoff(const LoopHandoff&) = delete;
  LoopHandoff& operator=(const LoopHandoff&) = delete;
  ~LoopHandoff() {  // also when a task has thrown
    take_over(&end_);
#ifdef MEANDER_THREAD_SANITIZER
    // TBB waited in a frame called from the one that holds this object; the stack grows downwards.
    constexpr std::size_t frames = 4096;
    take_over_all(reinterpret_cast<const char*>(reinterpret_cast<std::uintptr_t>(this) / 8 * 8 - frames),
                  frames);
#endif
  }

  // Lives as long as a task works.
  class Task {
   public:
    explicit Task(const LoopHandoff& loop) : loop_(loop) { take_over(&loop_.begin_); }
    Task(const Task&) = delete;
    Task& operator=(const Task&) = delete;
    ~Task() { hand_over(&loop_.end_); }

   private:
    const LoopHandoff& loop_;
  };

 private:
  char begin_ = 0, end_ = 0;
};

}  // namespace meander
