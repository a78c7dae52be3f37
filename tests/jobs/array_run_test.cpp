// Many processes, one store: meander plan, run --shard, status, merge, as a scheduler calls them.
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <numeric>
#include <random>
#include <set>
#include <thread>

#include "io/file/folder_lock.h"
#include "io/json/json_reader.h"
#include "io/json/json_tree.h"
#include "io/store/run_array.h"
#include "io/store/store_verify.h"
#include "jobs/cli/usage_error.h"
#include "jobs/inputs/run_report.h"
#include "jobs/run/array_plan.h"
#include "jobs/run/array_script.h"
#include "jobs/run/shard_run.h"
#include "support/catch.h"
#include "support/collection.h"
#include "support/fault_program.h"
#include "support/meander_program.h"
#include "support/sanitized.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;
namespace fs = std::filesystem;

namespace {

// Thirty small models in folders, some of them broken.
void make_models(const fs::path& folder) {
  write_collection(folder / "mixed");
  fs::create_directories(folder / "spheres");
  for (int i = 0; i < 20; ++i)
    write_mesh(folder / "spheres" / (std::to_string(i) + ".off"), icosphere(1 + i % 3));
}

struct Scene {
  ScratchFolder scratch;
  fs::path models = scratch / "models", whole = scratch / "whole.h5", store = scratch / "s.h5";
  std::string run = store.string() + ".run";

  explicit Scene(std::vector<std::string> given = {"-n", "40"}) : options(std::move(given)) {
    make_models(models);
    std::vector<std::string> arguments = {"run", models.string(), "-o", whole.string()};
    arguments.insert(arguments.end(), options.begin(), options.end());
    REQUIRE(meander_with(arguments).exit_code == 3);
  }
  ProcessResult plan(int shards, std::vector<std::string> more = {}) const {
    std::vector<std::string> arguments = {"plan",         models.string(), "-o",
                                          store.string(), "--shards",      std::to_string(shards)};
    arguments.insert(arguments.end(), options.begin(), options.end());
    arguments.insert(arguments.end(), more.begin(), more.end());
    return meander_with(arguments);
  }
  std::vector<std::string> shard_command(const std::string& shard) const {
    return {fault_program, "run", run, "--shard", shard, "-j", "1", "--progress", "none"};
  }
  ProcessResult shard(const std::string& shard) const { return run_process(shard_command(shard)); }
  bool is_as_one_process_makes_it() const { return read_file(store) == read_file(whole); }
  std::vector<std::string> options;
};

std::vector<int> shuffled(int count, unsigned seed) {
  std::vector<int> order(static_cast<std::size_t>(count));
  std::iota(order.begin(), order.end(), 0);
  std::shuffle(order.begin(), order.end(), std::mt19937(seed));
  return order;
}

}  // namespace

TEST_CASE("array: any number of shards in any order gives the store of one process") {
  // Chunks of several rows with descriptors and labels; chunks of one row; the columns of tensors.
  const std::vector<std::pair<std::vector<std::string>, std::vector<int>>> runs = {
      {{"-n", "40", "--describe", "d2,pairs", "--label-from-folder"}, {1, 2, 7, 64}},
      {{"-n", "1500"}, {5}},
      {{"-n", "40", "--method", "anisotropic"}, {3}}};
  for (const auto& [options, counts] : runs) {
    const Scene scene(options);
    for (const int shards : counts) {
      if (sanitized && (shards == 64 || shards == 1)) continue;  // release builds start so many processes
      INFO(shards << " shards of " << options[1] << " samples");
      REQUIRE(scene.plan(shards, {"--fresh"}).exit_code == 0);
      for (const int i : shuffled(shards, 5))
        REQUIRE(scene.shard(std::to_string(i) + "/" + std::to_string(shards)).exit_code == 0);
      const ProcessResult merged = meander_with({"merge", scene.run});
      INFO(merged.err);
      REQUIRE(merged.exit_code == 3);  // some of the models are broken
      CHECK(scene.is_as_one_process_makes_it());
      CHECK_FALSE(fs::exists(scene.run));
      CHECK(read_file(scene.store.string() + ".failed.txt") ==
            read_file(scene.whole.string() + ".failed.txt"));
      // Again: it is done.
      const ProcessResult again = meander_with({"merge", scene.run});
      CHECK(again.exit_code == 3);
      CHECK(contains(again.out, "merged already"));
      const ProcessResult status = meander_with({"status", scene.run});
      CHECK(status.exit_code == 0);
      CHECK(contains(status.out, "s.h5 is merged: "));
      CHECK(meander_with({"status", scene.run, "--array"}).out == "\n");
      const JsonObject json(meander_with({"status", scene.run, "--json"}).out, "status");
      CHECK(json.integer("rows_done") == json.integer("rows"));
      CHECK(*json.integer("failed") > 0);
    }
  }
}

TEST_CASE("array: killed tasks resume, no recorded row is redone, and a second copy is refused") {
  const Scene scene;
  REQUIRE(scene.plan(3).exit_code == 0);
  ProcessOptions slow;
  slow.environment = {{"MEANDER_TEST_FAULT", "slow:15"}};
  for (int i = 0; i < 3; ++i) {
    const std::string shard = std::to_string(i) + "/3";
    using std::chrono::milliseconds;
    const ProcessResult last =
        run_killed(scene.shard_command(shard), slow, {2, 6, milliseconds(20), milliseconds(120)}, 0,
                   [&] { fs::remove(shard_store(scene.store, static_cast<std::size_t>(i))); });
    INFO(last.err);
    REQUIRE(last.exit_code == 0);
    const ProcessResult again = scene.shard(shard);
    CHECK(again.exit_code == 0);
    CHECK(contains(again.out, "done before"));
  }
  REQUIRE(meander_with({"merge", scene.run}).exit_code == 3);
  CHECK(scene.is_as_one_process_makes_it());
}

TEST_CASE("array: a task that another process works on exits with 75") {
  const Scene scene;
  REQUIRE(scene.plan(2).exit_code == 0);
  {
    const FileDescriptor held = lock_folder(shard_folder(scene.store, 1), "lock", false);
    const ProcessResult second = scene.shard("1/2");
    CHECK(second.exit_code == 75);
    CHECK(contains(second.err, "another process"));
    CHECK(second.err.ends_with("repeat the command when that one has ended\n"));
    const ProcessResult status = meander_with({"status", scene.run, "--json"});
    CHECK(status.exit_code == 75);
    CHECK(JsonObject(status.out, "status").integer("shards_in_work") == 1);
    // Nor is the plan discarded meanwhile.
    CHECK(scene.plan(3, {"--fresh"}).exit_code == 75);
  }
  CHECK(scene.shard("1/2").exit_code == 0);
  CHECK(scene.plan(3, {"--fresh"}).exit_code == 0);
}

