#pragma once
// A scene as clients see it: its names, its clock, its sensors.
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
  std::string id;  // what clients ask for
  std::filesystem::path path;
};

/// "ID=PATH", or a path, whose scene is named like its folder or file without the extension. Error{kUsage}
/// for none at all, an empty name, and a name that two have.
[[nodiscard]] std::vector<SceneSource> scene_sources(const std::vector<std::string>& arguments);

/// What a scene is made into.
struct SceneEdit {
  std::function<void(Scene&)> apply;
  std::vector<std::string> external;  // actors that got another one's particles, or came to be
  std::vector<std::string> inserted;  // of those: who came to be
  std::size_t bytes = 0;              // that it keeps, about
};

/// A scene that has been read. What it tells is safe to ask from any thread; its device is RenderSession's.
class ServedScene {
 public:
  /// Errors as read_scene().
  explicit ServedScene(const SceneSource& source);
  /// The same scene, edited; this one stays as it is. Errors as `edit` throws them.
  [[nodiscard]] std::unique_ptr<ServedScene> edited(const SceneEdit& edit) const;
  /// As it was read.
  [[nodiscard]] std::unique_ptr<ServedScene> restored() const;
  [[nodiscard]] bool is_edited() const { return original_ != nullptr; }
  [[nodiscard]] const Scene& original() const { return is_edited() ? *original_ : *scene_; }

  [[nodiscard]] const std::string& id() const { return id_; }
  [[nodiscard]] const std::vector<std::string>& notes() const { return notes_; }  // of a file of splats
  [[nodiscard]] const Scene& scene() const { return *scene_; }
  /// Actors with the particles of another one.
  [[nodiscard]] const std::set<std::string>& external() const { return external_; }
  /// Actors that were not recorded: who doesn't say where they are has them on their own tracks.
  [[nodiscard]] bool is_inserted(const std::string& actor) const { return inserted_.contains(actor); }
  [[nodiscard]] const Trajectory& world_from_rig() const { return world_from_rig_; }
  /// Its cameras, in order.
  [[nodiscard]] const std::vector<Sensor>& cameras() const { return cameras_; }
  [[nodiscard]] const Sensor* find_camera(const std::string& name) const;
  /// As SensorRig::find() takes it, but no file: of the scene, or built in. Refusal{kNotFound} where there is
  /// none, and where it is a camera.
  [[nodiscard]] Sensor lidar(const std::string& name) const;

  /// What clients count.
  [[nodiscard]] std::uint64_t microseconds(double time_s) const { return clock_.microseconds(time_s); }
  /// Refusal{kOutOfRange} for what lies farther beyond the path than it can be continued.
  [[nodiscard]] double seconds(std::uint64_t time_us, const std::string& field) const;

  /// Clients' places are relative to the scene's origin: numbers small enough for single precision.
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
  std::shared_ptr<const Scene> original_;  // of one that is edited
  std::set<std::string> external_, inserted_;
  SceneClock clock_;
  std::vector<std::optional<SceneOnDevice>> on_devices_;  // by RenderSession's devices
  mutable std::mutex lidars_mutex_;
  mutable std::map<std::string, Sensor> lidars_;  // that were asked for
};

}  // namespace simuli::serve
