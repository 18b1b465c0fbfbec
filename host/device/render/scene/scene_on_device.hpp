#pragma once
// A scene and a device, ready to be looked at.
#include <Eigen/Core>
#include <cstddef>
#include <memory>

#include "host/core/scene/scene.hpp"
#include "host/core/sensors/sensor.hpp"
#include "host/device/render/options/options.hpp"
#include "host/device/render/scene/frame.hpp"
#include "host/device/render/scene/shot.hpp"
#include "host/device/runtime/device.hpp"

namespace simuli {

/// A scene that its owner keeps for as long as anybody looks at it.
[[nodiscard]] inline std::shared_ptr<const Scene> borrowed(const Scene& scene) {
  return {std::make_shared<char>(), &scene};  // an owner of its own, by which frames know their scene
}

/// Renders any sensor in a scene. Movable; used by one thread at a time.
///   SceneOnDevice scene(Device::best(), std::move(file.scene));
///   const Sensor lidar = SensorRig(file).find("hesai_xt32@20");
///   const Frame frame = scene.render(lidar, Shot::along(file.world_from_rig, lidar, 1.5));
///   frame.points();
/// A particle set goes to the device when a sensor of its kind is first rendered, once for all options that
/// keep the same of it. What rays a sensor has there is kept, for all scenes of the device, until sensors used
/// later have taken a quarter of the device's memory, copies on the host counted: those of a rig are made
/// once or twice, whatever the order of its frames. Those of sensors that were used once have a quarter of that,
/// 256 MiB at most.
class SceneOnDevice {
 public:
  /// Error{kUsage} for options that validate() refuses.
  SceneOnDevice(const Device& device, Scene scene, const RenderOptions& options = {});
  /// The same for a scene that others look at, too.
  SceneOnDevice(const Device& device, std::shared_ptr<const Scene> scene, const RenderOptions& options = {});
  SceneOnDevice(SceneOnDevice&&) noexcept;
  SceneOnDevice& operator=(SceneOnDevice&&) noexcept;
  ~SceneOnDevice();

  /// Queues a frame: pictures over the scene's environment or background, graded by the colour grids when the
  /// sensor's model has the name of a camera that the scene was trained on. Returns while the device may
  /// still be at work. Error{kUsage} for edits of unknown actors and options that validate() refuses,
  /// Error{kInput} for poses that are none, Error{kDevice} when the device has no room.
  [[nodiscard]] Frame render(const Sensor& sensor, const Shot& shot, const FrameRequest& request = {});

  /// dL/d(particles) of the set that the frame's sensor sees, for a loss L of which the caller has the
  /// derivatives by what each ray saw: [N, param_rows] as GaussianSet::params, zeros for particles that no
  /// ray sees. Renders the frame again, as it was asked for, and waits. Error{kUsage} for a frame of another
  /// scene (or from before set_scene()), one through colour grids, options that have no gradients
  /// (need_gradients()) and derivatives that are not finite or not one per ray.
  [[nodiscard]] Eigen::MatrixXf gradients(const Frame& frame, const RayGradients& of_rays);

  /// From now on this scene is rendered; rays of sensors stay. Frames that were rendered before stay, too.
  void set_scene(Scene scene);
  void set_scene(std::shared_ptr<const Scene> scene);

  [[nodiscard]] const Scene& scene() const;
  [[nodiscard]] const Device& device() const;
  /// Sensors whose rays are kept on the device now, of any scene.
  [[nodiscard]] std::size_t sensor_count() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace simuli
