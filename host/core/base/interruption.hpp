#pragma once
#include <functional>

namespace simuli {

/// During its lifetime, long calls of this thread regularly call `check` (thousands of times a second); an
/// exception thrown by it ends them, and their results are discarded.
class Interruption {
 public:
  explicit Interruption(const std::function<void()>& check);
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;
  ~Interruption();

  /// Called by long-running functions.
  static void ask();
  /// Whether this thread has an active check.
  [[nodiscard]] static bool is_on();

 private:
  const std::function<void()>* before_;
};

}  // namespace simuli
