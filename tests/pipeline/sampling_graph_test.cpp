// The graph on items made in memory, with failures put into every node (the traps of flow graphs: lost
// messages, holes, re-entered bodies, exceptions that cancel everything, items unaccounted for).
#include "pipeline/sampling_graph.h"
#include "io/run_error.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <thread>

#include "kernels/core/parallel.h"
#include "kernels/model/model_sampler.h"
#include "support/catch.h"
#include "support/test_meshes.h"

using namespace meander;

namespace {

constexpr std::uint32_t points = 4;

struct MemorySink : RowSink {
  std::map<std::uint64_t, Row> rows;
  std::uint64_t begun = 0;
  const StoreHeader* header = nullptr;
  std::uint64_t fail_after = ~std::uint64_t{0};
  std::atomic<int> inside{0};

  void begin(std::uint64_t) override { ++begun; }
  void write(EncodedRow row) override {
    REQUIRE(inside.fetch_add(1) == 0);  // the writer is serial
    if (rows.size() >= fail_after) {
      --inside;
      throw RunError(RunError::Kind::stopped, "no space left");
    }
    REQUIRE(rows.emplace(row.row, decode_row(*header, row)).second);
    --inside;
  }
};

struct Setup {
  std::vector<PlanItem> plan;
  StoreHeader header;
  GraphParameters parameters;
  MemorySink sink;
  std::atomic<bool> canceled{false};
  std::vector<NodeStatistics> statistics;

  explicit Setup(std::size_t items, int threads = 2) {
    header.samples = points;
    for (std::size_t i = 0; i < items; ++i) {
      PlanItem item;
      item.row = i;
      item.id = "item" + std::to_string(1000000 + i);
      item.reserved_bytes = 1 + i % 7;
      plan.push_back(item);
      header.ids.push_back(item.id);
      header.labels.push_back(-1);
    }
    parameters.threads = threads;
    parameters.memory_bytes = 20;
    parameters.sample.samples = points;
    sink.header = &header;
  }
  GraphResult run(const GraphStages& stages, const std::function<void(const FinishedItem&)>& observer = {}) {
    return run_sampling_graph(plan, parameters, stages, header, sink, canceled, statistics, observer);
  }
};

void make_points(GraphItem& item) {
  Samples& s = item.model.row.samples;
  s.points.assign(3 * points, static_cast<float>(item.plan->row));
  s.normals.assign(3 * points, 1);
  s.face.assign(points, 0);
  s.corners.assign(3 * points, 0);
  s.barycentric.assign(2 * points, 0);
  s.curve_rank = {0, 1, 2, 3};
  s.density.assign(points, 1);
  item.model.row.report.status = Status::ok;
}

GraphStage idle(std::string_view name) {
  return {name, [](GraphItem&) {}};
}
GraphStages three_stages(std::function<void(GraphItem&)> middle) {
  return {idle("read_mesh"), {"flatten_chart", std::move(middle)}, {"place_samples", make_points}};
}

// How many items end while others wait: between their admission, their stages and their row. What ends while
// an item is worked on does not count: a machine under load may halt its thread for any time.
struct Passing {
  explicit Passing(std::size_t items) : at_wait(items, 0), ended_before(items, 0), place(items, 0) {}
  void wait(std::uint64_t row) { at_wait[row] = ended; }
  void go_on(std::uint64_t row) { ended_before[row] += ended - at_wait[row]; }
  void end(std::uint64_t row) {
    go_on(row);
    place[row] = ended++;
  }
  std::atomic<int> ended{0};
  std::vector<int> at_wait, ended_before, place;  // per item
};

}  // namespace

TEST_CASE("sampling graph: 20,000 items, 6 % failing, nested isolated loops, all come out once") {
  Setup setup(20000);
  const auto stages = three_stages([](GraphItem& item) {
    std::vector<double> values(item.plan->row % 50 == 0 ? 2 * parallel_threshold : 16, 1.0);
    if (blocked_sum(values) != static_cast<double>(values.size())) throw std::logic_error("sum");
    if (item.plan->row % 17 == 3) throw ItemError(Status::non_finite, "made to fail");
  });
  const GraphResult result = setup.run(stages);
  CHECK(result.taken == 20000);
  CHECK(result.written == 20000);
  CHECK(result.dropped == 0);
  CHECK_FALSE(result.stopped);
  CHECK(result.peak_reserved_bytes <= 20);
  CHECK(setup.sink.begun == 20000);
  std::uint64_t failed = 0;
  for (const auto& [row, content] : setup.sink.rows) {
    failed += content.report.status != Status::ok;
    REQUIRE((content.report.status == Status::non_finite) == (row % 17 == 3));
    if (content.report.status == Status::ok) REQUIRE(content.samples.points[0] == static_cast<float>(row));
  }
  CHECK(failed == result.failed);
}

