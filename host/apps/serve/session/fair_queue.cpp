#include "host/apps/serve/session/fair_queue.hpp"

#include <chrono>
#include <set>

#include "host/apps/serve/session/refusal.hpp"

namespace simuli::serve {

namespace {

[[noreturn]] void give_up() { throw Refusal(RefusalKind::kCancelled, "cancelled, or past its deadline"); }

}  // namespace

bool never_given_up() { return false; }

void throw_if_cancelled(const IsGivenUp& is_given_up) {
  if (is_given_up()) give_up();
}

struct FairQueue::Ticket::Queue {
  std::mutex mutex;
  std::condition_variable changed;
  std::set<std::size_t> free;
  std::list<int> waiting;  // in order of arrival; the numbers have no meaning

  explicit Queue(std::size_t places) {
    for (std::size_t place = 0; place < places; ++place) free.insert(place);
  }
};

FairQueue::FairQueue(std::size_t places) : queue_(std::make_shared<Ticket::Queue>(places)) {}

FairQueue::Ticket::~Ticket() {
  if (!queue_) return;
  {
    const std::lock_guard lock(queue_->mutex);
    queue_->free.insert(place_);
  }
  queue_->changed.notify_all();
}

std::size_t FairQueue::waiting() const {
  const std::lock_guard lock(queue_->mutex);
  return queue_->waiting.size();
}

std::size_t FairQueue::free() const {
  const std::lock_guard lock(queue_->mutex);
  return queue_->free.size();
}

FairQueue::Ticket FairQueue::take(const IsGivenUp& is_given_up) const {
  constexpr std::chrono::milliseconds kAskAgain{20};
  Ticket::Queue& queue = *queue_;
  std::unique_lock lock(queue.mutex);
  const auto place = queue.waiting.insert(queue.waiting.end(), 0);
  while (queue.free.empty() || queue.waiting.begin() != place) {
    queue.changed.wait_for(lock, kAskAgain);
    if (!is_given_up()) continue;
    queue.waiting.erase(place);
    lock.unlock();
    queue.changed.notify_all();
    give_up();
  }
  queue.waiting.erase(place);
  const std::size_t taken = *queue.free.begin();
  queue.free.erase(queue.free.begin());
  const bool has_more = !queue.free.empty() && !queue.waiting.empty();
  lock.unlock();
  if (has_more) queue.changed.notify_all();
  return {queue_, taken};
}

}  // namespace simuli::serve
