// Runs that are interrupted: whatever happens, the finished store has the bytes of an undisturbed run.
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <thread>

#include "store_support.h"

using namespace meander;
using namespace meander::test;
namespace fs = std::filesystem;

namespace {

// Continues a run to its end and returns the bytes of the store.
std::string finish_run(const fs::path& store, const StoreHeader& header) {
  {
    RunDirectory run(store, header);
    for (const std::uint64_t row : row_order(header.ids.size(), 5)) {
      if (run.done(row)) continue;
      run.begin_item(row);
      run.end_item(make_encoded(header, row));
    }
    run.finish();
  }
  CHECK_FALSE(fs::exists(store.string() + ".run"));
  return read_file(store);
}

// The same in a copy of the folder.
std::string finish_copy(const ScratchFolder& folder, const StoreHeader& header) {
  const ScratchFolder copy;
  fs::copy(folder.path(), copy.path(), fs::copy_options::recursive);
  return finish_run(copy / "s.h5", header);
}

// The message and kind with which a run is refused; kind 0 unusable, 1 stopped, 2 not refused.
std::pair<std::string, int> refusal(const fs::path& store, const StoreHeader& header) {
  try {
    const RunDirectory run(store, header);
  } catch (const RunError& error) {
    return {error.what(), error.kind() == RunError::Kind::stopped ? 1 : 0};
  }
  return {"", 2};
}

std::vector<std::string> names_in(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace

TEST_CASE("run: the bytes of the store do not depend on the order of arrival") {
  for (const std::uint32_t samples : {5u, 1500u})
    for (const Compression compression : {Compression::standard, Compression::none}) {
      const StoreHeader header = make_header(samples == 5 ? 600 : 300, samples, compression);
      const std::string expected = store_bytes(header);
      for (const std::uint64_t seed : {1, 2}) {
        const ScratchFolder folder;
        write_store(folder / "s.h5", header, seed);
        CHECK((read_file(folder / "s.h5") == expected));
      }
    }
}

TEST_CASE("run: only the store is left when it is finished") {
  const ScratchFolder folder;
  write_store(folder / "s.h5", make_header(10, 3));
  CHECK(names_in(folder.path()) == std::vector<std::string>{"s.h5"});
}

TEST_CASE("run: stopped and continued after every single row") {
  for (const std::uint32_t samples : {4u, 1400u}) {
    const StoreHeader header = make_header(40, samples);
    const std::string expected = store_bytes(header);
    const ScratchFolder folder;
    std::uint64_t done = 0;
    for (const std::uint64_t row : row_order(40, 9)) {
      RunDirectory run(folder / "s.h5", header);
      CHECK(run.done_count() == done);
      CHECK_FALSE(run.done(row));
      run.begin_item(row);
      run.end_item(make_encoded(header, row));
      CHECK(run.done(row));
      CHECK(run.status(row) == make_row(header, row).report.status);
      ++done;
    }
    CHECK((finish_run(folder / "s.h5", header) == expected));
  }
}

TEST_CASE("run: stopped and continued with several shards, some sealed") {
  const StoreHeader header = make_header(4096 + 4096 + 50, 2);
  const std::string expected = store_bytes(header);
  const ScratchFolder folder;
  std::uint64_t done = 0;
  const auto order = row_order(header.ids.size(), 0);
  for (const std::uint64_t stop : {100, 4096, 5000, 8192, 8200}) {
    RunDirectory run(folder / "s.h5", header);
    CHECK(run.done_count() == done);
    for (; done < stop; ++done) run.end_item(make_encoded(header, order[done]));
    for (std::uint64_t i = 0; i < stop; i += 13) CHECK(run.status(i) == make_row(header, i).report.status);
  }
  CHECK((finish_run(folder / "s.h5", header) == expected));
}

TEST_CASE("run: the journal cut off at every byte") {
  const StoreHeader header = make_header(6, 2);
  const std::string expected = store_bytes(header);
  const ScratchFolder folder;
  std::vector<std::uint64_t> ends{0};
  const fs::path wal = folder / "s.h5.run/journal/shard-000000.wal";
  {
    RunDirectory run(folder / "s.h5", header);
    for (const std::uint64_t row : {4, 1, 0, 5}) {
      run.end_item(make_encoded(header, row));
      ends.push_back(fs::file_size(wal));
    }
  }
  const std::string journal = read_file(wal);
  for (std::size_t length = 0; length <= journal.size(); ++length) {
    // Behind the cut stands what a crashed file system may leave: nothing, zeros, or anything.
    std::string bytes = journal.substr(0, length);
    if (length % 3 == 1) bytes += std::string(100, '\0');
    if (length % 3 == 2) bytes += std::string(100, 'M');
    write_file(wal, bytes);
    {
      const RunDirectory run(folder / "s.h5", header);
      const auto whole = std::upper_bound(ends.begin(), ends.end(), length) - ends.begin() - 1;
      REQUIRE(run.done_count() == static_cast<std::uint64_t>(whole));
      REQUIRE(fs::file_size(wal) == ends[static_cast<std::size_t>(whole)]);
    }
    if (length % 61 == 0) REQUIRE((finish_copy(folder, header) == expected));
  }
}

TEST_CASE("run: one flipped bit in the journal costs rows, never the result") {
  const StoreHeader header = make_header(5, 2);
  const std::string expected = store_bytes(header);
  const ScratchFolder folder;
  {
    RunDirectory run(folder / "s.h5", header);
    for (const std::uint64_t row : {0, 1, 2, 3}) run.end_item(make_encoded(header, row));
  }
  const fs::path wal = folder / "s.h5.run/journal/shard-000000.wal";
  const std::string journal = read_file(wal);
  for (std::size_t i = 0; i < journal.size(); ++i) {
    std::string damaged = journal;
    damaged[i] = static_cast<char>(damaged[i] ^ (1 << (i % 8)));
    write_file(wal, damaged);
    {
      const RunDirectory run(folder / "s.h5", header);
      REQUIRE(run.done_count() < 4);
    }
    if (i % 61 == 0) REQUIRE((finish_copy(folder, header) == expected));
  }
}

TEST_CASE("run: rows that end twice do no harm") {
  const StoreHeader header = make_header(6, 3);
  const std::string expected = store_bytes(header);
  const ScratchFolder folder;
  const fs::path wal = folder / "s.h5.run/journal/shard-000000.wal";
  {
    RunDirectory run(folder / "s.h5", header);
    for (const std::uint64_t row : {2, 3, 2, 3, 2}) run.end_item(make_encoded(header, row));
    CHECK(run.done_count() == 2);
  }
  const std::string journal = read_file(wal);
  write_file(wal, journal + journal);
  {
    const RunDirectory run(folder / "s.h5", header);
    CHECK(run.done_count() == 2);
  }
  CHECK((finish_run(folder / "s.h5", header) == expected));
}

TEST_CASE("run: what a kill between two steps of sealing or finishing leaves is cleared up") {
  const StoreHeader header = make_header(4096 + 20, 2);
  const std::string expected = store_bytes(header);
  const ScratchFolder folder;
  const fs::path run_folder = folder / "s.h5.run";
  std::string journal;
  {
    RunDirectory run(folder / "s.h5", header);
    for (std::uint64_t row = 0; row < 4095; ++row) run.end_item(make_encoded(header, row));
    journal = read_file(run_folder / "journal/shard-000000.wal");
    run.end_item(make_encoded(header, 4095));
  }
  CHECK(fs::exists(run_folder / "shards/shard-000000.h5"));
  CHECK_FALSE(fs::exists(run_folder / "journal/shard-000000.wal"));
  write_file(run_folder / "journal/shard-000000.wal", journal);  // sealed, but the journal not yet removed
  write_file(run_folder / "shards/shard-000001.h5.new", "half a shard");
  write_file(folder / "s.h5.part-123", "half a store");
  fs::create_directories(folder / "s.h5.run.removed-123/shards");
  {
    const RunDirectory run(folder / "s.h5", header);
    CHECK(run.done_count() == 4096);
  }
  CHECK((finish_run(folder / "s.h5", header) == expected));
  CHECK(names_in(folder.path()) == std::vector<std::string>{"s.h5"});
}

TEST_CASE("run: a shard whose rows are all done but that was never sealed is sealed at the end") {
  const StoreHeader header = make_header(30, 2);
  const std::string expected = store_bytes(header);
  const ScratchFolder folder;
  std::string last;
  {
    RunDirectory run(folder / "s.h5", header);
    for (std::uint64_t row = 0; row < 29; ++row) run.end_item(make_encoded(header, row));
  }
  const EncodedRow encoded = make_encoded(header, 29);
  const fs::path wal = folder / "s.h5.run/journal/shard-000000.wal";
  write_file(wal, read_file(wal) +
                      std::string(reinterpret_cast<const char*>(encoded.bytes.data()), encoded.bytes.size()));
  RunDirectory run(folder / "s.h5", header);
  CHECK(run.done_count() == 30);
  run.finish();
  CHECK((read_file(folder / "s.h5") == expected));
}

TEST_CASE("run: a damaged sealed shard is named, and removing it is enough") {
  const StoreHeader header = make_header(20, 2);
  const std::string expected = store_bytes(header);
  const ScratchFolder folder;
  {
    RunDirectory run(folder / "s.h5", header);
    for (std::uint64_t row = 0; row < 20; ++row) run.end_item(make_encoded(header, row));
  }
  const fs::path shard = folder / "s.h5.run/shards/shard-000000.h5";
  std::string bytes = read_file(shard);
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 4);
  write_file(shard, bytes);
  std::string message;
  try {
    RunDirectory run(folder / "s.h5", header);
    run.finish();
  } catch (const RunError& error) {
    CHECK(error.kind() == RunError::Kind::unusable);
    message = error.what();
  }
  CHECK_THAT(message, Catch::Contains("shard-000000.h5 is damaged"));
  CHECK_FALSE(fs::exists(folder / "s.h5"));
  fs::remove(shard);
  CHECK((finish_run(folder / "s.h5", header) == expected));
}

TEST_CASE("run: killed while its folder is set up") {
  const StoreHeader header = make_header(9, 2);
  const std::string expected = store_bytes(header);
  for (const int stage : {0, 1, 2}) {
    const ScratchFolder folder;
    fs::create_directories(folder / "s.h5.run");
    if (stage > 0) fs::create_directories(folder / "s.h5.run/journal");
    if (stage > 1) write_file(folder / "s.h5.run/plan.bin", "meander pl");
    CHECK((finish_run(folder / "s.h5", header) == expected));
  }
}

TEST_CASE("run: suspects are the rows that were begun and never ended") {
  const StoreHeader header = make_header(50, 2);
  const ScratchFolder folder;
  const auto end = [&](RunDirectory& run, std::uint64_t row) { run.end_item(make_encoded(header, row)); };
  {
    RunDirectory run(folder / "s.h5", header);
    CHECK(run.suspects().empty());
    for (const std::uint64_t row : {9, 3, 7, 5, 3}) run.begin_item(row);
    end(run, 7);
    end(run, 20);  // never begun: nothing to suspect
    CHECK(run.suspects().empty());
  }
  const fs::path log = folder / "s.h5.run/begun.log";
  {
    RunDirectory run(folder / "s.h5", header);
    CHECK(run.suspects() == std::vector<std::uint64_t>{3, 5, 9});
    CHECK(fs::file_size(log) == 3 * 16);
    end(run, 5);
    run.begin_item(11);
    run.begin_item(12);
    end(run, 12);
  }
  {
    // A suspect that nobody dealt with remains one.
    const RunDirectory run(folder / "s.h5", header);
    CHECK(run.suspects() == std::vector<std::uint64_t>{3, 9, 11});
  }
  const std::string bytes = read_file(log);
  for (std::size_t length = 0; length <= bytes.size(); ++length) {
    write_file(log, bytes.substr(0, length));
    const RunDirectory run(folder / "s.h5", header);
    CHECK(run.suspects().size() == length / 16);
  }
  std::string damaged = bytes;
  damaged[20] = static_cast<char>(damaged[20] ^ 1);
  write_file(log, damaged + std::string(64, '\0'));
  const RunDirectory run(folder / "s.h5", header);
  CHECK(run.suspects().size() == 2);
}

TEST_CASE("run: a second process is stopped, a name left by a dead one is no obstacle") {
  const StoreHeader header = make_header(5, 2);
  const ScratchFolder folder;
  {
    const RunDirectory run(folder / "s.h5", header);
    const auto [message, kind] = refusal(folder / "s.h5", header);
    CHECK(kind == 1);
    CHECK_THAT(message, Catch::Contains("another process (pid " + std::to_string(::getpid()) + ") holds"));
    try {
      discard_run(folder / "s.h5");
      FAIL("the store of a running process was discarded");
    } catch (const RunError& error) {
      CHECK(error.kind() == RunError::Kind::stopped);
    }
  }
  write_file(folder / "s.h5.run/lock", "99999999");
  CHECK(refusal(folder / "s.h5", header).second == 2);
}

TEST_CASE("run: other parameters and other items are refused by name") {
  const StoreHeader header = make_header(20, 4);
  const ScratchFolder folder;
  {
    RunDirectory run(folder / "s.h5", header);
    run.end_item(make_encoded(header, 3));
  }
  const auto message = [&](const std::function<void(StoreHeader&)>& change) {
    StoreHeader other = header;
    change(other);
    const auto [text, kind] = refusal(folder / "s.h5", other);
    CHECK(kind == 0);
    return text;
  };
  using Catch::Contains;
  CHECK_THAT(message([](StoreHeader& h) { h.samples = 5; }),
             Contains("number of samples was 4, now it is 5"));
  CHECK_THAT(message([](StoreHeader& h) { h.seed = 8; }), Contains("seed was 7, now it is 8"));
  CHECK_THAT(message([](StoreHeader& h) { h.order = "curve"; }),
             Contains("order was progressive, now it is curve"));
  CHECK_THAT(message([](StoreHeader& h) { h.compression = Compression::none; }),
             Contains("compression was default"));
  CHECK_THAT(message([](StoreHeader& h) {
               h.parameters_json = R"({"density":"mean","describe":["d2"],"method":"conformal"})";
             }),
             Contains(R"(parameter "density" was "uniform", now it is "mean")"));
  CHECK_THAT(message([](StoreHeader& h) {
               h.parameters_json = R"({"density":"uniform","describe":["d2","a,:}3"],"method":"conformal"})";
             }),
             Contains(R"(parameter "describe" was ["d2"], now it is ["d2","a,:}3"])"));
  CHECK_THAT(
      message([](StoreHeader& h) { h.parameters_json = R"({"density":"uniform","describe":["d2"]})"; }),
      Contains(R"(parameter "method" was "conformal" and is not given now)"));
  CHECK_THAT(message([](StoreHeader& h) {
               h.parameters_json =
                   R"({"a":{"b":[1,{"c":2}]},"density":"uniform","describe":["d2"],"method":"conformal"})";
             }),
             Contains(R"(parameter "a" was not given, now it is {"b":[1,{"c":2}]})"));
  CHECK_THAT(message([](StoreHeader& h) { h.descriptors.pop_back(); }),
             Contains("were d2(64), a3(5), now they are d2(64)"));
  CHECK_THAT(message([](StoreHeader& h) { h.descriptors[1].attributes[0].second = "other"; }),
             Contains("bins of descriptor a3"));
  CHECK_THAT(message([](StoreHeader& h) { h.labels[2] = 99; }), Contains("label of \"class/m0000002.off\""));
  CHECK_THAT(message([](StoreHeader& h) { h.splits[2] = Split::none; }),
             Contains("split of \"class/m0000002.off\" was test, now it is none"));
  CHECK_THAT(message([](StoreHeader& h) { h.label_names.pop_back(); }), Contains("names of the classes"));
  CHECK_THAT(message([](StoreHeader& h) {
               h.ids.erase(h.ids.begin() + 4, h.ids.begin() + 6);
               h.labels.resize(h.ids.size());
               h.splits.resize(h.ids.size());
             }),
             Contains("2 gone (the first is \"class/m0000004.off\")"));
  CHECK_THAT(
      message([](StoreHeader& h) {
        h.ids.front() = "a.off";
        h.ids.push_back("zebra.off");
        h.labels.push_back(0);
        h.splits.push_back(Split::none);
      }),
      Contains("1 gone (the first is \"class/m0000000-long-name.off\"), 2 new (the first is \"a.off\")"));
  CHECK(refusal(folder / "s.h5", header).second == 2);
}