TEST_CASE("sampling graph: every kind of exception in every node becomes that item's status") {
  for (std::size_t node = 0; node < 3; ++node)
    for (int kind = 0; kind < 4; ++kind) {
      Setup setup(60);
      GraphStages stages = three_stages([](GraphItem&) {});
      auto body = stages[node].body;
      stages[node].body = [body, kind](GraphItem& item) {
        body(item);
        if (item.plan->row != 30) return;
        if (kind == 0) throw ItemError(Status::zero_area, "flat");
        if (kind == 1) throw std::bad_alloc();
        if (kind == 2) throw std::runtime_error("surprise");
        throw 42;
      };
      std::vector<std::string> reported;
      const GraphResult result = setup.run(stages, [&](const FinishedItem& item) {
        if (item.report.status != Status::ok)
          reported.push_back(item.plan.id + " in " + std::string(item.failed_in));
      });
      CHECK(result.written == 60);
      CHECK(result.failed == 1);
      const Status expected[] = {Status::zero_area, Status::out_of_memory, Status::internal,
                                 Status::internal};
      CHECK(setup.sink.rows.at(30).report.status == expected[kind]);
      CHECK_FALSE(setup.sink.rows.at(30).report.reason.empty());
      CHECK(setup.sink.rows.at(31).report.status == Status::ok);
      REQUIRE(reported.size() == 1);
      CHECK(reported[0] == setup.plan[30].id + " in " + std::string(stages[node].name));
    }
}

TEST_CASE("sampling graph: a failed item skips the remaining stages") {
  Setup setup(10);
  std::atomic<int> reached{0};
  GraphStages stages = {{"read_mesh", [](GraphItem&) { throw ItemError(Status::empty, "nothing"); }},
                        {"place_samples", [&](GraphItem&) { ++reached; }}};
  setup.run(stages);
  CHECK(reached == 0);
  CHECK(setup.sink.rows.size() == 10);
}

TEST_CASE("sampling graph: a thread waiting inside a node body never enters it again") {
  Setup setup(300);
  std::atomic<int> deepest{0};
  const auto stages = three_stages([&](GraphItem&) {
    thread_local int depth = 0;
    ++depth;
    int seen = deepest.load();
    while (depth > seen && !deepest.compare_exchange_weak(seen, depth)) {
    }
    parallel_blocks(4 * parallel_threshold, 512, [](std::size_t begin, std::size_t end) {
      volatile double sum = 0;
      for (std::size_t i = begin; i < end; ++i) sum = sum + 1;
    });
    --depth;
  });
  setup.run(stages);
  CHECK(deepest == 1);
}

TEST_CASE("sampling graph: cancellation drops items in flight, and all items are accounted for") {
  Setup setup(500);
  const auto stages = three_stages([&](GraphItem& item) {
    if (item.plan->row == 3) setup.canceled = true;
    item.model.cancel.check();
  });
  const GraphResult result = setup.run(stages);
  CHECK(result.stopped);
  CHECK(result.written < 500);
  CHECK(result.taken == result.written + result.dropped);
  CHECK(setup.sink.rows.size() == result.written);
}

TEST_CASE("sampling graph: a failing sink ends the run with its exception, and nothing is lost before") {
  Setup setup(200);
  setup.sink.fail_after = 50;
  CHECK_THROWS_AS(setup.run(three_stages([](GraphItem&) {})), RunError);
  CHECK(setup.sink.rows.size() == 50);
  setup.sink.fail_after = ~std::uint64_t{0};  // space again: the rest continues
  std::vector<PlanItem> rest;
  for (const PlanItem& item : setup.plan)
    if (!setup.sink.rows.contains(item.row)) rest.push_back(item);
  setup.plan = rest;
  setup.canceled = false;
  setup.run(three_stages([](GraphItem&) {}));
  CHECK(setup.sink.rows.size() == 200);
}

