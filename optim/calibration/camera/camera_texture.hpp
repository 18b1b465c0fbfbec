#pragma once
// Where a camera sits and how its clock runs, from what the LiDAR's intensity and the pictures both show:
// paint on the road, joints and frames in walls. Every return is compared with the one place of the picture
// that it falls on, so that the distance between beams does not enter.
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

/// What is looked for: rig_from_camera, and what is to be added to the pictures' times.
struct Mounting {
  Pose rig_from_camera;
  double time_offset_s = 0.0;
};

/// Changes of a mounting: place along x, y, z of the camera (m), turn about them (rad), clock (s).
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

/// The path's pose at a time that a clock on trial may have put outside of it.
[[nodiscard]] Pose pose_near(const Trajectory& path, double time_s);

/// Returns in world, each moved by the path at its own time, with the plane that they lie on.
struct SurfacePoint {
  Eigen::Vector3d p_world = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  // unit, either side; zero: on no plane
  int plane = -1;                                    // number of a flat piece of up to 1 m
  float intensity = 0.0F;
  double time_s = 0.0;
};
/// By time.
[[nodiscard]] std::vector<SurfacePoint> surface_points(const std::vector<Returns>& sweeps,
                                                       const Trajectory& world_from_rig);

struct TextureFit {
  Mounting mounting;
  MountingMatrix covariance = MountingMatrix::Zero();
  std::size_t pieces = 0;  // flat pieces, each in each picture that sees it, on which both agree
  std::size_t points = 0;  // returns on them, in pictures
  double before = 0.0;  // median correlation of intensity and luminance on them, where `start` puts them ...
  double after = 0.0;   // ... and at the end
};

/// Moves `start`, which is believed as far as `covariance` says, to where flat pieces look alike: luminance =
/// b intensity, b > 0, but for what is linear along the piece, with a b for each piece in each picture.
/// spacing_rad: between neighbouring beams, for what hides what. Without with_time the clock stays. The
/// covariance takes neighbouring pictures for dependent on one another (they see the same pieces). pieces ==
/// 0: the pictures show nothing of it, and `start` is the answer.
[[nodiscard]] TextureFit fit_texture(const std::vector<CameraView>& views,
                                     const Camera& camera,
                                     const Trajectory& world_from_rig,
                                     const std::vector<SurfacePoint>& points,
                                     double spacing_rad,
                                     const Mounting& start,
                                     const MountingMatrix& covariance,
                                     bool with_time,
                                     const std::function<void(std::size_t, std::size_t)>& progress = {});

/// Mean correlation of intensity and luminance under each of two mountings, on the pieces on which they agree
/// under the one or the other; nothing where those are too few to tell.
[[nodiscard]] std::optional<std::array<double, 2>> texture_of(const std::vector<CameraView>& views,
                                                              const Camera& camera,
                                                              const Trajectory& world_from_rig,
                                                              const std::vector<SurfacePoint>& points,
                                                              double spacing_rad,
                                                              const std::array<Mounting, 2>& mountings);

}  // namespace simuli::calibration
