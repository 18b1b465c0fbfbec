#pragma once
// Handling of SIGINT, SIGTERM, SIGHUP and SIGPIPE: incomplete files are removed, and a training with
// checkpoints writes a last one.
#include <stdexcept>
#include <string>

namespace simuli::cli {

/// Exit code of interrupted work that can be resumed (EX_TEMPFAIL of sysexits.h).
inline constexpr int kInterruptedExit = 75;

/// Thrown by interrupted work after its state has been stored; what() contains the place. run_program()
/// returns kInterruptedExit for it.
class Interrupted : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Installs the handlers: each of these signals removes the temporaries (io/base/temporary.hpp) and then ends
/// the process with the signal's default action. Signals that are ignored at the start (nohup) remain
/// ignored.
void watch_signals();

/// Ends the process by SIGPIPE, without an error, when the reader of its output has closed (`| head`).
void end_if_unread();

/// During the lifetime of an object the first signal only sets is_asked_for() and prints `note` to stderr;
/// the second signal ends the process.
class InterruptionPoint {
 public:
  /// `note` must be a string literal, since a signal may arrive at any time.
  explicit InterruptionPoint(const char* note = "a checkpoint is written; a second signal ends it without");
  InterruptionPoint(const InterruptionPoint&) = delete;
  InterruptionPoint& operator=(const InterruptionPoint&) = delete;
  ~InterruptionPoint();
  [[nodiscard]] bool is_requested_for() const;
};

}  // namespace simuli::cli