TEST_CASE("array: a stopped task exits with 75 and resumes later") {
  const Scene scene;
  REQUIRE(scene.plan(1).exit_code == 0);
  ProcessOptions stop;
  stop.environment = {{"MEANDER_TEST_FAULT", "stop:spheres/7"}};
  CHECK(run_process(scene.shard_command("0/1"), stop).exit_code == 75);
  // What it has recorded counts, with the models that failed.
  const JsonObject stopped(meander_with({"status", scene.run, "--json"}).out, "status");
  CHECK(stopped.integer("shards_done") == 0);
  CHECK(*stopped.integer("rows_done") > 0);
  CHECK(*stopped.integer("rows_done") < *stopped.integer("rows"));
  CHECK(contains(meander_with({"status", scene.run}).out,
                 "with " + std::to_string(*stopped.integer("rows_done")) + " of "));
  CHECK(scene.shard("0/1").exit_code == 0);
  const JsonObject done(meander_with({"status", scene.run, "--json"}).out, "status");
  CHECK(done.integer("rows_done") == done.integer("rows"));
  REQUIRE(meander_with({"merge", scene.run}).exit_code == 3);
  CHECK(scene.is_as_one_process_makes_it());
}

TEST_CASE("array: an item that crashes a task is identified and recorded") {
  const Scene scene;
  REQUIRE(scene.plan(2).exit_code == 0);
  ProcessOptions crash;
  crash.environment = {{"MEANDER_TEST_FAULT", "segv:spheres/7"}};
  int died = 0;
  for (const std::string shard : {"0/2", "1/2"}) {
    ProcessResult result = run_process(scene.shard_command(shard), crash);
    died += result.signal == SIGSEGV;
    if (result.signal != 0) result = run_process(scene.shard_command(shard), crash);
    CHECK(result.exit_code == 0);
  }
  CHECK(died == 1);
  REQUIRE(meander_with({"merge", scene.run}).exit_code == 3);
  const StoreReader store(scene.store);
  const auto row = store.find("spheres/7.off");
  REQUIRE(row);
  CHECK(store.report(*row).status == Status::crashed);
}

TEST_CASE("array: work on a scratch folder is copied back when it is finished") {
  const Scene scene;
  REQUIRE(scene.plan(2).exit_code == 0);
  const fs::path local = scene.scratch / "local";
  fs::create_directories(local);
  std::vector<std::string> command = scene.shard_command("0/2");
  command.insert(command.end(), {"--scratch", local.string()});
  ProcessOptions stop;
  stop.environment = {{"MEANDER_TEST_FAULT", "stop:spheres/1"}};
  const bool stopped = run_process(command, stop).exit_code == 75;
  CHECK(fs::is_empty(local) != stopped);
  CHECK(run_process(command).exit_code == 0);
  CHECK(fs::is_empty(local));
  CHECK(scene.shard("1/2").exit_code == 0);
  REQUIRE(meander_with({"merge", scene.run}).exit_code == 3);
  CHECK(scene.is_as_one_process_makes_it());
}

TEST_CASE("array: the task number comes from the variables of the scheduler") {
  const Scene scene;
  REQUIRE(scene.plan(7).exit_code == 0);
  const auto task = [&](const char* variable, const char* value, std::vector<std::string> more = {}) {
    ProcessOptions options;
    options.environment = {{variable, value}};
    std::vector<std::string> command = {"run", scene.run, "--progress", "none"};
    command.insert(command.end(), more.begin(), more.end());
    return meander_with(command, options);
  };
  const ProcessResult first = task("SLURM_ARRAY_TASK_ID", "3");
  CHECK(first.exit_code == 0);
  CHECK(contains(first.err, "SLURM_ARRAY_TASK_ID is 3: shard 3 of 7"));
  CHECK(contains(first.out, "shard 3 of 7"));
  CHECK(contains(task("JOB_COMPLETION_INDEX", "0").out, "shard 0 of 7"));
  CHECK(contains(task("PBS_ARRAY_INDEX", "1").out, "shard 1 of 7"));
  CHECK(contains(task("AWS_BATCH_JOB_ARRAY_INDEX", "2").out, "shard 2 of 7"));
  CHECK(contains(task("OMPI_COMM_WORLD_RANK", "4").out, "shard 4 of 7"));
  // Arrays that begin at 1 or elsewhere, several shards a task, the last of which has fewer.
  CHECK(task("SGE_TASK_ID", "undefined").exit_code == 2);
  CHECK(contains(task("SGE_TASK_ID", "4", {"--shard-offset", "1"}).out, "shard 5 of 7"));
  const ProcessResult several = task("LSB_JOBINDEX", "1", {"--shards-per-task", "4"});
  CHECK(contains(several.out, "shard 6 of 7"));
  CHECK(contains(several.out, "shard 4 of 7: "));
  const ProcessResult beyond = task("SLURM_ARRAY_TASK_ID", "7");
  CHECK(beyond.exit_code == 2);
  CHECK(contains(beyond.err, "numbered from 0"));
  const ProcessResult none = meander_with({"run", scene.run});
  CHECK(none.exit_code == 2);
  CHECK(contains(none.err, "--shard i/7"));
  CHECK(meander_with({"merge", scene.run}).exit_code == 3);
  CHECK(scene.is_as_one_process_makes_it());
}