TEST_CASE("run: a damaged plan is refused at every byte") {
  const StoreHeader header = make_header(2, 4);
  const ScratchFolder folder;
  { const RunDirectory run(folder / "s.h5", header); }
  const fs::path plan = folder / "s.h5.run/plan.bin";
  const std::string bytes = read_file(plan);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::string damaged = bytes;
    damaged[i] = static_cast<char>(damaged[i] ^ (1 << (i % 8)));
    write_file(plan, damaged);
    CHECK(refusal(folder / "s.h5", header).second == 0);
    write_file(plan, bytes.substr(0, i));
    CHECK(refusal(folder / "s.h5", header).second == 0);
  }
}

TEST_CASE("run: a folder that is not there is unusable") {
  const ScratchFolder folder;
  const auto [message, kind] = refusal(folder / "nowhere/s.h5", make_header(2, 4));
  CHECK(kind == 0);
  CHECK_THAT(message, Catch::Contains("No such file or directory"));
}

TEST_CASE("run: headers and rows that contradict themselves are bugs of ours") {
  const ScratchFolder folder;
  StoreHeader header = make_header(4, 2);
  std::swap(header.ids[1], header.ids[2]);
  CHECK_THROWS_AS(RunDirectory(folder / "s.h5", header), ItemError);
  header = make_header(4, 2);
  header.ids[1] = header.ids[0];
  CHECK_THROWS_AS(RunDirectory(folder / "s.h5", header), ItemError);
  header = make_header(4, 2);
  header.labels.pop_back();
  CHECK_THROWS_AS(RunDirectory(folder / "s.h5", header), ItemError);
  header = make_header(4, 0);
  CHECK_THROWS_AS(RunDirectory(folder / "s.h5", header), ItemError);
  header = make_header(4, 2);
  RunDirectory run(folder / "s.h5", header);
  CHECK_THROWS_AS(run.begin_item(4), ItemError);
  CHECK_THROWS_AS(run.done(4), ItemError);
  CHECK_THROWS_AS(run.status(0), ItemError);
  CHECK_THROWS_AS(run.finish(), ItemError);
  EncodedRow encoded = make_encoded(header, 1);
  encoded.row = 2;
  CHECK_THROWS_AS(run.end_item(encoded), ItemError);
}

