#pragma once
// Estimates a camera's mounting and clock from textures seen by LiDAR intensity and pictures: paint on the
// road, joints and frames in walls. Every return is compared with its own position in the picture, so the beam
// spacing does not limit accuracy.
#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "host/core/sensors/camera.hpp"
#include "host/core/sensors/trajectory.hpp"
#include "optim/calibration/camera/luminance.hpp"
#include "optim/calibration/path/returns.hpp"

namespace simuli::calibration {

/// One picture with its exposure; exposure_end_s equals exposure_start_s for a global shutter.
struct CameraView {
  Luminance picture;
  double exposure_start_s = 0.0;
  double exposure_end_s = 0.0;
};

/// Unknowns: rig_from_camera, and the offset to add to the pictures' times.
struct Mounting {
  Pose rig_from_camera;
  double time_offset_s = 0.0;
};

/// Changes of a mounting: translation along x, y, z of the camera (m), rotation about them (rad), clock (s).
using MountingStep = Eigen::Matrix<double, 7, 1>;
using MountingMatrix = Eigen::Matrix<double, 7, 7>;
[[nodiscard]] Mounting moved(const Mounting& mounting, const MountingStep& step);
/// The step from `from` to `to`.
[[nodiscard]] MountingStep step_between(const Mounting& from, const Mounting& to);

/// A world point in the camera's frame at a time of its recorded clock, with derivatives by a MountingStep.
struct CameraPoint {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  // m
  Eigen::Matrix<double, 3, 7> slope = Eigen::Matrix<double, 3, 7>::Zero();
};
[[nodiscard]] CameraPoint camera_point(const Trajectory& world_from_rig,
                                       const Mounting& mounting,
                                       double recorded_s,
                                       const Eigen::Vector3d& p_world);

/// The trajectory's pose, clamped at its ends for trial clock offsets.
[[nodiscard]] Pose pose_near(const Trajectory& path, double time_s);

/// Returns in the world, motion-compensated, with their plane.
struct SurfacePoint {
  Eigen::Vector3d p_world = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  // unit, arbitrary sign; zero: no plane
  int plane = -1;  // index of a flat piece of up to 1 m
  float intensity = 0.0F;
  double time_s = 0.0;
};
/// Sorted by time.
[[nodiscard]] std::vector<SurfacePoint> surface_points(const std::vector<Returns>& sweeps,
                                                       const Trajectory& world_from_rig);

struct TextureFit {
  Mounting mounting;
  MountingMatrix covariance = MountingMatrix::Zero();
  std::size_t pieces = 0;  // flat pieces with agreement, counted per picture
  std::size_t points = 0;  // returns on them, in pictures
  double before = 0.0;  // median correlation of intensity and luminance on them, at `start` ...
  double after = 0.0;   // ... and at the end
};

/// Moves `start`, with `covariance` as a prior, to maximise agreement on flat pieces: luminance = b intensity,
/// b > 0, except for linear trends on the piece, with a separate b for each piece in each picture. spacing_rad:
/// between neighbouring beams, for occlusion. Without with_time the clock is fixed. The covariance accounts for
/// pieces shared by neighbouring pictures. pieces == 0: no usable texture, and the result is `start`.
[[nodiscard]] TextureFit fit_texture(const std::vector<CameraView>& views,
                                     const Camera& camera,
                                     const Trajectory& world_from_rig,
                                     const std::vector<SurfacePoint>& points,
                                     double spacing_rad,
                                     const Mounting& start,
                                     const MountingMatrix& covariance,
                                     bool with_time,
                                     const std::function<void(std::size_t, std::size_t)>& progress = {});

/// Mean correlation of intensity and luminance under each of two mountings, on the pieces that agree under
/// either; no value with too few pieces.
[[nodiscard]] std::optional<std::array<double, 2>> texture_of(const std::vector<CameraView>& views,
                                                              const Camera& camera,
                                                              const Trajectory& world_from_rig,
                                                              const std::vector<SurfacePoint>& points,
                                                              double spacing_rad,
                                                              const std::array<Mounting, 2>& mountings);

}  // namespace simuli::calibration