TEST_CASE("sampling graph: stops after too many failures") {
  Setup setup(1000);
  setup.parameters.max_failures = 10;
  const GraphResult result =
      setup.run(three_stages([](GraphItem&) { throw ItemError(Status::empty, "nothing"); }));
  CHECK(result.stopped);
  CHECK(result.failed > 10);
  CHECK(result.failed < 100);
}

TEST_CASE("sampling graph: a file larger than its reservation is requeued with what it needs") {
  Setup setup(40);
  const auto need = [](GraphItem& item) {
    const std::uint64_t bytes = 2 + item.plan->row % 19;
    if (item.reserved_bytes < bytes) throw NeedsMoreMemory(bytes);
  };
  GraphStages stages = {{"read_mesh", need}, {"place_samples", make_points}};
  const GraphResult result = setup.run(stages);
  CHECK(result.written == 40);
  CHECK(result.requeued > 10);
  CHECK(result.failed == 0);
  CHECK(result.peak_reserved_bytes <= 20);
}

TEST_CASE("sampling graph: an item above the budget is too_large, or runs alone if allowed") {
  for (const bool allowed : {false, true}) {
    Setup setup(20);
    setup.plan[5].reserved_bytes = 100;
    setup.parameters.allow_oversize = allowed;
    std::atomic<int> running{0}, beside{0};
    const auto stages = three_stages([&](GraphItem& item) {
      const int others = running.fetch_add(1);
      if (item.plan->row == 5) beside = others;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      --running;
    });
    const GraphResult result = setup.run(stages);
    CHECK(result.written == 20);
    CHECK(setup.sink.rows.at(5).report.status == (allowed ? Status::ok : Status::too_large));
    CHECK(beside == 0);
  }
}

TEST_CASE("sampling graph: the deadline of one model does not affect others") {
  Setup setup(12);
  setup.parameters.timeout_seconds = 2;  // more than a loaded machine needs for the others, which do nothing
  GraphStages stages = three_stages([](GraphItem& item) { item.model.cancel.check(); });
  stages[0].body = [](GraphItem& item) {
    if (item.plan->row == 4) item.worked += std::chrono::seconds(3);
  };
  setup.run(stages);
  CHECK(setup.sink.rows.at(4).report.status == Status::timeout);
  CHECK(setup.sink.rows.at(5).report.status == Status::ok);
}

TEST_CASE("sampling graph: with one thread items end in the order of their admission") {
  Setup setup(50, 1);
  setup.parameters.memory_bytes = 1 << 20;
  for (std::size_t i = 0; i < setup.plan.size(); ++i) setup.plan[i].reserved_bytes = 1000 - i;
  std::vector<std::uint64_t> ended;
  setup.run(three_stages([](GraphItem&) {}),
            [&](const FinishedItem& item) { ended.push_back(item.plan.row); });
  REQUIRE(ended.size() == 50);
  CHECK(std::is_sorted(ended.begin(), ended.end()));
}

TEST_CASE("sampling graph: no item waits behind later ones, one slow item among them") {
  for (const int threads : {1, 2, 4}) {
    Setup setup(120, threads);
    setup.parameters.memory_bytes = 1 << 20;
    // Plan order is the order of admission; the first item is slow.
    for (std::size_t i = 0; i < setup.plan.size(); ++i) setup.plan[i].reserved_bytes = 1000 - i;
    Passing passing(120);
    struct CountingSink : RowSink {
      MemorySink& rows;
      Passing& passing;
      CountingSink(MemorySink& r, Passing& p) : rows(r), passing(p) {}
      void begin(std::uint64_t row) override { passing.wait(row); }
      void write(EncodedRow row) override { rows.write(std::move(row)); }
    } sink(setup.sink, passing);
    const auto stage = [&](std::string_view name, const std::function<void(GraphItem&)>& body) -> GraphStage {
      return {name, [&passing, body](GraphItem& item) {
                passing.go_on(item.plan->row);
                body(item);
                passing.wait(item.plan->row);
              }};
    };
    const GraphStages stages = {
        stage("read_mesh", [](GraphItem&) {}),
        stage("flatten_chart",
              [&](GraphItem& item) {
                const bool slow = item.plan->row == 0;
                for (int i = 0; i == 0 || (slow && i < 2000 && threads > 1 && passing.ended < 20); ++i)
                  std::this_thread::sleep_for(std::chrono::milliseconds(5));
              }),
        stage("place_samples", make_points)};
    run_sampling_graph(setup.plan, setup.parameters, stages, setup.header, sink, setup.canceled,
                       setup.statistics, [&](const FinishedItem& item) { passing.end(item.plan.row); });
    REQUIRE(passing.ended == 120);
    INFO(threads << " threads");
    // What was admitted is worked on, and what was worked on is written, before more than the items of the
    // other threads have ended; the slow item, too.
    for (std::size_t row = 0; row < 120; ++row) {
      INFO("item " << row);
      CHECK(passing.ended_before[row] <= 2 * threads);
      if (threads == 1) CHECK(passing.place[row] == static_cast<int>(row));
    }
  }
}

