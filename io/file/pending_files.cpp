#include "io/file/pending_files.h"

#include <unistd.h>

#include <array>
#include <atomic>
#include <climits>
#include <cstring>
#include <string>

namespace meander {

namespace {

constexpr std::size_t max_files = 256;

// Paths are in fixed arrays, since a signal handler must neither allocate nor lock.
struct Slot {
  enum State : int { free, changing, noted };
  std::atomic<int> state{free};
  pid_t process = 0;
  std::array<char, PATH_MAX> path{};
};
std::array<Slot, max_files> slots;

}  // namespace

std::size_t note_pending_file(const std::filesystem::path& path) {
  const std::string text = std::filesystem::absolute(path).string();  // the handler may run in another folder
  if (text.size() >= PATH_MAX) return max_files;
  for (std::size_t i = 0; i < max_files; ++i) {
    int expected = Slot::free;
    if (!slots[i].state.compare_exchange_strong(expected, Slot::changing)) continue;
    slots[i].process = ::getpid();
    std::memcpy(slots[i].path.data(), text.c_str(), text.size() + 1);
    slots[i].state = Slot::noted;
    return i;
  }
  return max_files;
}

void forget_pending_file(std::size_t number) {
  if (number < max_files) slots[number].state = Slot::free;
}

void remove_pending_files() noexcept {
  const pid_t own = ::getpid();
  for (Slot& slot : slots)
    if (slot.state == Slot::noted && slot.process == own) ::unlink(slot.path.data());
}

}  // namespace meander
