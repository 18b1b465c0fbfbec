#pragma once
// The street from a rig that brakes, accelerates and turns, so that calibration is determined.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "io/synth/street.hpp"
#include "optim/calibration/path/returns.hpp"

namespace simuli::test {

/// The speed varies about the mean by `swing` of it with a period of 1.6 s; the rig yaws and pitches.
inline Pose drive_pose(double time_s, double speed_m_per_s, double swing) {
  const double w = 2.0 * std::numbers::pi / 1.6;
  const double x = 4.0 + speed_m_per_s * (time_s - swing * (std::cos(w * time_s) - 1.0) / w);
  const double y = -1.75 + 0.4 * std::sin(0.3 * x);
  const double heading = std::atan(0.4 * 0.3 * std::cos(0.3 * x));
  const double pitch = 0.008 * std::sin(0.9 * x);
  const double roll = 0.008 * std::sin(0.6 * x + 1.0);
  return {Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitZ()) *
              Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) *
              Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX()),
          {x, y, 0.0}};
}

struct StreetDrive {
  Street street{{.car = std::nullopt}};
  Log log;  // sensors, frames and the true trajectory, without files

  StreetDrive(int frames, double speed_m_per_s, double swing, int width = 320) {
    StreetOptions options;
    options.output = "not written";
    options.frames = frames;
    options.image_width = width;
    options.image_height = width * 9 / 16;
    options.moving_car = false;
    options.speed_m_per_s = speed_m_per_s;
    log = street_log(options);
    std::vector<TimedPose> poses;
    for (int i = -20; i <= 10 * frames + 20; ++i) {
      poses.push_back({0.01 * i, drive_pose(0.01 * i, speed_m_per_s, swing)});
    }
    log.world_from_rig = Trajectory(std::move(poses));
  }

  [[nodiscard]] Sweep sweep(std::size_t i) const {
    const SweepFrame& frame = log.sweeps[i];
    return scan_street(street, log.lidars[0], log.world_from_rig, frame.time_start_s, frame.time_end_s);
  }
  [[nodiscard]] std::vector<calibration::Returns> returns(bool reversed = false) const {
    std::vector<calibration::Returns> out;
    for (std::size_t i = 0; i < log.sweeps.size(); ++i) {
      const SweepFrame& frame = log.sweeps[i];
      out.push_back(
          calibration::returns_of(sweep(i), log.lidars[0], frame.time_start_s, frame.time_end_s, reversed));
    }
    return out;
  }
};

}  // namespace simuli::test
