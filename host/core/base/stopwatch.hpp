#pragma once
#include <chrono>
#include <utility>

namespace simuli {

/// Measures time with the steady clock since construction.
class Stopwatch {
 public:
  [[nodiscard]] double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }
  [[nodiscard]] double ms() const { return 1e3 * seconds(); }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Returns the milliseconds that f takes.
template <class F>
[[nodiscard]] double time_ms(F&& f) {
  const Stopwatch watch;
  std::forward<F>(f)();
  return watch.ms();
}

}  // namespace simuli