TEST_CASE("run: a store that is there is replaced in one step") {
  const ScratchFolder folder;
  write_store(folder / "s.h5", make_header(10, 3));
  const StoreHeader header = make_header(7, 2);
  CHECK((finish_run(folder / "s.h5", header) == store_bytes(header)));
}

TEST_CASE("run: links that lead nowhere are refused at once") {
  const ScratchFolder folder;
  const StoreHeader header = make_header(5, 2);
  fs::create_symlink(folder / "nowhere", folder / "s.h5.run");
  const auto [message, kind] = refusal(folder / "s.h5", header);
  CHECK(kind == 0);
  CHECK_THAT(message, Catch::Contains("s.h5.run") && Catch::Contains("No such file"));
  fs::create_directory(folder / "t.h5.run");
  fs::create_symlink(folder / "none/nowhere", folder / "t.h5.run/lock");
  CHECK_THAT(refusal(folder / "t.h5", header).first, Catch::Contains("t.h5.run/lock"));
}

TEST_CASE("discard_run: removes the run and what was left of others, and no store") {
  const ScratchFolder folder;
  discard_run(folder / "s.h5");
  write_store(folder / "s.h5", make_header(10, 3));
  { const RunDirectory run(folder / "s.h5", make_header(5, 3)); }
  write_file(folder / "s.h5.part-7", "x");
  write_file(folder / "s.h5x", "stays");
  write_file(folder / "s.h5.part-1.off", "stays");
  discard_run(folder / "s.h5");
  CHECK(names_in(folder.path()) == std::vector<std::string>{"s.h5", "s.h5.part-1.off", "s.h5x"});
}

