#include "host/apps/serve/session/render_session.hpp"

#include <algorithm>
#include <chrono>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <optional>
#include <utility>

#include "host/apps/serve/session/refusal.hpp"
#include "host/core/base/close_names.hpp"
#include "host/core/base/error.hpp"
#include "host/core/base/one_line.hpp"
#include "host/core/base/stopwatch.hpp"
#include "host/device/render/options/validate.hpp"

namespace simuli::serve {

RenderSession::RenderSession(SessionOptions options)
    : options_(std::move(options)),
      slots_(std::make_shared<std::vector<std::unique_ptr<Slot>>>()),
      queue_(options_.devices.size()) {
  validate(options_.render);
  if (options_.devices.empty()) throw Error(ErrorKind::kUsage, "devices: found none, allowed at least one");
  for (const std::string& request : options_.devices) slots_->push_back(std::make_unique<Slot>(request));
}

RenderSession::~RenderSession() = default;

std::string RenderSession::devices() const {
  std::vector<std::string> labels;
  for (const auto& slot : *slots_) labels.push_back(slot->device.info().label());
  return fmt::format("{}", fmt::join(labels, ", "));
}

/// Scenes are destroyed while no other thread uses their devices, whichever owner is the last.
RenderSession::ScenePtr RenderSession::owned(std::unique_ptr<ServedScene> scene) const {
  scene->on_devices_.resize(slots_->size());
  return {scene.release(), [slots = slots_](ServedScene* last) {
            for (std::size_t i = 0; i < slots->size(); ++i) {
              const std::lock_guard lock((*slots)[i]->mutex);
              last->on_devices_[i].reset();
            }
            delete last;
          }};
}

RenderSession::ScenePtr RenderSession::read(const SceneSource& source) const {
  auto scene = std::make_unique<ServedScene>(source);
  for (const std::string& note : scene->notes())
    if (options_.note) options_.note(on_one_line(fmt::format("{}: {}", source.id, note)));
  std::vector<SceneEdit> edits;
  {
    const std::lock_guard lock(mutex_);
    if (const auto found = edits_.find(source.id); found != edits_.end()) edits = found->second;
  }
  for (const SceneEdit& edit : edits) scene = scene->edited(edit);
  return owned(std::move(scene));
}

std::list<RenderSession::CachedScene> RenderSession::keep_front(CachedScene scene) {
  std::list<CachedScene> dropped;
  kept_.push_front(std::move(scene));
  while (kept_.size() > std::max<std::size_t>(options_.cache_size, 1)) {
    dropped.splice(dropped.end(), kept_, std::prev(kept_.end()));
    metrics_.count_eviction();
  }
  return dropped;
}

void RenderSession::forget(const std::string& id) {
  const std::lock_guard lock(mutex_);
  kept_.remove_if([&](const CachedScene& k) { return k.id == id; });
}

std::shared_future<RenderSession::ScenePtr> RenderSession::keep(const SceneSource& source) {
  std::promise<ScenePtr> promise;
  std::shared_future<ScenePtr> scene;
  std::list<CachedScene> dropped;  // destroyed after all locks are released
  bool is_ours = false;
  {
    const std::lock_guard lock(mutex_);
    const auto kept =
        std::find_if(kept_.begin(), kept_.end(), [&](const CachedScene& k) { return k.id == source.id; });
    if (kept != kept_.end()) {
      kept_.splice(kept_.begin(), kept_, kept);
      metrics_.count_hit();
    } else {
      is_ours = true;
      dropped = keep_front({source.id, promise.get_future().share()});
    }
    scene = kept_.front().scene;
  }
  dropped.clear();  // frees memory before the next scene is read
  if (is_ours) {
    try {
      const Stopwatch watch;
      promise.set_value(read(source));
      metrics_.add_time(RequestStage::kSceneRead, watch.seconds());
      metrics_.count_load();
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
    constexpr std::size_t kMaxReported = 10;
    const std::string allowed = known.size() <= kMaxReported ? fmt::format("{}", fmt::join(known, ", "))
                                                             : fmt::format("one of {}", known.size());
    throw Refusal(RefusalKind::kNotFound,
                  fmt::format("scene_id: found \"{}\", {}allowed {}", id, did_you_mean(id, known), allowed));
  }
  const std::shared_future<ScenePtr> scene = keep(*source);
  constexpr std::chrono::milliseconds kAskAgain{20};
  while (scene.wait_for(kAskAgain) != std::future_status::ready) throw_if_cancelled(is_given_up);
  try {
    return scene.get();
  } catch (const Error& error) {
    throw Refusal(RefusalKind::kPrecondition, error.what());
  }
}

void RenderSession::edit(const std::string& id, const SceneEdit& edit, const IsGivenUp& is_given_up) {
  const std::lock_guard editing(edit_mutex_);
  if (edit_bytes_ + edit.bytes > kMostEditBytes) {
    throw Refusal(RefusalKind::kExhausted,
                  fmt::format("edit_assets: found edits of {:.1f} MiB in all, allowed {} MiB until "
                              "restore_model_parameters takes some back",
                              static_cast<double>(edit_bytes_ + edit.bytes) / (1 << 20),
                              kMostEditBytes >> 20U));
  }
  replace(id, owned(open(id, is_given_up)->edited(edit)), edit);
}

void RenderSession::restore(const std::string& id, const IsGivenUp& is_given_up) {
  const std::lock_guard editing(edit_mutex_);
  const ScenePtr scene = open(id, is_given_up);
  if (scene->is_edited()) replace(id, owned(scene->restored()), std::nullopt);
}

void RenderSession::replace(const std::string& id, ScenePtr scene, const std::optional<SceneEdit>& edit) {
  std::promise<ScenePtr> promise;
  promise.set_value(std::move(scene));
  std::list<CachedScene> dropped;  // destroyed after mutex_ is released
  const std::lock_guard lock(mutex_);
  ++edition_;
  if (edit) {
    edits_[id].push_back(*edit);
    edit_bytes_ += edit->bytes;
  } else {
    for (const SceneEdit& back : edits_[id]) edit_bytes_ -= back.bytes;
    edits_.erase(id);
  }
  const auto kept =
      std::find_if(kept_.begin(), kept_.end(), [&](const CachedScene& k) { return k.id == id; });
  if (kept != kept_.end()) dropped.splice(dropped.end(), kept_, kept);
  dropped.splice(dropped.end(), keep_front({id, promise.get_future().share()}));
}

std::vector<Gauge> RenderSession::gauges() const {
  const auto number = [](std::uint64_t value) { return static_cast<double>(value); };
  std::uint64_t bytes = 0, peak_bytes = 0, limit_bytes = 0;
  for (const auto& slot : *slots_) {
    bytes += slot->bytes;
    peak_bytes += slot->peak_bytes;
    limit_bytes += slot->device.info().global_bytes;
  }
  return {
      {"simuli_scenes_kept", "Scenes in memory.", number(kept().size())},
      {"simuli_scenes_kept_limit", "Scenes that are kept in memory at most.", number(cache_size())},
      {"simuli_device_queue", "Requests that wait for a device.", number(queue_.waiting())},
      {"simuli_device_busy", "Devices that are at work.", number(slots_->size() - queue_.free())},
      {"simuli_device_memory_bytes", "Device memory in use behind the last frames.", number(bytes)},
      {"simuli_device_memory_peak_bytes", "The most that was in use.", number(peak_bytes)},
      {"simuli_device_memory_limit_bytes", "What the devices have.", number(limit_bytes)},
  };
}

std::vector<std::string> RenderSession::kept() const {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> ids;
  for (const CachedScene& k : kept_) ids.push_back(k.id);
  return ids;
}

void RenderSession::render(ServedScene& scene, std::span<FrameJob> jobs, const IsGivenUp& is_given_up) {
  std::atomic<std::size_t> next{0};
  std::vector<std::future<void>> others;
  for (std::size_t device = 1; device < std::min(slots_->size(), jobs.size()); ++device) {
    others.push_back(std::async(std::launch::async, [&] { render_on_one(scene, jobs, next, is_given_up); }));
  }
  std::exception_ptr failure;
  const auto unless_failed = [&failure](const auto& work) {
    try {
      work();
    } catch (...) {
      if (!failure) failure = std::current_exception();
    }
  };
  unless_failed([&] { render_on_one(scene, jobs, next, is_given_up); });
  for (std::future<void>& other : others) unless_failed([&] { other.get(); });
  if (failure) std::rethrow_exception(failure);
}

void RenderSession::render_on_one(ServedScene& scene,
                                  std::span<FrameJob> jobs,
                                  std::atomic<std::size_t>& next,
                                  const IsGivenUp& is_given_up) {
  Stopwatch watch;
  const FairQueue::Ticket ticket = queue_.take(is_given_up);
  metrics_.add_time(RequestStage::kDeviceWait, watch.seconds());
  if (next >= jobs.size()) return;  // other threads have taken the remaining jobs
  watch = {};
  Slot& slot = *(*slots_)[ticket.place()];
  const std::lock_guard lock(slot.mutex);
  auto& on_device = scene.on_devices_[ticket.place()];
  if (!on_device) on_device.emplace(slot.device, scene.scene_, options_.render);
  struct Coming {
    FrameJob& job;
    Frame frame;
    std::optional<ByteDownload> bytes;
  };
  std::optional<Coming> coming;
  const auto take = [&] {
    if (!coming) return;
    Coming now = std::move(*coming);
    coming.reset();
    try {
      if (now.bytes) {
        now.job.bytes = now.bytes->take();
      } else {
        now.job.take(now.frame);
      }
      metrics_.count_frame(true);
    } catch (...) {
      now.job.error = std::current_exception();
      metrics_.count_frame(false);
    }
  };
  for (std::size_t i = next++; i < jobs.size(); i = next++) {
    FrameJob& job = jobs[i];
    throw_if_cancelled(is_given_up);
    try {
      Coming started{job, on_device->render(job.sensor, job.shot), {}};
      if (job.take) {
        started.frame.fetch();
      } else {
        started.bytes.emplace(slot.picture_bytes.start(started.frame, job.order));
      }
      take();
      coming.emplace(std::move(started));
    } catch (...) {
      job.error = std::current_exception();
      metrics_.count_frame(false);
    }
  }
  take();
  metrics_.add_time(RequestStage::kRendering, watch.seconds());
  slot.bytes = slot.device.memory().now;
  slot.peak_bytes = slot.device.memory().peak;
}

}  // namespace simuli::serve
