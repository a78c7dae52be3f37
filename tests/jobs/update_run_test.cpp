// A second `meander run` on a store: new, changed and missing inputs, --retry, --fresh, --reuse, and all
// of them interrupted.
#include <algorithm>
#include <cctype>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <thread>

#include "io/store/run_directory.h"
#include "io/store/store_reader.h"
#include "io/store/store_verify.h"
#include "support/catch.h"
#include "support/collection.h"
#include "support/fault_program.h"
#include "support/mesh_files.h"
#include "support/run_process.h"
#include "support/scratch_files.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace fs = std::filesystem;

namespace {

// Folder "in" with six good models and a store "s.h5" beside it.
struct Collection {
  ScratchFolder scratch;
  fs::path in = scratch / "in", store = scratch / "s.h5";

  Collection() {
    for (int i = 0; i < 6; ++i) add("m" + std::to_string(i) + ".off", i);
  }
  void add(const std::string& name, double shift) const {
    fs::create_directories((in / name).parent_path());
    write_mesh(in / name, moved(icosphere(2), 1, shift, 0, 0), MeshFile::off_binary);
  }
  std::vector<std::string> command(std::vector<std::string> more = {},
                                   const std::string& name = "s.h5") const {
    std::vector<std::string> arguments = {
        fault_program, "run", in.string(), "-o", (scratch / name).string(), "-n", "64", "--method", "direct"};
    if (std::find(more.begin(), more.end(), "-j") == more.end()) more.insert(more.end(), {"-j", "2"});
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  ProcessResult run(std::vector<std::string> more = {}, const std::string& name = "s.h5") const {
    return run_process(command(std::move(more), name));
  }
  // The store of a fresh run over the current inputs.
  std::string fresh_bytes(std::vector<std::string> more = {}) const {
    more.push_back("--fresh");
    const ProcessResult result = run(more, "fresh.h5");
    INFO(result.err);
    REQUIRE((result.exit_code == 0 || result.exit_code == 3));
    return read_file(scratch / "fresh.h5");
  }
  std::string bytes() const { return read_file(store); }
};

// As if the file had been written long before the store.
void make_old(const fs::path& path) {
  fs::last_write_time(path, fs::file_time_type::clock::now() - std::chrono::hours(48));
}
void make_new(const fs::path& path) {
  fs::last_write_time(path, fs::file_time_type::clock::now() + std::chrono::seconds(5));
}

bool says(const ProcessResult& result, const std::string& text) {
  return (result.err + result.out).find(text) != std::string::npos;
}

// See fault_program.cpp.
ProcessOptions with_fault(const std::string& fault) {
  ProcessOptions options;
  options.environment = {{"MEANDER_TEST_FAULT", fault}};
  return options;
}

// Less than lies between any two readings of the clock.
constexpr const char* no_time = "0.000000001s";

}  // namespace

TEST_CASE("second run: new files join the store, the rest is kept, with the bytes of a run from scratch") {
  const Collection c;
  REQUIRE(c.run().exit_code == 0);
  c.add("a/first.off", 20);
  c.add("m2a.off", 21);
  const ProcessResult result = c.run({"--progress", "json"});
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  CHECK(says(result, "new inputs"));
  CHECK(says(result, "\"id\":\"a/first.off\""));
  CHECK_FALSE(says(result, "\"id\":\"m2.off\""));  // was not sampled again
  CHECK(c.bytes() == c.fresh_bytes());
  CHECK(c.run().exit_code == 0);  // and there is nothing left to do
}

TEST_CASE("second run: labels and splits of kept rows follow the inputs") {
  const Collection c;
  c.add("cat/x.off", 20);
  REQUIRE(c.run({"--label-from-folder"}).exit_code == 0);
  c.add("bee/y.off", 21);  // its class comes first: the numbers of the others change
  REQUIRE(c.run({"--label-from-folder"}).exit_code == 0);
  CHECK(c.bytes() == c.fresh_bytes({"--label-from-folder"}));
  const ProcessResult without = c.run();
  CHECK(without.exit_code == 2);
  CHECK(says(without, "has labels, but this command gives none"));
}

TEST_CASE("second run: a changed input is detected by size or time and content, kept, and redone on demand") {
  const Collection c;
  for (const auto& entry : fs::directory_iterator(c.in)) make_old(entry.path());
  REQUIRE(c.run().exit_code == 0);
  const std::string before = c.bytes();

  make_new(c.in / "m1.off");  // touched, not changed
  CHECK(c.run().exit_code == 0);

  c.add("m1.off", 9);  // the same size, a newer time
  REQUIRE(fs::file_size(c.in / "m1.off") == fs::file_size(c.in / "m2.off"));
  make_new(c.in / "m1.off");
  write_mesh(c.in / "m3.off", icosphere(1), MeshFile::off);  // another size, an old time
  make_old(c.in / "m3.off");
  for (int again = 0; again < 2; ++again) {
    const ProcessResult noticed = c.run();
    INFO(noticed.err);
    CHECK(noticed.exit_code == 3);
    CHECK(says(noticed, "m1.off: the file changed after it was sampled"));
    CHECK(says(noticed, "m3.off: the file changed after it was sampled"));
    CHECK(says(noticed, "changed inputs: 2; `--retry changed` samples them again"));
    CHECK(c.bytes() == before);
  }
  const ProcessResult json = c.run({"--json"});
  CHECK(says(json, "\"changed\":[\"m1.off\",\"m3.off\"]"));

  // A new input joins; those that changed are still noticed afterwards.
  c.add("new.off", 30);
  CHECK(c.run().exit_code == 3);
  CHECK(says(c.run(), "changed inputs: 2"));

  REQUIRE(c.run({"--retry", "changed"}).exit_code == 0);
  CHECK(c.bytes() == c.fresh_bytes());
  CHECK(c.run().exit_code == 0);
}

TEST_CASE("second run: an unreadable input that becomes readable counts as changed") {
  const Collection c;
  fs::create_symlink(c.scratch / "elsewhere.off", c.in / "link.off");
  REQUIRE(c.run().exit_code == 3);
  CHECK(c.run().exit_code == 3);
  CHECK_FALSE(says(c.run(), "changed"));
  write_mesh(c.scratch / "elsewhere.off", icosphere(1), MeshFile::off);
  CHECK(says(c.run(), "link.off: the file changed"));
  CHECK(c.run({"--retry", "changed"}).exit_code == 0);
  CHECK(c.bytes() == c.fresh_bytes());
}

TEST_CASE("second run: a vanished input is named and its row kept until its removal is requested") {
  const Collection c;
  REQUIRE(c.run().exit_code == 0);
  const std::string before = c.bytes();
  fs::remove(c.in / "m4.off");
  const ProcessResult noticed = c.run();
  CHECK(noticed.exit_code == 3);
  CHECK(says(noticed, "m4.off: no input has this id now"));
  CHECK(c.bytes() == before);
  c.add("m9.off", 40);  // the row stays when others join
  CHECK(c.run().exit_code == 3);
  CHECK(StoreReader(c.store).rows() == 7);
  REQUIRE(c.run({"--retry", "vanished"}).exit_code == 0);
  CHECK(c.bytes() == c.fresh_bytes());
}

TEST_CASE("second run: --retry vanished removes no row while some inputs could not be searched") {
  const Collection c;
  REQUIRE(c.run().exit_code == 0);
  const std::string before = c.bytes();
  fs::remove(c.in / "m4.off");
  fs::create_symlink(c.scratch / "nowhere", c.in / "disk");
  const ProcessResult refused = c.run({"--retry", "vanished"});
  INFO(refused.err);
  CHECK(refused.exit_code == 2);
  CHECK(says(refused, "may still exist"));
  CHECK(c.bytes() == before);
  fs::remove(c.in / "disk");
  CHECK(c.run({"--retry", "vanished"}).exit_code == 0);
  CHECK(c.bytes() == c.fresh_bytes());
}

TEST_CASE("second run: the unfinished work of another command is left to that command") {
  const Collection c;
  REQUIRE(c.run().exit_code == 0);
  const std::string before = c.bytes();
  { RunDirectory other(c.store, RunPlan{StoreReader(c.store).header(), RunPurpose::describe}); }
  const ProcessResult refused = c.run();
  INFO(refused.err);
  CHECK(refused.exit_code == 2);
  CHECK(says(refused, "was begun to describe its rows"));
  CHECK(c.bytes() == before);
  CHECK(fs::exists(c.scratch / "s.h5.run"));
  CHECK(c.run({"--fresh"}).exit_code == 0);
  CHECK(c.bytes() == before);
}

TEST_CASE("second run: an unfinished run is finished first, then new inputs join") {
  const Collection c;
  const ProcessResult stopped = run_process(c.command(), with_fault("stop:m3"));
  INFO(stopped.err);
  REQUIRE(stopped.exit_code == 75);
  c.add("b.off", 50);
  fs::remove(c.in / "m0.off");
  const ProcessResult result = c.run();
  INFO(result.err);
  CHECK(result.exit_code == 3);  // m0.off vanished
  CHECK(StoreReader(c.store).rows() == 7);
  REQUIRE(c.run({"--retry", "vanished"}).exit_code == 0);
  CHECK(c.bytes() == c.fresh_bytes());
}

TEST_CASE("second run: an unfinished run is not continued with inputs that are not its own") {
  const Collection c;
  REQUIRE(run_process(c.command(), with_fault("stop:m3")).exit_code == 75);
  fs::create_directories(c.scratch / "other");
  write_mesh(c.scratch / "other/x.off", cube());
  std::vector<std::string> command = c.command();
  command[2] = c.scratch / "other";
  const ProcessResult refused = run_process(command);
  CHECK(refused.exit_code == 2);
  CHECK(says(refused,
             "was begun with other inputs: its items look like `m0.off`, those of this command like "
             "`x.off`"));
  CHECK(c.run().exit_code == 0);
  CHECK(c.bytes() == c.fresh_bytes());
}

TEST_CASE("second run: --dry-run says what would be done with the existing store, and does nothing") {
  const Collection c;
  CHECK_FALSE(says(c.run({"--dry-run"}), "the store has"));
  REQUIRE(run_process(c.command(), with_fault("stop:m3")).exit_code == 75);
  CHECK(says(c.run({"--dry-run"}), "an unfinished run of 6 models would be continued"));
  REQUIRE(c.run().exit_code == 0);
  c.add("b.off", 50);
  fs::remove(c.in / "m0.off");
  c.add("m1.off", 9);
  make_new(c.in / "m1.off");
  const std::string before = c.bytes();
  const ProcessResult dry = c.run({"--dry-run"});
  INFO(dry.out << dry.err);
  CHECK(dry.exit_code == 0);
  CHECK(says(dry, "the store has 5 of these models: 1 would be sampled"));
  CHECK(says(dry, "1 changed since they were sampled: --retry changed samples them again"));
  CHECK(says(dry, "1 of the store are no longer in the input: their rows would be kept"));
  CHECK(says(c.run({"--dry-run", "--retry", "changed,vanished"}), "their rows would be removed"));
  const ProcessResult refused = c.run({"--dry-run", "--seed", "5"});
  CHECK(refused.exit_code == 2);
  CHECK(says(refused, "other parameters"));
  CHECK(c.bytes() == before);
  CHECK_FALSE(fs::exists(c.scratch / "s.h5.run"));
}

TEST_CASE("second run: an update killed at any moment resumes, with more inputs and with another --retry") {
  const Collection c;
  REQUIRE(c.run().exit_code == 0);
  for (int i = 0; i < 8; ++i) c.add("n" + std::to_string(i) + ".off", 60 + i);
  const auto check_old_store = [&] {  // it lives until the new one is there
    CHECK(verify_store(c.store).problems.empty());
    CHECK(StoreReader(c.store).rows() == 6);
  };
  // In the middle of the update for certain: one thread takes the items in their order.
  for (const char* id : {"n1", "n4"}) {
    REQUIRE(run_process(c.command({"-j", "1"}), with_fault(std::string("kill:") + id)).signal == SIGKILL);
    check_old_store();
  }
  for (const int moment : {100, 300, 500, 700}) {
    ProcessOptions options = with_fault("slow:300");
    options.signal_after = std::chrono::milliseconds(moment);
    const ProcessResult killed = run_process(c.command(), options);
    INFO(killed.err);
    if (killed.signal == 0) {
      REQUIRE(killed.exit_code == 0);
      break;
    }
    check_old_store();
  }
  c.add("o.off", 80);
  const ProcessResult result = c.run({"--retry", "timeout"});
  INFO(result.err);
  CHECK(result.exit_code == 0);
  CHECK(c.bytes() == c.fresh_bytes());
}

namespace {

// Models in two folders of the folder "in", and lists of them. A store made from a list over both folders has
// ids that begin with the name of a folder.
struct ListedFolders {
  Collection c;

