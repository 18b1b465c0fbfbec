#include "host/apps/serve/session/unread_replies.hpp"

#include <algorithm>
#include <utility>
#include <vector>

namespace simuli::serve {

using std::chrono::milliseconds;

UnreadReplies::UnreadReplies(const ReplyLimits& limits) : limits_(limits), watcher_([this] { watch(); }) {}

UnreadReplies::~UnreadReplies() {
  {
    const std::lock_guard lock(mutex_);
    is_ended_ = true;
  }
  changed_.notify_all();
  watcher_.join();
}

void UnreadReplies::begin(const void* call, std::size_t bytes, std::function<void()> give_up) {
  {
    const std::lock_guard lock(mutex_);
    replies_[call] = {Clock::now(), bytes, std::move(give_up)};
    bytes_ += bytes;
  }
  changed_.notify_all();
}

void UnreadReplies::end(const void* call) {
  {
    const std::lock_guard lock(mutex_);
    const auto found = replies_.find(call);
    if (found == replies_.end()) return;
    bytes_ -= found->second.bytes;
    replies_.erase(found);
  }
  changed_.notify_all();
}

void UnreadReplies::need_room(const IsGivenUp& is_given_up) {
  constexpr milliseconds kAskAgain{20};
  std::unique_lock lock(mutex_);
  while (bytes_ > limits_.most_bytes) {
    changed_.wait_for(lock, kAskAgain);
    throw_if_cancelled(is_given_up);
  }
}

std::size_t UnreadReplies::count() const {
  const std::lock_guard lock(mutex_);
  return replies_.size();
}

UnreadReplies::Clock::time_point UnreadReplies::give_up_due(Clock::time_point now) {
  std::vector<Reply*> open;
  std::size_t bytes = 0;
  for (auto& [call, reply] : replies_) {
    if (!reply.give_up) continue;
    open.push_back(&reply);
    bytes += reply.bytes;
  }
  std::sort(open.begin(), open.end(), [](const Reply* a, const Reply* b) { return a->since < b->since; });
  auto next = now + std::chrono::hours(1);
  for (std::size_t i = 0; i < open.size(); ++i) {
    Reply& reply = *open[i];
    const bool is_crowded = bytes > limits_.most_bytes || open.size() - i > limits_.most;
    const auto mib = static_cast<milliseconds::rep>(reply.bytes >> 20U);
    const auto due = reply.since + (is_crowded ? limits_.hurried + milliseconds(1000 * mib / 16)
                                               : limits_.patience + milliseconds(1000 * mib));
    if (due > now) {
      next = std::min(next, due);
      continue;
    }
    bytes -= reply.bytes;
    std::exchange(reply.give_up, nullptr)();  // under the lock, so that the call still exists
  }
  return next;
}

void UnreadReplies::watch() {
  std::unique_lock lock(mutex_);
  while (!is_ended_) changed_.wait_until(lock, give_up_due(Clock::now()));
}

}  // namespace simuli::serve
