#pragma once
// A small synthetic KITTI raw drive: a room around the car, measured by every fourth beam except in a sector.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <numbers>
#include <string>
#include <vector>

#include "host/core/sensors/lidar.hpp"
#include "io/picture/image.hpp"
#include "tests/io/scratch.hpp"

namespace simuli::test {

class KittiFolder {
 public:
  static constexpr int kFrames = 3;
  static constexpr int kFirings = 2150;
  static constexpr int kBeamStep = 4;
  /// Beams have no return for azimuths in [first, last).
  static constexpr double kSilentFirst_rad = 0.5;
  static constexpr double kSilentLast_rad = 0.8;

  explicit KittiFolder(const Scratch& scratch)
      : date_(scratch / "2011_09_26"), drive_(date_ / "2011_09_26_drive_0001_sync") {
    write("calib_cam_to_cam.txt",
          "calib_time: 09-Jan-2012 13:57:47\nS_rect_02: 1.2e+01 8.0e+00\n"
          "R_rect_00: 1 0 0 0 1 0 0 0 1\nP_rect_02: 10 0 6 0.5 0 10 4 0 0 0 1 0\n");
    write("calib_velo_to_cam.txt", "R: 0 -1 0 0 0 -1 1 0 0\nT: 0 -0.1 -0.3\n");
    write("calib_imu_to_velo.txt", "R: 1 0 0 0 1 0 0 0 1\nT: -0.8 0.3 -0.8\n");
    const auto times = [&](double offset_s) {
      std::string text;
      for (int i = 0; i < kFrames; ++i) {
        text += fmt::format("2011-09-26 23:59:59.{:09}\n", static_cast<int>(1e9 * (offset_s + 0.1 * i)));
      }
      return text;
    };
    write(name() + "/image_02/timestamps.txt", times(0.06));
    write(name() + "/velodyne_points/timestamps_start.txt", times(0.0));
    write(name() + "/velodyne_points/timestamps.txt", times(0.05));
    write(name() + "/velodyne_points/timestamps_end.txt", times(0.1));
    write(name() + "/oxts/timestamps.txt", times(0.055));
    for (int i = 0; i < kFrames; ++i) {
      write(name() + fmt::format("/oxts/data/{:010}.txt", i), oxts(8.4 + 1e-5 * i));
      write(sweep_name(i), sweep_bytes());
      std::filesystem::create_directories((date_ / image_name(i)).parent_path());
      Image image(12, 8, 3);
      image.at(i, 0, 0) = 1.0F;
      write_image(date_ / image_name(i), image);
    }
  }

  [[nodiscard]] const std::filesystem::path& drive() const { return drive_; }
  [[nodiscard]] std::filesystem::path operator/(const std::string& file) const { return date_ / file; }
  [[nodiscard]] static std::string name() { return "2011_09_26_drive_0001_sync"; }
  [[nodiscard]] static std::string image_name(int i) {
    return name() + fmt::format("/image_02/data/{:010}.png", i);
  }
  [[nodiscard]] static std::string sweep_name(int i) {
    return name() + fmt::format("/velodyne_points/data/{:010}.bin", i);
  }
  /// Replaces or creates a file in the folder of the date.
  void write(const std::string& file, const std::string& bytes) const {
    std::filesystem::create_directories((date_ / file).parent_path());
    std::ofstream(date_ / file, std::ios::binary) << bytes;
  }
  [[nodiscard]] static std::string oxts(double longitude_deg) {
    std::string text = fmt::format("49.0 {:.9f} 114.0 0.01 -0.02 0.3", longitude_deg);
    for (int i = 6; i < 30; ++i) text += " 0";
    return text + "\n";
  }

  /// Returns float32 x y z reflectance, ring by ring, top to bottom, each counter-clockwise from azimuth 0.
  [[nodiscard]] static std::string sweep_bytes() {
    const Lidar lidar = builtin_lidar("kitti_hdl64e");
    std::string bytes;
    for (int r = 0; r < lidar.row_count(); r += kBeamStep) {
      // Beams fire at different azimuths. 0 and 1 would be half-way between two columns.
      const double phase = 0.3 + 0.4 * r / lidar.row_count();
      for (int i = 0; i < kFirings; ++i) {
        const double azimuth = (i + phase) * 2.0 * std::numbers::pi / kFirings;
        if (azimuth >= kSilentFirst_rad && azimuth < kSilentLast_rad) continue;
        const double elevation = lidar.rows[static_cast<std::size_t>(r)].elevation;
        const Eigen::Vector3d p = lidar.origin(r, azimuth) + (8.0 + 3.0 * std::sin(5.0 * azimuth)) *
                                                                 Lidar::direction(azimuth, elevation);
        for (const double v : {p.x(), p.y(), p.z(), 0.25 + 0.5 * r / 64.0}) {
          const auto value = static_cast<float>(v);
          bytes.append(std::bit_cast<std::array<char, sizeof value>>(value).data(), sizeof value);
        }
      }
    }
    return bytes;
  }

 private:
  std::filesystem::path date_;
  std::filesystem::path drive_;
};

}  // namespace simuli::test
