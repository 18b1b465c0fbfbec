#pragma once
// A view requested by the page.
#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "host/core/base/pose.hpp"
#include "host/core/scene/edit.hpp"

namespace simuli::cli {

/// Displayed quantity of a camera's frame: colour; expected distance of each ray
/// (RayResults::expected_distance(), logarithmic colour scale); opacity; colour with hatched pixels that no
/// recorded camera faced; support.
enum class ViewLayer { kColour, kDepth, kOpacity, kUnseen, kSupport };

/// Members with a default may be missing in a request, except rig_shift_m, yaw_rad, pitch_rad, removed and
/// moved. A request contains the viewer's whole state except added actors: the session stores no other.
/// actors that were added: the session keeps none.
struct ViewRequest {
  static constexpr int kNarrowest_px = 64, kWidest_px = 4096;
  static constexpr double kMostPixels = 4096.0 * 4096.0;
  static constexpr double kFreeHalf_rad = 0.45;
  static constexpr int kMostSweeps = 100;

  std::string sensor;   // of the scene, or built in
  std::string quality;  // as in --quality
  double time_s = 0.0;
  int width = 960;  // px, of pictures; the height is proportional
  ViewLayer layer = ViewLayer::kColour;
  bool lossless = false;                                  // PNG instead of JPEG
  Eigen::Vector3d rig_shift_m = Eigen::Vector3d::Zero();  // forward, left, up
  double yaw_rad = 0.0, pitch_rad = 0.0;                  // of a camera: left, down
  std::optional<Pose> scene_from_camera;                  // instead of the rig's camera
  /// Height in px, with scene_from_camera: a pinhole camera instead of the sensor, with kFreeHalf_rad above and
  /// below its axis.
  std::optional<int> height;
  std::optional<Eigen::Vector2d> pixel;  // to probe, as shares of the picture's sides
  std::string points;                    // LiDAR whose returns are drawn over a picture; empty: none
  int sweeps = 1;                        // of a log: number of sweeps, evenly spaced along the trajectory
  std::vector<std::string> removed;      // actors
  std::map<std::string, Eigen::Vector3d> moved;    // actors, (forward, left, up) m in their own frame
  std::map<std::string, double> turned_deg;        // actors, degrees to their left
  std::map<std::string, Eigen::Vector2d> retimed;  // actors, (rate, delay in s)

  /// Returns the edits of actors, in the order of the command line.
  [[nodiscard]] std::vector<ActorEdit> edits() const;
  /// Whether the view has the recorded pose and content.
  [[nodiscard]] bool is_as_recorded() const;
};

/// Throws Error{kInput} for invalid syntax, missing or unknown keys, and numbers out of range.
[[nodiscard]] ViewRequest parse_view_request(const std::string& json);

}  // namespace simuli::cli
