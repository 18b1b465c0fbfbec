#pragma once
#include <cstdint>
#include <functional>
#include <iosfwd>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace simuli {

/// How progress is shown: a bar redrawn in place, plain lines (log files, CI), one JSON object a line (other
/// programs), or not at all.
enum class ProgressStyle { kBar, kLines, kJson, kQuiet };

/// kBar when stderr is a terminal, else kLines.
[[nodiscard]] ProgressStyle progress_style();

/// What a task says of itself beside how far it is: text for people, named numbers for programs.
struct ProgressNote {
  std::string text;
  std::vector<std::pair<std::string, double>> values;  // unit in the name; not finite: null

  ProgressNote() = default;
  ProgressNote(const char* said) : text(said) {}  // NOLINT: a text is a note
  ProgressNote(std::string said, std::vector<std::pair<std::string, double>> numbers)
      : text(std::move(said)), values(std::move(numbers)) {}
};

/// Shows how far a task of known size is, with the time left at its average speed so far: once a twentieth of
/// it, two steps and two seconds are behind it, and the time elapsed before. What is done never gets less. As
/// a bar it is redrawn at most ten times a second; as lines at most every ten seconds and once at the end; as
/// JSON {"task", "done", "total", "elapsed_s", "left_s", "finished", values...} at most once a second and at
/// the end, with left_s null as long as it can't be known. Notes are parted by two spaces; those that a
/// narrow terminal has no room for are left out whole. Nothing is written from the destructor but the newline
/// that a broken-off bar still owes the terminal.
class Progress {
 public:
  /// Monotonic time in seconds.
  using Clock = std::function<double()>;

  /// `total` steps to do (0: the size is unknown, only the count is shown; 1: the time alone). Bars are cut to
  /// `columns` characters, so that a narrow terminal does not scroll.
  Progress(std::string label,
           std::uint64_t total,
           ProgressStyle style,
           std::ostream& out,
           Clock clock,
           int columns = 110);
  /// On stderr with the system's steady clock and the terminal's own width.
  Progress(std::string label, std::uint64_t total, ProgressStyle style);
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  Progress(Progress&&) = delete;
  Progress& operator=(Progress&&) = delete;
  ~Progress();

  /// The clock starts now, with `done` steps done: what was before tells nothing of the speed.
  void start_at(std::uint64_t done);
  /// The size of the task, once it is known.
  void set_total(std::uint64_t total) { total_ = total; }
  /// `done` steps are done; `note` is shown behind the time, e.g. "PSNR 21.3 dB".
  void update(std::uint64_t done, const ProgressNote& note = {});
  /// Shows the last state, whatever the time since the one before, and ends the line.
  void finish(const ProgressNote& note = {});
  /// The same of a task that is done, whether or not it needed all of its steps.
  void complete();

 private:
  void show(const ProgressNote& note, double now_s);
  /// Of at most `columns` characters.
  [[nodiscard]] std::string line(const std::string& note, double now_s, std::size_t columns) const;
  [[nodiscard]] std::string json(const ProgressNote& note, double now_s) const;
  /// At the average speed so far; infinite before it can be known.
  [[nodiscard]] double left_s(double now_s) const;

  std::string label_;
  std::uint64_t total_;
  ProgressStyle style_;
  std::ostream* out_;
  Clock clock_;
  int columns_;
  std::uint64_t done_ = 0;
  std::uint64_t first_ = 0;  // steps that were done when the clock started
  double start_s_ = 0.0;
  double shown_s_ = 0.0;
  bool shown_once_ = false;
  bool bar_open_ = false;  // the cursor stands at the end of a bar
  bool finished_ = false;
};

/// "0:07", "12:34", "1:02:03"; "--:--" for a time that is not a finite number >= 0.
[[nodiscard]] std::string format_duration(double seconds);

}  // namespace simuli
