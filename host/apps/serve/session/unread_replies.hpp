#pragma once
// Replies that clients have not taken yet: what each of them holds of the server, and for how long.
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <map>
#include <mutex>
#include <thread>

#include "host/apps/serve/session/fair_queue.hpp"

namespace simuli::serve {

/// A client may take its time as long as there is room: each reply keeps its bytes and a thread.
struct ReplyLimits {
  std::chrono::milliseconds patience{30000};  // with one reply, and a second for each MiB of it
  std::chrono::milliseconds hurried{2000};    // beyond `most`, and a second for each 16 MiB of it
  std::size_t most_bytes = std::size_t{256} << 20U;
  std::size_t most = 64;  // of the threads that requests have, half
};

/// Gives up replies that are not taken, those that have waited longest first. Safe to use from any thread.
class UnreadReplies {
 public:
  explicit UnreadReplies(const ReplyLimits& limits = {});
  UnreadReplies(const UnreadReplies&) = delete;
  UnreadReplies& operator=(const UnreadReplies&) = delete;
  ~UnreadReplies();

  /// From now on `call` waits for its client. `give_up` is called at most once, before end() returns.
  void begin(const void* call, std::size_t bytes, std::function<void()> give_up);
  /// The reply is taken, or given up. Calls that never began are ignored.
  void end(const void* call);
  /// Waits until replies leave room for another one: what is kept is bounded by `most_bytes` and the replies
  /// that are at work. Refusal{kCancelled} once `is_given_up` says so.
  void need_room(const IsGivenUp& is_given_up);
  [[nodiscard]] std::size_t count() const;

 private:
  using Clock = std::chrono::steady_clock;
  struct Reply {
    Clock::time_point since;
    std::size_t bytes = 0;
    std::function<void()> give_up;  // empty: it has been
  };
  /// The lock is the caller's. When to look again.
  [[nodiscard]] Clock::time_point give_up_due(Clock::time_point now);
  void watch();

  ReplyLimits limits_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::map<const void*, Reply> replies_;
  std::size_t bytes_ = 0;
  bool is_ended_ = false;
  std::thread watcher_;  // last: it uses all of them
};

}  // namespace simuli::serve
