#include "jobs/laboratory/python_program.h"

#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <system_error>

#include "io/file/file_descriptor.h"
#include "io/plot/color.h"
#include "jobs/cli/usage_error.h"
#include "meander_python_place.h"

namespace meander {

namespace {

namespace fs = std::filesystem;

// A file in memory. A child process reads from it or writes to it instead of a pipe, which could fill up. It
// is closed at the end of the object, and in every child but for the descriptors that dup2 made of it. Throws
// std::system_error.
class MemoryFile {
 public:
  explicit MemoryFile(std::string_view content) : file_(memfd_create("meander", MFD_CLOEXEC)) {
    check(file_ ? try_write(file_, std::as_bytes(std::span(content)), 0).error : errno);
  }
  int descriptor() const { return file_.get(); }
  // All that was written to it, by any process.
  std::string content() const {
    std::string text(file_size(file_, "a file in memory"), '\0');
    check(try_read(file_, std::as_writable_bytes(std::span(text)), 0).error);
    return text;
  }

 private:
  static void check(int error) {
    if (error != 0) throw std::system_error(error, std::generic_category(), "a file in memory");
  }
  FileDescriptor file_;
};

// The exit code of plots.py if matplotlib is missing.
constexpr int matplotlib_missing = 3;

fs::path own_program() {
  std::error_code error;
  return fs::read_symlink("/proc/self/exe", error);
}

// The folder that has the package `meander`, of an installation or of the build tree.
fs::path package_folder() {
  const fs::path beside = own_program().parent_path();
  for (const fs::path& folder : {beside / python_place_installed, beside / python_place_built})
    if (fs::exists(folder / "meander" / "figures" / "plots.py")) return folder.lexically_normal();
  throw UsageError("plots and figures need the Python package of Meander, which is not beside the program");
}

// The interpreter that the package was built for, or the first on PATH.
std::string interpreter() {
  if (const char* const named = std::getenv("MEANDER_PYTHON")) return named;
  return fs::exists(python_interpreter) ? python_interpreter : "python3";
}

// "#0072b2,#d55e00,...", as many as are distinct.
std::string palette_text() {
  std::string text;
  for (std::size_t i = 0; i < distinct_colors; ++i) {
    const auto [red, green, blue] = palette_color(i);
    text += fmt::format("{}#{:02x}{:02x}{:02x}", i == 0 ? "" : ",", red, green, blue);
  }
  return text;
}

std::vector<char*> pointers_to(std::vector<std::string>& words) {
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  return pointers;
}

}  // namespace

void become_figures_program(const std::vector<std::string>& arguments) {
  const fs::path folder = package_folder();
  std::vector<std::string> words = {interpreter(), "-m", "meander.figures"};
  words.insert(words.end(), arguments.begin(), arguments.end());
  const char* const before = std::getenv("PYTHONPATH");
  setenv("PYTHONPATH", (folder.string() + (before ? std::string(":") + before : std::string())).c_str(), 1);
  setenv("MEANDER_PROGRAM", own_program().c_str(), 1);
  setenv("MEANDER_COMMAND", "meander figures", 1);
  execvp(words.front().c_str(), pointers_to(words).data());
  throw UsageError(
      fmt::format("figures need Python 3, but `{}` cannot be run ({}): install python3, python3-numpy and "
                  "python3-matplotlib",
                  words.front(), std::generic_category().message(errno)));
}

std::string draw_plot(std::string_view json) {
  const MemoryFile input(json), output(""), errors("");
  std::vector<std::string> words = {
      interpreter(), (package_folder() / "meander" / "figures" / "plots.py").string(), palette_text()};
  const std::vector<char*> pointers = pointers_to(words);
  const pid_t child = fork();
  if (child < 0) throw std::system_error(errno, std::generic_category(), "cannot start a child process");
  if (child == 0) {
    dup2(input.descriptor(), STDIN_FILENO);
    dup2(output.descriptor(), STDOUT_FILENO);
    dup2(errors.descriptor(), STDERR_FILENO);
    execvp(pointers.front(), pointers.data());
    _exit(matplotlib_missing);
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return output.content();
  if (WIFEXITED(status) && WEXITSTATUS(status) == matplotlib_missing)
    throw UsageError(
        fmt::format("plots need matplotlib, which `{}` does not have: install python3-matplotlib, or leave "
                    "the picture out",
                    words.front()));
  throw std::runtime_error("the plot could not be drawn: " + errors.content());
}

}  // namespace meander
