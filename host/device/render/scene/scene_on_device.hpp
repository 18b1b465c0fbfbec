#pragma once
// A scene on a device, ready for rendering.
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

/// Returns a non-owning pointer to a scene that outlives all users.
[[nodiscard]] inline std::shared_ptr<const Scene> borrowed(const Scene& scene) {
  return {std::make_shared<char>(), &scene};  // a control block of its own, with which frames identify their scene
}

/// Renders any sensor in a scene. Movable; used by one thread at a time.
///   SceneOnDevice scene(Device::best(), std::move(file.scene));
///   const Sensor lidar = SensorRig(file).find("hesai_xt32@20");
///   const Frame frame = scene.render(lidar, Shot::along(file.world_from_rig, lidar, 1.5));
///   frame.points();
/// A particle set is uploaded when a sensor of its kind is first rendered, once for all options with the same
/// UploadOptions. Rays of sensors are cached for all scenes of the device, within a quarter of the device's
/// memory including host copies; sensors used only once have a quarter of that, at most 256 MiB.
class SceneOnDevice {
 public:
  /// Throws Error{kUsage} for options that validate() refuses.
  SceneOnDevice(const Device& device, Scene scene, const RenderOptions& options = {});
  /// Uses a scene that has other users.
  SceneOnDevice(const Device& device, std::shared_ptr<const Scene> scene, const RenderOptions& options = {});
  SceneOnDevice(SceneOnDevice&&) noexcept;
  SceneOnDevice& operator=(SceneOnDevice&&) noexcept;
  ~SceneOnDevice();

  /// Queues a frame: pictures are composited over the scene's environment or background, and exposure-corrected
  /// by the colour grids when the sensor has the name of a training camera. Returns while the device may still
  /// be rendering. Throws Error{kUsage} for edits of unknown actors and options that validate() refuses,
  /// Error{kInput} for invalid poses, Error{kDevice} when the device lacks memory.
  [[nodiscard]] Frame render(const Sensor& sensor, const Shot& shot, const FrameRequest& request = {});

  /// Returns dL/d(particles) of the set that the frame's sensor uses, for a loss L with given derivatives by
  /// ray results: [N, param_rows] as GaussianSet::params, zeros for invisible particles. Renders the frame
  /// again and waits. Throws Error{kUsage} for a frame of another scene (or from before set_scene()), a frame
  /// with colour grid, options without gradients (need_gradients()), and derivatives that are not finite or not
  /// one per ray.
  [[nodiscard]] Eigen::MatrixXf gradients(const Frame& frame, const RayGradients& of_rays);

  /// Replaces the scene; cached rays of sensors and earlier frames remain valid.
  void set_scene(Scene scene);
  void set_scene(std::shared_ptr<const Scene> scene);

  [[nodiscard]] const Scene& scene() const;
  [[nodiscard]] const Device& device() const;
  /// Number of sensors with cached rays on the device, of all scenes.
  [[nodiscard]] std::size_t sensor_count() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace simuli
