#pragma once
// A queue for a resource with a limited number of concurrent users.
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <list>
#include <memory>
#include <mutex>

namespace simuli::serve {

/// Whether no caller waits for the result any more.
using IsGivenUp = std::function<bool()>;
/// Returns a predicate for work that is never cancelled.
[[nodiscard]] bool never_given_up();

/// Throws Refusal{kCancelled} if the predicate is true.
void throw_if_cancelled(const IsGivenUp& is_given_up);

/// Admits up to `places` callers at a time, in order of arrival. A handle: copies refer to the same queue.
class FairQueue {
 public:
  explicit FairQueue(std::size_t places);

  /// A place, held until destruction. Move-only.
  class Ticket {
   public:
    Ticket(Ticket&&) noexcept = default;
    Ticket& operator=(Ticket&&) = delete;
    Ticket(const Ticket&) = delete;
    Ticket& operator=(const Ticket&) = delete;
    ~Ticket();
    /// Returns the index of the place: the first free one.
    [[nodiscard]] std::size_t place() const { return place_; }

   private:
    friend class FairQueue;
    struct Queue;
    Ticket(std::shared_ptr<Queue> queue, std::size_t place) : queue_(std::move(queue)), place_(place) {}
    std::shared_ptr<Queue> queue_;
    std::size_t place_;
  };

  /// Waits for a place. Throws Refusal{kCancelled} if `is_given_up`, which is called about 50 times per second,
  /// returns true.
  [[nodiscard]] Ticket take(const IsGivenUp& is_given_up = never_given_up) const;
  /// Returns the number of waiting callers.
  [[nodiscard]] std::size_t waiting() const;
  /// Returns the number of free places.
  [[nodiscard]] std::size_t free() const;

 private:
  std::shared_ptr<Ticket::Queue> queue_;
};

}  // namespace simuli::serve
