// Runs that are interrupted: whatever happens, the finished store has the bytes of an undisturbed run.
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <thread>

#include "io/store/store_merge.h"
#include "store_support.h"
#include "support/catch.h"
#include "support/sanitized.h"

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

TEST_CASE("run: only the store is left when the run is finished") {
  const ScratchFolder folder;
  write_store(folder / "s.h5", make_header(10, 3));
  CHECK(names_in(folder.path()) == std::vector<std::string>{"s.h5"});
}

TEST_CASE("run: stopped after every single row, it resumes to identical bytes") {
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

TEST_CASE("run: stopped with several journals, some of them full, it resumes to identical bytes") {
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

TEST_CASE("run: a journal cut off at every byte keeps its complete rows") {
  const StoreHeader header = make_header(6, 2);
  const std::string expected = store_bytes(header);
  const ScratchFolder folder;
  std::vector<std::uint64_t> ends{0};
  const fs::path wal = folder / "s.h5.run/journal/rows-000000.wal";
  {
    RunDirectory run(folder / "s.h5", header);
    for (const std::uint64_t row : {4, 1, 0, 5}) {
      run.end_item(make_encoded(header, row));
      ends.push_back(fs::file_size(wal));
    }
  }
  const std::string journal = read_file(wal);
  for (std::size_t length = 0; length <= journal.size(); ++length) {
    // After the cut comes what a crashed file system may leave: nothing, zeros or arbitrary bytes.
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
  const fs::path wal = folder / "s.h5.run/journal/rows-000000.wal";
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

TEST_CASE("run: a damaged record costs its row, and the rows after it if its header is damaged") {
  const StoreHeader header = make_header(5, 2);
  const std::string expected = store_bytes(header);
  const ScratchFolder folder;
  const fs::path wal = folder / "s.h5.run/journal/rows-000000.wal";
  std::vector<std::uintmax_t> ends{0};
  {
    RunDirectory run(folder / "s.h5", header);
    for (const std::uint64_t row : {0, 1, 2, 3}) {
      run.end_item(make_encoded(header, row));
      ends.push_back(fs::file_size(wal));
    }
  }
  const std::string journal = read_file(wal);
  const auto with_flip = [&](std::uintmax_t at) {
    std::string damaged = journal;
    damaged[at] = static_cast<char>(damaged[at] ^ 1);
    write_file(wal, damaged);
  };
  with_flip(ends[2] - 1);  // the last byte of row 1
  {
    const RunDirectory run(folder / "s.h5", header);
    for (std::uint64_t row = 0; row < 5; ++row) CHECK(run.done(row) == (row != 1 && row != 4));
    CHECK(fs::file_size(wal) == ends[4]);
  }
  with_flip(ends[4] - 1);  // of the last record: it is cut off
  {
    const RunDirectory run(folder / "s.h5", header);
    CHECK(run.done_count() == 3);
    CHECK(fs::file_size(wal) == ends[3]);
  }
  with_flip(ends[1] + 1);  // the header of row 1
  CHECK(RunDirectory(folder / "s.h5", header).done_count() == 1);
  with_flip(ends[2] - 1);
  CHECK((finish_run(folder / "s.h5", header) == expected));
}

TEST_CASE("run: rows that end twice do no harm") {
  const StoreHeader header = make_header(6, 3);
  const std::string expected = store_bytes(header);
  const ScratchFolder folder;
  const fs::path wal = folder / "s.h5.run/journal/rows-000000.wal";
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

TEST_CASE("run: leftovers of a kill while the store was written are removed") {
  const StoreHeader header = make_header(4096 + 20, 2);
  const std::string expected = store_bytes(header);
  const ScratchFolder folder;
  {
    RunDirectory run(folder / "s.h5", header);
    for (std::uint64_t row = 0; row < 4096; ++row) run.end_item(make_encoded(header, row));
  }
  write_file(folder / "s.h5.part-123", "half a store");
  fs::create_directories(folder / "s.h5.run.removed-123/journal");
  {
    const RunDirectory run(folder / "s.h5", header);
    CHECK(run.done_count() == 4096);
  }
  CHECK((finish_run(folder / "s.h5", header) == expected));
  CHECK(names_in(folder.path()) == std::vector<std::string>{"s.h5"});
}

TEST_CASE("run: killed after its last row, it is finished by the next process") {
  const StoreHeader header = make_header(30, 2);
  const std::string expected = store_bytes(header);
  const ScratchFolder folder;
  {
    RunDirectory run(folder / "s.h5", header);
    for (std::uint64_t row = 0; row < 29; ++row) run.end_item(make_encoded(header, row));
  }
  const EncodedRow encoded = make_encoded(header, 29);
  const fs::path wal = folder / "s.h5.run/journal/rows-000000.wal";
  write_file(wal, read_file(wal) +
                      std::string(reinterpret_cast<const char*>(encoded.bytes.data()), encoded.bytes.size()));
  RunDirectory run(folder / "s.h5", header);
  CHECK(run.done_count() == 30);
  run.finish();
  CHECK((read_file(folder / "s.h5") == expected));
}

TEST_CASE("run: a store written from journals has the bytes of a merged one") {
  struct Size {
    std::uint64_t rows;
    std::uint32_t samples;
    bool points_alone = false;
  };
  // The last two have two chunks a row; two rows of points alone are still less than 4 MiB.
  for (const auto& [rows, samples, points_alone] : {Size{300, 2},
                                                    {300, 700},
                                                    {300, 1400},
                                                    {300, 1400, true},
                                                    {4096, 3},
                                                    {4096 + 4096 + 700, 3},
                                                    {5, 70000},
                                                    {5, 90000},
                                                    {5, 100000, true}})
    for (const Compression compression : {Compression::standard, Compression::none}) {
      if (sanitized && rows >= 4096 && compression == Compression::none) continue;  // for the time it takes
      StoreHeader header = make_header(rows, samples, compression);
      if (points_alone) header.columns = points_alone_columns();
      const ScratchFolder folder;
      {
        RunDirectory run(folder / "s.h5", header);
        for (std::uint64_t row = 0; row < rows; ++row) run.end_item(make_encoded(header, row));
        run.finish();
      }
      // Two halves of it, merged.
      std::vector<store::MergeSource> halves;
      for (const store::RowRange half : {store::RowRange{0, rows / 2}, {rows / 2, rows}}) {
        StoreHeader part = header;
        const auto cut = [&](auto& values) {
          values = {values.begin() + static_cast<std::ptrdiff_t>(half.begin),
                    values.begin() + static_cast<std::ptrdiff_t>(half.end)};
        };
        cut(part.ids);
        cut(part.labels);
        cut(part.splits);
        halves.push_back({folder / ("part" + std::to_string(half.begin)), half});
        RunDirectory run(halves.back().path, part);
        for (std::uint64_t row = half.begin; row < half.end; ++row)
          run.end_item(encode_row(part, row - half.begin, make_row(header, row)));
        run.finish();
      }
      store::merge_rows(folder / "merged.h5", header, store::make_layout(header), halves);
      INFO(rows << " rows of " << samples << " samples, points alone: " << points_alone);
      CHECK((read_file(folder / "s.h5") == read_file(folder / "merged.h5")));
    }
}

TEST_CASE("run: a journal truncated during a run is named, and no store is written") {
  const StoreHeader header = make_header(4096 + 20, 2);
  const std::string expected = store_bytes(header);
  const ScratchFolder folder;
  const fs::path journal = folder / "s.h5.run/journal/rows-000001.wal";
  std::string message;
  {
    RunDirectory run(folder / "s.h5", header);
    for (std::uint64_t row = 0; row < 4096 + 20; ++row) run.end_item(make_encoded(header, row));
    fs::resize_file(journal, fs::file_size(journal) - 3);
    try {
      run.finish();
    } catch (const RunError& error) {
      CHECK(error.kind() == RunError::Kind::stopped);
      message = error.what();
    }
  }
  CHECK_THAT(message, Catch::Matchers::ContainsSubstring(
                          "rows-000001.wal has changed since row 4115 was written to it; "
                          "what is damaged will be computed again"));
  CHECK(names_in(folder.path()) == std::vector<std::string>{"s.h5.run"});
  CHECK(RunDirectory(folder / "s.h5", header).done_count() == 4096 + 19);
  CHECK((finish_run(folder / "s.h5", header) == expected));
}

TEST_CASE("run: killed while its folder is set up, it starts anew") {
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
    // A suspect row that was not tried remains one.
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

TEST_CASE("run: a second process is refused, the lock of a dead one is ignored") {
  const StoreHeader header = make_header(5, 2);
  const ScratchFolder folder;
  {
    const RunDirectory run(folder / "s.h5", header);
    const auto [message, kind] = refusal(folder / "s.h5", header);
    CHECK(kind == 1);
    CHECK_THAT(message, Catch::Matchers::ContainsSubstring("another process (pid " +
                                                           std::to_string(::getpid()) + ") holds"));
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

TEST_CASE("run: an existing store is replaced in one step") {
  const ScratchFolder folder;
  write_store(folder / "s.h5", make_header(10, 3));
  const StoreHeader header = make_header(7, 2);
  CHECK((finish_run(folder / "s.h5", header) == store_bytes(header)));
}

TEST_CASE("discard_run: removes the run and leftovers of others, and no store") {
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

TEST_CASE("run: reports beside the store are written before the run is forgotten") {
  const StoreHeader header = make_header(9, 2);
  const ScratchFolder folder;
  {
    RunDirectory run(folder / "s.h5", header);
    for (std::uint64_t row = 0; row < 9; ++row) run.end_item(make_encoded(header, row));
    CHECK_THROWS_AS(run.finish([] { throw RunError(RunError::Kind::stopped, "no room for it"); }), RunError);
  }
  CHECK(names_in(folder.path()) == std::vector<std::string>{"s.h5", "s.h5.run"});
  bool written = false;
  {
    RunDirectory run(folder / "s.h5", header);
    CHECK(run.done_count() == 9);
    run.finish([&] { written = fs::exists(folder / "s.h5") && fs::exists(folder / "s.h5.run"); });
  }
  CHECK(written);
  CHECK(names_in(folder.path()) == std::vector<std::string>{"s.h5"});
  CHECK((read_file(folder / "s.h5") == store_bytes(header)));
}

TEST_CASE("tidy_store: removes leftovers of killed processes, and nothing of a running one") {
  const StoreHeader header = make_header(5, 2);
  const ScratchFolder folder;
  write_store(folder / "s.h5", header);
  fs::create_directories(folder / "s.h5.run.removed-123/journal");
  write_file(folder / "s.h5.part-9", "half a store");
  write_file(folder / "s.h5.part-9.off", "a mesh");
  {
    const RunDirectory run(folder / "s.h5", header);
    write_file(folder / "s.h5.part-9", "of a process at work");
    tidy_store(folder / "s.h5");
    CHECK(fs::exists(folder / "s.h5.part-9"));
  }
  fs::remove_all(folder / "s.h5.run");
  fs::create_directories(folder / "s.h5.run.removed-123/journal");
  tidy_store(folder / "s.h5");
  CHECK(names_in(folder.path()) == std::vector<std::string>{"s.h5", "s.h5.part-9.off"});
}

TEST_CASE("run: killed by SIGKILL at random moments, it resumes to identical bytes") {
  const StoreHeader header = make_header(4096 + 700, 40);
  const ScratchFolder folder;
  const fs::path store = folder / "s.h5";
  std::vector<EncodedRow> rows;
  for (const std::uint64_t row : row_order(header.ids.size(), 4)) rows.push_back(make_encoded(header, row));
  std::mt19937_64 random(1);
  int kills = 0;
  std::vector<std::string> finished;
  for (int starts = 0; finished.empty() || kills < 20; ++starts) {
    REQUIRE(starts < 400);
    const bool calm = kills >= 40;
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
          if (++begun % 16 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        run.finish();
        code = 0;
      } catch (...) {
      }
      ::_exit(code);
    }
    if (!calm)
      std::this_thread::sleep_for(std::chrono::milliseconds(5 + random() % (kills < 20 ? 30 : 3000)));
    int state = 0;
    if (::waitpid(child, &state, calm ? 0 : WNOHANG) == 0) {
      ::kill(child, SIGKILL);
      ::waitpid(child, &state, 0);
    }
    if (WIFSIGNALED(state)) {
      CHECK(WTERMSIG(state) == SIGKILL);
      ++kills;
    } else {
      REQUIRE(WEXITSTATUS(state) == 0);
      finished.push_back(read_file(store));
      if (kills < 20) fs::remove(store);  // faster than the kills: once more from nothing
    }
  }
  const std::string expected = store_bytes(header);
  for (const std::string& bytes : finished) CHECK((bytes == expected));
  CHECK(names_in(folder.path()) == std::vector<std::string>{"s.h5"});
}
