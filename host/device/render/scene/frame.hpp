#pragma once
// What a sensor saw in one shot.
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

/// What one frame is asked for beside sensor and shot.
struct FrameRequest {
  std::optional<RenderOptions> options = {};  // instead of the scene's
  std::vector<bool> rays = {};  // [rays] those to render, the others show the background; empty: all
  bool graded = true;           // pictures through the scene's colour grids
  bool camera_median = false;   // cameras: also RayResults::median (LiDARs: RenderOptions::median_distance)
  bool actors = false;  // also Frame::actors() and owners(), for which the frame is rendered once more
};

/// dL/d(RayResults) by ray, of a loss that is the caller's. What is empty is 0.
struct RayGradients {
  std::vector<float> feature[3];     // [rays]
  std::vector<float> transmittance;  // [rays]
  std::vector<float> distance;       // [rays], of the sum of w tau
};

/// A frame that SceneOnDevice renders. A handle: copies are the same frame. It has its results to itself:
/// frames that are rendered later leave it as it is, and any number of them may be on their way at once.
///   std::vector<Frame> frames;
///   for (const Sensor& sensor : rig) {
///     frames.push_back(scene.render(sensor, shot_of(sensor)));
///     frames.back().fetch();  // while the next one is rendered
///   }
///   for (const Frame& frame : frames) use(frame.results());
/// Used by the thread that uses the scene. Errors of the device come from the call that waits:
/// Error{kDevice}.
class Frame {
 public:
  [[nodiscard]] const Sensor& sensor() const;
  [[nodiscard]] const Shot& shot() const;

  /// Whether the device has rendered it; does not wait.
  [[nodiscard]] bool is_ready() const;
  /// Until the device has rendered it.
  void wait() const;
  /// Starts bringing the results to the host; does not wait. Without it, results() starts when it is called,
  /// and comes behind whatever is queued by then.
  void fetch() const;

  /// By ray, in the sensor's order: pixels row-major, beams x firings, a list's rays. Waits; brought to the
  /// host once.
  [[nodiscard]] const RayResults& results() const;
  /// Of a camera, clipped to [0, 1]: [height][width][3]. Error{kUsage} of a LiDAR.
  [[nodiscard]] Image image() const;
  /// Of a LiDAR: what it states of each ray. Error{kUsage} of a camera.
  [[nodiscard]] LidarFrame lidar() const;
  /// Where a LiDAR's rays ended: [rays] m; of rays without a return the rays' origins.
  [[nodiscard]] std::vector<Eigen::Vector3d> points(PointFrame in = PointFrame::kWorld) const;
  /// Of a frame that was asked for them: [rays] whose particle takes the ray's light below a half, 1 + its
  /// place in Scene::actors; 0: none's, or half of the light goes on. Where the median distance is.
  /// Error{kUsage} of others.
  [[nodiscard]] std::vector<std::uint32_t> owners() const;
  /// The same of actors' bodies alone (ActorBoxes::is_of_body()): without the shadow and the road around them
  /// that their particles show, too.
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