TEST_CASE("run: killed by SIGKILL at random moments") {
  const StoreHeader header = make_header(4096 + 700, 40);
  const ScratchFolder folder;
  const fs::path store = folder / "s.h5";
  std::vector<EncodedRow> rows;
  for (const std::uint64_t row : row_order(header.ids.size(), 4)) rows.push_back(make_encoded(header, row));
  std::mt19937_64 random(1);
  int kills = 0;
  for (bool finished = false; !finished;) {
    const pid_t child = ::fork();
    REQUIRE(child >= 0);
    if (child == 0) {
      int code = 1;
      try {
        RunDirectory run(store, header);
        std::uint64_t begun = 0;
        for (const EncodedRow& row : rows) {
          if (run.done(row.row)) continue;
          run.begin_item(row.row);
          run.end_item(row);
          // About 20 kills should fall between the first row and the end of finish().
          if (++begun % 16 == 0) std::this_thread::sleep_for(std::chrono::microseconds(400));
        }
        run.finish();
        code = 0;
      } catch (...) {
      }
      ::_exit(code);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(5 + random() % (kills < 20 ? 30 : 3000)));
    int state = 0;
    if (::waitpid(child, &state, WNOHANG) == 0) {
      ::kill(child, SIGKILL);
      ::waitpid(child, &state, 0);
    }
    if (WIFSIGNALED(state)) {
      CHECK(WTERMSIG(state) == SIGKILL);
      ++kills;
    } else {
      REQUIRE(WEXITSTATUS(state) == 0);
      finished = true;
    }
    REQUIRE(kills < 200);
  }
  CHECK(kills >= 20);
  CHECK((read_file(store) == store_bytes(header)));
  CHECK(names_in(folder.path()) == std::vector<std::string>{"s.h5"});
}
