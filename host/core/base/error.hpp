#pragma once
// The only error type of the library. Library code throws it and never prints or exits; the command line prints
// what() and exits with exit_code().
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

namespace simuli {

/// Kind of failure; the value is the exit code of the command line.
enum class ErrorKind : int {
  kUsage = 2,
  kInput = 3,
  kDevice = 4,
  kKernel = 5,
  kNumeric = 6,
  kNothing = 8,  // no recorded data remain (7: ranks of a training differ)
  kInternal = 70,
};

/// Exit code for std::bad_alloc, which is not converted: the host is out of memory.
inline constexpr int kMemoryExit = 71;

class Error : public std::runtime_error {
 public:
  /// Converts the message to one line, except a kKernel's, which contains a driver's log.
  Error(ErrorKind kind, const std::string& message);
  [[nodiscard]] ErrorKind kind() const noexcept { return kind_; }
  [[nodiscard]] int exit_code() const noexcept { return static_cast<int>(kind_); }

 private:
  ErrorKind kind_;
};

/// Throws Error{kInput} reading "FILE: FIELD: found FOUND, allowed ALLOWED" (one line).
[[noreturn]] void throw_input_error(std::string_view file,
                                    std::string_view field,
                                    std::string_view found,
                                    std::string_view allowed);

/// Throws the same as Error{kNothing}.
[[noreturn]] void throw_nothing_left(std::string_view file,
                                     std::string_view field,
                                     std::string_view found,
                                     std::string_view allowed);

/// Runs f; adds "while CONTEXT: " in front of an Error that f throws, and keeps its kind.
template <class F>
decltype(auto) with_context(std::string_view context, F&& f) {
  try {
    return std::forward<F>(f)();
  } catch (const Error& error) {
    throw Error(error.kind(), "while " + std::string(context) + ": " + error.what());
  }
}

}  // namespace simuli