TEST_CASE("array: merge names the builds that made the shards if they differ, as does a merge of stores") {
  const Scene scene;
  REQUIRE(scene.plan(2).exit_code == 0);
  for (const char* shard : {"0/2", "1/2"}) REQUIRE(scene.shard(shard).exit_code == 0);
  ShardReport report = *read_shard_report(scene.store.string(), 1);
  CHECK(report.build == build_text());
  report.build = "another compiler";
  write_shard_report(scene.store.string(), 1, report);
  const ProcessResult merged = meander_with({"merge", scene.run});
  CHECK(merged.exit_code == 3);
  CHECK(contains(merged.err, "2 builds made these rows"));
  CHECK(contains(merged.err, "  another compiler\n"));
  CHECK(contains(merged.err, "  " + build_text() + "\n"));
  const std::set<std::string> both = {"another compiler", build_text()};
  CHECK(read_run_report(scene.store).builds == both);

  const fs::path other = scene.scratch / "other", one = scene.scratch / "one.h5",
                 two = scene.scratch / "two.h5";
  fs::create_directories(other);
  write_mesh(other / "other.off", icosphere(1));
  REQUIRE(meander_with({"run", other.string(), "-o", one.string(), "-n", "40"}).exit_code == 0);
  CHECK(read_run_report(one).builds == std::set<std::string>{build_text()});
  const ProcessResult joined =
      meander_with({"merge", one.string(), scene.store.string(), "-o", two.string()});
  CHECK(joined.exit_code == 3);
  CHECK(contains(joined.err, "2 builds made these rows"));
  CHECK(read_run_report(two).builds == both);
}

TEST_CASE("array: missing shards are listed in array notation") {
  const Scene scene;
  REQUIRE(scene.plan(10).exit_code == 0);
  for (const int i : {0, 1, 2, 4, 5, 6}) REQUIRE(scene.shard(std::to_string(i) + "/10").exit_code == 0);
  CHECK(meander_with({"status", scene.run, "--array"}).out == "3,7-9\n");
  const ProcessResult merged = meander_with({"merge", scene.run});
  CHECK(merged.exit_code == 75);
  CHECK(contains(merged.err, "4 of 10 shards"));
  CHECK(contains(merged.err, "--array=3,7-9"));
  CHECK_FALSE(fs::exists(scene.store));
  const ProcessResult status = meander_with({"status", scene.run});
  CHECK(status.exit_code == 75);
  CHECK(contains(status.out, "6 of 10 shards and "));
  const ProcessResult info = meander_with({"info", scene.store.string()});
  CHECK(contains(info.err, "meander status"));
}

TEST_CASE("array: damaged and foreign shards are refused by name") {
  const Scene scene;
  REQUIRE(scene.plan(2).exit_code == 0);
  for (const char* shard : {"0/2", "1/2"}) REQUIRE(scene.shard(shard).exit_code == 0);
  const fs::path result = shard_store(scene.store, 1);
  const std::string whole = read_file(result);
  std::string damaged = whole;
  damaged[damaged.size() / 2] = static_cast<char>(damaged[damaged.size() / 2] ^ 1);
  write_file(result, damaged);
  const ProcessResult refused = meander_with({"merge", scene.run});
  CHECK(refused.exit_code == 2);
  CHECK(contains(refused.err, result.string()));
  // One of another plan: other items under the same number.
  write_file(result, read_file(shard_store(scene.store, 0)));
  CHECK(meander_with({"merge", scene.run}).exit_code == 2);
  CHECK_FALSE(fs::exists(scene.store));
  write_file(result, whole);
  CHECK(meander_with({"merge", scene.run}).exit_code == 3);
  CHECK(scene.is_as_one_process_makes_it());
}

TEST_CASE("array: a shard's list gives back the items of its plan, and refuses unknown formats") {
  const ScratchFolder scratch;
  StoreHeader header;
  header.ids = {"a.off", "b.glb"};
  header.labels = {0, -1};
  std::vector<PlanItem> items(2);
  for (std::size_t i = 0; i < items.size(); ++i) {
    items[i].id = header.ids[i];
    items[i].path = scratch / header.ids[i];
  }
  items[1].format = MeshFormat::gltf;
  write_shard_items(scratch.path(), items);
  const std::vector<PlanItem> back = read_shard_items(scratch.path(), header);
  REQUIRE(back.size() == 2);
  CHECK(back[1].format == MeshFormat::gltf);
  CHECK(back[1].path == items[1].path);
  const std::string text = read_file(scratch / "items.jsonl");
  const std::size_t at = text.find("\"format\":4");
  REQUIRE(at != std::string::npos);
  for (const char* const format : {"5", "-1", "260", "4294967296"}) {
    write_file(scratch / "items.jsonl", std::string(text).replace(at + 9, 1, format));
    REQUIRE_THROWS_WITH(
        read_shard_items(scratch.path(), header),
        Catch::Matchers::ContainsSubstring("line 2 has the unknown format " + std::string(format)));
  }
}

TEST_CASE("array: options that the plan fixes are refused for a task, and planned stores for a plain run") {
  const Scene scene;
  REQUIRE(scene.plan(2).exit_code == 0);
  const auto fails = [](const std::vector<std::string>& arguments, const char* why) {
    const ProcessResult result = meander_with(arguments);
    INFO(result.err);
    CHECK(result.exit_code == 2);
    CHECK(contains(result.err, why));
  };
  fails({"run", scene.run, "--shard", "0/2", "--seed", "1"}, "--seed is decided by the plan");
  fails({"run", scene.run, "--shard", "2/2"}, "numbered from 0 to 1");
  fails({"run", scene.run, "--shard", "0/3"}, "the plan has 2 shards");
  fails({"run", scene.run, "--shard", "x"}, "is not of the form i/n");
  fails({"run", scene.models.string(), "-o", (scene.scratch / "t.h5").string(), "--shard", "0/2"},
        "meander plan");
  fails({"run", scene.models.string()}, "--output is required");
  fails({"run", scene.models.string(), "-o", scene.store.string(), "-n", "40"},
        "divided among many processes");
  fails({"plan", scene.models.string(), "-o", scene.store.string()}, "planned already");
  fails({"plan", scene.models.string(), "-o", scene.whole.string()}, "bring it up to date");
  fails({"plan", scene.models.string(), "-o", (scene.scratch / "t.h5").string(), "--shards", "0"},
        "--shards");
  fails({"status", scene.models.string()}, "is not a run that");
  fails({"merge", scene.models.string()}, "is not a run that");
}

