#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "optim/train/ranks/ranks.hpp"

namespace simuli {
namespace {

/// Ends a rank because another rank has failed.
struct OtherHasEnded : Error {
  OtherHasEnded() : Error(ErrorKind::kInternal, "ranks: another one has ended") {}
};

/// Exchanges the messages of the ranks, one round at a time.
class Meeting {
 public:
  explicit Meeting(std::size_t count) : given_(count), all_(count) {}
  [[nodiscard]] std::size_t size() const { return given_.size(); }

  std::span<const Ranks::Message> gather(std::size_t rank, Ranks::Message own) {
    std::unique_lock lock(mutex_);
    need_all();
    given_[rank].assign(own.begin(), own.end());
    const std::uint64_t round = rounds_;
    if (++come_ == size()) {
      come_ = 0;
      std::swap(all_, given_);
      messages_.assign(all_.begin(), all_.end());
      ++rounds_;
      changed_.notify_all();
    } else {
      changed_.wait(lock, [&] { return rounds_ != round || failure_ != nullptr; });
      // A finished rank is not reported as failed: its failure, if any, belongs to a later round.
      if (rounds_ == round) need_all();
    }
    return messages_;  // valid until all ranks have called again
  }
  void fail(std::exception_ptr failure) {
    const std::lock_guard lock(mutex_);
    if (failure_ == nullptr) failure_ = std::move(failure);
    changed_.notify_all();
  }
  void rethrow() const {
    if (failure_ != nullptr) std::rethrow_exception(failure_);
  }

 private:
  void need_all() const {
    if (failure_ != nullptr) throw OtherHasEnded();
  }
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Ranks::Bytes> given_, all_;
  std::vector<Ranks::Message> messages_;  // messages joined in all_
  std::size_t come_ = 0;
  std::uint64_t rounds_ = 0;
  std::exception_ptr failure_;
};

class RankThread final : public Ranks {
 public:
  RankThread(Meeting& meeting, std::size_t rank) : meeting_(meeting), rank_(rank) {}
  [[nodiscard]] std::size_t rank() const override { return rank_; }
  [[nodiscard]] std::size_t size() const override { return meeting_.size(); }
  [[nodiscard]] std::span<const Message> all_gather(Message own) override {
    return meeting_.gather(rank_, own);
  }

 private:
  Meeting& meeting_;
  std::size_t rank_;
};

}  // namespace

void run_rank_threads(std::size_t count, const std::function<void(Ranks&)>& work) {
  Meeting meeting(count);
  const auto run = [&](std::size_t rank) {
    try {
      RankThread own(meeting, rank);
      work(own);
    } catch (...) {
      meeting.fail(std::current_exception());
    }
  };
  {
    std::vector<std::jthread> threads;
    try {
      for (std::size_t rank = 1; rank < count; ++rank) threads.emplace_back(run, rank);
    } catch (...) {
      meeting.fail(std::current_exception());  // the started ranks wait for the others
    }
    run(0);
  }
  meeting.rethrow();
}

}  // namespace simuli
