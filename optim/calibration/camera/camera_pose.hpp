#pragma once
// Where a camera sits on the rig, and by how much its clock is off: from depth edges of the LiDAR that must
// lie on edges of the pictures, then from the texture that both sensors see. The path of the rig and the
// lens are given.
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

/// What the LiDAR saw over the log, by time.
struct LidarScene {
  std::vector<DepthEdge> edges;
  std::vector<SurfacePoint> surfaces;
  double spacing_rad = 0.0;  // between neighbouring beams, median
};
/// The spacing of a sensor's rows, or of its columns where it has one row.
[[nodiscard]] double beam_spacing(const Lidar& lidar);

// What a mounting is good for: 3 cm at 10 m.
inline constexpr double kWorstTranslation_m = 0.03;
inline constexpr double kWorstRotation_rad = 0.2 * std::numbers::pi / 180.0;

struct CameraPoseOptions {
  double widest_search = 0.06;   // of the focal length: 3.4 degrees
  int rounds = 14;               // of finding edges and solving
  double least_strength = 0.01;  // luminance per pixel
  double sweeps_about_s = 0.16;  // edges of sweeps this near in time to a picture are looked for in it
  bool with_clock = true;        // else the pictures' times are right
};

struct CameraPoseReport {
  Pose rig_from_camera;
  double time_offset_s = 0.0;  // to be added to the pictures' times
  /// Standard deviations: translation along x, y, z of the camera (m), turn about them (rad), clock (s).
  Eigen::Vector3d translation_sigma_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d rotation_sigma_rad = Eigen::Vector3d::Zero();
  double time_sigma_s = 0.0;
  Eigen::Vector3d translation_change_m = Eigen::Vector3d::Zero();  // camera frame, from the value given
  double rotation_change_rad = 0.0;
  /// Where there are pictures enough, by how much a half of the drive puts it elsewhere than the other does,
  /// along and about the camera's axes; no standard deviation above is less than half of it.
  std::optional<Eigen::Vector3d> halves_apart_m, halves_apart_rad;
  bool time_known = false;
  bool as_given = false;   // by settle(): the changes above tell what was found, the mounting is that given
  std::size_t pieces = 0;  // flat pieces with a texture that both show, each in each picture; 0: none
  std::size_t texture_points = 0;  // returns on them
  double texture_before = 0.0;     // median correlation on them, as depth edges put the camera ...
  double texture_after = 0.0;      // ... and at the end
  std::size_t edges = 0;           // depth edges in view
  std::size_t matched = 0;         // of them, found in the pictures at the end
  double outlier_share = 0.0;      // of the matched, farther than 3 sigma
  double before_px = 0.0;          // median distance of matched edges, with the values given ...
  double after_px = 0.0;           // ... and with those found
  std::vector<std::string> notes;  // what is not determined, and why
};

/// Throws Error{kNumeric} with the reason where the data cannot tell the mounting: too few edges in view (a
/// blank wall), or a direction in which neither edges nor texture hold the camera. A clock that cannot be
/// told apart from the mounting (a straight drive at constant speed) stays as it is, noted.
[[nodiscard]] CameraPoseReport find_camera_pose(
    const std::vector<CameraView>& views,
    const LogCamera& camera,
    const Trajectory& world_from_rig,
    const LidarScene& scene,
    const CameraPoseOptions& options = {},
    const std::function<void(std::size_t, std::size_t)>& progress = {});

/// Mean distance of depth edges in view from the pictures' nearest, px, of each at most kFarEdge_px: under each
/// of two mountings of the camera. Errors as find_camera_pose().
inline constexpr double kFarEdge_px = 3.0;
[[nodiscard]] std::array<double, 2> edges_apart_px(const std::vector<CameraView>& views,
                                                   const LogCamera& camera,
                                                   const std::array<Mounting, 2>& mountings,
                                                   const Trajectory& world_from_rig,
                                                   const LidarScene& scene,
                                                   const CameraPoseOptions& options = {});

/// Error{kNumeric} unless pictures that `whose` estimate has not seen are nearer to what the LiDAR saw with what it
/// found than with what was given: their edges to depth edges and, where it tells, their texture to the returns'.
void need_better(const std::vector<CameraView>& views,
                 const LogCamera& given,
                 const Mounting& found,
                 const std::string& whose,
                 const Trajectory& world_from_rig,
                 const LidarScene& scene,
                 const CameraPoseOptions& options = {});

/// A mounting that was given right is moved neither by noise nor to where its pictures fit less well: where the
/// report's mounting and clock are within two of its standard deviations of what was given that is taken
/// instead. Error{kNumeric} where a standard deviation is above the worst that a mounting is good for, or where
/// depth edges lie farther from the pictures' than with what was given.
void settle(const LogCamera& given, CameraPoseReport& report);

/// Reads the pictures (at most `most_views`, evenly taken) and the sweeps of a log; what the camera's masks
/// hide of the pictures is left out. Both halves of the drive are asked by themselves, too: Error{kNumeric}
/// where they disagree, and for a mounting that is not as given where the pictures are too few for it, or where
/// the other half's do not need_better(). Then settle(). Error{kInput} for a picture of another size than the camera's.
[[nodiscard]] CameraPoseReport find_camera_pose(
    const Log& log,
    const std::string& camera,
    const std::string& lidar,
    const Trajectory& world_from_rig,
    std::size_t most_views = 60,
    const CameraPoseOptions& options = {},
    const std::function<void(std::size_t, std::size_t)>& progress = {});

}  // namespace simuli::calibration