  ListedFolders() {
    fs::remove_all(c.in);
    for (const char* folder : {"a", "b"})
      for (int i = 0; i < 3; ++i) c.add(std::string(folder) + "/m" + std::to_string(i) + ".off", i);
  }
  // Several more in `a`, which an update from a list over `a` alone adds.
  void add_more() const {
    for (int i = 0; i < 5; ++i) c.add("a/n" + std::to_string(i) + ".off", 30 + i);
  }
  // A list of every model in these folders.
  std::string list(const std::string& name, const std::vector<std::string>& folders) const {
    std::string text;
    for (const std::string& folder : folders)
      for (const auto& entry : fs::recursive_directory_iterator(c.in / folder))
        if (entry.is_regular_file()) text += entry.path().string() + "\n";
    write_file(c.scratch / name, text);
    return "@" + (c.scratch / name).string();
  }
  std::vector<std::string> command(const std::string& store, const std::vector<std::string>& inputs,
                                   const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {fault_program, "run"};
    arguments.insert(arguments.end(), inputs.begin(), inputs.end());
    const std::vector<std::string> rest = {"-o",    (c.scratch / store).string(), "-n", "64", "--method",
                                           "direct"};
    arguments.insert(arguments.end(), rest.begin(), rest.end());
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  ProcessResult run(const std::string& store, const std::vector<std::string>& inputs,
                    const std::vector<std::string>& more = {}) const {
    return run_process(command(store, inputs, more));
  }
  // The update s.h5, stopped and killed on its way and continued by the same command, has the bytes of one of
  // a copy of the store that nobody disturbs.
  void check_continues(const std::vector<std::string>& inputs, std::vector<std::string> more,
                       const std::vector<std::string>& faults) const {
    for (const char* end : {".h5", ".h5.run.json"})
      fs::copy_file(c.scratch / (std::string("s") + end), c.scratch / (std::string("t") + end),
                    fs::copy_options::overwrite_existing);
    const ProcessResult undisturbed = run("t.h5", inputs, more);
    INFO(undisturbed.err);
    REQUIRE(undisturbed.exit_code != 2);
    std::vector<std::string> serial = more;
    serial.insert(serial.end(), {"-j", "1"});
    for (const std::string& fault : faults) {
      const ProcessResult stopped = run_process(command("s.h5", inputs, serial), with_fault(fault));
      INFO(fault << ": " << stopped.err);
      REQUIRE((stopped.exit_code == 75 || stopped.signal == SIGKILL));
      CHECK(run("s.h5", inputs, {"--dry-run"}).exit_code == 0);
    }
    const ProcessResult last = run("s.h5", inputs, more);
    INFO(last.err);
    CHECK(last.exit_code == undisturbed.exit_code);
    CHECK_FALSE(fs::exists(c.scratch / "s.h5.run"));
    CHECK((c.bytes() == read_file(c.scratch / "t.h5")));  // not printed: they are binary
    CHECK(run("s.h5", inputs).exit_code == undisturbed.exit_code);
    CHECK((c.bytes() == read_file(c.scratch / "t.h5")));
  }
};

}  // namespace

TEST_CASE("second run: an update from a list over some folders resumes after a stop and a kill") {
  const ListedFolders l;
  REQUIRE(l.run("s.h5", {l.list("both", {"a", "b"})}).exit_code == 0);
  l.add_more();
  l.check_continues({l.list("some", {"a"})}, {}, {"stop:n2", "kill:n3"});
  const StoreReader store(l.c.store);
  CHECK(store.find("a/n4.off"));
  CHECK(store.find("b/m2.off"));
  CHECK(store.rows() == 11);
}

TEST_CASE("second run: an update from several lists, or from standard input, resumes") {
  const ListedFolders l;
  REQUIRE(l.run("s.h5", {l.list("a", {"a"}), l.list("b", {"b"})}).exit_code == 0);
  l.add_more();
  l.c.add("c/x.off", 50);
  l.check_continues({l.list("c", {"c"}), l.list("some", {"a"})}, {"--trust"}, {"stop:n2"});
  l.c.add("c/y.off", 51);
  ProcessOptions piped = with_fault("stop:c/y");
  piped.input = (l.c.in / "c/y.off").string() + "\n";
  REQUIRE(run_process(l.command("s.h5", {"-"}), piped).exit_code == 75);
  piped.environment.clear();
  CHECK(run_process(l.command("s.h5", {"-"}), piped).exit_code == 3);  // all others vanished
  CHECK(StoreReader(l.c.store).find("c/y.off"));
  CHECK(StoreReader(l.c.store).rows() == 13);
}

TEST_CASE("second run: --retry over a list of some folders resumes") {
  const ListedFolders l;
  REQUIRE(l.run("s.h5", {l.list("both", {"a", "b"})}, {"--timeout", no_time}).exit_code == 3);
  l.check_continues({l.list("some", {"a"})}, {"--retry", "timeout"}, {"stop:a/m1", "kill:a/m2"});
  CHECK(StoreReader(l.c.store).report(0).status == Status::ok);
  CHECK(StoreReader(l.c.store).report(3).status == Status::timeout);
  l.c.add("a/m1.off", 77);
  make_new(l.c.in / "a/m1.off");
  l.add_more();
  l.check_continues({l.list("some", {"a"})}, {"--retry", "changed"}, {"stop:a/m1", "stop:n3"});
  l.check_continues({l.list("some", {"b"})}, {"--retry", "timeout,vanished"}, {"stop:b/m1"});
  CHECK(StoreReader(l.c.store).rows() == 3);
}

TEST_CASE("second run: an update from a list with --reuse resumes") {
  const ListedFolders l;
  REQUIRE(l.run("s.h5", {l.list("both", {"a", "b"})}).exit_code == 0);
  l.add_more();
  REQUIRE(l.run("old.h5", {(l.c.in / "a/n0.off").string(), (l.c.in / "a/n4.off").string()}).exit_code == 0);
  l.check_continues({l.list("some", {"a"})}, {"--reuse", (l.c.scratch / "old.h5").string()}, {"stop:n2"});
}

TEST_CASE("second run: --root is remembered by a stopped update, and by one from a folder") {
  const ListedFolders l;
  const std::string above = l.c.scratch.path().string();
  REQUIRE(l.run("s.h5", {l.list("both", {"a", "b"})}, {"--root", above}).exit_code == 0);
  REQUIRE(StoreReader(l.c.store).find("in/b/m0.off"));
  l.add_more();
  l.check_continues({l.list("some", {"a"})}, {}, {"stop:n2"});
  REQUIRE(StoreReader(l.c.store).find("in/a/n4.off"));
  // Ids of a folder are relative to it; those of lists stay relative to their root.
  l.c.add("b/late.off", 60);
  REQUIRE(l.run("s.h5", {(l.c.in / "b").string()}).exit_code == 3);
  l.c.add("a/later.off", 61);
  l.check_continues({l.list("some", {"a"})}, {}, {"stop:later"});
  CHECK(StoreReader(l.c.store).find("in/a/later.off"));
}

TEST_CASE("second run: an update stopped under another --root does not take ids of the store's root") {
  const ListedFolders l;
  const std::string both = l.list("both", {"a", "b"});
  REQUIRE(l.run("s.h5", {both}).exit_code == 0);
  const std::string before = l.c.bytes(), in_a = (l.c.in / "a").string();
  l.add_more();
  const std::vector<std::string> update = l.command("s.h5", {l.list("some", {"a"})}, {"--root", in_a});
  REQUIRE(run_process(update, with_fault("stop:n2")).exit_code == 75);
  const ProcessResult refused = l.run("s.h5", {both}, {"--root", l.c.in.string()});
  INFO(refused.err);
  CHECK(refused.exit_code == 2);
  CHECK(says(refused, "begun with ids relative to `" + in_a + "`"));
  CHECK(l.c.bytes() == before);
  CHECK(run_process(update).exit_code == 3);  // those of the first root vanished
  CHECK(StoreReader(l.c.store).find("n4.off"));
  CHECK(StoreReader(l.c.store).find("b/m2.off"));
}

TEST_CASE("second run: the root of lists is that of the store unless the plan of an update has one") {
  const ListedFolders l;
  REQUIRE(l.run("s.h5", {l.list("both", {"a", "b"})}).exit_code == 0);
  {
    const StoreReader store(l.c.store);
    RunDirectory begun(l.c.store, RunPlan{store.header(), RunPurpose::update});
  }
  l.add_more();
  const ProcessResult result = l.run("s.h5", {l.list("some", {"a"})});
  INFO(result.err);
  CHECK(result.exit_code == 3);
  CHECK(StoreReader(l.c.store).find("a/n4.off"));
  CHECK(StoreReader(l.c.store).rows() == 11);
}

TEST_CASE("second run: a store merged from stores of lists with one root remembers it") {
  const ListedFolders l;
  const std::string root = l.c.in.string();
  REQUIRE(l.run("x.h5", {l.list("a", {"a"})}, {"--root", root}).exit_code == 0);
  REQUIRE(l.run("y.h5", {l.list("b", {"b"})}, {"--root", root}).exit_code == 0);
  REQUIRE(run_process({fault_program, "merge", (l.c.scratch / "x.h5").string(),
                       (l.c.scratch / "y.h5").string(), "-o", l.c.store.string()})
              .exit_code == 0);
  l.add_more();
  l.check_continues({l.list("some", {"a"})}, {}, {"stop:n2"});
  CHECK(StoreReader(l.c.store).find("a/n4.off"));
  CHECK(StoreReader(l.c.store).rows() == 11);
}

TEST_CASE("second run: an update from a list of archives resumes") {
  const ListedFolders l;
  const auto pack = [&](const std::string& folder) {
    const std::string archive = (l.c.in / (folder + ".tar")).string();
    REQUIRE(run_process({"/bin/tar", "-cf", archive, "-C", (l.c.in / folder).string(), "."}).exit_code == 0);
    return archive + "\n";
  };
  const std::string a = pack("a"), b = pack("b");
  write_file(l.c.scratch / "both", a + b);
  write_file(l.c.scratch / "some", a);
  REQUIRE(l.run("s.h5", {"@" + (l.c.scratch / "both").string()}).exit_code == 0);
  REQUIRE(StoreReader(l.c.store).find("b/m0.off"));
  l.add_more();
  pack("a");
  l.check_continues({"@" + (l.c.scratch / "some").string()}, {}, {"stop:n2", "kill:n3"});
  CHECK(StoreReader(l.c.store).rows() == 11);
}

TEST_CASE("second run: an interrupted --retry is finished, and a second list is not ignored") {
  const Collection c;
  write_file(c.in / "bad.off", "OFF\n1 1 0\n0 0 0\n3 0 1 2\n");  // unusable until it is corrected
  write_mesh(c.in / "big.off", icosphere(5), MeshFile::off);
  REQUIRE(c.run({"--memory", "100M", "--timeout", no_time}).exit_code == 3);
  REQUIRE(StoreReader(c.store).report(0).status == Status::timeout);
  write_mesh(c.in / "bad.off", icosphere(1), MeshFile::off);
  const ProcessResult stopped = run_process(c.command({"--retry", "timeout"}), with_fault("stop:m3"));
  INFO(stopped.err);
  REQUIRE(stopped.exit_code == 75);
  const ProcessResult result = c.run({"--retry", "changed"});
  INFO(result.err);
  CHECK(result.exit_code == 0);
  CHECK(c.bytes() == c.fresh_bytes());
}

TEST_CASE("second run: explains how to redo rows that failed for a limit") {
  const Collection c;
  REQUIRE(c.run({"--timeout", no_time}).exit_code == 3);
  const ProcessResult result = c.run({"--timeout", "10s"});
  CHECK(result.exit_code == 3);
  CHECK(says(result, "`--retry timeout`"));
  CHECK(c.run({"--timeout", "10s", "--retry", "timeout"}).exit_code == 0);
}

TEST_CASE("second run: --fresh keeps the old store until the new one is complete") {
  const Collection c;
  REQUIRE(c.run().exit_code == 0);
  const std::string before = c.bytes();
  ProcessResult stopped = run_process(c.command({"--fresh", "--seed", "5"}), with_fault("stop:m3"));
  INFO(stopped.err);
  REQUIRE(stopped.exit_code == 75);
  CHECK(says(stopped, "the same command without --fresh continues"));
  CHECK(c.bytes() == before);
  stopped = c.run();  // of other parameters than what is unfinished
  CHECK(stopped.exit_code == 2);
  CHECK(says(stopped, "seed"));
  REQUIRE(c.run({"--seed", "5"}).exit_code == 0);
  CHECK(c.bytes() == c.fresh_bytes({"--seed", "5"}));
}

TEST_CASE(
    "second run: --fresh with --reuse of the same name works, and an invalid --reuse destroys nothing") {
  const Collection c;
  REQUIRE(c.run().exit_code == 0);
  const std::string before = c.bytes();
  CHECK(c.run({"--fresh", "--reuse", (c.scratch / "typo.h5").string()}).exit_code == 2);
  CHECK(c.bytes() == before);
  CHECK(c.run({"--fresh", "--seed", "2", "--reuse", c.store.string()}).exit_code == 2);
  CHECK(c.bytes() == before);
  const ProcessResult result = c.run({"--fresh", "--reuse", c.store.string(), "--progress", "json"});
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  CHECK(says(result, "\"reused\":true"));
  CHECK(c.bytes() == before);
}

TEST_CASE("second run: a stopped run leaves no suspects") {
  const Collection c;
  REQUIRE(run_process(c.command(), with_fault("stop:m3")).exit_code == 75);
  CHECK(fs::file_size(c.scratch / "s.h5.run" / fs::path("begun.log")) == 0);
  CHECK(c.run().exit_code == 0);
}

TEST_CASE("run: --max-failures is named as the reason, and counts over restarts") {
  const Collection c;
  for (int i = 0; i < 40; ++i) write_file(c.in / ("bad" + std::to_string(i) + ".off"), "OFF\n0 0 0\n");
  const ProcessResult first = c.run({"--max-failures", "3", "-j", "1"});
  INFO(first.err);
  CHECK(first.exit_code == 75);
  CHECK(says(first, "models failed, more than --max-failures 3"));
  CHECK(says(first, "with a larger --max-failures continues"));
  const ProcessResult second = c.run({"--max-failures", "3", "-j", "1"});
  CHECK(second.exit_code == 75);
  CHECK(says(second, "more than --max-failures 3"));
  const ProcessResult third = c.run({"--max-failures", "6", "-j", "1"});
  CHECK(third.exit_code == 75);
  CHECK(says(third, "7 models failed"));
  CHECK(c.run({"--max-failures", "40"}).exit_code == 3);
  CHECK(c.bytes() == c.fresh_bytes());
}

TEST_CASE("run: with one thread items end in order of size, and none waits for the others") {
  const Collection c;
  write_mesh(c.in / "large.off", icosphere(5), MeshFile::off);
  const ProcessResult result =
      run_process(c.command({"-j", "1", "--progress", "json", "--timeout", "60s"}), with_fault("slow:60"));
  INFO(result.err);
  CHECK(result.exit_code == 0);
  CHECK(result.err.find("\"id\":\"large.off\"") < result.err.find("\"id\":\"m0.off\""));
  CHECK(result.err.find("\"waited\":") != std::string::npos);
}

TEST_CASE("documents: list every status and exit code, and only options that exist") {
  std::string page;
  for (const char* const name : {"REFERENCE", "RUNNING", "DATASETS", "COLUMNS"})
    page += read_file(std::string(MEANDER_SOURCE_DIR) + "/docs/" + name + ".md");
  for (const std::string_view status : status_names) {
    INFO(status);
    CHECK(page.find("| `" + std::string(status) + "` |") != std::string::npos);
  }
  for (const char* code : {"| 0 |", "| 1 |", "| 2 |", "| 3 |", "| 75 |"})
    CHECK(page.find(code) != std::string::npos);
  const ScratchFolder scratch;
  REQUIRE(run_process({fault_program, "pages", scratch.path().string()}).exit_code == 0);
  const std::string help = read_file(scratch / "doc/meander/OPTIONS.md") + " --help --help-all --version";
  for (std::size_t at = 0; (at = page.find("--", at)) != std::string::npos;) {
    std::size_t end = at + 2;
    while (end < page.size() && (std::isalpha(static_cast<unsigned char>(page[end])) || page[end] == '-'))
      ++end;
    const std::string option = page.substr(at, end - at);
    at = end;
    if (option.find_first_not_of('-') == std::string::npos) continue;  // a rule of a table
    INFO(option);
    CHECK(help.find(option) != std::string::npos);
  }
}
