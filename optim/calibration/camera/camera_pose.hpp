#pragma once
// Estimates the mounting of a camera on the rig and its clock offset: LiDAR depth edges must match picture
// edges, then textures seen by both sensors. The rig's trajectory and the lens are given.
#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <functional>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "io/log/log.hpp"
#include "optim/calibration/camera/camera_edges.hpp"
#include "optim/calibration/camera/camera_texture.hpp"

namespace simuli::calibration {

/// The LiDAR's observations over the log, by time.
struct LidarScene {
  std::vector<DepthEdge> edges;
  std::vector<SurfacePoint> surfaces;
  double spacing_rad = 0.0;  // between neighbouring beams, median
};
/// The spacing of a sensor's rows, or of its columns if it has one row.
[[nodiscard]] double beam_spacing(const Lidar& lidar);

// Largest accepted errors: 3 cm at 10 m.
inline constexpr double kWorstTranslation_m = 0.03;
inline constexpr double kWorstRotation_rad = 0.2 * std::numbers::pi / 180.0;

struct CameraPoseOptions {
  double widest_search = 0.06;   // of the focal length: 3.4 degrees
  int rounds = 14;  // of edge search and solving
  double least_strength = 0.01;  // luminance per pixel
  double sweeps_about_s = 0.16;  // a picture uses edges of sweeps within this time
  bool with_clock = true;  // estimate the clock offset
};

struct CameraPoseReport {
  Pose rig_from_camera;
  double time_offset_s = 0.0;  // to add to the pictures' times
  /// Standard deviations: translation along x, y, z of the camera (m), rotation about them (rad), clock (s).
  Eigen::Vector3d translation_sigma_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d rotation_sigma_rad = Eigen::Vector3d::Zero();
  double time_sigma_s = 0.0;
  Eigen::Vector3d translation_change_m = Eigen::Vector3d::Zero();  // camera frame, relative to the given mounting
  double rotation_change_rad = 0.0;
  /// With enough pictures: difference between the results of the two halves of the drive, along and about the
  /// camera's axes; standard deviations are at least half of it.
  std::optional<Eigen::Vector3d> halves_apart_m, halves_apart_rad;
  bool time_known = false;
  bool as_given = false;  // set by settle(): the given mounting is kept; the changes above are those found
  std::size_t pieces = 0;  // flat textured pieces seen by both sensors, counted per picture; 0: none
  std::size_t texture_points = 0;  // returns on them
  double texture_before = 0.0;  // median correlation on them, for the edge solution ...
  double texture_after = 0.0;      // ... and at the end
  std::size_t edges = 0;           // depth edges in view
  std::size_t matched = 0;         // of them, found in the pictures at the end
  double outlier_share = 0.0;  // of the matched edges, beyond 3 sigma
  double before_px = 0.0;  // median distance of matched edges, with the given values ...
  double after_px = 0.0;  // ... and with the estimated ones
  std::vector<std::string> notes;  // undetermined parameters, with reasons
};

/// Throws Error{kNumeric} with the reason when the data do not determine the mounting: too few edges in view (a
/// blank wall), or a direction constrained by neither edges nor texture. A clock offset that is not separable
/// from the mounting (a straight drive at constant speed) stays unchanged, with a note.
[[nodiscard]] CameraPoseReport find_camera_pose(
    const std::vector<CameraView>& views,
    const LogCamera& camera,
    const Trajectory& world_from_rig,
    const LidarScene& scene,
    const CameraPoseOptions& options = {},
    const std::function<void(std::size_t, std::size_t)>& progress = {});

/// Returns the mean distance of depth edges in view to the nearest picture edges, px, each at most kFarEdge_px,
/// under each of two mountings. Throws as find_camera_pose().
inline constexpr double kFarEdge_px = 3.0;
[[nodiscard]] std::array<double, 2> edges_apart_px(const std::vector<CameraView>& views,
                                                   const LogCamera& camera,
                                                   const std::array<Mounting, 2>& mountings,
                                                   const Trajectory& world_from_rig,
                                                   const LidarScene& scene,
                                                   const CameraPoseOptions& options = {});

/// Throws Error{kNumeric} unless pictures not used by `whose` estimate agree better with the LiDAR under its
/// result than under the given mounting: their edges with depth edges and, where available, their texture with
/// the returns'.
void need_better(const std::vector<CameraView>& views,
                 const LogCamera& given,
                 const Mounting& found,
                 const std::string& whose,
                 const Trajectory& world_from_rig,
                 const LidarScene& scene,
                 const CameraPoseOptions& options = {});

/// Protects a correct given mounting from noise: if the result and clock are within two standard deviations of
/// the given values, these are kept. Throws Error{kNumeric} when a standard deviation exceeds the largest
/// accepted error, or when depth edges fit worse than with the given values.
void settle(const LogCamera& given, CameraPoseReport& report);

/// Reads the pictures (at most `most_views`, evenly) and sweeps of a log; masked pixels are ignored. Also
/// estimates both halves of the drive separately: throws Error{kNumeric} when they disagree, and for a changed
/// mounting when there are too few pictures for this test, or when the other half does not pass need_better().
/// Then calls settle(). Throws Error{kInput} for a picture of another size than the camera's.
[[nodiscard]] CameraPoseReport find_camera_pose(
    const Log& log,
    const std::string& camera,
    const std::string& lidar,
    const Trajectory& world_from_rig,
    std::size_t most_views = 60,
    const CameraPoseOptions& options = {},
    const std::function<void(std::size_t, std::size_t)>& progress = {});

}  // namespace simuli::calibration
