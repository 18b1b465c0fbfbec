#pragma once
// Work that several callers ask for at once.
#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "host/apps/serve/session/fair_queue.hpp"

namespace simuli::serve {

/// Done once for all who ask while it is under way; nothing is kept behind it. Safe to use from any thread.
class SharedWork {
 public:
  using Result = std::shared_ptr<const void>;
  /// What it is given says that none of those who asked waits any more.
  using Work = std::function<Result(const IsGivenUp& is_given_up)>;

  /// The result of `work`, or of another caller's under the same key, and what that throws.
  /// Refusal{kCancelled} once `is_given_up` says so, which ends the work when nobody else waits for it.
  [[nodiscard]] Result get(const std::string& key, const Work& work, const IsGivenUp& is_given_up);
  /// Callers so far who found another one's work under way.
  [[nodiscard]] std::size_t shared() const;

 private:
  struct Task;
  [[nodiscard]] Result wait_for(const std::shared_ptr<Task>& task, const IsGivenUp& is_given_up);

  mutable std::mutex mutex_;
  std::map<std::string, std::shared_ptr<Task>> tasks_;  // under way
  std::size_t shared_ = 0;
};

}  // namespace simuli::serve
