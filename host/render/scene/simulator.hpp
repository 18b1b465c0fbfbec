#pragma once
// A scene and a device, ready to be looked at: the call most programs want. `Renderer` below it is for those
// who need gradients or results that stay on the device.
#include <Eigen/Core>
#include <memory>
#include <vector>

#include "host/base/image.hpp"
#include "host/render/options/quality.hpp"
#include "host/render/scene/seen.hpp"
#include "host/runtime/device.hpp"
#include "host/scene/pose.hpp"
#include "host/scene/scene.hpp"
#include "host/sensors/camera.hpp"
#include "host/sensors/lidar_model.hpp"
#include "host/sensors/trajectory.hpp"

namespace simuli {

/// Where a sensor is, and when, while it takes one frame. World coordinates (m), seconds of the scene's log.
struct Shot {
  Pose world_from_sensor_start;
  Pose world_from_sensor_end;
  double time_start_s = 0.0;
  double time_end_s = 0.0;

  /// A sensor at rest. The duration is of a rolling shutter or a LiDAR's turn, in which actors go on.
  [[nodiscard]] static Shot at(const Pose& world_from_sensor, double time_s, double duration_s = 0.0);
  /// A sensor that is carried along a path. Errors as Trajectory::at().
  [[nodiscard]] static Shot along(const Trajectory& world_from_rig,
                                  const Pose& rig_from_sensor,
                                  double time_start_s,
                                  double time_end_s);
};

/// Renders any camera and any LiDAR in a scene. Movable; used by one thread at a time. Sets go to the device
/// when a sensor of their kind is first rendered; the rays of the last sensors are kept there.
class Simulator {
 public:
  /// Error{kUsage} for options that validate() refuses.
  Simulator(const Device& device, Scene scene, const RenderOptions& options = options_of(Quality::kBalanced));
  Simulator(Simulator&&) noexcept;
  Simulator& operator=(Simulator&&) noexcept;
  ~Simulator();

  /// [height][width][3] in [0, 1], over the scene's environment or background; graded by the scene's colour
  /// grids when camera.name is one that it was trained on. Error{kInput} for a camera that validate()
  /// refuses.
  [[nodiscard]] Image render(const Camera& camera, const Shot& shot);
  /// All rays of one frame. Error{kInput} for a LiDAR that validate() refuses.
  [[nodiscard]] LidarFrame render(const LidarModel& lidar, const Shot& shot);

  [[nodiscard]] const Scene& scene() const;
  [[nodiscard]] const Device& device() const;
  /// The last frame on the device, until the next; its rays() tell which slot is which ray's. Error{kUsage}
  /// before the first.
  [[nodiscard]] const Pass& pass() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Where the rays of a frame ended, in the world: [rays] m; of rays without a return the rays' origins.
[[nodiscard]] std::vector<Eigen::Vector3d> world_points(const LidarModel& lidar,
                                                        const LidarFrame& frame,
                                                        const Shot& shot);

}  // namespace simuli
