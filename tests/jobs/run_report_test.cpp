#include "jobs/inputs/run_report.h"

#include "support/catch.h"
#include "support/mesh_files.h"

using namespace meander;
using namespace meander::test;

namespace {

RunReport report_of(const std::string& text) {
  const ScratchFolder scratch;
  write_file(scratch / "s.h5.run.json", text);
  return read_run_report(scratch / "s.h5");
}

}  // namespace

TEST_CASE("run report: holds the root of lists and the time when inputs were read") {
  const RunReport report = report_of(
      "{\"tool\":\"x\",\"root\":\"/models \\\"a\\\"/100%25\",\"inputs_read_since_unix_ns\":1500}\n");
  CHECK(report.root == "/models \"a\"/100%");
  REQUIRE(report.inputs_read_since);
  CHECK(report.inputs_read_since->time_since_epoch() == std::chrono::nanoseconds(1500));
}

TEST_CASE("run report: missing, damaged and mistyped members are ignored, and the rest is read") {
  const ScratchFolder scratch;
  for (const RunReport& report :
       {read_run_report(scratch / "none.h5"), report_of(""), report_of("my notes\n"), report_of("{\"root\":"),
        report_of("[1]"), report_of("{\"root\":5}"), report_of("{\"inputs_read_since_unix_ns\":\"now\"}")}) {
    CHECK(report.root.empty());
    CHECK_FALSE(report.inputs_read_since);
  }
  CHECK(report_of("{\"root\":\"/a\",\"inputs_read_since_unix_ns\":[]}").root == "/a");
  CHECK(report_of("{\"root\":[],\"inputs_read_since_unix_ns\":1}").inputs_read_since);
}
