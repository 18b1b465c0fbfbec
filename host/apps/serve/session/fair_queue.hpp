#pragma once
// A queue for something that only so many callers use at a time.
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <list>
#include <memory>
#include <mutex>

namespace simuli::serve {

/// Whether nobody waits for the answer any more.
using IsGivenUp = std::function<bool()>;
/// Of work that is always finished.
[[nodiscard]] bool never_given_up();

/// Refusal{kCancelled} once it says so.
void throw_if_cancelled(const IsGivenUp& is_given_up);

/// Up to `places` callers at a time, in the order in which they came. A handle: copies mean the same queue.
class FairQueue {
 public:
  explicit FairQueue(std::size_t places);

  /// A place, until it is destroyed. Move-only.
  class Ticket {
   public:
    Ticket(Ticket&&) noexcept = default;
    Ticket& operator=(Ticket&&) = delete;
    Ticket(const Ticket&) = delete;
    Ticket& operator=(const Ticket&) = delete;
    ~Ticket();
    /// Which of the places, from 0: the first that was free.
    [[nodiscard]] std::size_t place() const { return place_; }

   private:
    friend class FairQueue;
    struct Queue;
    Ticket(std::shared_ptr<Queue> queue, std::size_t place) : queue_(std::move(queue)), place_(place) {}
    std::shared_ptr<Queue> queue_;
    std::size_t place_;
  };

  /// Waits for a place. Refusal{kCancelled} once `is_given_up` says so, which is asked some 50 times a
  /// second.
  [[nodiscard]] Ticket take(const IsGivenUp& is_given_up = never_given_up) const;
  /// Callers without a place.
  [[nodiscard]] std::size_t waiting() const;
  /// Places that nobody has.
  [[nodiscard]] std::size_t free() const;

 private:
  std::shared_ptr<Ticket::Queue> queue_;
};

}  // namespace simuli::serve
