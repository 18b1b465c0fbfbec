#pragma once
// Work that several concurrent callers share.
#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "host/apps/serve/session/fair_queue.hpp"

namespace simuli::serve {

/// Runs work once for all callers with the same key while it is in progress; caches nothing. Safe to use from
/// any thread.
class SharedWork {
 public:
  using Result = std::shared_ptr<const void>;
  /// `is_given_up` is true if no caller waits any more.
  using Work = std::function<Result(const IsGivenUp& is_given_up)>;

  /// Returns the result of `work`, or of another caller's work under the same key, or throws its exception.
  /// Throws Refusal{kCancelled} if `is_given_up` returns true, which cancels the work if no other caller waits
  /// for it.
  [[nodiscard]] Result get(const std::string& key, const Work& work, const IsGivenUp& is_given_up);
  /// Returns the number of calls so far that shared the work of another caller.
  [[nodiscard]] std::size_t shared() const;

 private:
  struct Task;
  [[nodiscard]] Result wait_for(const std::shared_ptr<Task>& task, const IsGivenUp& is_given_up);

  mutable std::mutex mutex_;
  std::map<std::string, std::shared_ptr<Task>> tasks_;  // in progress
  std::size_t shared_ = 0;
};

}  // namespace simuli::serve
