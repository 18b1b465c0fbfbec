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
  std::vector<std::string> devices = {""};            // each as Device::best() takes it; at least one
  RenderOptions render = {};                          // of all frames
  std::size_t cache_size = 4;                         // scenes that are kept: those used last
  std::function<void(const std::string&)> note = {};  // of scenes that are read; from any thread
};

/// One frame of a batch. What goes wrong with it stays with it.
struct FrameJob {
  Sensor sensor;
  Shot shot;
  /// Gets the frame when it is rendered, while the device is the caller's: copies what it needs, and keeps
  /// no frame. With several devices from several threads. Empty: a picture, whose bytes are all that comes to
  /// the host.
  std::function<void(const Frame&)> take = {};
  PixelOrder order = PixelOrder::kPlanar;
  std::string bytes = {};
  std::exception_ptr error = {};
};

/// Safe to use from any thread. Who holds a scene keeps it, whatever is dropped meanwhile.
class RenderSession {
 public:
  /// Error{kDevice} without one; Error{kUsage} for options that validate() refuses.
  explicit RenderSession(SessionOptions options);
  RenderSession(const RenderSession&) = delete;
  RenderSession& operator=(const RenderSession&) = delete;
  ~RenderSession();

  /// In the order of the command line.
  [[nodiscard]] const std::vector<SceneSource>& sources() const { return options_.scenes; }
  [[nodiscard]] std::size_t cache_size() const { return options_.cache_size; }
  [[nodiscard]] const Device& device(std::size_t number = 0) const { return slots_->at(number)->device; }
  /// The devices' labels, one behind the other.
  [[nodiscard]] std::string devices() const;
  /// Grows with every edit of any scene: what was rendered under the same number is of the same scenes.
  [[nodiscard]] std::uint64_t edition() const { return edition_; }
  [[nodiscard]] Metrics& metrics() const { return metrics_; }
  /// Of scenes, the device's queue and its memory, as it was behind the last frame.
  [[nodiscard]] std::vector<Gauge> gauges() const;

  /// Edits are kept for scenes that are read again.
  static constexpr std::size_t kMostEditBytes = std::size_t{64} << 20U;

  using ScenePtr = std::shared_ptr<ServedScene>;
  /// Reads it unless it is kept; two who ask at once wait for the same reading. Refusal{kNotFound} for a name
  /// that there is not, Refusal{kPrecondition} for a scene that can't be read, Refusal{kCancelled}.
  [[nodiscard]] ScenePtr open(const std::string& id, const IsGivenUp& is_given_up = never_given_up);
  /// The same before anybody asks, for who starts the server: Error{kInput} for a scene that can't be read.
  void read_now(const std::string& id);
  /// Who opens the scene from now on finds it edited, also when it is read again; those who hold it have it
  /// as it was. Errors as open() and `edit` throw them, Refusal{kExhausted} where all edits together would
  /// keep more than kMostEditBytes; then nothing has changed.
  void edit(const std::string& id, const SceneEdit& edit, const IsGivenUp& is_given_up = never_given_up);
  /// Takes all edits back. Errors as open().
  void restore(const std::string& id, const IsGivenUp& is_given_up = never_given_up);
  /// Names of those that are kept, the last used first.
  [[nodiscard]] std::vector<std::string> kept() const;

  /// Renders the frames on all devices that are free, each in the order of those that it gets, one on its way
  /// while the one before is taken. Refusal{kCancelled} while it waits for a device, and between frames.
  void render(ServedScene& scene, std::span<FrameJob> jobs, const IsGivenUp& is_given_up = never_given_up);

 private:
  struct CachedScene {
    std::string id;
    std::shared_future<ScenePtr> scene;
  };
  [[nodiscard]] ScenePtr owned(std::unique_ptr<ServedScene> scene) const;
  [[nodiscard]] ScenePtr read(const SceneSource& source) const;
  /// What is kept under this name from now on; mutex_ is the caller's. Returns what goes for it.
  [[nodiscard]] std::list<CachedScene> keep_front(CachedScene scene);
  /// An edit more, or without one all taken back.
  void replace(const std::string& id, ScenePtr scene, const std::optional<SceneEdit>& edit);
  /// A scene that is kept from here on, and read by now, or by another caller soon.
  [[nodiscard]] std::shared_future<ScenePtr> keep(const SceneSource& source);
  void forget(const std::string& id);

  /// One of the devices, used by who has the ticket of its number; `mutex` is also of who lets go a scene
  /// there.
  struct Slot {
    explicit Slot(const std::string& request) : device(Device::best(request)), picture_bytes(device) {}
    Device device;
    PictureBytes picture_bytes;
    std::mutex mutex;
    std::atomic<std::uint64_t> bytes{0}, peak_bytes{0};  // as they were behind the last frame
  };
  /// Takes frames from `next` on, until there are no more, on one device.
  void render_on_one(ServedScene& scene,
                     std::span<FrameJob> jobs,
                     std::atomic<std::size_t>& next,
                     const IsGivenUp& is_given_up);

  SessionOptions options_;
  std::shared_ptr<std::vector<std::unique_ptr<Slot>>> slots_;  // also of those who hold a scene
  FairQueue queue_;
  mutable Metrics metrics_;
  std::atomic<std::uint64_t> edition_{0};
  mutable std::mutex mutex_;
  std::list<CachedScene> kept_;                          // last used first
  std::map<std::string, std::vector<SceneEdit>> edits_;  // by scene
  std::size_t edit_bytes_ = 0;                           // of edits_
  std::mutex edit_mutex_;                                // one after the other; before mutex_
};

}  // namespace simuli::serve
