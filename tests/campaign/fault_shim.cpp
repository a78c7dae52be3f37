// A layer between a program and the operating system, for tests: counts the calls that touch files of one
// folder, and fails, cuts short, kills at, or records them. Preloaded (LD_PRELOAD), it needs nothing of the
// program.
//
//   MEANDER_FAULT_FOLDER  the absolute folder; calls on other files are left alone
//   MEANDER_FAULT_CALLS   names of calls, separated by commas; without it all of them
//   MEANDER_FAULT_AT      the call that is changed, from 1
//   MEANDER_FAULT_DO      ENOSPC, EIO, EINTR, EMFILE, ENOMEM or EDQUOT: it fails so; short: it transfers half
//   of its
//                         bytes; kill: the process, not a child that it forked, ends by SIGKILL before it
//   MEANDER_FAULT_STAY    with it every later call of these names fails, too, as on a disk that stays full
//   MEANDER_FAULT_LOG     a file outside of the folder; gets a line for every call, "NUMBER NAME PATH", with
//   " *" at
//                         the end where it was changed
//   MEANDER_FAULT_RECORD  a file outside of the folder; gets every call that changes what a disk holds, with
//   its data
//                         (tests/campaign/power_cuts.py has the layout)
//
// Numbers count over all threads and, from the moment of a fork on, in each process for itself.
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <climits>
#include <csignal>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <string>
#include <string_view>

namespace {

std::string text_of(const char* variable) {
  const char* const text = std::getenv(variable);
  return text == nullptr ? "" : text;
}

int error_named(std::string_view name) {
  constexpr std::array<std::pair<std::string_view, int>, 6> errors = {{{"ENOSPC", ENOSPC},
                                                                       {"EIO", EIO},
                                                                       {"EINTR", EINTR},
                                                                       {"EMFILE", EMFILE},
                                                                       {"ENOMEM", ENOMEM},
                                                                       {"EDQUOT", EDQUOT}}};
  for (const auto& [text, error] : errors)
    if (text == name) return error;
  return 0;
}

enum class Deed { pass, fail, cut };

struct Shim {
  Shim()
      : folder(text_of("MEANDER_FAULT_FOLDER")),
        calls("," + text_of("MEANDER_FAULT_CALLS") + ","),
        deed(text_of("MEANDER_FAULT_DO")),
        error(error_named(deed)),
        at(std::strtoull(text_of("MEANDER_FAULT_AT").c_str(), nullptr, 10)),
        stays(!text_of("MEANDER_FAULT_STAY").empty()) {
    const auto open_log = [](const char* variable) {
      const std::string path = text_of(variable);
      if (path.empty()) return -1;
      const int file = static_cast<int>(
          ::syscall(SYS_openat, AT_FDCWD, path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666));
      // A number that the program does not expect to be given.
      const int high = ::fcntl(file, F_DUPFD_CLOEXEC, 900);
      if (high >= 0) ::syscall(SYS_close, file);
      return high >= 0 ? high : file;
    };
    log = open_log("MEANDER_FAULT_LOG");
    record = open_log("MEANDER_FAULT_RECORD");
  }

  bool below(std::string_view path) const {
    return !folder.empty() && path.starts_with(folder) &&
           (path.size() == folder.size() || path[folder.size()] == '/');
  }
  bool counts(std::string_view name) const {
    return calls == ",," || calls.find("," + std::string(name) + ",") != std::string::npos;
  }

