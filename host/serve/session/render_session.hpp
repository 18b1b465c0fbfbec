#pragma once
// Scenes and the one device that renders them, for any number of callers.
#include <exception>
#include <functional>
#include <future>
#include <list>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "host/serve/session/served_scene.hpp"
#include "host/serve/session/turns.hpp"

namespace simuli::serve {

struct SessionOptions {
  std::vector<SceneSource> scenes;
  std::string device;          // as Device::best() takes it
  RenderOptions render = {};   // of all frames
  std::size_t cache_size = 4;  // scenes that are kept: those used last
};

/// One frame of a batch. `take` gets it when it is rendered, while the device is the caller's: it copies what
/// it needs, and keeps no frame. What goes wrong with this frame stays with it.
struct FrameJob {
  Sensor sensor;
  Shot shot;
  std::function<void(const Frame&)> take;
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
  [[nodiscard]] const Device& device() const { return device_; }

  using ScenePtr = std::shared_ptr<ServedScene>;
  /// Reads it unless it is kept; two who ask at once wait for the same reading. Refusal{kNotFound} for a name
  /// that there is not, Refusal{kPrecondition} for a scene that can't be read, Refusal{kCancelled}.
  [[nodiscard]] ScenePtr open(const std::string& id, const IsGivenUp& is_given_up = never_given_up);
  /// The same before anybody asks, for who starts the server: Error{kInput} for a scene that can't be read.
  void read_now(const std::string& id);
  /// Names of those that are kept, the last used first.
  [[nodiscard]] std::vector<std::string> kept() const;

  /// Renders the frames in their order, one on its way while the one before is taken. Refusal{kCancelled}
  /// while it waits for the device, and between frames.
  void render(ServedScene& scene, std::span<FrameJob> jobs, const IsGivenUp& is_given_up = never_given_up);

 private:
  struct Kept {
    std::string id;
    std::shared_future<ScenePtr> scene;
  };
  [[nodiscard]] ScenePtr read(const SceneSource& source) const;
  /// A scene that is kept from here on, and read by now, or by another caller soon.
  [[nodiscard]] std::shared_future<ScenePtr> keep(const SceneSource& source);
  void forget(const std::string& id);

  SessionOptions options_;
  Device device_;
  Turns turns_{1};
  mutable std::mutex mutex_;
  std::list<Kept> kept_;  // last used first
};

}  // namespace simuli::serve
