#pragma once
// The one error type of the library. Library code throws it and never prints or exits; the command
// line prints what() and exits with exit_code().
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

namespace simuli {

/// What went wrong; the value is the exit code of the command line.
enum class ErrorKind : int {
  kUsage = 2,
  kInput = 3,
  kDevice = 4,
  kKernel = 5,
  kNumeric = 6,
  kNothing = 8,  // of what was recorded nothing is left (7: ranks of a training differ)
  kInternal = 70,
};

/// The same of std::bad_alloc, which is left as it is: the host's memory ran out.
inline constexpr int kMemoryExit = 71;

class Error : public std::runtime_error {
 public:
  /// The message becomes one line, whatever it quotes; a kKernel's is a driver's log and stays.
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

/// The same as Error{kNothing}.
[[noreturn]] void throw_nothing_left(std::string_view file,
                                     std::string_view field,
                                     std::string_view found,
                                     std::string_view allowed);

/// Runs f; an Error that leaves it is rethrown with "while CONTEXT: " in front, its kind kept.
template <class F>
decltype(auto) with_context(std::string_view context, F&& f) {
  try {
    return std::forward<F>(f)();
  } catch (const Error& error) {
    throw Error(error.kind(), "while " + std::string(context) + ": " + error.what());
  }
}

}  // namespace simuli
