#pragma once
// One view, as the page asks for it.
#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "host/core/base/pose.hpp"
#include "host/core/scene/edit.hpp"

namespace simuli::cli {

/// What of a camera's frame is shown: its picture; how far each ray gets (RayResults::expected_distance(),
/// on a logarithmic scale of colours); how much of each ray the particles take; its picture, hatched where no
/// recorded camera faced.
enum class ViewLayer { kColour, kDepth, kOpacity, kUnseen, kSupport };

/// What has a default here but rig_shift_m, yaw_rad, pitch_rad, removed and moved may be missing. All of the viewer's state is here, but for
/// actors that were added: the session keeps none.
struct ViewRequest {
  static constexpr int kNarrowest_px = 64, kWidest_px = 4096;
  static constexpr double kMostPixels = 4096.0 * 4096.0;
  static constexpr double kFreeHalf_rad = 0.45;
  static constexpr int kMostSweeps = 100;

  std::string sensor;   // of the scene, or built in
  std::string quality;  // see --quality
  double time_s = 0.0;
  int width = 960;  // px, of pictures; the height follows
  ViewLayer layer = ViewLayer::kColour;
  bool lossless = false;                                  // a PNG instead of a JPEG
  Eigen::Vector3d rig_shift_m = Eigen::Vector3d::Zero();  // forward, left, up
  double yaw_rad = 0.0, pitch_rad = 0.0;                  // of a camera: to the left, down
  std::optional<Pose> scene_from_camera;                  // instead of the rig's camera
  /// px, with scene_from_camera: a pinhole camera of that height instead of the sensor, kFreeHalf_rad above
  /// and below its axis.
  std::optional<int> height;
  std::optional<Eigen::Vector2d> pixel;            // to probe, in parts of the picture's sides
  std::string points;                              // over a picture: the LiDAR whose returns; empty: none
  int sweeps = 1;                                  // of a log: as many, spread along the path
  std::vector<std::string> removed;                // actors
  std::map<std::string, Eigen::Vector3d> moved;    // actors, (forward, left, up) m in their own frame
  std::map<std::string, double> turned_deg;        // actors, to their left
  std::map<std::string, Eigen::Vector2d> retimed;  // actors, (times as fast, s later)

  /// Of its actors, in the order of the command line's.
  [[nodiscard]] std::vector<ActorEdit> edits() const;
  /// Whether it shows what was recorded, from where it was.
  [[nodiscard]] bool is_as_recorded() const;
};

/// Error{kInput} for what is no request: syntax, missing and unknown keys, numbers out of range.
[[nodiscard]] ViewRequest parse_view_request(const std::string& json);

}  // namespace simuli::cli
