#include "host/cli/base/interrupt.hpp"

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <fcntl.h>
#include <iostream>
#include <system_error>
#include <thread>
#include <unistd.h>

#include "io/base/temporary.hpp"

namespace simuli::cli {
namespace {

std::atomic<int> points{0};  // InterruptionPoint objects
std::atomic<bool> is_noted{false};
int signal_pipe = -1;  // the handler's end

/// All that a handler may do; files are removed by a thread.
void note_signal(int signal) {
  const int error = errno;
  const auto byte = static_cast<unsigned char>(signal);
  static_cast<void>(!::write(signal_pipe, &byte, 1));
  errno = error;
}

void end_by(int signal) {
  remove_temporaries();
  std::signal(signal, SIG_DFL);
  ::kill(::getpid(), signal);
}

void serve(int pipe) {
  unsigned char signal = 0;
  for (;;) {
    const ssize_t got = ::read(pipe, &signal, 1);
    if (got < 0 && errno == EINTR) continue;
    if (got != 1) return;
    if (points > 0 && !is_noted.exchange(true)) {
      std::cerr << "simuli: interrupted: a checkpoint is written; a second signal ends it without"
                << std::endl;
      continue;
    }
    end_by(signal);
  }
}

}  // namespace

void watch_signals() {
  std::array<int, 2> ends{};
  if (signal_pipe >= 0 || ::pipe2(ends.data(), O_CLOEXEC) != 0) return;  // signals end it as they would
  try {
    std::thread(serve, ends[0]).detach();
  } catch (const std::system_error&) {  // no memory for its stack: as above
    ::close(ends[0]);
    ::close(ends[1]);
    return;
  }
  signal_pipe = ends[1];
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction action {};
    if (::sigaction(signal, nullptr, &action) != 0 || action.sa_handler == SIG_IGN) continue;
    action = {};
    action.sa_handler = note_signal;
    action.sa_flags = SA_RESTART;
    static_cast<void>(::sigaction(signal, &action, nullptr));
  }
}

InterruptionPoint::InterruptionPoint() { ++points; }
InterruptionPoint::~InterruptionPoint() { --points; }
bool InterruptionPoint::is_asked_for() const { return is_noted; }

}  // namespace simuli::cli
