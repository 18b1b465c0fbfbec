#pragma once
// SIGINT, SIGTERM, SIGHUP and SIGPIPE: nothing half-written stays, and a training that keeps checkpoints keeps
// one more.
#include <stdexcept>
#include <string>

namespace simuli::cli {

/// Exit code of work that was interrupted and can go on where it was (EX_TEMPFAIL of sysexits.h).
inline constexpr int kInterruptedExit = 75;

/// Leaves work that has stored its state; what() says where. run_program() makes kInterruptedExit of it.
class Interrupted : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// From here on such a signal removes the temporaries (io/base/temporary.hpp) and then ends the process, as
/// it would have at once. Signals that are ignored (nohup) stay ignored.
void watch_signals();

/// Ends the process, as such a signal does, where what it prints has lost its reader (`| head`): no error to tell.
void end_if_unread();

/// While there is one, the first signal is only noted, and `note` told on stderr; the second ends the
/// process.
class InterruptionPoint {
 public:
  /// `note` is a literal: it is told whenever the signal comes.
  explicit InterruptionPoint(const char* note = "a checkpoint is written; a second signal ends it without");
  InterruptionPoint(const InterruptionPoint&) = delete;
  InterruptionPoint& operator=(const InterruptionPoint&) = delete;
  ~InterruptionPoint();
  [[nodiscard]] bool is_asked_for() const;
};

}  // namespace simuli::cli
