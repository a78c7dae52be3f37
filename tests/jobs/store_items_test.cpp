
#include "jobs/inputs/store_items.h"
#include "io/store/run_directory.h"
#include "jobs/cli/usage_error.h"
#include "support/catch.h"
#include "support/mesh_files.h"

using namespace meander;
using namespace meander::test;

TEST_CASE("store parameters: every difference is named with both values") {
  const ScratchFolder scratch;
  StoreHeader header;
  header.samples = 4;
  header.parameters_json = R"({"method":"auto","samples":4,"seed":1})";
  RunDirectory(scratch / "s.h5", header).finish();
  const StoreReader store(scratch / "s.h5");
  CHECK(parameter_mismatch(store, header).empty());
  header.parameters_json = R"({"method":"direct","samples":4,"seed":2})";
  CHECK(parameter_mismatch(store, header) ==
        R"(parameter "method" was "auto", now it is "direct"; parameter "seed" was 1, now it is 2)");
  CHECK_THROWS_AS(find_item(store, "0"), UsageError);
}

TEST_CASE("store parameters: columns of measures that another program had are a difference") {
  const ScratchFolder scratch;
  StoreHeader header;
  header.samples = 4;
  header.parameters_json = R"({"certify":true,"samples":4})";
  header.descriptors = {{"box_rms_ratio", 1, {}, "certificate"}, {"d2", 8, {}, "descriptors"}};
  RunDirectory(scratch / "s.h5", header).finish();
  const StoreReader store(scratch / "s.h5");
  header.descriptors.pop_back();  // descriptors can be added to a store and left out of it
  CHECK(parameter_mismatch(store, header).empty());
  header.descriptors.push_back({"rho", 1, {}, "certificate"});
  CHECK(parameter_mismatch(store, header) ==
        "the columns of measures were certificate/box_rms_ratio, now they are certificate/box_rms_ratio, "
        "certificate/rho");
}

TEST_CASE("store parameters: a run begun with others names all differences") {
  const ScratchFolder scratch;
  StoreHeader header;
  header.samples = 4;
  header.parameters_json = R"({"method":"auto","samples":4,"seed":1})";
  header.ids = {"a.off"};
  header.labels = {-1};
  { const RunDirectory run(scratch / "s.h5", header); }
  header.samples = 8;
  header.seed = 2;
  header.parameters_json = R"({"method":"auto","samples":8,"seed":2})";
  CHECK_THROWS_WITH(RunDirectory(scratch / "s.h5", header),
                    Catch::Matchers::ContainsSubstring(
                        R"(parameter "samples" was 4, now it is 8; parameter "seed" was 1, now)"));
}
