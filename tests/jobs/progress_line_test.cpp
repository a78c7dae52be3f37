// The line of progress at all widths, and the time that is left in runs that are simulated.
#include <algorithm>
#include <cmath>
#include <functional>
#include <queue>
#include <random>
#include <string>
#include <vector>

#include "jobs/cli/progress.h"
#include "jobs/cli/remaining_time.h"
#include "support/catch.h"

using namespace meander;

namespace {

struct SimulatedItem {
  double work, seconds;
};

// The largest error of the time left, as a share of it, between two parts of a run in which `threads` take
// the items in order.
double largest_error(const std::vector<SimulatedItem>& items, int threads, double from, double to) {
  struct End {
    double at, begun;
    std::size_t item;
    bool operator>(const End& other) const { return at > other.at; }
  };
  double work = 0;
  for (const SimulatedItem& item : items) work += item.work;
  std::priority_queue<End, std::vector<End>, std::greater<>> at_work;
  std::vector<End> ends;
  std::size_t next = 0;
  double now = 0;
  while (ends.size() < items.size()) {
    for (; next < items.size() && at_work.size() < static_cast<std::size_t>(threads); ++next)
      at_work.push({now + items[next].seconds, now, next});
    ends.push_back(at_work.top());
    now = ends.back().at;
    at_work.pop();
  }
  RemainingTime time(work, threads);
  double largest = 0;
  for (std::size_t i = 0; i < ends.size(); ++i) {
    const End& end = ends[i];
    double in_flight = 0;
    for (std::size_t later = i + 1; later < ends.size(); ++later)
      in_flight += std::max(0.0, end.at - ends[later].begun);
    time.finished(items[end.item].work, items[end.item].seconds, end.at, in_flight);
    if (end.at < from * now || end.at > to * now) continue;
    const double truth = now - end.at;
    largest = std::max(largest, std::abs(*time.left(end.at) - truth) / truth);
  }
  return largest;
}

// Items from large to small, as a collection has them. `large`, `small`: how many times the estimate the
// parts of an item by its size and of every item take.
std::vector<SimulatedItem> collection(std::size_t count, double large, double small, double spread) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  std::vector<SimulatedItem> items;
  for (std::size_t i = 0; i < count; ++i) {
    const double by_size = 0.02 * std::exp(normal(random)), by_item = 0.02;
    items.push_back(
        {by_size + by_item, (large * by_size + small * by_item) * std::exp(spread * normal(random))});
  }
  std::sort(items.begin(), items.end(), [](const auto& a, const auto& b) { return a.work > b.work; });
  return items;
}

ProgressFacts example() {
  ProgressFacts facts;
  facts.items = 421;
  facts.done = 140;
  facts.failed = 3;
  facts.share = 0.3349;
  facts.points_per_second = 123456;
  facts.bytes_per_second = 4.56e6;
  facts.elapsed = 12.3;
  facts.left = 83.9;
  return facts;
}

}  // namespace

TEST_CASE("progress: a line holds what there is room for, and is never longer") {
  CHECK(
      progress_line(example(), 119) ==
      "[########................] 33% 140/421 models, 3 failed, 123k points/s, 4.56MB/s, 0:12 elapsed, 1:24 "
      "left");
  CHECK(progress_line(example(), 79) ==
        "[##......] 33% 140/421 models, 3 failed, 123k points/s, 0:12 elapsed, 1:24 left");
  CHECK(progress_line(example(), 60) == "[######............] 33% 140/421 models, 3 failed, 1:24 left");
  CHECK(progress_line(example(), 39) == "33% 140/421 models, 3 failed, 1:24 left");
  CHECK(progress_line(example(), 30) == "33% 140/421 models, 1:24 left");
  ProgressFacts large = example();
  large.items = 51234567;
  large.done = 50000000;
  large.failed = 123456;
  large.elapsed = 123456;
  large.left = 1234567;
  for (const ProgressFacts& facts : {example(), large, ProgressFacts{}})
    for (int width = 20; width <= 120; ++width) {
      CAPTURE(width);
      CHECK(progress_line(facts, width).size() <= static_cast<std::size_t>(width));
      if (width >= 60) CHECK(progress_line(facts, width).ends_with(" left"));
    }
  // What is shown does not change while the numbers do.
  for (const int width : {60, 79, 119}) {
    ProgressFacts running;
    running.items = 421;
    running.left = 100;
    const auto commas = [&] {
      const std::string line = progress_line(running, width);
      return std::count(line.begin(), line.end(), ',');
    };
    running.share = 0.12;
    running.done = 100;
    running.points_per_second = 36.2e3;
    running.bytes_per_second = 4.31e6;
    const auto shown = commas();
    for (int done = 1; done < 421; ++done) {
      running.done = static_cast<std::uint64_t>(done);
      running.share = done / 421.;
      running.points_per_second = 20000 + 61.7 * done;
      running.bytes_per_second = 6e6 - 7123 * done;
      running.elapsed = done;
      CAPTURE(width, done);
      CHECK(commas() == shown);
    }
  }
  ProgressFacts unknown = example();
  unknown.left.reset();
  CHECK(progress_line(unknown, 30) == "33% 140/421 models, ? left");
  ProgressFacts all = example();
  all.done = all.items;
  all.share = 1;
  all.failed = 0;
  CHECK(progress_line(all, 39) == "100% 421/421 models, 0:00 left");
}

TEST_CASE("progress: from a tenth of a run on the time left is right within 30 %") {
  for (const int threads : {1, 2, 8}) {
    CAPTURE(threads);
    // A machine that is four times slower or faster than the one of the estimates.
    CHECK(largest_error(collection(1000, 4, 4, 0.3), threads, 0.1, 0.9) < 0.3);
    CHECK(largest_error(collection(1000, 0.25, 0.25, 0.3), threads, 0.1, 0.9) < 0.3);
    // Large models are estimated otherwise than small ones.
    CHECK(largest_error(collection(1000, 1.3, 0.8, 0.3), threads, 0.1, 0.9) < 0.3);
    // One model in fifty takes thirty times as long as its like, the second one too.
    std::vector<SimulatedItem> outliers = collection(1000, 1, 1, 0.3);
    for (std::size_t i = 1; i < outliers.size(); i += 50) outliers[i].seconds *= 10;
    CHECK(largest_error(outliers, threads, 0.1, 0.9) < 0.3);
    // One of the first models takes an eighth of all work, others are done beside it.
    std::vector<SimulatedItem> giant = collection(400, 1, 1, 0.1);
    double work = 0;
    for (const SimulatedItem& item : giant) work += item.work;
    giant[1].seconds = work / 8;
    CHECK(largest_error(giant, threads, 0.1, 0.9) < 0.3);
  }
}

TEST_CASE(
    "progress: the time left runs down between items, is unknown before the first and 0 after the last") {
  RemainingTime time(3, 1);
  CHECK_FALSE(time.left(0));
  CHECK(time.share() == 0);
  time.finished(1, 1, 1, 0);
  CHECK(*time.left(1) == Approx(2));
  CHECK(*time.left(1.5) == Approx(1.5));
  CHECK(*time.left(9) == 0);
  CHECK(time.share() == Approx(1. / 3));
  time.finished(1, 1, 2, 0);
  time.finished(1, 1, 3, 0);
  CHECK(*time.left(3) == 0);
  CHECK(time.share() == 1);
  // Items without work (unreadable ones) are no reason to be surprised.
  RemainingTime nothing(0, 4);
  nothing.finished(0, 0, 0, 0);
  CHECK(*nothing.left(0) == 0);
  CHECK(nothing.share() == 0);
}