TEST_CASE("sampling graph: a finished item knows for how long the others have been in flight") {
  Setup setup(40, 2);
  setup.parameters.memory_bytes = 1 << 20;
  setup.plan[0].reserved_bytes = 100;  // it is admitted first, and ends after twenty others
  std::atomic<int> ended{0};
  double least = 1e9, last = -1;
  std::vector<double> beside;
  setup.run(three_stages([&](GraphItem& item) {
              for (int i = 0; i < 2000 && item.plan->row == 0 && ended < 20; ++i)
                std::this_thread::sleep_for(std::chrono::milliseconds(5));
            }),
            [&](const FinishedItem& item) {
              if (item.plan.row != 0 && ended < 20) beside.push_back(item.in_flight_seconds);
              least = std::min(least, item.in_flight_seconds);
              last = item.in_flight_seconds;
              ++ended;
            });
  REQUIRE(beside.size() == 20);
  CHECK(*std::min_element(beside.begin(), beside.end()) > 0);
  CHECK(least >= 0);
  CHECK(last == 0);
}

TEST_CASE("sampling graph: the clock of an item stops while it waits") {
  using Clock = std::chrono::steady_clock;
  for (const int threads : {1, 2}) {
    Setup setup(80, threads);
    setup.parameters.memory_bytes = 1 << 20;
    setup.parameters.timeout_seconds = 3600;
    std::vector<Clock::time_point> left(80);  // the end of the stage before
    std::vector<Clock::duration> worked(80);  // when that began
    std::atomic<int> wrong{0};
    const auto stage = [&](std::string_view name, const std::function<void(GraphItem&)>& body) -> GraphStage {
      return {name, [&, body](GraphItem& item) {
                const std::size_t row = item.plan->row;
                // The clock was started for this stage, with what the stages before have worked.
                const Clock::time_point entered = Clock::now(), started = item.model.cancel.deadline -
                                                                          std::chrono::hours(1) + item.worked;
                wrong += started > entered || started < std::max(left[row], item.start);
                wrong += item.worked < worked[row];
                worked[row] = item.worked;
                body(item);
                left[row] = Clock::now();
                worked[row] += left[row] - entered;
              }};
    };
    const GraphStages stages = {
        stage("read_mesh", [](GraphItem&) {}), stage("flatten_chart", [](GraphItem&) {}),
        stage("place_samples", make_points), stage("describe_shape", [](GraphItem&) {})};
    double working = 0;
    const Clock::time_point begin = Clock::now();
    const GraphResult result =
        setup.run(stages, [&](const FinishedItem& item) { working += item.seconds - item.waited_seconds; });
    CHECK(result.written == 80);
    CHECK(wrong == 0);
    // Clocks run only as long as threads work: together no longer than the threads had.
    CHECK(working <= threads * std::chrono::duration<double>(Clock::now() - begin).count());
  }
}

TEST_CASE("sampling graph: the time limit covers the work of all stages together") {
  Setup setup(4, 2);
  setup.parameters.timeout_seconds = 2;  // more than a loaded machine needs for the others, which do nothing
  const auto work = [](GraphItem& item) {
    if (item.plan->row == 2) item.worked += std::chrono::milliseconds(1200);
  };
  const GraphStages stages = {
      {"read_mesh", work}, {"flatten_chart", work}, {"place_samples", make_points}, idle("describe_shape")};
  std::string failed_in;
  setup.run(stages, [&](const FinishedItem& item) {
    if (item.plan.row == 2) failed_in = item.failed_in;
  });
  CHECK(setup.sink.rows.at(2).report.status == Status::timeout);
  CHECK(failed_in == "place_samples");
  CHECK(setup.sink.rows.at(1).report.status == Status::ok);
}

