#pragma once
// The result of one shot of a sensor.
#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "host/core/base/image.hpp"
#include "host/core/sensors/sensor.hpp"
#include "host/device/render/options/options.hpp"
#include "host/device/render/scene/ray_results.hpp"
#include "host/device/render/scene/readings.hpp"
#include "host/device/render/scene/shot.hpp"

namespace simuli {

/// Optional requests of a frame in addition to sensor and shot.
struct FrameRequest {
  std::optional<RenderOptions> options = {};  // in place of the scene's
  std::vector<bool> rays = {};  // [rays] to render, others show the background; empty: all
  bool graded = true;  // pictures exposure-corrected by the scene's colour grids
  bool camera_median = false;   // cameras: also RayResults::median (LiDARs: RenderOptions::median_distance)
  bool actors = false;  // also Frame::actors() and owners(), which take another rendering
};

/// dL/d(RayResults) by ray, for a loss of the caller. Empty vectors are 0.
struct RayGradients {
  std::vector<float> feature[3];     // [rays]
  std::vector<float> transmittance;  // [rays]
  std::vector<float> distance;       // [rays], of the sum of w tau
};

/// A frame rendered by SceneOnDevice. A handle: copies refer to the same frame. Its results are independent of
/// later frames, and any number of frames may be in progress at once.
///   std::vector<Frame> frames;
///   for (const Sensor& sensor : rig) {
///     frames.push_back(scene.render(sensor, shot_of(sensor)));
///     frames.back().fetch();  // while the next one is rendered
///   }
///   for (const Frame& frame : frames) use(frame.results());
/// Used by the thread that uses the scene. Calls that wait throw Error{kDevice} for failures on the device.
class Frame {
 public:
  [[nodiscard]] const Sensor& sensor() const;
  [[nodiscard]] const Shot& shot() const;

  /// Whether the device has finished rendering; does not wait.
  [[nodiscard]] bool is_ready() const;
  /// Waits until the device has finished rendering.
  void wait() const;
  /// Queues the download of the results; does not wait. Otherwise results() queues it, after all work queued
  /// until then.
  void fetch() const;

  /// Returns the results by ray, in the sensor's order: pixels row-major, beams x firings, or a list's rays.
  /// Waits; downloads once.
  [[nodiscard]] const RayResults& results() const;
  /// Returns a camera's picture, clipped to [0, 1]: [height][width][3]. Throws Error{kUsage} for a LiDAR.
  [[nodiscard]] Image image() const;
  /// Returns a LiDAR's measurements by ray. Throws Error{kUsage} for a camera.
  [[nodiscard]] LidarFrame lidar() const;
  /// Returns the end points of a LiDAR's rays: [rays] m; for rays without a return the rays' origins.
  [[nodiscard]] std::vector<Eigen::Vector3d> points(PointFrame in = PointFrame::kWorld) const;
  /// Returns, for a frame requested with actors, [rays]: 1 + the index in Scene::actors of the particle at
  /// which transmittance falls below 1/2 (the median distance); 0: the background, or transmittance stays
  /// above. Throws Error{kUsage} for other frames.
  [[nodiscard]] std::vector<std::uint32_t> owners() const;
  /// Returns the same only for actors' bodies (ActorBoxes::is_of_body()), without shadow and road that their
  /// particles also show.
  [[nodiscard]] std::vector<std::uint32_t> actors() const;

 private:
  friend class SceneOnDevice;
  friend struct FrameAccess;
  struct State;
  [[nodiscard]] static const State& last_of(const State& state);
  explicit Frame(std::shared_ptr<State> state) : state_(std::move(state)) {}
  std::shared_ptr<State> state_;
};

}  // namespace simuli
