#include "host/apps/cli/base/progress.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <iostream>
#include <limits>
#include <sys/ioctl.h>
#include <unistd.h>
#include <utility>

#include "io/base/json_reader.hpp"

namespace simuli {
namespace {

constexpr double kBarInterval_s = 0.1;
constexpr double kLineInterval_s = 10.0;
constexpr double kJsonInterval_s = 1.0;
constexpr std::size_t kBarCells = 24;
// Minimum progress before the remaining time is estimated: step times vary, and the first step is the
// slowest.
constexpr double kMinShare = 0.05;
constexpr std::uint64_t kMinSteps = 2;
constexpr double kMin_s = 2.0;

double steady_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

int terminal_columns() {
  winsize size{};
  if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return 80;
  return size.ws_col;
}

double interval_s(ProgressStyle style) {
  if (style == ProgressStyle::kBar) return kBarInterval_s;
  return style == ProgressStyle::kJson ? kJsonInterval_s : kLineInterval_s;
}

}  // namespace

ProgressStyle progress_style() {
  return isatty(STDERR_FILENO) == 1 ? ProgressStyle::kBar : ProgressStyle::kLines;
}

std::string format_duration(double seconds) {
  constexpr double kLongest_s = 1e9;  // a longer estimate is meaningless
  if (!(seconds >= 0.0 && seconds < kLongest_s)) return "--:--";
  const auto whole = static_cast<std::int64_t>(std::llround(seconds));
  const std::int64_t hours = whole / 3600;
  const std::int64_t minutes = whole / 60 % 60;
  if (hours > 0) return fmt::format("{}:{:02}:{:02}", hours, minutes, whole % 60);
  return fmt::format("{}:{:02}", minutes, whole % 60);
}

Progress::Progress(
    std::string label, std::uint64_t total, ProgressStyle style, std::ostream& out, Clock clock, int columns)
    : label_(std::move(label)),
      total_(total),
      style_(style),
      out_(&out),
      clock_(std::move(clock)),
      columns_(std::max(columns, 20)),
      start_s_(clock_()),
      shown_s_(start_s_) {}

Progress::Progress(std::string label, std::uint64_t total, ProgressStyle style)
    : Progress(std::move(label), total, style, std::cerr, steady_seconds, terminal_columns()) {}

Progress::~Progress() {
  if (!bar_open_) return;
  try {
    *out_ << '\n' << std::flush;
  } catch (...) {  // a destructor must not throw
  }
}

void Progress::start_at(std::uint64_t done) {
  first_ = done_ = done;
  start_s_ = clock_();
}

void Progress::update(std::uint64_t done, const ProgressNote& note) {
  done_ = std::max(done_, done);
  if (style_ == ProgressStyle::kQuiet || finished_) return;
  const double now_s = clock_();
  const bool at_once = style_ != ProgressStyle::kLines;
  // The first bar appears at once; the first line only when the task takes long.
  const bool due = now_s - shown_s_ >= interval_s(style_);
  if (due || (at_once && !shown_once_)) show(note, now_s);
}

void Progress::finish(const ProgressNote& note) {
  if (style_ == ProgressStyle::kQuiet || finished_) return;
  finished_ = true;
  const double now_s = clock_();
  // A log file needs no line on a short task of one step.
  const bool is_shown = style_ != ProgressStyle::kLines || total_ != 1 || now_s - start_s_ >= kLineInterval_s;
  if (is_shown) show(note, now_s);
  if (bar_open_) *out_ << '\n' << std::flush;
  bar_open_ = false;
}

void Progress::complete() {
  done_ = total_ > 0 ? total_ : done_;
  finish();
}

void Progress::show(const ProgressNote& note, double now_s) {
  shown_s_ = now_s;
  shown_once_ = true;
  if (style_ == ProgressStyle::kJson) {
    *out_ << json(note, now_s) << '\n' << std::flush;
  } else if (style_ == ProgressStyle::kLines) {
    *out_ << line(note.text, now_s, std::string::npos) << '\n' << std::flush;
  } else {
    // Returns to the start of the line and erases the rest of a longer previous text.
    *out_ << '\r' << line(note.text, now_s, static_cast<std::size_t>(columns_ - 1)) << "\x1b[K" << std::flush;
    bar_open_ = true;
  }
}

double Progress::left_s(double now_s) const {
  if (finished_) return 0.0;
  constexpr double kUnknown_s = std::numeric_limits<double>::infinity();
  if (done_ < first_ + kMinSteps || total_ <= first_ || now_s - start_s_ < kMin_s) return kUnknown_s;
  const auto done = static_cast<double>(done_ - first_);
  const auto all = static_cast<double>(total_ - first_);
  if (done < kMinShare * all) return kUnknown_s;
  return (now_s - start_s_) * std::max(all - done, 0.0) / done;
}

std::string Progress::json(const ProgressNote& note, double now_s) const {
  Json object{{"task", label_},
              {"done", done_},
              {"total", total_},
              {"elapsed_s", now_s - start_s_},
              {"left_s", left_s(now_s)},
              {"finished", finished_}};
  for (const auto& [name, value] : note.values) object[std::string(name)] = value;
  return object.dump();  // null: not finite
}

std::string Progress::line(const std::string& note, double now_s, std::size_t columns) const {
  const double left = left_s(now_s);
  const bool shows_left = !finished_ && std::isfinite(left);
  const std::string time =
      format_duration(shows_left ? left : now_s - start_s_) + (shows_left ? " left" : " elapsed");
  std::string bar, count;
  if (total_ == 0) {
    count = fmt::format(" {}", done_);
  } else if (total_ > 1) {
    const double share = std::min(1.0, static_cast<double>(done_) / static_cast<double>(total_));
    if (style_ == ProgressStyle::kBar) {
      const auto filled = static_cast<std::size_t>(share * kBarCells);
      bar = " [" + std::string(filled, '#') + std::string(kBarCells - filled, '.') + "]";
    }
    // Rounds down, so that 100 % means done.
    count = fmt::format(" {:3.0f} % {}/{}", std::floor(100.0 * share), done_, total_);
  }
  std::string text = label_ + bar + count + "  " + time;
  // Appends complete notes while they fit.
  for (std::size_t at = 0; at < note.size();) {
    const std::size_t end = std::min(note.find("  ", at), note.size());
    if (text.size() + 2 + (end - at) > columns) break;
    text += "  " + note.substr(at, end - at);
    at = std::min(note.find_first_not_of(' ', end), note.size());
  }
  return text.substr(0, columns);
}

}  // namespace simuli
