#pragma once
// A scene with the names, the clock and the sensors that clients use.
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "host/device/render/scene/scene_on_device.hpp"
#include "io/scene/scene_clock.hpp"
#include "io/scene/sensor_rig.hpp"

namespace simuli::serve {

struct SceneSource {
  std::string id;  // name that clients use
  std::filesystem::path path;
};

/// Parses "ID=PATH", or a path, whose scene is named like its folder or file without extension. Throws
/// Error{kUsage} for no scene, an empty name and a repeated name.
[[nodiscard]] std::vector<SceneSource> scene_sources(const std::vector<std::string>& arguments);

/// Result of an edit.
struct SceneEdit {
  std::function<void(Scene&)> apply;
  std::vector<std::string> external;  // actors with another actor's particles
  std::vector<std::string> inserted;  // inserted actors, a subset of `external`
  std::size_t bytes = 0;              // approximate memory of the edit
};

/// A scene that was read. Its const members may be called from any thread; RenderSession synchronises its
/// devices.
class ServedScene {
 public:
  /// Errors as in read_scene().
  explicit ServedScene(const SceneSource& source);
  /// Returns an edited copy of the scene. Errors as in `edit`.
  [[nodiscard]] std::unique_ptr<ServedScene> edited(const SceneEdit& edit) const;
  /// Returns the scene as it was read.
  [[nodiscard]] std::unique_ptr<ServedScene> restored() const;
  [[nodiscard]] bool is_edited() const { return original_ != nullptr; }
  [[nodiscard]] const Scene& original() const { return is_edited() ? *original_ : *scene_; }

  [[nodiscard]] const std::string& id() const { return id_; }
  [[nodiscard]] const std::vector<std::string>& notes() const { return notes_; }  // of a splat file
  [[nodiscard]] const Scene& scene() const { return *scene_; }
  /// Returns the actors with another actor's particles.
  [[nodiscard]] const std::set<std::string>& external() const { return external_; }
  /// Whether an actor was inserted; without a pose in the request it has its own track.
  [[nodiscard]] bool is_inserted(const std::string& actor) const { return inserted_.contains(actor); }
  [[nodiscard]] const Trajectory& world_from_rig() const { return world_from_rig_; }
  /// Returns the scene's cameras in order.
  [[nodiscard]] const std::vector<Sensor>& cameras() const { return cameras_; }
  [[nodiscard]] const Sensor* find_camera(const std::string& name) const;
  /// Returns a LiDAR of the scene or a built-in one, as SensorRig::find() without files. Throws
  /// Refusal{kNotFound} for an unknown name and for a camera.
  [[nodiscard]] Sensor lidar(const std::string& name) const;

  /// Converts to the clients' time unit.
  [[nodiscard]] std::uint64_t microseconds(double time_s) const { return clock_.microseconds(time_s); }
  /// Throws Refusal{kOutOfRange} for times farther beyond the trajectory than it can be extrapolated.
  [[nodiscard]] double seconds(std::uint64_t time_us, const std::string& field) const;

  /// Clients' coordinates are relative to the scene's origin, so that single precision suffices.
  [[nodiscard]] Pose local(Pose world) const;
  [[nodiscard]] Pose world(Pose local) const;

 private:
  friend class RenderSession;
  ServedScene(const ServedScene& base, std::shared_ptr<const Scene> scene);
  std::string id_;
  std::vector<std::string> notes_;
  SensorRig rig_;
  std::vector<Sensor> cameras_;
  Trajectory world_from_rig_;
  std::shared_ptr<const Scene> scene_;
  std::shared_ptr<const Scene> original_;  // of an edited scene
  std::set<std::string> external_, inserted_;
  SceneClock clock_;
  std::vector<std::optional<SceneOnDevice>> on_devices_;  // indexed by RenderSession's devices
  mutable std::mutex lidars_mutex_;
  mutable std::map<std::string, Sensor> lidars_;  // requested so far
};

}  // namespace simuli::serve
