#pragma once
// What the viewer shows, rendered on request: one scene on one device, for any number of pages.
#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "host/cli/base/commands.hpp"
#include "host/cli/view/live_page.hpp"
#include "host/render/scene/scene_on_device.hpp"
#include "io/scene/sensor_rig.hpp"

namespace simuli::cli {

/// One view, as the page asks for it. All of the viewer's state is here: the session keeps none.
struct ViewRequest {
  static constexpr int kNarrowest_px = 64, kWidest_px = 4096;
  static constexpr double kMostPixels = 4096.0 * 4096.0;
  static constexpr double kTallest_px = 65535.0;  // of any JPEG

  std::string sensor;   // of the scene, or built in
  std::string quality;  // see --quality
  double time_s = 0.0;
  int width = 960;                                        // px, of pictures; the height follows
  Eigen::Vector3d rig_shift_m = Eigen::Vector3d::Zero();  // forward, left, up
  double yaw_rad = 0.0, pitch_rad = 0.0;                  // of a camera: to the left, down
  std::optional<Pose> scene_from_camera;                  // instead of the rig's camera
  std::vector<std::string> removed;                       // actors
  std::map<std::string, Eigen::Vector3d> moved;           // actors, (forward, left, up) m in their own frame
};
/// Error{kInput} for what is no request: syntax, missing and unknown keys, numbers out of range.
[[nodiscard]] ViewRequest parse_view_request(const std::string& json);

/// Calls may come from any thread; renders wait for each other.
class ViewSession {
 public:
  /// `file` may have empty sets, of a training that has not begun: views are then refused.
  ViewSession(const Globals& globals, SceneFile file);
  ViewSession(const ViewSession&) = delete;
  ViewSession& operator=(const ViewSession&) = delete;

  /// From now on this scene is shown.
  void show(Scene scene);
  void set_progress(const ViewProgress& progress);
  /// Seconds since a page last asked for anything; infinite before.
  [[nodiscard]] double idle_s() const;

  /// JSON: names, sensors, actors, the path and times of the drive.
  [[nodiscard]] std::string describe() const;
  /// JSON: ViewProgress, and a number that changes with every show().
  [[nodiscard]] std::string progress() const;
  /// Replies of two parts: a little-endian u32, that many bytes of JSON (times, poses), zeros up to the next
  /// multiple of 4, and a JPEG; or the returned rays as float x, y, z (scene frame, m), intensity.
  /// Error{kUsage} for an unknown sensor, quality or actor, Error{kInput} for a scene without such particles.
  [[nodiscard]] std::string picture(const ViewRequest& request);
  [[nodiscard]] std::string sweep(const ViewRequest& request);

 private:
  /// The request's shot of that sensor; a camera's may be a free one.
  [[nodiscard]] Shot shot_of(const ViewRequest& request, const Sensor& sensor) const;
  void touch();

  Globals globals_;
  mutable std::mutex mutex_;  // of everything below but the progress
  SceneFile file_;            // without its scene, which is on the device
  SensorRig rig_;
  SceneOnDevice scene_;
  mutable std::mutex progress_mutex_;
  ViewProgress progress_;
  std::uint64_t version_ = 0;
  double asked_s_;
};

}  // namespace simuli::cli
