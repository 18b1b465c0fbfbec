#pragma once
// Describes slow work in progress to waiting users.
#include <list>
#include <mutex>
#include <string>

namespace simuli {

/// Work in progress in any thread, during this object's lifetime.
class Activity {
 public:
  explicit Activity(const std::string& text) {
    const std::lock_guard lock(running().mutex);
    self_ = &running().texts.emplace_back(text);
  }
  Activity(const Activity&) = delete;
  Activity& operator=(const Activity&) = delete;
  ~Activity() {
    const std::lock_guard lock(running().mutex);
    running().texts.remove_if([this](const std::string& text) { return &text == self_; });
  }

  /// Returns the latest activity in progress ("compiling kernels/render.cl"); empty without any.
  [[nodiscard]] static std::string now() {
    const std::lock_guard lock(running().mutex);
    return running().texts.empty() ? std::string() : running().texts.back();
  }

 private:
  struct Running {
    std::mutex mutex;
    std::list<std::string> texts;
  };
  static Running& running() {
    static Running all;
    return all;
  }

  const std::string* self_;
};

}  // namespace simuli
