// The progress of a run on a terminal.
#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "support/catch.h"
#include "support/fault_program.h"
#include "support/mesh_files.h"
#include "support/pseudo_terminal.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

// What a terminal that is `columns` wide shows: its lines, each as it was last written. A line that is too
// long goes on in the next.
std::vector<std::string> shown(const std::string& written, std::size_t columns) {
  std::vector<std::string> lines(1);
  std::size_t column = 0;
  for (std::size_t i = 0; i < written.size(); ++i) {
    if (written[i] == '\r') {
      column = 0;
    } else if (written[i] == '\n') {
      lines.emplace_back();
    } else if (written.compare(i, 3, "\x1b[K") == 0) {
      lines.back().resize(column);
      i += 2;
    } else {
      if (column == columns) {
        lines.emplace_back();
        column = 0;
      }
      lines.back().resize(std::max(lines.back().size(), column + 1), ' ');
      lines.back()[column++] = written[i];
    }
  }
  if (lines.back().empty()) lines.pop_back();
  return lines;
}

}  // namespace

TEST_CASE("progress: on a terminal of any width the bar is redrawn in one line") {
  const ScratchFolder scratch;
  std::filesystem::create_directory(scratch / "in");
  for (int m = 0; m < 8; ++m) write_mesh(scratch / ("in/m" + std::to_string(m) + ".off"), icosphere(2));
  for (const int columns : {40, 80, 120}) {
    CAPTURE(columns);
    ProcessOptions slow;
    slow.environment = {{"MEANDER_TEST_FAULT", "slow:120"}};
    const ProcessResult result =
        run_in_terminal({fault_program, "run", scratch / "in", "-o", scratch / "s.h5", "-n", "64", "-j", "1",
                         "--fresh", "--timeout", "60s"},
                        columns, STDERR_FILENO, slow);
    CAPTURE(result.err);
    REQUIRE(result.exit_code == 0);
    std::size_t redrawn = 0;
    for (std::size_t at = 0; (at = result.err.find("\r\x1b[K", at)) != std::string::npos; ++at) ++redrawn;
    CHECK(redrawn >= 3);
    const std::vector<std::string> lines = shown(result.err, static_cast<std::size_t>(columns));
    REQUIRE(lines.size() == 1);
    CHECK(lines.front().size() < static_cast<std::size_t>(columns));
    CHECK(lines.front().ends_with("0:00 left"));
    CHECK(lines.front().find("100% 8/8 models, ") != std::string::npos);
    CHECK(lines.front().starts_with("[####"));
  }
}

TEST_CASE("progress: a failure takes a line of its own, and the bar goes on below it") {
  const ScratchFolder scratch;
  std::filesystem::create_directory(scratch / "in");
  for (int m = 0; m < 3; ++m) write_mesh(scratch / ("in/m" + std::to_string(m) + ".off"), icosphere(2));
  write_file(scratch / "in/bad.off", "OFF\n1 0 0\n0 0 0\n");
  ProcessOptions slow;
  slow.environment = {{"MEANDER_TEST_FAULT", "slow:120"}};
  const ProcessResult result = run_in_terminal({fault_program, "run", scratch / "in", "-o", scratch / "s.h5",
                                                "-n", "64", "-j", "1", "--timeout", "60s"},
                                               60, STDERR_FILENO, slow);
  CAPTURE(result.err);
  CHECK(result.exit_code == 3);
  const std::vector<std::string> lines = shown(result.err, 60);
  std::size_t failures = 0, bars = 0;
  for (const std::string& line : lines) {
    failures += line.starts_with("bad.off: empty: ");
    bars += line.find("models, 1 failed") != std::string::npos;
  }
  CHECK(failures == 1);
  CHECK(bars == 1);
}
