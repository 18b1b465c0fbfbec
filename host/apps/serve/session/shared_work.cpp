#include "host/apps/serve/session/shared_work.hpp"

#include <chrono>
#include <future>
#include <utility>

namespace simuli::serve {

struct SharedWork::Task {
  std::promise<Result> promise;
  std::shared_future<Result> result{promise.get_future()};
  std::size_t wanting = 1;  // callers that wait for the result; under mutex_; never increases from 0
};

SharedWork::Result SharedWork::get(const std::string& key, const Work& work, const IsGivenUp& is_given_up) {
  std::shared_ptr<Task> task;
  bool is_own = false;
  {
    const std::lock_guard lock(mutex_);
    std::shared_ptr<Task>& known = tasks_[key];
    is_own = known == nullptr || known->wanting == 0;  // a task without waiting callers ends on its own
    if (is_own) {
      known = std::make_shared<Task>();
    } else {
      ++known->wanting;
      ++shared_;
    }
    task = known;
  }
  if (!is_own) return wait_for(task, is_given_up);
  bool has_given_up = false;
  const auto nobody_waits = [&] {
    const bool gives_up = is_given_up();
    const std::lock_guard lock(mutex_);
    if (gives_up && !has_given_up) --task->wanting;
    has_given_up = has_given_up || gives_up;
    return task->wanting == 0;
  };
  const auto end = [&] {
    const std::lock_guard lock(mutex_);
    const auto own = tasks_.find(key);
    if (own != tasks_.end() && own->second == task) tasks_.erase(own);
  };
  try {
    Result result = work(nobody_waits);
    end();
    task->promise.set_value(result);
    return result;
  } catch (...) {
    end();
    task->promise.set_exception(std::current_exception());
    throw;
  }
}

SharedWork::Result SharedWork::wait_for(const std::shared_ptr<Task>& task, const IsGivenUp& is_given_up) {
  constexpr std::chrono::milliseconds kAskAgain{20};
  while (task->result.wait_for(kAskAgain) != std::future_status::ready) {
    if (!is_given_up()) continue;
    {
      const std::lock_guard lock(mutex_);
      --task->wanting;
    }
    throw_if_cancelled(is_given_up);
  }
  return task->result.get();
}

std::size_t SharedWork::shared() const {
  const std::lock_guard lock(mutex_);
  return shared_;
}

}  // namespace simuli::serve
