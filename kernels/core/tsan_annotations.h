// Annotations for ThreadSanitizer of the order that oneTBB guarantees between threads; empty in all other
// builds.
//
// The distribution's TBB is not instrumented: its task queues order what one thread wrote before spawning and
// another reads in the task, but the sanitizer does not see that. Nothing here synchronizes anything. Only
// ordering that TBB guarantees is annotated; everything else stays checked.
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
// before it can acquire anything, so its own accesses are not looked at. It must do no more than acquire and
// call on.
#ifdef MEANDER_THREAD_SANITIZER
#define MEANDER_CALLED_BY_TBB __attribute__((no_sanitize("thread")))
#else
#define MEANDER_CALLED_BY_TBB
#endif

namespace meander {

// Tells the sanitizer that what this thread has written is visible to the thread that later calls
// tsan_acquire with the same address.
inline void tsan_release([[maybe_unused]] const void* address) {
#ifdef MEANDER_THREAD_SANITIZER
  __tsan_release(const_cast<void*>(address));
#endif
}

inline void tsan_acquire([[maybe_unused]] const void* address) {
#ifdef MEANDER_THREAD_SANITIZER
  __tsan_acquire(const_cast<void*>(address));
#endif
}

// tsan_acquire for every address of a range of memory in which TBB may keep the counters that it waits on.
// The last step of a worker updates such a counter, and the sanitizer does not see the wait for it.
inline void tsan_acquire_all([[maybe_unused]] const void* begin, [[maybe_unused]] std::size_t bytes) {
#ifdef MEANDER_THREAD_SANITIZER
  for (std::size_t at = 0; at < bytes; at += 4) tsan_acquire(static_cast<const char*>(begin) + at);
#endif
}

// Scope of one piece of work on the object at `address`: it sees what earlier scopes on it wrote, and later
// scopes see what it writes. For the bodies of a flow graph, which TBB runs one after the other for one item
// or serial node.
class TsanTurn {
 public:
  explicit TsanTurn(const void* address) : address_(address) { tsan_acquire(address_); }
  TsanTurn(const TsanTurn&) = delete;
  TsanTurn& operator=(const TsanTurn&) = delete;
  ~TsanTurn() { tsan_release(address_); }

 private:
  const void* address_;
};

// The two synchronisation edges of a parallel loop: from the thread that starts it to every task, and from
// every task to the end of the loop. Not from task to task.
class TsanLoop {
 public:
  TsanLoop() { tsan_release(&begin_); }
  TsanLoop(const TsanLoop&) = delete;
  TsanLoop& operator=(const TsanLoop&) = delete;
  ~TsanLoop() {  // also when a task has thrown
    tsan_acquire(&end_);
#ifdef MEANDER_THREAD_SANITIZER
    // TBB waited in a frame called from the one that holds this object; the stack grows downwards.
    constexpr std::size_t frames = 4096;
    tsan_acquire_all(reinterpret_cast<const char*>(reinterpret_cast<std::uintptr_t>(this) / 8 * 8 - frames),
                     frames);
#endif
  }

  // Lives as long as a task works.
  class Task {
   public:
    explicit Task(const TsanLoop& loop) : loop_(loop) { tsan_acquire(&loop_.begin_); }
    Task(const Task&) = delete;
    Task& operator=(const Task&) = delete;
    ~Task() { tsan_release(&loop_.end_); }

   private:
    const TsanLoop& loop_;
  };

 private:
  char begin_ = 0, end_ = 0;
};

}  // namespace meander
