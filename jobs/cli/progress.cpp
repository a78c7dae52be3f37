#include "jobs/cli/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string_view>

#include "io/json_writer.h"
#include "jobs/cli/terminal.h"

namespace meander {

namespace {

constexpr auto redraw_every = std::chrono::milliseconds(200);
constexpr auto plain_line_every = std::chrono::seconds(30);
constexpr int plain_width = 120;

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

std::string progress_line(const ProgressFacts& facts, int width) {
  enum Rank { always, time_left, failures, time_elapsed, points, bytes };  // the last are left out first
  // Parts are chosen by the room that they take at their longest, so that none comes and goes while they
  // change.
  struct Part {
    int rank;
    std::string text;
    std::size_t room = 0;
  };
  const std::size_t digits = std::to_string(facts.items).size();
  const std::string left = facts.done == facts.items ? "0:00"
                           : facts.left              ? duration_text(std::max(1.0, std::ceil(*facts.left)))
                                                     : "?";
  const Part parts[] = {{always, fmt::format("{}/{} models", facts.done, facts.items), 2 * digits + 8},
                        {failures, facts.failed == 0 ? "" : fmt::format("{} failed", facts.failed)},
                        {points, fmt::format("{} points/s", count_text(facts.points_per_second)), 14},
                        {bytes, fmt::format("{}B/s", count_text(facts.bytes_per_second)), 8},
                        {time_elapsed, fmt::format("{} elapsed", duration_text(facts.elapsed))},
                        {time_left, fmt::format("{} left", left)}};
  const auto text_up_to = [&](int rank) {
    std::string text = fmt::format("{:.0f}%", std::floor(100 * facts.share));
    const char* between = " ";
    for (const Part& part : parts) {
      if (part.rank > rank || part.text.empty()) continue;
      text += between + part.text;
      between = ", ";
    }
    return text;
  };
  const auto room_up_to = [&](int rank) {
    std::size_t room = 2;  // of the share: "55%", without the separator of the first part
    for (const Part& part : parts)
      if (part.rank <= rank && !part.text.empty()) room += 2 + std::max(part.room, part.text.size());
    return room;
  };
  const auto columns = static_cast<std::size_t>(width);
  constexpr std::size_t min_bar = 7, max_bar = 24, frame = 3;  // brackets and a blank
  int rank = bytes;
  while (rank > failures && room_up_to(rank) + min_bar + frame > columns) --rank;
  while (rank > always && text_up_to(rank).size() > columns) --rank;
  std::string text = text_up_to(rank);
  if (text.size() + min_bar + frame <= columns) {
    const std::size_t length = std::min(max_bar, columns - text.size() - frame);
    const auto filled = static_cast<std::size_t>(facts.share * static_cast<double>(length));
    text = fmt::format("[{}{}] {}", std::string(filled, '#'), std::string(length - filled, '.'), text);
  }
  text.resize(std::min(text.size(), columns));
  return text;
}

Progress::Progress(ProgressStyle style, std::uint64_t items, double work, int threads, std::uint32_t samples)
    : style_(style), items_(items), samples_(samples), time_(work, threads) {
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
    if (style_ == ProgressStyle::plain) print(progress_line(facts(), plain_width) + "\n");
  }
}

double Progress::elapsed() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

ProgressFacts Progress::facts() const {
  ProgressFacts facts;
  facts.items = items_;
  facts.done = done_;
  facts.failed = failed_;
  facts.share = done_ == items_ ? 1 : time_.share();
  facts.elapsed = elapsed();
  facts.points_per_second = static_cast<double>(points_) / std::max(facts.elapsed, 1e-3);
  facts.bytes_per_second = static_cast<double>(done_bytes_) / std::max(facts.elapsed, 1e-3);
  facts.left = time_.left(facts.elapsed);
  return facts;
}

// The last column stays free: some terminals begin a new line once it is written.
void Progress::draw() {
  print("\r\x1b[K" + progress_line(facts(), terminal_width(STDERR_FILENO) - 1));
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
  done_bytes_ += item.file_bytes;
  time_.finished(item.plan.work, item.seconds, elapsed(), item.in_flight_seconds);
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
            json.member("elapsed", elapsed());
            json.member("left", done_ == items_ ? 0.0 : time_.left(elapsed()).value_or(0));
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
