// Progress of a run on standard error: a bar on a terminal, plain lines or JSON lines elsewhere.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "jobs/cli/remaining_time.h"
#include "pipeline/sampling_graph.h"

namespace meander {

enum class ProgressStyle { bar, plain, json, none };

// The style of a word of --progress; auto: bar when standard error is a terminal that can rewrite a line,
// else plain.
ProgressStyle progress_style(const std::string& word);

// What a line of progress says.
struct ProgressFacts {
  std::uint64_t items = 0, done = 0, failed = 0;
  double share = 0;  // of the work
  double points_per_second = 0, bytes_per_second = 0, elapsed = 0;
  std::optional<double> left;  // seconds
};

// The line in at most `width` columns (20 or more), with a bar, and without what there is no room for.
std::string progress_line(const ProgressFacts& facts, int width);

// The serial writer reports every finished item. A thread redraws the bar (five times a second) or prints a
// line (every 30 s), so that a long model does not look like a hang. Failures are printed at once, one line
// each (`id: status: reason`).
class Progress {
 public:
  // work: the sum of PlanItem::work of all items.
  Progress(ProgressStyle style, std::uint64_t items, double work, int threads, std::uint32_t samples);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void finished(const FinishedItem& item);
  void note(const std::string& text);  // prints a line

 private:
  void loop();
  double elapsed() const;
  ProgressFacts facts() const;
  void draw();
  void clear();

  const ProgressStyle style_;
  const std::uint64_t items_;
  const std::uint32_t samples_;
  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  RemainingTime time_;
  std::uint64_t done_ = 0, failed_ = 0, done_bytes_ = 0, points_ = 0;
  bool drawn_ = false, stop_ = false;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::thread thread_;
};

}  // namespace meander