TEST_CASE("sampling graph: statistics count every node") {
  Setup setup(25, 1);
  setup.run(three_stages([](GraphItem&) {}));
  REQUIRE(setup.statistics.size() == 6);
  CHECK(setup.statistics[1].name == "read_mesh");
  CHECK(setup.statistics[1].items == 25);
  CHECK(setup.statistics[4].name == "encode_row");
  CHECK(setup.statistics[4].bytes > 0);
  CHECK(setup.statistics[5].items == 25);
}

TEST_CASE("sampling graph: an empty plan ends at once") {
  Setup setup(0);
  const GraphResult result = setup.run(three_stages([](GraphItem&) {}));
  CHECK(result.written == 0);
  CHECK_FALSE(result.stopped);
}

namespace {

// Takes rows in blocks of 65,536 samples, calling `before_block` for each.
struct BlockSink : RowSink {
  const StoreHeader& header;
  std::function<void()> before_block = [] {};
  std::vector<float> points;
  std::optional<Row> failed;

  explicit BlockSink(const StoreHeader& of) : header(of) {}
  void begin(std::uint64_t) override {}
  void write(EncodedRow row) override {
    if (!row.blocks) {
      failed = decode_row(header, row);
      return;
    }
    CHECK(row.report->status == Status::ok);
    for (std::uint64_t begin = 0; begin < header.samples; begin += 65536) {
      before_block();
      const Samples block = row.blocks(begin, std::min<std::uint64_t>(begin + 65536, header.samples));
      points.insert(points.end(), block.points.begin(), block.points.end());
    }
  }
};

// One torus with a large set of samples, which its stages leave as sites.
struct LargeSet : Setup {
  GraphStages stages;
  BlockSink blocks{header};

  LargeSet() : Setup(1) {
    header.samples = 140000;
    parameters.sample = parameters_for("auto");
    parameters.sample.rows_only = true;
    parameters.sample.most_kept_samples = 0;
    parameters.sample.samples = header.samples;
    stages = {{"read_mesh", [](GraphItem& item) {
                 item.model.file = test::torus(24, 12);
                 item.model.key = make_random_key(1, {});
               }}};
    for (ModelStage& stage : stages_of(parameters.sample, nullptr))
      stages.push_back({stage.name, [run = std::move(stage.run)](GraphItem& item) { run(item.model); }});
  }
  GraphResult run() {
    return run_sampling_graph(plan, parameters, stages, header, blocks, canceled, statistics);
  }
};

}  // namespace

TEST_CASE("sampling graph: the samples of a large set reach the sink block by block") {
  LargeSet setup;
  const GraphResult result = setup.run();
  CHECK(result.written == 1);
  CHECK(result.failed == 0);
  SampleParameters whole = setup.parameters.sample;
  whole.rows_only = false;
  CHECK((setup.blocks.points == ModelSampler(whole).sample(test::torus(24, 12)).samples.points));
}

TEST_CASE(
    "sampling graph: a set that cannot be made while it is written fails as an item, and the run continues") {
  LargeSet setup;
  setup.parameters.timeout_seconds = 3600;
  setup.blocks.before_block = [&] {
    if (!setup.blocks.points.empty()) throw ItemError(Status::timeout, "took too long");
  };
  std::string_view failed_in;
  const GraphResult result = run_sampling_graph(
      setup.plan, setup.parameters, setup.stages, setup.header, setup.blocks, setup.canceled,
      setup.statistics, [&](const FinishedItem& item) { failed_in = item.failed_in; });
  CHECK(result.written == 1);
  CHECK(result.failed == 1);
  CHECK(failed_in == "write_row");
  REQUIRE(setup.blocks.failed);
  CHECK(setup.blocks.failed->report.status == Status::timeout);
  CHECK(setup.blocks.failed->report.reason == "took too long");
  CHECK(setup.blocks.failed->samples.count() == 0);
}

TEST_CASE("sampling graph: stopping a run while a large set is written drops it") {
  LargeSet setup;
  setup.blocks.before_block = [&] { setup.canceled = !setup.blocks.points.empty(); };
  const GraphResult result = setup.run();
  CHECK(result.stopped);
  CHECK(result.dropped == 1);
  CHECK(result.written == 0);
  CHECK_FALSE(setup.blocks.failed);
}
