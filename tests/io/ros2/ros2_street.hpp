#pragma once
// The street for recordings with ROS 2.
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <gtest/gtest.h>
#include <numbers>
#include <vector>

#include "io/import/ros2/ros2_log.hpp"
#include "io/synth/street.hpp"
#include "tests/io/scratch.hpp"

namespace simuli::test {

/// Coordinates are float32 (2e-6 m in the street), times of whole nanoseconds and float32 (1e-8 s).
inline constexpr double kStored_m = 1e-4;
inline constexpr double kStored_rad = 1e-5;
inline constexpr std::int64_t kStart_ns = 1'700'000'000'123'456'789;

inline Log street(const Scratch& scratch) {
  StreetOptions options;
  options.output = scratch / "street.log";
  options.frames = 3;
  options.image_width = 48;
  options.image_height = 27;
  options.lidar_columns = 180;
  return synth_street(options);
}

inline const Lidar& lidar_of(const Log& log) { return log.lidars.at(0).with_rows(); }

struct Point {
  Eigen::Vector3d p;
  double intensity, time_s;
  int row;
};

inline std::vector<Point> points_of(const Log& log, const SweepFrame& frame) {
  const Lidar& lidar = lidar_of(log);
  const Sweep sweep = read_sweep(log.folder / frame.file, lidar);
  std::vector<Point> points;
  for (std::size_t i = 0; i < sweep.range.size(); ++i) {
    if (sweep.range[i] == 0.0F) continue;
    const int row = static_cast<int>(i / static_cast<std::size_t>(lidar.columns));
    const double azimuth = sweep.rays.azimuth[i];
    points.push_back({lidar.origin(row, azimuth) +
                          double{sweep.range[i]} * Lidar::direction(azimuth, sweep.rays.elevation[i]),
                      sweep.intensity[i],
                      sweep.rays.time_fraction[i] * (frame.time_end_s - frame.time_start_s),
                      row});
  }
  return points;
}

inline Ros2Options options_for(const Log& log,
                               const std::filesystem::path& file,
                               const std::filesystem::path& output) {
  Ros2Options options;
  options.recording = file;
  options.output = output;
  options.lidars = {{"/top/points", lidar_of(log)}};
  return options;
}

inline Log imported(const Ros2Options& options, Ros2Report& report) {
  return import_ros2(options, {}, report);
}

inline void expect_same_sweeps(const Log& log, const Log& back) {
  ASSERT_EQ(back.sweeps.size(), log.sweeps.size());
  const Lidar& lidar = lidar_of(log);
  double range_off = 0.0, angle_off = 0.0, time_off = 0.0, intensity_off = 0.0;
  std::size_t returned = 0;
  for (std::size_t s = 0; s < log.sweeps.size(); ++s) {
    EXPECT_NEAR(back.sweeps[s].time_start_s - back.sweeps[0].time_start_s,
                log.sweeps[s].time_start_s - log.sweeps[0].time_start_s,
                1e-6);
    const Sweep a = read_sweep(log.folder / log.sweeps[s].file, lidar);
    const Sweep b = read_sweep(back.folder / back.sweeps[s].file, lidar_of(back));
    for (std::size_t i = 0; i < a.range.size(); ++i) {
      ASSERT_EQ(a.range[i] > 0.0F, b.range[i] > 0.0F) << "ray " << i;
      returned += a.range[i] > 0.0F ? 1 : 0;
      const auto off = [](float x, float y) { return std::abs(double{x} - double{y}); };
      range_off = std::max(range_off, off(a.range[i], b.range[i]));
      intensity_off = std::max(intensity_off, off(a.intensity[i], b.intensity[i]));
      const double turn =
          std::remainder(double{a.rays.azimuth[i]} - double{b.rays.azimuth[i]}, 2.0 * std::numbers::pi);
      angle_off = std::max({angle_off, std::abs(turn), off(a.rays.elevation[i], b.rays.elevation[i])});
      time_off = std::max(time_off, off(a.rays.time_fraction[i], b.rays.time_fraction[i]));
    }
  }
  EXPECT_GT(returned, 1000U);
  EXPECT_LT(range_off, kStored_m);
  EXPECT_LT(angle_off, kStored_rad);
  EXPECT_LT(time_off, 2e-5);         // of 0.1 s: 2e-6 s
  EXPECT_LT(intensity_off, 2.1e-3);  // half a step of 255
}

}  // namespace simuli::test
