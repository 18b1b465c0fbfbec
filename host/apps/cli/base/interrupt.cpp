#include "host/apps/cli/base/interrupt.hpp"

#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <fcntl.h>
#include <iostream>
#include <system_error>
#include <thread>
#include <unistd.h>

#include "host/device/runtime/disk_cache.hpp"
#include "io/base/temporary.hpp"

namespace simuli::cli {
namespace {

std::atomic<int> points{0};  // InterruptionPoint objects
std::atomic<const char*> point_note{""};
std::atomic<bool> is_noted{false};
std::atomic<bool> is_unread{false};
int signal_pipe = -1;  // the handler's end

/// Only writes to a pipe, as a handler must; a thread removes the files.
void note_signal(int signal) {
  const int error = errno;
  if (signal == SIGPIPE) is_unread = true;
  const auto byte = static_cast<unsigned char>(signal);
  static_cast<void>(!::write(signal_pipe, &byte, 1));
  errno = error;
}

// SIGPIPE means that the reader of the output has closed, like a closed terminal.
constexpr std::array<int, 4> kSignals{SIGINT, SIGTERM, SIGHUP, SIGPIPE};
std::array<bool, kSignals.size()>
    ignored{};  // at the start, as under nohup, or by code that writes to sockets

std::atomic<bool> is_ending{false};

void watch_for_signals() {
  if (is_ending) return;
  for (std::size_t i = 0; i < kSignals.size(); ++i) {
    struct sigaction action {};
    ignored[i] =
        ignored[i] || ::sigaction(kSignals[i], nullptr, &action) != 0 || action.sa_handler == SIG_IGN;
    if (ignored[i]) continue;
    action = {};
    action.sa_handler = note_signal;
    action.sa_flags = SA_RESTART;
    static_cast<void>(::sigaction(kSignals[i], &action, nullptr));
  }
}

void end_by(int signal) {
  remove_temporaries();
  is_ending = true;
  for (;;) {  // another thread may have restored the handler
    std::signal(signal, SIG_DFL);
    ::kill(::getpid(), signal);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

void serve(int pipe) {
  unsigned char signal = 0;
  for (;;) {
    const ssize_t got = ::read(pipe, &signal, 1);
    if (got < 0 && errno == EINTR) continue;
    if (got != 1) return;
    if (points > 0) {
      const bool is_first = !is_noted.exchange(true);
      if (is_first) {
        std::cerr << "simuli: interrupted: " << point_note << std::endl;
        kill_groups();
      }
      if (is_first || signal == SIGPIPE) continue;  // each further unread line sends one SIGPIPE
    }
    end_by(signal);
  }
}

/// Opens /dev/null for each of the descriptors 0 to 2 that the parent process has closed. Otherwise the next
/// opened file would receive the output.
void fill_standard_streams() {
  int opened = 0;
  do opened = ::open("/dev/null", O_RDWR);
  while (opened >= 0 && opened <= STDERR_FILENO);
  if (opened >= 0) ::close(opened);
}

}  // namespace

void watch_signals() {
  fill_standard_streams();
  std::signal(SIGXFSZ, SIG_IGN);  // a write above the shell's file size limit fails, as on a full disk
  // A parent may pass on an ignored SIGCHLD; then waitpid() and pclose() lose the exit codes of ffmpeg and
  // fixers.
  std::signal(SIGCHLD, SIG_DFL);
  std::array<int, 2> ends{};
  if (signal_pipe >= 0 || ::pipe2(ends.data(), O_CLOEXEC) != 0) return;  // signals keep their default action
  try {
    std::thread(serve, ends[0]).detach();
  } catch (const std::system_error&) {  // no memory for the thread's stack: as above
    ::close(ends[0]);
    ::close(ends[1]);
    return;
  }
  signal_pipe = ends[1];
  keep_installed(watch_for_signals);
}

void end_if_unread() {
  if (is_unread) end_by(SIGPIPE);
}

InterruptionPoint::InterruptionPoint(const char* note) {
  point_note = note;
  ++points;
}
InterruptionPoint::~InterruptionPoint() { --points; }
bool InterruptionPoint::is_requested_for() const { return is_noted; }

}  // namespace simuli::cli
