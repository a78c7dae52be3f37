// Many processes, one store: meander plan, run --shard, status, merge, as a scheduler calls them.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <numeric>
#include <random>
#include <thread>

#include "io/file/folder_lock.h"
#include "io/json/json_reader.h"
#include "io/store/run_array.h"
#include "jobs/array_plan.h"
#include "jobs/shard_run.h"
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
      if (sanitized && shards == 64) continue;  // release builds start so many processes
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
    }
  }
}

TEST_CASE("array: killed tasks go on, nothing that was recorded is done twice, a second copy is refused") {
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

TEST_CASE("array: a task that another process works on ends with 75") {
  const Scene scene;
  REQUIRE(scene.plan(2).exit_code == 0);
  {
    const FileDescriptor held = lock_folder(shard_folder(scene.store, 1), "lock", false);
    const ProcessResult second = scene.shard("1/2");
    CHECK(second.exit_code == 75);
    CHECK(contains(second.err, "another process"));
    const ProcessResult status = meander_with({"status", scene.run, "--json"});
    CHECK(status.exit_code == 75);
    CHECK(JsonObject(status.out, "status").integer("shards_in_work") == 1);
    // Nor is the plan discarded meanwhile.
    CHECK(scene.plan(3, {"--fresh"}).exit_code == 75);
  }
  CHECK(scene.shard("1/2").exit_code == 0);
  CHECK(scene.plan(3, {"--fresh"}).exit_code == 0);
}

TEST_CASE("array: asked to stop, a task ends with 75 and goes on later") {
  const Scene scene;
  REQUIRE(scene.plan(1).exit_code == 0);
  ProcessOptions stop;
  stop.environment = {{"MEANDER_TEST_FAULT", "stop:spheres/7"}};
  CHECK(run_process(scene.shard_command("0/1"), stop).exit_code == 75);
  CHECK(scene.shard("0/1").exit_code == 0);
  REQUIRE(meander_with({"merge", scene.run}).exit_code == 3);
  CHECK(scene.is_as_one_process_makes_it());
}

TEST_CASE("array: an item that crashes a task is found out and recorded") {
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

TEST_CASE("array: work on a scratch folder is handed over when it is finished") {
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

TEST_CASE("array: the number of the task comes from the scheduler's variables") {
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

TEST_CASE("array: missing shards are named in the notation of arrays") {
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
  CHECK(contains(status.out, "6 of 10 shards done"));
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

TEST_CASE("array: the list of a shard names the items of its plan, in formats that there are") {
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
    REQUIRE_THROWS_WITH(read_shard_items(scratch.path(), header),
                        Catch::Contains("line 2 has the format " + std::string(format) + ", which is none"));
  }
}

TEST_CASE("array: what the plan decided cannot be given to a task, and the other way round") {
  const Scene scene;
  REQUIRE(scene.plan(2).exit_code == 0);
  const auto fails = [](const std::vector<std::string>& arguments, const char* why) {
    const ProcessResult result = meander_with(arguments);
    INFO(result.err);
    CHECK(result.exit_code == 2);
    CHECK(contains(result.err, why));
  };
  fails({"run", scene.run, "--shard", "0/2", "--seed", "1"}, "--seed: the plan");
  fails({"run", scene.run, "--shard", "2/2"}, "numbered from 0 to 1");
  fails({"run", scene.run, "--shard", "0/3"}, "the plan has 2 shards");
  fails({"run", scene.run, "--shard", "x"}, "is not i/n");
  fails({"run", scene.models.string(), "-o", (scene.scratch / "t.h5").string(), "--shard", "0/2"},
        "meander plan");
  fails({"run", scene.models.string()}, "--output is required");
  fails({"run", scene.models.string(), "-o", scene.store.string(), "-n", "40"},
        "divided among many processes");
  fails({"plan", scene.models.string(), "-o", scene.store.string()}, "planned already");
  fails({"plan", scene.models.string(), "-o", scene.whole.string()}, "brings it up to date");
  fails({"plan", scene.models.string(), "-o", (scene.scratch / "t.h5").string(), "--shards", "0"},
        "--shards");
  fails({"status", scene.models.string()}, "no run that");
  fails({"merge", scene.models.string()}, "no run that");
}

TEST_CASE("array: rows of an older store are used again") {
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

TEST_CASE("array: packs with an index are one store") {
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
      CHECK(here.label == there.label);
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
  CHECK_THAT(joined.out, Catch::Contains(" models x 40 points"));
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

TEST_CASE("array: packs that are missing, damaged or of another store are refused by name") {
  const Scene scene;
  REQUIRE(scene.plan(2).exit_code == 0);
  for (const char* shard : {"0/2", "1/2"}) REQUIRE(scene.shard(shard).exit_code == 0);
  merge_run_array(scene.store, *read_run_array(scene.store), 8);
  const fs::path second = pack_path(scene.store, 1);
  const std::string whole = read_file(second);
  const auto refused = [&] {
    const StoreReader store(scene.store);
    CHECK(store.id(0) == StoreReader(scene.whole).id(0));  // the first pack is whole
    CHECK_THROWS_WITH(store.id(8), Catch::Contains(second.string()));
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

TEST_CASE("array: a merge into packs goes on after it was stopped, and spares files that are not its own") {
  const Scene scene;
  REQUIRE(scene.plan(2).exit_code == 0);
  for (const char* shard : {"0/2", "1/2"}) REQUIRE(scene.shard(shard).exit_code == 0);
  const RunArray array = *read_run_array(scene.store);
  write_file(pack_path(scene.store, 1), "the user's");
  CHECK_THROWS_WITH(merge_run_array(scene.store, array, 8), Catch::Contains("belongs to no store"));
  CHECK(read_file(pack_path(scene.store, 1)) == "the user's");
  fs::remove(pack_path(scene.store, 1));
  const auto stops = [] { throw std::runtime_error("stopped"); };
  CHECK_THROWS_WITH(merge_run_array(scene.store, array, 8, stops), "stopped");
  const std::string index = read_file(scene.store), second = read_file(pack_path(scene.store, 1));
  // As a process leaves it that dies earlier.
  fs::remove(scene.store);
  write_file(pack_path(scene.store, 1), second.substr(0, second.size() / 2));
  fs::remove(pack_path(scene.store, 2));
  CHECK_THROWS_WITH(merge_run_array(scene.store, array, 16), Catch::Contains("packs of 8 rows was begun"));
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

TEST_CASE("array: members of archives") {
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

TEST_CASE("merge: finished stores of the same parameters") {
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
  CHECK(contains(meander_with({"merge", a, a, "-o", merged, "--fresh"}).err, "ids must differ"));
  CHECK(contains(meander_with({"merge", a, b}).err, "-o"));
  CHECK(scene.plan(2).exit_code == 0);
  CHECK(contains(meander_with({"merge", scene.run, "-o", merged, "--fresh"}).err,
                 "holds the shards of an array"));
}

TEST_CASE("array: the script for GNU parallel makes the store") {
  if (std::system("command -v parallel >/dev/null 2>&1") != 0) {
    WARN("skipped: no GNU parallel here");
    return;
  }
  Scene scene;
  scene.store = scene.scratch / "it's.h5";
  scene.run = scene.store.string() + ".run";
  const ProcessResult planned = scene.plan(5, {"--emit", "parallel"});
  REQUIRE(planned.exit_code == 0);
  const fs::path script = scene.scratch / "run.sh";
  write_file(script, planned.out);
  // The program of the test under the name that scripts call.
  fs::create_symlink(program, scene.scratch / "meander");
  ProcessOptions options;
  options.environment = {{"PATH", scene.scratch.path().string() + ":" + std::getenv("PATH")},
                         {"PARALLEL_HOME", (scene.scratch / "home").string()}};
  const ProcessResult made = run_process({"/bin/sh", script.string()}, options);
  INFO(made.err);
  REQUIRE(made.exit_code == 3);  // that of merge: some models are broken
  CHECK(scene.is_as_one_process_makes_it());
}

TEST_CASE("array: rows are cut into shards of about equal cost, the largest first") {
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
