#pragma once
#include <chrono>
#include <utility>

namespace simuli {

/// Time by the system's steady clock since the object was made.
class Stopwatch {
 public:
  [[nodiscard]] double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }
  [[nodiscard]] double ms() const { return 1e3 * seconds(); }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Milliseconds that f takes.
template <class F>
[[nodiscard]] double time_ms(F&& f) {
  const Stopwatch watch;
  std::forward<F>(f)();
  return watch.ms();
}

}  // namespace simuli