  const std::string folder, calls, deed;
  const int error;
  const unsigned long long at;
  const bool stays;
  const pid_t process = ::getpid();
  int log = -1, record = -1;
  unsigned long long count = 0;
  std::mutex mutex;
};

Shim& shim() {
  static Shim* const one = new Shim;  // calls come before main and after it
  return *one;
}

void put(int file, std::string_view bytes) {
  while (!bytes.empty()) {
    const long wrote = ::syscall(SYS_write, file, bytes.data(), bytes.size());
    if (wrote <= 0) break;
    bytes.remove_prefix(static_cast<std::size_t>(wrote));
  }
}

std::string path_of(int descriptor) {
  std::array<char, PATH_MAX> target{};
  const std::string link = "/proc/self/fd/" + std::to_string(descriptor);
  const long size = ::syscall(SYS_readlink, link.c_str(), target.data(), target.size());
  return size <= 0 ? std::string() : std::string(target.data(), static_cast<std::size_t>(size));
}

std::string absolute(int base, const char* path) {
  if (path == nullptr) return {};
  if (path[0] == '/') return path;
  std::string folder;
  if (base == AT_FDCWD) {
    std::array<char, PATH_MAX> target{};
    const long size = ::syscall(SYS_readlink, "/proc/self/cwd", target.data(), target.size());
    if (size > 0) folder.assign(target.data(), static_cast<std::size_t>(size));
  } else {
    folder = path_of(base);
  }
  return std::string_view(path) == "." ? folder : folder + "/" + path;
}

// Counts the call; what is to become of it.
Deed consider(const char* name, const std::string& path) {
  Shim& s = shim();
  if (!s.below(path) || !s.counts(name)) return Deed::pass;
  const std::lock_guard lock(s.mutex);
  const unsigned long long number = ++s.count;
  const bool changed = s.at > 0 && (number == s.at || (s.stays && number > s.at));
  if (s.log >= 0) put(s.log, std::to_string(number) + " " + name + " " + path + (changed ? " *\n" : "\n"));
  if (!changed) return Deed::pass;
  if (s.deed == "kill") {
    if (::getpid() == s.process) ::kill(s.process, SIGKILL);
    return Deed::pass;
  }
  return s.error != 0 ? Deed::fail : Deed::cut;
}

// Sets errno when the call is to fail.
bool fails(Deed deed) {
  if (deed == Deed::fail) errno = shim().error;
  return deed == Deed::fail;
}

std::size_t share(Deed deed, std::size_t count) { return deed == Deed::cut && count > 1 ? count / 2 : count; }

// One record: a line "NAME NUMBER NUMBER PATH-BYTES DATA-BYTES", the path, the data.
void note(const char* name, long long first, long long second, std::string_view path = {},
          std::string_view data = {}) {
  Shim& s = shim();
  if (s.record < 0) return;
  const int kept = errno;
  std::string text = std::string(name) + " " + std::to_string(first) + " " + std::to_string(second) + " " +
                     std::to_string(path.size()) + " " + std::to_string(data.size()) + "\n";
  text.append(path).append(data).append("\n");
  put(s.record, text);
  errno = kept;
}

// Calls that are recorded are made one at a time, so that the record has their order.
std::unique_lock<std::mutex> in_order() {
  static std::mutex* const mutex = new std::mutex;
  return shim().record < 0 ? std::unique_lock<std::mutex>() : std::unique_lock<std::mutex>(*mutex);
}

template <class Function>
Function* next(const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

int opened(const char* name, int base, const char* path, int flags, mode_t mode) {
  const std::string whole = absolute(base, path);
  if (fails(consider((flags & O_CREAT) != 0 ? "create" : "open", whole))) return -1;
  const auto order = in_order();
  // Whether the file is made by this call decides what a power cut leaves of its name.
  struct stat facts {};
  const bool there = ::fstatat(AT_FDCWD, whole.c_str(), &facts, 0) == 0;
  const int file = std::string_view(name).starts_with("openat")
                       ? next<int(int, const char*, int, ...)>(name)(base, path, flags, mode)
                       : next<int(const char*, int, ...)>(name)(path, flags, mode);
  if (file >= 0 && shim().below(whole))
    note("open", file, (there ? 0 : 1) + ((flags & O_TRUNC) != 0 && there ? 2 : 0), whole);
  return file;
}

mode_t mode_of(int flags, va_list& arguments) {
  return (flags & (O_CREAT | O_TMPFILE)) != 0 ? static_cast<mode_t>(va_arg(arguments, unsigned)) : 0;
}

ssize_t written(const char* name, int file, const void* data, std::size_t count, long long offset) {
  const std::string path = path_of(file);
  const Deed deed = consider("write", path);
  if (fails(deed)) return -1;
  count = share(deed, count);
  const auto order = in_order();
  const bool recorded = shim().record >= 0 && shim().below(path);
  if (recorded && offset < 0) offset = ::lseek(file, 0, SEEK_CUR);
  const ssize_t done =
      std::string_view(name) == "write"
          ? next<ssize_t(int, const void*, std::size_t)>(name)(file, data, count)
          : next<ssize_t(int, const void*, std::size_t, off_t)>(name)(file, data, count, offset);
  if (recorded && done > 0)
    note("write", file, offset, {}, {static_cast<const char*>(data), static_cast<std::size_t>(done)});
  return done;
}

ssize_t read_from(const char* name, int file, void* data, std::size_t count, off_t offset) {
  const Deed deed = consider("read", path_of(file));
  if (fails(deed)) return -1;
  count = share(deed, count);
  return std::string_view(name) == "read"
             ? next<ssize_t(int, void*, std::size_t)>(name)(file, data, count)
             : next<ssize_t(int, void*, std::size_t, off_t)>(name)(file, data, count, offset);
}

int synced(const char* name, int file) {
  const std::string path = path_of(file);
  if (fails(consider("sync", path))) return -1;
  const auto order = in_order();
  const int result = next<int(int)>(name)(file);
  if (result == 0 && shim().below(path)) note("sync", file, 0, path);
  return result;
}

int cut_to(const char* name, int file, off_t size) {
  const std::string path = path_of(file);
  if (fails(consider("truncate", path))) return -1;
  const auto order = in_order();
  const int result = next<int(int, off_t)>(name)(file, size);
  if (result == 0 && shim().below(path)) note("truncate", file, size);
  return result;
}

int cut_path_to(const char* name, const char* path, off_t size) {
  const std::string whole = absolute(AT_FDCWD, path);
  if (fails(consider("truncate", whole))) return -1;
  const auto order = in_order();
  const int result = next<int(const char*, off_t)>(name)(path, size);
  if (result == 0 && shim().below(whole)) note("truncate", -1, size, whole);
  return result;
}

int reserved(const char* name, int file, int mode, off_t offset, off_t size) {
  if (fails(consider("reserve", path_of(file)))) return -1;
  return next<int(int, int, off_t, off_t)>(name)(file, mode, offset, size);
}

void* mapped(const char* name, void* at, std::size_t size, int protection, int flags, int file,
             off_t offset) {
  if (file >= 0 && (flags & MAP_ANONYMOUS) == 0 && fails(consider("map", path_of(file)))) return MAP_FAILED;
  return next<void*(void*, std::size_t, int, int, int, off_t)>(name)(at, size, protection, flags, file,
                                                                     offset);
}

// A call that changes names: `make` makes it.
template <class Make>
int renamed(const char* name, const std::string& from, const std::string& to, const Make& make) {
  if (fails(consider(name, to.empty() ? from : to))) return -1;
  const auto order = in_order();
  const int result = make();
  if (result == 0 && shim().below(from)) note(name, static_cast<long long>(from.size()), 0, from + to);
  return result;
}

}  // namespace

extern "C" {

int open(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = mode_of(flags, arguments);
  va_end(arguments);
  return opened("open", AT_FDCWD, path, flags, mode);
}

int open64(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = mode_of(flags, arguments);
  va_end(arguments);
  return opened("open64", AT_FDCWD, path, flags, mode);
}

int openat(int base, const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = mode_of(flags, arguments);
  va_end(arguments);
  return opened("openat", base, path, flags, mode);
}

int openat64(int base, const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = mode_of(flags, arguments);
  va_end(arguments);
  return opened("openat64", base, path, flags, mode);
}

ssize_t write(int file, const void* data, size_t count) { return written("write", file, data, count, -1); }
ssize_t pwrite(int file, const void* data, size_t count, off_t at) {
  return written("pwrite", file, data, count, at);
}
ssize_t pwrite64(int file, const void* data, size_t count, off64_t at) {
  return written("pwrite64", file, data, count, at);
}
ssize_t read(int file, void* data, size_t count) { return read_from("read", file, data, count, 0); }
ssize_t pread(int file, void* data, size_t count, off_t at) {
  return read_from("pread", file, data, count, at);
}
ssize_t pread64(int file, void* data, size_t count, off64_t at) {
  return read_from("pread64", file, data, count, at);
}

int fsync(int file) { return synced("fsync", file); }
int fdatasync(int file) { return synced("fdatasync", file); }

int ftruncate(int file, off_t size) noexcept { return cut_to("ftruncate", file, size); }
int ftruncate64(int file, off64_t size) noexcept { return cut_to("ftruncate64", file, size); }
int truncate(const char* path, off_t size) noexcept { return cut_path_to("truncate", path, size); }
int truncate64(const char* path, off64_t size) noexcept { return cut_path_to("truncate64", path, size); }
int fallocate(int file, int mode, off_t at, off_t size) {
  return reserved("fallocate", file, mode, at, size);
}
int fallocate64(int file, int mode, off64_t at, off64_t size) {
  return reserved("fallocate64", file, mode, at, size);
}

int close(int file) {
  const std::string path = path_of(file);
  const bool ours = shim().below(path);
  const Deed deed = ours ? consider("close", path) : Deed::pass;
  const auto order = in_order();
  // Linux closes the file whatever it returns.
  const int result = next<int(int)>("close")(file);
  if (ours) note("close", file, 0);
  return fails(deed) ? -1 : result;
}

void* mmap(void* at, size_t size, int protection, int flags, int file, off_t offset) noexcept {
  return mapped("mmap", at, size, protection, flags, file, offset);
}
void* mmap64(void* at, size_t size, int protection, int flags, int file, off64_t offset) noexcept {
  return mapped("mmap64", at, size, protection, flags, file, offset);
}

int flock(int file, int operation) noexcept {
  if (fails(consider("lock", path_of(file)))) return -1;
  return next<int(int, int)>("flock")(file, operation);
}

int rename(const char* from, const char* to) noexcept {
  return renamed("rename", absolute(AT_FDCWD, from), absolute(AT_FDCWD, to),
                 [&] { return next<int(const char*, const char*)>("rename")(from, to); });
}
int mkdir(const char* path, mode_t mode) noexcept {
  return renamed("mkdir", absolute(AT_FDCWD, path), {},
                 [&] { return next<int(const char*, mode_t)>("mkdir")(path, mode); });
}
int unlink(const char* path) noexcept {
  return renamed("unlink", absolute(AT_FDCWD, path), {},
                 [&] { return next<int(const char*)>("unlink")(path); });
}
int rmdir(const char* path) noexcept {
  return renamed("unlink", absolute(AT_FDCWD, path), {},
                 [&] { return next<int(const char*)>("rmdir")(path); });
}
int remove(const char* path) noexcept {
  return renamed("unlink", absolute(AT_FDCWD, path), {},
                 [&] { return next<int(const char*)>("remove")(path); });
}
int unlinkat(int base, const char* path, int flags) noexcept {
  return renamed("unlink", absolute(base, path), {},
                 [&] { return next<int(int, const char*, int)>("unlinkat")(base, path, flags); });
}

}  // extern "C"
