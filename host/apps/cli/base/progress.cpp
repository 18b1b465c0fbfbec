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
constexpr int kBarCells = 24;

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
  constexpr double kLongest_s = 1e9;  // beyond, the estimate says nothing
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
  } catch (...) {  // a stream that throws must not end the program from here
  }
}

void Progress::start_at(std::uint64_t done) {
  first_ = done_ = done;
  start_s_ = clock_();
}

void Progress::update(std::uint64_t done, const ProgressNote& note) {
  done_ = done;
  if (style_ == ProgressStyle::kQuiet || finished_) return;
  const double now_s = clock_();
  const bool at_once = style_ != ProgressStyle::kLines;
  // The first bar comes at once (something happens); the first line only when the task turns out long.
  const bool due = now_s - shown_s_ >= interval_s(style_);
  if (due || (at_once && !shown_once_)) show(note, now_s);
}

void Progress::finish(const ProgressNote& note) {
  if (style_ == ProgressStyle::kQuiet || finished_) return;
  finished_ = true;
  show(note, clock_());
  if (bar_open_) *out_ << '\n' << std::flush;
  bar_open_ = false;
}

void Progress::show(const ProgressNote& note, double now_s) {
  shown_s_ = now_s;
  shown_once_ = true;
  const std::string text = style_ == ProgressStyle::kJson ? json(note, now_s) : line(note.text, now_s);
  if (style_ != ProgressStyle::kBar) {
    *out_ << text << '\n' << std::flush;
    return;
  }
  // Back to the line's start, text, erase the rest of an older and longer text.
  *out_ << '\r' << text.substr(0, static_cast<std::size_t>(columns_ - 1)) << "\x1b[K" << std::flush;
  bar_open_ = true;
}

double Progress::left_s(double now_s) const {
  if (finished_) return 0.0;
  if (done_ <= first_ || total_ == 0) return std::numeric_limits<double>::infinity();
  const double left = total_ > done_ ? static_cast<double>(total_ - done_) : 0.0;
  return (now_s - start_s_) * left / static_cast<double>(done_ - first_);
}

std::string Progress::json(const ProgressNote& note, double now_s) const {
  Json object{{"task", label_},
              {"done", done_},
              {"total", total_},
              {"elapsed_s", now_s - start_s_},
              {"left_s", left_s(now_s)},
              {"finished", finished_}};
  for (const auto& [name, value] : note.values) object[std::string(name)] = value;
  return object.dump();  // what is not finite as null
}

std::string Progress::line(std::string_view extra, double now_s) const {
  const double elapsed_s = now_s - start_s_;
  std::string text = label_;
  if (total_ == 0) {
    text += fmt::format(" {}  {} elapsed", done_, format_duration(elapsed_s));
  } else {
    const double share = std::min(1.0, static_cast<double>(done_) / static_cast<double>(total_));
    if (style_ == ProgressStyle::kBar) {
      const auto filled = static_cast<std::size_t>(share * kBarCells);
      text += " [" + std::string(filled, '#') + std::string(kBarCells - filled, '.') + "]";
    }
    // Down, never up: 100 % is shown when everything is done and not before.
    text += fmt::format(" {:3.0f} % {}/{}", std::floor(100.0 * share), done_, total_);
    if (finished_) {
      text += fmt::format("  {} elapsed", format_duration(elapsed_s));
    } else {
      text += fmt::format("  {} left", format_duration(left_s(now_s)));
    }
  }
  if (!extra.empty()) text += "  " + std::string(extra);
  return text;
}

}  // namespace simuli
