#include "io/file/atomic_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <climits>
#include <cstring>
#include <string>
#include <system_error>

#include "io/file/directory.h"

namespace meander {

namespace fs = std::filesystem;

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

namespace {

fs::path replaced_file(const fs::path& path, FullDisk full_disk) {
  std::error_code none;
  const fs::file_status status = fs::status(path, none);
  if (!fs::exists(status)) return path;
  if (fs::is_directory(status)) throw_file_error(EISDIR, "replace", path, full_disk);
  if (!fs::is_regular_file(status))
    throw RunError(RunError::Kind::unusable,
                   fmt::format("cannot replace {}: not a regular file", path.string()));
  return fs::is_symlink(path, none) ? fs::canonical(path) : path;
}

}  // namespace

PendingFile::PendingFile(const fs::path& path, FullDisk full_disk)
    : path_(replaced_file(path, full_disk)), temporary_(path_), full_disk_(full_disk) {
  temporary_ += fmt::format(".tmp{}", ::getpid());
  noted_ = note_pending_file(temporary_);
}

PendingFile::~PendingFile() {
  if (!committed_) ::unlink(temporary_.c_str());
  forget_pending_file(noted_);
}

void PendingFile::fail(int error, std::string_view action) const {
  throw_file_error(error, action, path_, full_disk_);
}

FileDescriptor PendingFile::create() {
  FileDescriptor file = try_open(temporary_, O_WRONLY | O_CREAT | O_TRUNC);
  if (!file) fail(errno, "create");
  return file;
}

void PendingFile::commit(FileDescriptor file) {
  if (!file) file = try_open(temporary_, O_RDWR);
  if (!file) fail(errno, "open");
  if (uninterrupted([&] { return ::fsync(file.get()); }) != 0) fail(errno, "sync");
  if (const int error = file.close(); error != 0) fail(error, "close");
  if (::rename(temporary_.c_str(), path_.c_str()) != 0) fail(errno, "rename to");
  committed_ = true;
  sync_folder(path_.parent_path(), full_disk_);
}

AtomicFile::AtomicFile(const fs::path& path, FullDisk full_disk)
    : pending_(path, full_disk), file_(pending_.create()) {}

void AtomicFile::append(std::span<const std::byte> bytes) {
  if (const int error = try_write(file_, bytes, size_).error; error != 0) pending_.fail(error, "write");
  size_ += bytes.size();
}

void AtomicFile::append(std::string_view text) { append(std::as_bytes(std::span<const char>(text))); }

void AtomicFile::commit() { pending_.commit(std::move(file_)); }

void replace_file(const fs::path& path, std::span<const std::byte> bytes, FullDisk full_disk) {
  AtomicFile file(path, full_disk);
  file.append(bytes);
  file.commit();
}

void replace_file(const fs::path& path, std::string_view text, FullDisk full_disk) {
  replace_file(path, std::as_bytes(std::span<const char>(text)), full_disk);
}

}  // namespace meander
