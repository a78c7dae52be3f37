// Progress of a run on standard error: a bar on a terminal, plain lines or JSON lines elsewhere.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>

#include "pipeline/sampling_graph.h"

namespace meander {

enum class ProgressStyle { bar, plain, json, none };

// The style of a word of --progress; auto: bar when standard error is a terminal that can rewrite a line,
// else plain.
ProgressStyle progress_style(const std::string& word);

// The serial writer reports every finished item. A thread redraws the bar (five times a second) or prints a
// line (every 30 s), so that a long model does not look like a hang. Failures are printed at once, one line
// each (`id: status: reason`). The remaining time is estimated from the bytes of input; it is "?" until some
// are read.
class Progress {
 public:
  Progress(ProgressStyle style, std::uint64_t items, std::uint64_t bytes, std::uint32_t samples);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void finished(const FinishedItem& item);
  void note(const std::string& text);  // prints a line

 private:
  void loop();
  std::string line() const;
  void draw();
  void clear();

  const ProgressStyle style_;
  const std::uint64_t items_, bytes_;
  const std::uint32_t samples_;
  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::uint64_t done_ = 0, failed_ = 0, reused_ = 0, done_bytes_ = 0, points_ = 0;
  bool drawn_ = false, stop_ = false;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::thread thread_;
};

}  // namespace meander
