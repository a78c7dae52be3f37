// Tells ThreadSanitizer of the hand-offs between threads that it cannot see. The distribution's TBB is not
// instrumented: its task queues order what one thread wrote before spawning and another reads in the task,
// but the sanitizer does not know. Only edges that TBB guarantees are told; everything else stays checked. In
// any other build these are empty.
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

// What this thread has written so far is there for whoever takes over by the same address afterwards.
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

// Takes over by every address of a stretch of memory: for where TBB keeps the counts by which it waits. The
// last step of a worker is such a count, and the wait for it cannot be seen.
inline void take_over_all([[maybe_unused]] const void* begin, [[maybe_unused]] std::size_t bytes) {
#ifdef MEANDER_THREAD_SANITIZER
  for (std::size_t at = 0; at < bytes; at += 4) take_over(static_cast<const char*>(begin) + at);
#endif
}

// One piece of work on what `address` stands for: what those before it wrote is there, what it writes is
// there for those after it. For the bodies of a flow graph, which TBB runs one after the other for one item
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

// The two edges of a parallel loop: from the thread that starts it to every task, and from every task to the
// end of the loop. Not from task to task.
class LoopHandoff {
 public:
  LoopHandoff() { hand_over(&begin_); }
  LoopHandoff(const LoopHandoff&) = delete;
  LoopHandoff& operator=(const LoopHandoff&) = delete;
  ~LoopHandoff() {  // with an exception of a task too
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
