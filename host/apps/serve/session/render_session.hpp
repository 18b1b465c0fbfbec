#pragma once
// Scenes and the devices that render them, for any number of callers.
#include <atomic>
#include <cstdint>
#include <exception>
#include <functional>
#include <future>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/apps/serve/session/fair_queue.hpp"
#include "host/apps/serve/session/metrics.hpp"
#include "host/apps/serve/session/served_scene.hpp"
#include "host/device/render/outputs/picture_bytes.hpp"

namespace simuli::serve {

struct SessionOptions {
  std::vector<SceneSource> scenes;
  std::vector<std::string> devices = {""};            // each as in Device::best(); at least one
  RenderOptions render = {};                          // for all frames
  std::size_t cache_size = 4;                         // number of cached scenes, the most recently used
  std::function<void(const std::string&)> note = {};  // called for each scene that is read, from any thread
};

/// One frame of a batch. An error affects only this frame.
struct FrameJob {
  Sensor sensor;
  Shot shot;
  /// Called with the rendered frame while the caller holds the device; it copies the required data and must not
  /// keep the frame. With several devices it is called from several threads. Empty: a picture, of which only
  /// the bytes are copied to the host.
  std::function<void(const Frame&)> take = {};
  PixelOrder order = PixelOrder::kPlanar;
  std::string bytes = {};
  std::exception_ptr error = {};
};

/// Safe to use from any thread. A caller's scene stays valid when it is dropped from the cache.
class RenderSession {
 public:
  /// Throws Error{kDevice} without a device, Error{kUsage} for options that validate() refuses.
  explicit RenderSession(SessionOptions options);
  RenderSession(const RenderSession&) = delete;
  RenderSession& operator=(const RenderSession&) = delete;
  ~RenderSession();

  /// Returns the sources in the order of the command line.
  [[nodiscard]] const std::vector<SceneSource>& sources() const { return options_.scenes; }
  [[nodiscard]] std::size_t cache_size() const { return options_.cache_size; }
  [[nodiscard]] const Device& device(std::size_t number = 0) const { return slots_->at(number)->device; }
  /// Returns the devices' labels, joined.
  [[nodiscard]] std::string devices() const;
  /// Increases with every edit of any scene; equal numbers mean equal scenes.
  [[nodiscard]] std::uint64_t edition() const { return edition_; }
  [[nodiscard]] Metrics& metrics() const { return metrics_; }
  /// Returns gauges of scenes, and of queue and memory of the devices after the last frame.
  [[nodiscard]] std::vector<Gauge> gauges() const;

  /// Limit of stored edits, which are applied again when a scene is read again.
  static constexpr std::size_t kMostEditBytes = std::size_t{64} << 20U;

  using ScenePtr = std::shared_ptr<ServedScene>;
  /// Reads a scene unless it is cached; concurrent callers wait for the same read. Throws Refusal{kNotFound}
  /// for an unknown name, Refusal{kPrecondition} for an unreadable scene, Refusal{kCancelled}.
  [[nodiscard]] ScenePtr open(const std::string& id, const IsGivenUp& is_given_up = never_given_up);
  /// Reads a scene at the start of the server. Throws Error{kInput} for an unreadable scene.
  void read_now(const std::string& id);
  /// Edits a scene for all later calls of open(), also after it is read again; holders of the scene keep the
  /// previous version. Errors as in open() and `edit`; throws Refusal{kExhausted} if all edits together would
  /// exceed kMostEditBytes. Nothing changes on an error.
  void edit(const std::string& id, const SceneEdit& edit, const IsGivenUp& is_given_up = never_given_up);
  /// Removes all edits. Errors as in open().
  void restore(const std::string& id, const IsGivenUp& is_given_up = never_given_up);
  /// Returns the names of the cached scenes, the most recently used first.
  [[nodiscard]] std::vector<std::string> kept() const;

  /// Renders the frames on all free devices. Each device renders its frames in order and starts the next one
  /// while the previous one is taken. Throws Refusal{kCancelled} while it waits for a device, and between
  /// frames.
  void render(ServedScene& scene, std::span<FrameJob> jobs, const IsGivenUp& is_given_up = never_given_up);

 private:
  struct CachedScene {
    std::string id;
    std::shared_future<ScenePtr> scene;
  };
  [[nodiscard]] ScenePtr owned(std::unique_ptr<ServedScene> scene) const;
  [[nodiscard]] ScenePtr read(const SceneSource& source) const;
  /// Caches a scene under its name; the caller holds mutex_. Returns the scenes that are dropped.
  [[nodiscard]] std::list<CachedScene> keep_front(CachedScene scene);
  /// Adds an edit, or removes all edits if there is none.
  void replace(const std::string& id, ScenePtr scene, const std::optional<SceneEdit>& edit);
  /// Caches a scene that this or another caller reads.
  [[nodiscard]] std::shared_future<ScenePtr> keep(const SceneSource& source);
  void forget(const std::string& id);

  /// A device, used by the holder of the ticket with its number; `mutex` also protects the destruction of
  /// scenes on it.
  struct Slot {
    explicit Slot(const std::string& request) : device(Device::best(request)), picture_bytes(device) {}
    Device device;
    PictureBytes picture_bytes;
    std::mutex mutex;
    std::atomic<std::uint64_t> bytes{0}, peak_bytes{0};  // after the last frame
  };
  /// Renders frames from `next` on one device until none is left.
  void render_on_one(ServedScene& scene,
                     std::span<FrameJob> jobs,
                     std::atomic<std::size_t>& next,
                     const IsGivenUp& is_given_up);

  SessionOptions options_;
  std::shared_ptr<std::vector<std::unique_ptr<Slot>>> slots_;  // shared with the owners of scenes
  FairQueue queue_;
  mutable Metrics metrics_;
  std::atomic<std::uint64_t> edition_{0};
  mutable std::mutex mutex_;
  std::list<CachedScene> kept_;                          // the most recently used first
  std::map<std::string, std::vector<SceneEdit>> edits_;  // by scene
  std::size_t edit_bytes_ = 0;                           // of edits_
  std::mutex edit_mutex_;                                // serialises edits; locked before mutex_
};

}  // namespace simuli::serve