TEST_CASE("array: rows of an older store are reused") {
  const Scene scene;
  fs::rename(scene.models / "spheres", scene.models / "balls");
  REQUIRE(scene.plan(3, {"--reuse", scene.whole.string()}).exit_code == 0);
  for (const char* shard : {"2/3", "0/3", "1/3"}) REQUIRE(scene.shard(shard).exit_code == 0);
  REQUIRE(meander_with({"merge", scene.run}).exit_code == 3);
  const fs::path anew = scene.scratch / "anew.h5";
  REQUIRE(meander_with({"run", scene.models.string(), "-o", anew.string(), "-n", "40"}).exit_code == 3);
  CHECK(read_file(scene.store) == read_file(anew));
  // New inputs join the merged store as they join any other.
  write_mesh(scene.models / "late.off", cube());
  CHECK(meander_with({"run", scene.models.string(), "-o", scene.store.string(), "-n", "40"}).exit_code == 3);
  CHECK(StoreReader(scene.store).find("late.off"));
}

TEST_CASE("array: packs with an index form one store") {
  const Scene scene({"-n", "40", "--describe", "d2", "--label-from-folder"});
  const StoreReader whole(scene.whole);
  const auto rows_in_packs = [&](int shards, std::uint64_t pack_rows) {
    REQUIRE(scene.plan(shards, {"--fresh"}).exit_code == 0);
    for (const int i : shuffled(shards, 3))
      REQUIRE(scene.shard(std::to_string(i) + "/" + std::to_string(shards)).exit_code == 0);
    merge_run_array(scene.store, *read_run_array(scene.store), pack_rows);
    std::vector<std::string> packs;
    for (std::size_t p = 0; fs::exists(pack_path(scene.store, p)); ++p)
      packs.push_back(read_file(pack_path(scene.store, p)));
    return packs;
  };
  const std::vector<std::string> packs = rows_in_packs(1, 8);
  REQUIRE(packs.size() == (whole.rows() + 7) / 8);
  const std::string index = read_file(scene.store);
  CHECK(index.size() < read_file(scene.whole).size() / 2);
  {
    const StoreReader store(scene.store);
    REQUIRE(store.rows() == whole.rows());
    CHECK(store.read_descriptor("d2", 5, 20).size() == 20 * 32);
    for (std::uint64_t row = 0; row < whole.rows(); ++row) {
      const Row here = store.read_row(row), there = whole.read_row(row);
      CHECK(store.id(row) == whole.id(row));
      CHECK(store.find(whole.id(row)) == row);
      CHECK(store.label(row) == whole.label(row));
      CHECK(here.report.status == there.report.status);
      CHECK(here.report.reason == there.report.reason);
      CHECK(here.samples.points == there.samples.points);
      CHECK(here.samples.face == there.samples.face);
      REQUIRE(here.descriptors.size() == there.descriptors.size());
      if (!here.descriptors.empty()) CHECK(here.descriptors[0].values == there.descriptors[0].values);
    }
    CHECK_FALSE(store.find("a"));
    CHECK_FALSE(store.find("zz"));
  }
  CHECK(verify_store(scene.store).problems.empty());
  CHECK(meander_with({"info", scene.store.string()}).exit_code == 0);
  // Put together again they are the store of one process, and any number of shards makes the same packs.
  const fs::path one = scene.scratch / "one.h5";
  const ProcessResult joined = meander_with({"merge", scene.store.string(), "-o", one.string()});
  REQUIRE(joined.exit_code == 3);
  CHECK_THAT(joined.out, Catch::Matchers::ContainsSubstring(" models x 40 points"));
  CHECK(read_file(one) == read_file(scene.whole));
  CHECK((rows_in_packs(7, 8) == packs));  // not printed: they are binary
  CHECK((read_file(scene.store) == index));
  // As rows to use again.
  const fs::path again = scene.scratch / "again.h5";
  const ProcessResult reused =
      meander_with({"run", scene.models.string(), "-o", again.string(), "-n", "40", "--describe", "d2",
                    "--label-from-folder", "--reuse", scene.store.string()});
  INFO(reused.out);
  CHECK(reused.exit_code == 3);
  CHECK(read_file(again) == read_file(scene.whole));
  // A store that is brought up to date is one file; the packs go.
  write_mesh(scene.models / "late.off", cube());
  CHECK(meander_with({"run", scene.models.string(), "-o", scene.store.string(), "-n", "40", "--describe",
                      "d2", "--label-from-folder"})
            .exit_code == 3);
  CHECK(StoreReader(scene.store).find("late.off"));
  CHECK(verify_store(scene.store).problems.empty());
  CHECK_FALSE(fs::exists(pack_path(scene.store, 0)));
}

TEST_CASE("array: the rows of a pack depend on columns and samples, not on the items of a shard") {
  StoreHeader header;
  header.samples = 1000;
  header.ids = {"a.off"};
  header.labels = {0};
  const std::uint64_t bytes = std::uint64_t{1} << 30, rows = rows_of_pack(header, bytes);
  CHECK(rows % 4096 == 0);
  CHECK(rows > 4096);
  header.ids = {std::string(40000, 'x')};
  CHECK(rows_of_pack(header, bytes) == rows);
  header.samples = 2000;
  CHECK(rows_of_pack(header, bytes) < rows);
  CHECK(rows_of_pack(header, 1) == 4096);
}

TEST_CASE("array: missing, damaged and foreign packs are refused by name") {
  const Scene scene;
  REQUIRE(scene.plan(2).exit_code == 0);
  for (const char* shard : {"0/2", "1/2"}) REQUIRE(scene.shard(shard).exit_code == 0);
  merge_run_array(scene.store, *read_run_array(scene.store), 8);
  const fs::path second = pack_path(scene.store, 1);
  const std::string whole = read_file(second);
  const auto refused = [&] {
    const StoreReader store(scene.store);
    CHECK(store.id(0) == StoreReader(scene.whole).id(0));  // the first pack is whole
    CHECK_THROWS_WITH(store.id(8), Catch::Matchers::ContainsSubstring(second.string()));
    CHECK(store.id(16) == StoreReader(scene.whole).id(16));
    const VerifyResult result = verify_store(scene.store);
    REQUIRE(result.problems.size() == 1);
    CHECK(contains(result.problems[0], second.filename().string()));
  };
  fs::remove(second);
  refused();
  std::string damaged = whole;
  damaged[damaged.size() / 2] = static_cast<char>(damaged[damaged.size() / 2] ^ 1);
  write_file(second, damaged);
  refused();
  write_file(second, read_file(pack_path(scene.store, 0)));
  refused();
  write_file(second, whole);
  CHECK(verify_store(scene.store).problems.empty());
}

