#include "host/apps/cli/base/crash.hpp"

#include <array>
#include <csignal>
#include <exception>
#include <fcntl.h>
#include <fmt/format.h>
#include <memory>
#include <new>
#include <stdlib.h>
#include <string>
#include <unistd.h>

#include "host/core/base/error.hpp"
#include "host/device/runtime/disk_cache.hpp"

namespace simuli::cli {
namespace {

// All that the handler needs: it may neither allocate nor look anything up. Never freed.
struct Words {
  std::string file, count, message;
};
const Words* words = nullptr;

void write_all(int file, const std::string& text) {
  static_cast<void>(!::write(file, text.data(), text.size()));
}

/// Returns into what crashed, which crashes again and is ended by the system: the handler is gone by then.
void note_crash(int /*signal*/) {
  if (words == nullptr) return;
  constexpr mode_t kAll = 0666;
  const int file =
      words->file.empty() ? -1 : ::open(words->file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, kAll);
  if (file >= 0) {
    write_all(file, words->count);
    ::close(file);
  }
  write_all(STDERR_FILENO, words->message);
}

void watch_for_crashes() {
  for (const int signal : {SIGSEGV, SIGBUS, SIGILL, SIGABRT}) {
    struct sigaction action {};
    action.sa_handler = note_crash;
    action.sa_flags = static_cast<int>(SA_ONSTACK | SA_RESETHAND);
    static_cast<void>(::sigaction(signal, &action, nullptr));
  }
}

std::terminate_handler end_otherwise = nullptr;

/// Memory that a thread of a library's did not get is no crash.
[[noreturn]] void end_without_memory() {
  try {
    if (const std::exception_ptr thrown = std::current_exception()) std::rethrow_exception(thrown);
  } catch (const std::bad_alloc&) {
    write_all(STDERR_FILENO, "simuli: out of memory\n");
    ::_exit(kMemoryExit);
  } catch (...) {  // below
  }
  end_otherwise();
  ::abort();
}

}  // namespace

void watch_crashes() {
#ifdef __SANITIZE_ADDRESS__
  return;  // it tells of crashes itself, and more
#endif
  if (words != nullptr) return;
  const auto count = crash_count();
  const std::string what = "simuli: crashed, in the OpenCL driver or by a defect; ";
  auto all = std::make_unique<Words>();
  if (count && ::getenv("POCL_CACHE_DIR") == nullptr) {
    all->file = count->file.string();
    all->count = fmt::format("{}\n", count->next);
    all->message = what + "the next start keeps away from PoCL's cache, which may be damaged\n";
  } else {
    all->message =
        what + fmt::format("if it comes again, delete PoCL's cache {}\n", driver_cache_folder().string());
  }
  words = all.release();
  static std::array<char, 65536> stack;  // of its own: what crashes may have none left
  stack_t alternate{};
  alternate.ss_sp = stack.data();
  alternate.ss_size = stack.size();
  static_cast<void>(::sigaltstack(&alternate, nullptr));
  keep_installed(watch_for_crashes);
  end_otherwise = std::set_terminate(end_without_memory);
}

}  // namespace simuli::cli
