#pragma once
// A picture with brightness gradients, and its camera under a mounting.
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <ceres/cubic_interpolation.h>
#include <cmath>

#include "optim/calibration/camera/camera_residual.hpp"
#include "optim/calibration/camera/camera_texture.hpp"

namespace simuli::calibration {

/// A picture interpolated between pixels.
class SmoothPicture {
 public:
  SmoothPicture(const Luminance& picture, double blur_px)
      : blurred_(picture.blurred(blur_px)),
        grid_(blurred_.data(), 0, blurred_.height(), 0, blurred_.width()),
        cubic_(grid_),
        all_open_(blurred_.all_open()) {}
  SmoothPicture(const SmoothPicture&) = delete;  // cubic_ points at grid_
  SmoothPicture& operator=(const SmoothPicture&) = delete;

  /// Whether no masked pixel affects at(), here and within 3 px.
  [[nodiscard]] bool is_open(const Eigen::Vector2d& pixel) const {
    if (all_open_) return true;
    // A masked pixel affects at least 7 px: testing the centre and four points finds it.
    constexpr double kFurther_px = 3.0;
    Eigen::Vector2d unused;
    double sum = at(pixel, unused);
    for (const double dx : {-kFurther_px, kFurther_px}) {
      for (const double dy : {-kFurther_px, kFurther_px}) sum += at(pixel + Eigen::Vector2d(dx, dy), unused);
    }
    return !std::isnan(sum);
  }
  [[nodiscard]] double at(const Eigen::Vector2d& pixel, Eigen::Vector2d& gradient) const {
    double value = 0.0;
    cubic_.Evaluate(pixel.y() - 0.5, pixel.x() - 0.5, &value, &gradient[1], &gradient[0]);
    return value;
  }

 private:
  using Grid = ceres::Grid2D<float, 1>;
  Luminance blurred_;
  Grid grid_;
  ceres::BiCubicInterpolator<Grid> cubic_;
  bool all_open_;
};

inline Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d out;
  out << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return out;
}

inline Eigen::Vector3d rotation_vector(const Eigen::Quaterniond& rotation) {
  const double sign = rotation.w() < 0.0 ? -1.0 : 1.0;
  const Eigen::Vector3d half = sign * rotation.vec();
  const double sine = half.norm();
  return sine > 0.0 ? Eigen::Vector3d(2.0 * std::atan2(sine, sign * rotation.w()) / sine * half)
                    : Eigen::Vector3d::Zero();
}

/// The rig's poses under one mounting; computed once for a global shutter.
class PlacedView {
 public:
  PlacedView(const CameraView& view, const Trajectory& path, const Mounting& mounting)
      : view_(view), path_(path), mounting_(mounting), middle_(at(0.5)) {}

  [[nodiscard]] CameraPoint see(const Camera& camera, const Eigen::Vector3d& p_world) const {
    if (view_.exposure_end_s == view_.exposure_start_s) return middle_.see(p_world);
    // Rolling-shutter rows have their own times: two iterations suffice for 20 ms.
    CameraPoint point = middle_.see(p_world);
    for (int k = 0; k < 2; ++k) {
      Eigen::Vector2d pixel;
      if (!camera.project(point.position, pixel)) return point;
      point = at(std::clamp(camera.exposure_fraction(pixel), 0.0, 1.0)).see(p_world);
    }
    return point;
  }
  [[nodiscard]] Eigen::Vector3d centre() const { return middle_.world_from_camera.translation; }

 private:
  struct Moment {
    Pose world_from_camera;
    Pose camera_from_world;
    Pose camera_from_world_later;
    static constexpr double kLater_s = 1e-4;

    [[nodiscard]] CameraPoint see(const Eigen::Vector3d& p_world) const {
      CameraPoint out;
      out.position = camera_from_world * p_world;
      out.slope.leftCols<3>() = -Eigen::Matrix3d::Identity();
      out.slope.middleCols<3>(3) = cross_matrix(out.position);
      out.slope.col(6) = (camera_from_world_later * p_world - out.position) / kLater_s;
      return out;
    }
  };
  [[nodiscard]] Moment at(double fraction) const {
    const double time_s = view_.exposure_start_s +
                          fraction * (view_.exposure_end_s - view_.exposure_start_s) +
                          mounting_.time_offset_s;
    const Pose here = pose_near(path_, time_s) * mounting_.rig_from_camera;
    const Pose later = pose_near(path_, time_s + Moment::kLater_s) * mounting_.rig_from_camera;
    return {here, here.inverse(), later.inverse()};
  }
  friend CameraPoint simuli::calibration::camera_point(const Trajectory&,
                                                       const Mounting&,
                                                       double,
                                                       const Eigen::Vector3d&);

  const CameraView& view_;
  const Trajectory& path_;
  const Mounting& mounting_;
  Moment middle_;
};

}  // namespace simuli::calibration
