#include "host/serve/session/render_session.hpp"

#include <algorithm>
#include <chrono>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <optional>
#include <utility>

#include "host/base/close_names.hpp"
#include "host/base/error.hpp"
#include "host/render/options/validate.hpp"
#include "host/serve/session/refusal.hpp"

namespace simuli::serve {

RenderSession::RenderSession(SessionOptions options)
    : options_(std::move(options)), device_(Device::best(options_.device)) {
  validate(options_.render);
}

RenderSession::~RenderSession() = default;

/// What is on the device goes in a turn of its own, whoever holds the scene last.
RenderSession::ScenePtr RenderSession::read(const SceneSource& source) const {
  auto scene = std::make_unique<ServedScene>(source);
  return {scene.release(), [turns = turns_, device = device_](ServedScene* last) {
            const Turns::Turn turn = turns.take();
            delete last;
          }};
}

void RenderSession::forget(const std::string& id) {
  const std::lock_guard lock(mutex_);
  kept_.remove_if([&](const Kept& k) { return k.id == id; });
}

std::shared_future<RenderSession::ScenePtr> RenderSession::keep(const SceneSource& source) {
  std::promise<ScenePtr> promise;
  std::shared_future<ScenePtr> scene;
  std::list<Kept> dropped;  // goes when nothing is locked any more
  bool is_ours = false;
  {
    const std::lock_guard lock(mutex_);
    const auto kept =
        std::find_if(kept_.begin(), kept_.end(), [&](const Kept& k) { return k.id == source.id; });
    if (kept != kept_.end()) {
      kept_.splice(kept_.begin(), kept_, kept);
    } else {
      is_ours = true;
      kept_.push_front({source.id, promise.get_future().share()});
      while (kept_.size() > std::max<std::size_t>(options_.cache_size, 1)) {
        dropped.splice(dropped.end(), kept_, std::prev(kept_.end()));
      }
    }
    scene = kept_.front().scene;
  }
  dropped.clear();  // before another one takes memory
  if (is_ours) {
    try {
      promise.set_value(read(source));
    } catch (...) {
      forget(source.id);
      promise.set_exception(std::current_exception());
    }
  }
  return scene;
}

void RenderSession::read_now(const std::string& id) {
  for (const SceneSource& source : options_.scenes) {
    if (source.id == id) static_cast<void>(keep(source).get());
  }
}

RenderSession::ScenePtr RenderSession::open(const std::string& id, const IsGivenUp& is_given_up) {
  const auto source = std::find_if(
      options_.scenes.begin(), options_.scenes.end(), [&](const SceneSource& s) { return s.id == id; });
  if (source == options_.scenes.end()) {
    std::vector<std::string> known;
    for (const SceneSource& s : options_.scenes) known.push_back(s.id);
    constexpr std::size_t kMostTold = 10;
    const std::string allowed = known.size() <= kMostTold ? fmt::format("{}", fmt::join(known, ", "))
                                                          : fmt::format("one of {}", known.size());
    throw Refusal(RefusalKind::kNotFound,
                  fmt::format("scene_id: found \"{}\", {}allowed {}", id, did_you_mean(id, known), allowed));
  }
  const std::shared_future<ScenePtr> scene = keep(*source);
  constexpr std::chrono::milliseconds kAskAgain{20};
  while (scene.wait_for(kAskAgain) != std::future_status::ready) need_wanted(is_given_up);
  try {
    return scene.get();
  } catch (const Error& error) {
    throw Refusal(RefusalKind::kPrecondition, error.what());
  }
}

std::vector<std::string> RenderSession::kept() const {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> ids;
  for (const Kept& k : kept_) ids.push_back(k.id);
  return ids;
}

void RenderSession::render(ServedScene& scene, std::span<FrameJob> jobs, const IsGivenUp& is_given_up) {
  const Turns::Turn turn = turns_.take(is_given_up);
  if (!scene.on_device_) scene.on_device_.emplace(device_, scene.scene_, options_.render);
  struct Coming {
    Frame frame;
    FrameJob& job;
  };
  std::optional<Coming> coming;
  const auto take = [&] {
    if (!coming) return;
    const Coming now = std::move(*coming);
    coming.reset();
    try {
      now.job.take(now.frame);
    } catch (...) {
      now.job.error = std::current_exception();
    }
  };
  for (FrameJob& job : jobs) {
    need_wanted(is_given_up);
    try {
      Frame frame = scene.on_device_->render(job.sensor, job.shot);
      frame.fetch();
      take();
      coming.emplace(Coming{std::move(frame), job});
    } catch (...) {
      job.error = std::current_exception();
    }
  }
  take();
}

}  // namespace simuli::serve
