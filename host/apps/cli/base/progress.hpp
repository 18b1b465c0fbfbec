#pragma once
#include <cstdint>
#include <functional>
#include <iosfwd>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace simuli {

/// Output of progress: a bar redrawn in place, plain lines (log files, CI), one JSON object per line
/// (programs), or no output.
enum class ProgressStyle { kBar, kLines, kJson, kQuiet };

/// Returns kBar if stderr is a terminal, else kLines.
[[nodiscard]] ProgressStyle progress_style();

/// Additional information of a task: text for users, named numbers for programs.
struct ProgressNote {
  std::string text;
  std::vector<std::pair<std::string, double>> values;  // unit in the name; not finite: null

  ProgressNote() = default;
  ProgressNote(const char* said) : text(said) {}  // NOLINT: a text is a note
  ProgressNote(std::string said, std::vector<std::pair<std::string, double>> numbers)
      : text(std::move(said)), values(std::move(numbers)) {}
};

/// Shows the progress of a task. Bars and lines show the elapsed time, or the remaining time at the average
/// speed once a twentieth of the task, two steps and two seconds have passed. The count of done steps never
/// decreases. A bar is redrawn at most ten times per second. Lines are printed at most every ten seconds and
/// once at the end. JSON {"task", "done", "total", "elapsed_s", "left_s", "finished", values...} is printed
/// at most once per second and at the end; left_s is null while unknown. Notes are separated by two spaces; a
/// narrow terminal omits complete notes. The destructor only writes the newline that ends an unfinished bar.
class Progress {
 public:
  /// Returns monotonic time in s.
  using Clock = std::function<double()>;

  /// `total`: number of steps (0: unknown, only the count is shown; 1: only the time is shown). Bars are cut
  /// to `columns` characters so that a narrow terminal does not scroll.
  Progress(std::string label,
           std::uint64_t total,
           ProgressStyle style,
           std::ostream& out,
           Clock clock,
           int columns = 110);
  /// Writes to stderr, with the steady clock and the width of the terminal.
  Progress(std::string label, std::uint64_t total, ProgressStyle style);
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  Progress(Progress&&) = delete;
  Progress& operator=(Progress&&) = delete;
  ~Progress();

  /// Restarts the clock with `done` steps done: earlier steps do not count for the speed.
  void start_at(std::uint64_t done);
  /// Sets the number of steps.
  void set_total(std::uint64_t total) { total_ = total; }
  /// Reports `done` steps as done; `note` is shown after the time, for example "PSNR 21.3 dB".
  void update(std::uint64_t done, const ProgressNote& note = {});
  /// Shows the last state, regardless of the time since the previous output, and ends the line.
  void finish(const ProgressNote& note = {});
  /// Finishes a completed task, even if it needed fewer steps than planned.
  void complete();

 private:
  void show(const ProgressNote& note, double now_s);
  /// Returns a line of at most `columns` characters.
  [[nodiscard]] std::string line(const std::string& note, double now_s, std::size_t columns) const;
  [[nodiscard]] std::string json(const ProgressNote& note, double now_s) const;
  /// Estimates the remaining time in s from the average speed; infinite while unknown.
  [[nodiscard]] double left_s(double now_s) const;

  std::string label_;
  std::uint64_t total_;
  ProgressStyle style_;
  std::ostream* out_;
  Clock clock_;
  int columns_;
  std::uint64_t done_ = 0;
  std::uint64_t first_ = 0;  // steps done when the clock started
  double start_s_ = 0.0;
  double shown_s_ = 0.0;
  bool shown_once_ = false;
  bool bar_open_ = false;  // the cursor is at the end of a bar
  bool finished_ = false;
};

/// Returns "0:07", "12:34", "1:02:03"; "--:--" for a time that is not finite and >= 0.
[[nodiscard]] std::string format_duration(double seconds);

}  // namespace simuli