TEST_CASE("array: a stopped merge into packs resumes, and spares files of others") {
  const Scene scene;
  REQUIRE(scene.plan(2).exit_code == 0);
  for (const char* shard : {"0/2", "1/2"}) REQUIRE(scene.shard(shard).exit_code == 0);
  const RunArray array = *read_run_array(scene.store);
  write_file(pack_path(scene.store, 1), "the user's");
  CHECK_THROWS_WITH(merge_run_array(scene.store, array, 8),
                    Catch::Matchers::ContainsSubstring("belongs to no store"));
  CHECK(read_file(pack_path(scene.store, 1)) == "the user's");
  fs::remove(pack_path(scene.store, 1));
  const auto stops = [] { throw std::runtime_error("stopped"); };
  CHECK_THROWS_WITH(merge_run_array(scene.store, array, 8, stops), "stopped");
  const std::string index = read_file(scene.store), second = read_file(pack_path(scene.store, 1));
  // As a process leaves it that dies earlier.
  fs::remove(scene.store);
  write_file(pack_path(scene.store, 1), second.substr(0, second.size() / 2));
  fs::remove(pack_path(scene.store, 2));
  CHECK_THROWS_WITH(merge_run_array(scene.store, array, 16),
                    Catch::Matchers::ContainsSubstring("packs of 8 rows was begun"));
  merge_run_array(scene.store, array, 8);
  CHECK(read_file(scene.store) == index);
  CHECK(read_file(pack_path(scene.store, 1)) == second);
  CHECK_FALSE(fs::exists(scene.run));
  CHECK(verify_store(scene.store).problems.empty());
  // Planned anew, what an unfinished merge made goes with it.
  REQUIRE(scene.plan(2, {"--fresh"}).exit_code == 0);
  for (const char* shard : {"0/2", "1/2"}) REQUIRE(scene.shard(shard).exit_code == 0);
  CHECK_THROWS_WITH(merge_run_array(scene.store, array, 8, stops), "stopped");
  REQUIRE(scene.plan(1, {"--fresh"}).exit_code == 0);
  CHECK_FALSE(fs::exists(pack_path(scene.store, 0)));
  REQUIRE(scene.shard("0/1").exit_code == 0);
  // Sizes are options of the command; thirty rows are one pack.
  CHECK(meander_with({"merge", scene.run, "--pack-size", "lots"}).exit_code == 2);
  REQUIRE(meander_with({"merge", scene.run, "--pack-size", "1"}).exit_code == 3);
  CHECK(scene.is_as_one_process_makes_it());
}

TEST_CASE("array: members of archives are sampled as in one process") {
  const ScratchFolder scratch;
  fs::create_directories(scratch / "set");
  for (int i = 0; i < 6; ++i) write_mesh(scratch / "set" / (std::to_string(i) + ".off"), icosphere(1));
  const std::string archive = (scratch / "set.tar").string();
  REQUIRE(run_process({"/bin/tar", "-cf", archive, "-C", scratch.path().string(), "set"}).exit_code == 0);
  REQUIRE(meander_with({"run", archive, "-o", (scratch / "one.h5").string(), "-n", "30"}).exit_code == 0);
  REQUIRE(meander_with({"plan", archive, "-o", (scratch / "s.h5").string(), "-n", "30", "--shards", "3"})
              .exit_code == 0);
  for (const char* shard : {"0/3", "1/3", "2/3"})
    REQUIRE(meander_with({"run", (scratch / "s.h5.run").string(), "--shard", shard}).exit_code == 0);
  REQUIRE(meander_with({"merge", (scratch / "s.h5.run").string()}).exit_code == 0);
  CHECK(read_file(scratch / "s.h5") == read_file(scratch / "one.h5"));
}

