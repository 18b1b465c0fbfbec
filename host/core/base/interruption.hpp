#pragma once
#include <functional>

namespace simuli {

/// Long calls of this thread ask `check` between pieces of their work, while this lives: what it throws ends them.
/// They ask often (thousands of times a second); what they were making is then good for nothing.
class Interruption {
 public:
  explicit Interruption(const std::function<void()>& check);
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;
  ~Interruption();

  /// For the long calls.
  static void ask();
  /// Whether anything is asked in this thread.
  [[nodiscard]] static bool is_on();

 private:
  const std::function<void()>* before_;
};

}  // namespace simuli
