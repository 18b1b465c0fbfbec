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

// All data of the handler, which may neither allocate nor call other code. Never freed.
struct Words {
  std::string file, count, message;
};
const Words* words = nullptr;

void write_all(int file, const std::string& text) {
  static_cast<void>(!::write(file, text.data(), text.size()));
}

/// Returns to the crashed instruction, which crashes again; the system ends the process, because the handler
/// is removed.
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

/// Ends the process without a crash when a library's thread is out of memory.
[[noreturn]] void end_without_memory() {
  try {
    if (const std::exception_ptr thrown = std::current_exception()) std::rethrow_exception(thrown);
  } catch (const std::bad_alloc&) {
    write_all(STDERR_FILENO, "simuli: out of memory\n");
    ::_exit(kMemoryExit);
  } catch (...) {  // handled below
  }
  end_otherwise();
  ::abort();
}

}  // namespace

void watch_crashes() {
#ifdef __SANITIZE_ADDRESS__
  return;  // the sanitizer reports crashes
#endif
  if (words != nullptr) return;
  const auto count = crash_count();
  const std::string what = "simuli: crashed, in the OpenCL driver or by a defect; ";
  auto all = std::make_unique<Words>();
  if (count && ::getenv("POCL_CACHE_DIR") == nullptr) {
    all->file = count->file.string();
    all->count = fmt::format("{}\n", count->next);
    all->message = what + "the next start does not use PoCL's cache, which may be damaged\n";
  } else {
    all->message =
        what + fmt::format("if it happens again, delete PoCL's cache {}\n", driver_cache_folder().string());
  }
  words = all.release();
  static std::array<char, 65536> stack;  // stack of the handler: the crash may be a stack overflow
  stack_t alternate{};
  alternate.ss_sp = stack.data();
  alternate.ss_size = stack.size();
  static_cast<void>(::sigaltstack(&alternate, nullptr));
  keep_installed(watch_for_crashes);
  end_otherwise = std::set_terminate(end_without_memory);
}

}  // namespace simuli::cli
