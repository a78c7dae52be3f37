#include "jobs/cli/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <string_view>

#include "io/json_writer.h"

namespace meander {

namespace {

constexpr auto redraw_every = std::chrono::milliseconds(200);
constexpr auto plain_line_every = std::chrono::seconds(30);
constexpr int bar_width = 24;

std::string duration_text(double seconds) {
  const auto s = static_cast<std::uint64_t>(seconds + 0.5);
  if (s >= 3600) return fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
  return fmt::format("{}:{:02}", s / 60, s % 60);
}

std::string count_text(double value) {
  const char* units[] = {"", "k", "M", "G", "T"};
  std::size_t unit = 0;
  for (; value >= 1000 && unit < 4; ++unit) value /= 1000;
  return unit == 0 ? fmt::format("{:.0f}", value) : fmt::format("{:.3g}{}", value, units[unit]);
}

void print(const std::string& text) { std::fwrite(text.data(), 1, text.size(), stderr); }

}  // namespace

ProgressStyle progress_style(const std::string& word) {
  if (word == "bar") return ProgressStyle::bar;
  if (word == "plain") return ProgressStyle::plain;
  if (word == "json") return ProgressStyle::json;
  if (word == "none") return ProgressStyle::none;
  const char* terminal = std::getenv("TERM");
  const bool can_rewrite =
      isatty(STDERR_FILENO) && terminal != nullptr && std::string_view(terminal) != "dumb";
  return can_rewrite ? ProgressStyle::bar : ProgressStyle::plain;
}

Progress::Progress(ProgressStyle style, std::uint64_t items, std::uint64_t bytes, std::uint32_t samples)
    : style_(style), items_(items), bytes_(bytes), samples_(samples) {
  if (style_ == ProgressStyle::bar || style_ == ProgressStyle::plain)
    thread_ = std::thread([this] { loop(); });
}

Progress::~Progress() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  wake_.notify_all();
  if (thread_.joinable()) thread_.join();
  if (style_ == ProgressStyle::bar && drawn_) {
    draw();
    print("\n");
  }
}

void Progress::loop() {
  std::unique_lock lock(mutex_);
  while (!stop_) {
    if (style_ == ProgressStyle::bar) draw();
    if (wake_.wait_for(
            lock, style_ == ProgressStyle::bar ? std::chrono::milliseconds(redraw_every) : plain_line_every,
            [this] { return stop_; }))
      break;
    if (style_ == ProgressStyle::plain) print(line() + "\n");
  }
}

std::string Progress::line() const {
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start_;
  const double share = bytes_ > 0 ? static_cast<double>(done_bytes_) / static_cast<double>(bytes_) : 0;
  const std::string remaining =
      done_ > 0 && share > 0.001 ? duration_text(elapsed.count() * (1 - share) / share) : "?";
  const double seconds = std::max(elapsed.count(), 1e-3);
  return fmt::format("{}/{} models, {} failed, {} points/s, {}B/s, {} elapsed, {} left", done_, items_,
                     failed_, count_text(static_cast<double>(points_) / seconds),
                     count_text(static_cast<double>(done_bytes_) / seconds), duration_text(elapsed.count()),
                     done_ == items_ ? "0:00" : remaining);
}

void Progress::draw() {
  const double share = items_ > 0 ? static_cast<double>(done_) / static_cast<double>(items_) : 1;
  const int filled = static_cast<int>(share * bar_width);
  print(fmt::format("\r\x1b[K[{}{}] {:3.0f}% {}", std::string(static_cast<std::size_t>(filled), '#'),
                    std::string(static_cast<std::size_t>(bar_width - filled), '.'), 100 * share, line()));
  drawn_ = true;
}

void Progress::clear() {
  if (drawn_) print("\r\x1b[K");
}

void Progress::finished(const FinishedItem& item) {
  const std::lock_guard lock(mutex_);
  ++done_;
  const bool ok = item.report.status == Status::ok;
  failed_ += !ok;
  reused_ += item.reused;
  done_bytes_ += item.file_bytes;
  points_ += ok ? samples_ : 0;
  if (style_ == ProgressStyle::json) {
    print(json_object([&](JsonWriter& json) {
            json.member("id", item.plan.id);
            json.member("status", name_of(item.report.status));
            json.member("reason", item.report.reason);
            json.member("method", name_of(item.report.method));
            json.member("order_reason", name_of(item.report.order_reason));
            json.member("vertices", item.report.vertices);
            json.member("faces", item.report.faces);
            json.member("seconds", item.seconds);
            json.member("waited", item.waited_seconds);
            json.member("reused", item.reused);
            json.member("done", done_);
            json.member("items", items_);
          }) +
          "\n");
  } else if (!ok && style_ != ProgressStyle::none) {
    clear();
    print(fmt::format("{}: {}: {}\n", item.plan.id, name_of(item.report.status), item.report.reason));
  }
}

void Progress::note(const std::string& text) {
  const std::lock_guard lock(mutex_);
  if (style_ == ProgressStyle::none || style_ == ProgressStyle::json) return;
  clear();
  print(text + "\n");
}

}  // namespace meander
