#pragma once
// Replies that clients have not read yet, with limits of their memory and time.
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <map>
#include <mutex>
#include <thread>

#include "host/apps/serve/session/fair_queue.hpp"

namespace simuli::serve {

/// Limits of unread replies. Each reply holds its bytes and a thread; a client may be slow while there is room.
struct ReplyLimits {
  std::chrono::milliseconds patience{30000};  // per reply, plus one second per MiB
  std::chrono::milliseconds hurried{2000};    // with more than `most` replies, plus one second per 16 MiB
  std::size_t most_bytes = std::size_t{256} << 20U;
  std::size_t most = 64;  // half of the request threads
};

/// Cancels replies that are not read, the oldest first. Safe to use from any thread.
class UnreadReplies {
 public:
  explicit UnreadReplies(const ReplyLimits& limits = {});
  UnreadReplies(const UnreadReplies&) = delete;
  UnreadReplies& operator=(const UnreadReplies&) = delete;
  ~UnreadReplies();

  /// Registers a reply that waits for its client. `give_up` is called at most once, before end() returns.
  void begin(const void* call, std::size_t bytes, std::function<void()> give_up);
  /// Unregisters a reply that was read or cancelled. Ignores unregistered calls.
  void end(const void* call);
  /// Waits until there is room for another reply: memory is bounded by `most_bytes` and the replies in
  /// progress. Throws Refusal{kCancelled} if `is_given_up` returns true.
  void need_room(const IsGivenUp& is_given_up);
  [[nodiscard]] std::size_t count() const;

 private:
  using Clock = std::chrono::steady_clock;
  struct Reply {
    Clock::time_point since;
    std::size_t bytes = 0;
    std::function<void()> give_up;  // empty after the call
  };
  /// The caller holds the lock. Returns the time of the next check.
  [[nodiscard]] Clock::time_point give_up_due(Clock::time_point now);
  void watch();

  ReplyLimits limits_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::map<const void*, Reply> replies_;
  std::size_t bytes_ = 0;
  bool is_ended_ = false;
  std::thread watcher_;  // last, because it uses all other members
};

}  // namespace simuli::serve