TEST_CASE("merge: finished stores with the same parameters are merged") {
  const Scene scene({"-n", "40", "--label-from-folder"});
  const auto part = [&](const char* folder, const char* name, std::vector<std::string> more = {}) {
    const std::string path = (scene.scratch / name).string();
    std::vector<std::string> arguments = {
        "run", (scene.models / folder).string(), "-o", path, "-n", "40", "--label-from-folder"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    meander_with(arguments);
    return path;
  };
  // Ids are relative to each folder: those of the whole lack nothing but the folder's name.
  const std::string a = part("mixed", "a.h5"), b = part("spheres", "b.h5"),
                    other = part("mixed", "c.h5", {"--seed", "9"});
  const std::string merged = (scene.scratch / "m.h5").string();
  const ProcessResult result = meander_with({"merge", b, a, "-o", merged});
  INFO(result.err);
  REQUIRE(result.exit_code == 3);
  const StoreReader store(merged), first(a), second(b);
  REQUIRE(store.rows() == first.rows() + second.rows());
  for (std::uint64_t row = 0; row < store.rows(); ++row) {
    const StoreReader& from = first.find(store.id(row)) ? first : second;
    const std::uint64_t there = *from.find(store.id(row));
    CHECK(store.read_row(row).samples.points == from.read_row(there).samples.points);
    CHECK(store.report(row).status == from.report(there).status);
    CHECK(store.label_names()[static_cast<std::size_t>(store.label(row))] ==
          from.label_names()[static_cast<std::size_t>(from.label(there))]);
  }
  CHECK(meander_with({"verify", merged}).exit_code == 0);
  // What a run leaves beside its store, though without paths: a store keeps none.
  const std::string failed = read_file(merged + ".failed.txt");
  for (std::uint64_t row = 0; row < store.rows(); ++row)
    CHECK(contains(failed, "# " + store.id(row) + ": ") == (store.report(row).status != Status::ok));
  const auto since = [](const std::string& path) {
    return *JsonObject(read_file(path + ".run.json"), path).integer("inputs_read_since_unix_ns");
  };
  CHECK(since(merged) == std::min(since(a), since(b)));
  CHECK(contains(meander_with({"merge", a, b, "-o", merged}).err, "--fresh replaces it"));
  CHECK(contains(meander_with({"merge", a, other, "-o", merged, "--fresh"}).err, "other parameters"));
  CHECK(contains(meander_with({"merge", a, a, "-o", merged, "--fresh"}).err, "ids must be unique"));
  CHECK(contains(meander_with({"merge", a, b}).err, "-o"));
  CHECK(scene.plan(2).exit_code == 0);
  CHECK(contains(meander_with({"merge", scene.run, "-o", merged, "--fresh"}).err,
                 "holds the shards of an array"));
}

namespace {

// As a scheduler starts a task: in a folder of its own, with an empty PATH.
ProcessOptions far_away(std::vector<std::pair<std::string, std::string>> more = {}) {
  ProcessOptions options;
  options.environment = std::move(more);
  options.environment.emplace_back("PATH", "");
  options.in_child = [] {
    if (::chdir("/") != 0) std::abort();
  };
  return options;
}

// Names that a shell, GNU parallel, YAML and Kubernetes could each take for something else.
constexpr const char* awkward = "it's $HOME \"x\" `y` {} {#} $(z) \\ @LAST@ #\n\xc3\xa4; ";

// The tasks that a script says its array has.
int tasks_of(const std::string& script, const std::string& before) {
  const std::size_t at = script.find(before);
  return at == std::string::npos ? -1 : std::atoi(script.c_str() + at + before.size());
}

// The words of the command of a script for Kubernetes, as a container gets them.
std::vector<std::string> container_command(const std::string& script) {
  const std::size_t begin = script.find("command: ") + 9;
  const JsonTree tree(script.substr(begin, script.find('\n', begin) - begin));
  std::vector<std::string> words;
  for (const JsonValue& value : tree.root().items()) {
    std::string& word = words.emplace_back(value.text().value_or(""));
    for (std::size_t at = 0; (at = word.find("$$", at)) != std::string::npos; ++at) word.erase(at, 1);
  }
  return words;
}

// A scene whose program and store have awkward names; the store is given by a relative path.
struct AwkwardScene : Scene {
  fs::path folder, copy;

  AwkwardScene() {
    folder = scratch / awkward;
    fs::create_directories(folder / "bin");
    copy = folder / "bin" / "meander";
    fs::copy_file(program, copy);
    store = folder / (std::string(awkward) + ".h5");
    run = store.string() + ".run";
  }
  std::string script(const std::string& scheduler, int shards, int most_tasks) const {
    ProcessOptions here;
    here.in_child = [this] {
      if (::chdir(folder.c_str()) != 0) std::abort();
    };
    const ProcessResult planned = run_process(
        {"bin/meander", "plan", models.string(), "-o", store.filename().string(), "-n", "40", "--shards",
         std::to_string(shards), "--max-array", std::to_string(most_tasks), "--emit", scheduler, "--fresh"},
        here);
    INFO(planned.err);
    REQUIRE(planned.exit_code == 0);
    return planned.out;
  }
};

bool is_executable_script(const fs::path& file, const std::string& text) {
  write_file(file, text);
  fs::permissions(file, fs::perms::owner_all);
  return text.starts_with("#!/bin/");
}

}  // namespace

TEST_CASE("array: the Slurm script runs from another folder with an empty PATH, whatever the names") {
  const AwkwardScene scene;
  const std::string text = scene.script("slurm", 7, 3);
  CHECK(tasks_of(text, "--array=0-") == 2);
  const fs::path file = scene.scratch / "job.sh";
  REQUIRE(is_executable_script(file, text));
  for (const char* task : {"2", "0", "1"}) {
    const ProcessResult ended = run_process({file.string()}, far_away({{"SLURM_ARRAY_TASK_ID", task}}));
    INFO(ended.err);
    CHECK(ended.exit_code == 0);
  }
  REQUIRE(meander_with({"merge", scene.run}).exit_code == 3);
  CHECK(scene.is_as_one_process_makes_it());
}

TEST_CASE("array: the Kubernetes script runs from another folder with an empty PATH", "[release]") {
  const AwkwardScene scene;
  const std::string text = scene.script("kubernetes", 5, 4);
  REQUIRE(tasks_of(text, "completions: ") == 3);
  for (const char* task : {"0", "1", "2"}) {
    const ProcessResult ended =
        run_process(container_command(text), far_away({{"JOB_COMPLETION_INDEX", task}}));
    INFO(ended.err);
    CHECK(ended.exit_code == 0);
  }
  REQUIRE(meander_with({"merge", scene.run}).exit_code == 3);
  CHECK(scene.is_as_one_process_makes_it());
  // A name that is not UTF-8 has no place there; nothing is planned then.
  const fs::path other = scene.scratch / "\xff.h5";
  const ProcessResult refused =
      meander_with({"plan", scene.models.string(), "-o", other.string(), "--emit", "kubernetes"});
  CHECK(refused.exit_code == 2);
  CHECK(contains(refused.err, "not UTF-8"));
  CHECK_FALSE(fs::exists(other.string() + ".run"));
}

TEST_CASE("array: the GNU parallel script runs from another folder with an empty PATH", "[release]") {
  if (std::system("parallel --version 2>/dev/null | grep -q GNU") != 0) {
    WARN("skipped: no GNU parallel here");
    return;
  }
  const AwkwardScene scene;
  const fs::path file = scene.scratch / "run.sh";
  for (const int most_tasks : {100, 2}) {
    REQUIRE(is_executable_script(file, scene.script("parallel", 5, most_tasks)));
    const ProcessResult made =
        run_process({file.string()}, far_away({{"PARALLEL_HOME", (scene.scratch / "home").string()},
                                               {"SLURM_ARRAY_TASK_ID", "3"}}));  // of a job around it
    INFO(made.err << made.out);
    REQUIRE(made.exit_code == 3);  // that of merge: some models are broken
    CHECK(scene.is_as_one_process_makes_it());
  }
}

TEST_CASE("array: scripts name the program by its real path, however it was started") {
  const ScratchFolder scratch;
  write_mesh(scratch / "a.off", cube());
  fs::create_directories(scratch / "bin");
  fs::create_symlink(fs::relative(program, scratch / "bin"), scratch / "bin" / "meander");
  fs::create_symlink("bin/meander", scratch / "link");
  ProcessOptions here;
  here.environment = {{"PATH", (scratch / "bin").string()}};
  here.in_child = [&] {
    if (::chdir(scratch.path().c_str()) != 0) std::abort();
  };
  const std::string rest = " plan a.off -o s.h5 --fresh --emit slurm";
  for (const char* start : {"meander", "bin/meander", "./link", "bin/../link"}) {
    INFO(start);
    const ProcessResult planned = run_process({"/bin/sh", "-c", start + rest}, here);
    INFO(planned.err);
    REQUIRE(planned.exit_code == 0);
    CHECK(contains(planned.out, "\nprogram=" + shell_word(fs::canonical(program).string()) + "\n"));
    CHECK(contains(planned.out,
                   "\nstore=" + shell_word(fs::canonical(scratch / "s.h5.run").replace_extension())));
  }
}

TEST_CASE("array: words in scripts are quoted for the shell, for YAML and for Kubernetes") {
  CHECK(shell_word("/a/b-1.h5") == "/a/b-1.h5");
  CHECK(shell_word("") == "''");
  for (const std::string& text :
       {std::string(awkward), std::string("'"), std::string("''a'"), std::string("~"), std::string("-n *"),
        std::string("a=b"), std::string("\xff\x01\t\r\n\\n")}) {
    const ProcessResult said = run_process({"/bin/sh", "-c", "printf %s " + shell_word(text)});
    CHECK(said.out == text);
  }
  CHECK(kubernetes_word("/a b") == "\"/a b\"");
  CHECK(kubernetes_word("a\"\\$(X)$") == "\"a\\\"\\\\$$(X)$$\"");
  CHECK(kubernetes_word("\n\x7f\xc2\x85\xe2\x80\xa8\xc3\xa4") == "\"\\u000A\\u007F\\u0085\\u2028\xc3\xa4\"");
  CHECK_THROWS_AS(kubernetes_word("\xc3"), UsageError);
}

TEST_CASE("array: respects --max-array, and names missing work in tasks") {
  const Scene scene;
  const ProcessResult planned = scene.plan(23, {"--max-array", "10", "--json"});
  REQUIRE(planned.exit_code == 0);
  const JsonObject plan(planned.out, "plan");
  CHECK(plan.integer("shards") == 23);
  CHECK(plan.integer("tasks") == 8);
  CHECK(plan.integer("shards_per_task") == 3);
  CHECK(plan.text("array") == "0-7");
  const auto task = [&](int number, std::vector<std::string> more = {}) {
    std::vector<std::string> command = {"run",        scene.run, "--task", std::to_string(number),
                                        "--progress", "none"};
    command.insert(command.end(), more.begin(), more.end());
    return meander_with(command);
  };
  CHECK(contains(task(7).err, "--task is 7: shards 21 to 22 of 23"));
  REQUIRE(task(0).exit_code == 0);
  REQUIRE(scene.shard("3/23").exit_code == 0);  // of task 1, which has others
  CHECK(meander_with({"status", scene.run, "--array"}).out == "1-6\n");
  REQUIRE(task(2).exit_code == 0);
  REQUIRE(task(4).exit_code == 0);
  CHECK(meander_with({"status", scene.run, "--array"}).out == "1,3,5-6\n");
  CHECK(contains(meander_with({"merge", scene.run}).err,
                 "11 of 23 shards of " + scene.run + " are not done: --array=1,3,5-6\n"));
  CHECK(contains(meander_with({"status", scene.run}).out, "tasks of 3 shards each to start again: 1,3,5-6"));
  // Tasks of another size, and numbered otherwise, as they were given it.
  CHECK(meander_with({"status", scene.run, "--array", "--shards-per-task", "1"}).out == "4-5,9-11,15-20\n");
  CHECK(meander_with({"status", scene.run, "--array", "--shard-offset", "-1"}).out == "2,4,6-7\n");
  CHECK(meander_with({"status", scene.run, "--array", "--shard-offset", "3"}).out == "0,2-3\n");
  CHECK(meander_with({"status", scene.run, "--shard-offset", "3"}).exit_code == 2);
  REQUIRE(task(2, {"--shard-offset", "-1"}).exit_code == 0);  // the second of an array that begins with 1
  const ProcessResult before = task(0, {"--shard-offset", "-1"});
  CHECK(before.exit_code == 2);
  CHECK(contains(before.err, "there is no shard -3"));
  REQUIRE(task(9, {"--shards-per-task", "1"}).exit_code == 0);
  CHECK(meander_with({"status", scene.run, "--array"}).out == "3,5-6\n");
  for (const int number : {3, 5, 6}) REQUIRE(task(number).exit_code == 0);
  CHECK(meander_with({"status", scene.run, "--array"}).out == "\n");
  CHECK(task(8).exit_code == 2);
  CHECK(contains(task(0, {"--shard", "0/23"}).err, "--shard names one shard"));
  const ProcessResult none = meander_with({"run", scene.run, "--task", "-1"});
  CHECK(none.exit_code == 2);
  CHECK(contains(none.err, "--task"));
  CHECK(contains(meander_with({"run", scene.run, "--task", "99999999999999999999"}).err, "--task"));
  CHECK(
      contains(meander_with({"run", scene.run, "--task", "18446744073709551615"}).err, "there is no shard"));
  REQUIRE(meander_with({"merge", scene.run}).exit_code == 3);
  CHECK(scene.is_as_one_process_makes_it());
}

TEST_CASE("array: a task of many shards opens few files, and resumes where it was killed") {
  const Scene scene;
  REQUIRE(scene.plan(100, {"--max-array", "1"}).exit_code == 0);
  const std::vector<std::string> command = {fault_program, "run",  scene.run, "--task", "0",
                                            "--progress",  "none", "-j",      "1"};
  ProcessOptions few_files;
  few_files.environment = {{"MEANDER_TEST_FAULT", "segv:spheres/7"}};
  few_files.in_child = [] {
    const rlimit files = {60, 60};
    if (::setrlimit(RLIMIT_NOFILE, &files) != 0) std::abort();
  };
  const ProcessResult died = run_process(command, few_files);
  INFO(died.err);
  REQUIRE(died.signal == SIGSEGV);
  const ProcessResult ended = run_process(command, few_files);
  INFO(ended.err);
  REQUIRE(ended.exit_code == 0);  // the model that crashed it was found out
  REQUIRE(meander_with({"merge", scene.run}).exit_code == 3);
  const StoreReader store(scene.store);
  CHECK(store.report(*store.find("spheres/7.off")).status == Status::crashed);
}

TEST_CASE("array: shards are divided among a limited number of tasks, and missing ones have a short name") {
  CHECK(shards_per_task(5000, 1001) == 5);
  CHECK(shards_per_task(1001, 1001) == 1);
  CHECK(shards_per_task(1002, 1001) == 2);
  CHECK(shards_per_task(1, 1001) == 1);
  CHECK(shards_per_task(1000000, 1) == 1000000);
  ArrayScript script{"/p", "/s.h5", 5000, 5};
  CHECK(contains(array_script("slurm", script), "--array=0-999\n"));
  script.shards = 5001;
  CHECK(contains(array_script("slurm", script), "--array=0-1000\n"));
  CHECK(contains(array_script("kubernetes", script), "completions: 1001\n"));
  std::vector<std::size_t> odd;
  for (std::size_t i = 1; i < 200000; i += 2) odd.push_back(i);
  odd.push_back(300000);
  CHECK(array_expression(odd) == "1-199999,300000");
  CHECK(array_expression(std::span(odd).first(500), 64 << 10).size() > 1500);  // all, one by one
  CHECK(array_expression(odd, 10) == "1-300000");
  const std::array<std::size_t, 5> gaps = {1, 5, 7, 100, 102};
  CHECK(array_expression(gaps, 12) == "1-7,100-102");
  CHECK(tasks_of_shards(gaps, 5) == std::vector<std::size_t>{0, 1, 20});
  CHECK(tasks_of_shards({}, 5).empty());
}

TEST_CASE("array: paths given relative to the folder of the plan hold for tasks in another folder") {
  const Scene scene;
  const fs::path in = scene.scratch / "cwd";
  fs::create_directories(in / "set");
  fs::create_directories(in / "tensors" / "set");
  for (int i = 0; i < 3; ++i) write_mesh(in / "set" / (std::to_string(i) + ".off"), icosphere(1));
  write_file(in / "labels.csv", "id,class\nset/0.off,ball\n");
  write_file(in / "list.txt", "set/0.off\nset/1.off\nset/2.off\n");
  for (int i = 0; i < 3; ++i)
    write_file(in / "tensors" / "set" / (std::to_string(i) + ".txt"), "1 0 0 1 0 1\n");
  const auto from = [](const fs::path& folder) {
    ProcessOptions options;
    options.in_child = [folder] {
      if (::chdir(folder.c_str()) != 0) std::abort();
    };
    return options;
  };
  const std::vector<std::vector<std::string>> forms = {
      {"@list.txt", "--root", ".", "-n", "40", "--labels", "labels.csv"},
      {"@list.txt", "--root", ".", "-n", "30", "--method", "anisotropic", "--tensor", "file:tensors"},
      {"@list.txt", "--root", ".", "-n", "40", "--reuse", "first.h5"}};
  for (const std::vector<std::string>& form : forms) {
    INFO(form.back());
    std::vector<std::string> whole = {"run", "-o", form == forms.front() ? "first.h5" : "whole.h5",
                                      "--fresh"},
                             plan = {"plan", "-o", "s.h5", "--shards", "2", "--fresh"};
    whole.insert(whole.end(), form.begin(), form.end());
    plan.insert(plan.end(), form.begin(), form.end());
    const ProcessResult one = meander_with(whole, from(in));
    INFO(one.err);
    REQUIRE((one.exit_code == 0 || one.exit_code == 3));
    const ProcessResult planned = meander_with(plan, from(in));
    INFO(planned.err);
    REQUIRE(planned.exit_code == 0);
    for (const char* task : {"0", "1"}) {
      const ProcessResult ended =
          meander_with({"run", (in / "s.h5.run").string(), "--task", task}, from("/"));
      INFO(ended.err);
      CHECK(ended.exit_code == 0);
    }
    CHECK(meander_with({"merge", (in / "s.h5.run").string()}, from("/")).exit_code == one.exit_code);
    CHECK((read_file(in / "s.h5") == read_file(in / whole[2])));
  }
}

TEST_CASE("array: a plan with an impossible number of shards per task is damaged, the default is one") {
  const Scene scene;
  REQUIRE(scene.plan(4, {"--max-array", "2"}).exit_code == 0);
  const fs::path file = array_folder(scene.store) / "array.json";
  const std::string text = read_file(file), member = "\"shards_per_task\":2,";
  const std::size_t at = text.find(member);
  REQUIRE(at != std::string::npos);
  for (const char* number : {"0", "-1", "1000001"}) {
    write_file(file, std::string(text).replace(at, member.size(),
                                               "\"shards_per_task\":" + std::string(number) + ","));
    CHECK(contains(meander_with({"status", scene.run}).err,
                   "is damaged: " + std::string(number) + " shards a task"));
  }
  write_file(file, std::string(text).erase(at, member.size()));
  CHECK(meander_with({"status", scene.run, "--array"}).out == "0-3\n");
}

TEST_CASE("array: shards have about equal cost, the largest first") {
  std::mt19937 random(3);
  std::lognormal_distribution<double> cost(0, 1.5);
  for (const std::size_t rows : {std::size_t{1}, std::size_t{50}, std::size_t{5000}, std::size_t{200000}})
    for (const std::size_t shards : {std::size_t{1}, std::size_t{7}, std::size_t{64}}) {
      INFO(rows << " rows, " << shards << " shards");
      std::vector<double> costs(rows);
      for (double& c : costs) c = cost(random);
      const std::vector<ArrayShard> cut = cut_into_shards(costs, shards);
      REQUIRE(cut.size() == shards);
      std::vector<ArrayShard> by_row = cut;
      std::erase_if(by_row, [](const ArrayShard& s) { return s.rows() == 0; });
      std::sort(by_row.begin(), by_row.end(), [](const auto& a, const auto& b) { return a.begin < b.begin; });
      std::uint64_t row = 0;
      for (const ArrayShard& shard : by_row) {
        CHECK(shard.begin == row);
        row = shard.end;
        double sum = 0;
        for (std::uint64_t r = shard.begin; r < shard.end; ++r) sum += costs[r];
        CHECK(shard.cost == Approx(sum));
      }
      CHECK(row == rows);
      CHECK(std::is_sorted(cut.begin(), cut.end(),
                           [](const auto& a, const auto& b) { return a.cost > b.cost; }));
      const double mean = std::accumulate(costs.begin(), costs.end(), 0.0) / static_cast<double>(shards);
      const double largest = *std::max_element(costs.begin(), costs.end());
      if (rows >= 5000) CHECK(cut.front().cost <= 1.1 * mean + largest);
    }
  const std::array<std::size_t, 4> missing = {3, 7, 8, 9};
  CHECK(array_expression(missing) == "3,7-9");
  CHECK(array_expression({}).empty());
}
