#include <cmath>
#include <fmt/format.h>
#include <numbers>

#include "host/core/base/error.hpp"
#include "io/base/file.hpp"
#include "io/base/json_reader.hpp"
#include "io/import/kitti/kitti_parts.hpp"

namespace simuli::kitti {
namespace {

namespace fs = std::filesystem;

constexpr double kRadPerDeg = std::numbers::pi / 180.0;

GeodeticPose read_record(const fs::path& file) {
  constexpr std::size_t kFields = 30;
  const std::vector<double> v = parse_numbers(read_file(file, 1U << 16U), kFields, file, "record");
  const auto require = [&](const char* field, double value, double limit) {
    if (!(std::abs(value) <= limit)) {
      throw_input_error(
          file.string(), field, fmt::format("{}", value), fmt::format("{} to {}", -limit, limit));
    }
  };
  require("lat (deg)", v[0], 90.0);
  require("lon (deg)", v[1], 180.0);
  require("alt (m)", v[2], 1e5);
  require("roll (rad)", v[3], 2.0 * std::numbers::pi);
  require("pitch (rad)", v[4], std::numbers::pi);
  require("yaw (rad)", v[5], 2.0 * std::numbers::pi);
  return {v[0] * kRadPerDeg, v[1] * kRadPerDeg, v[2], v[3], v[4], v[5]};
}

/// Returns world_from_velo of one entry of a pose file.
Pose read_world_from_velo(JsonObject& object) {
  const std::string key = "world_from_velo";
  const auto refuse = [&](const std::string& found) {
    throw_input_error(object.file(), object.field(key), found, "a rigid 4x4 matrix of 4 rows of 4 numbers");
  };
  Eigen::Matrix4d m;
  const Json& rows = object.get(key);
  if (!rows.is_array() || rows.size() != 4) refuse("another shape");
  for (std::size_t r = 0; r < 4; ++r) {
    if (!rows[r].is_array() || rows[r].size() != 4) refuse("another shape");
    for (std::size_t c = 0; c < 4; ++c) {
      if (!rows[r][c].is_number()) refuse("an entry that is no number");
      m(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(c)) = rows[r][c].get<double>();
    }
  }
  constexpr double kTolerance = 1e-4;  // such files print 6 to 9 digits
  const Eigen::Matrix3d rotation = m.topLeftCorner<3, 3>();
  const double off = (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  const bool rigid = off <= kTolerance && rotation.determinant() > 0.0 &&
                     (m.row(3) - Eigen::RowVector4d(0.0, 0.0, 0.0, 1.0)).cwiseAbs().maxCoeff() <= kTolerance;
  if (!rigid) refuse("a matrix that is not rigid");
  return Pose::from_matrix(m.topRows<3>());
}

}  // namespace

Pose ecef_from_imu(const GeodeticPose& pose) {
  constexpr double kEquator_m = 6378137.0;  // WGS 84
  constexpr double kFlattening = 1.0 / 298.257223563;
  constexpr double kEccentricity2 = kFlattening * (2.0 - kFlattening);
  const double sin_lat = std::sin(pose.latitude_rad);
  const double cos_lat = std::cos(pose.latitude_rad);
  const double sin_lon = std::sin(pose.longitude_rad);
  const double cos_lon = std::cos(pose.longitude_rad);
  const double normal_m = kEquator_m / std::sqrt(1.0 - kEccentricity2 * sin_lat * sin_lat);
  Eigen::Matrix3d ecef_from_enu;
  ecef_from_enu << -sin_lon, -sin_lat * cos_lon, cos_lat * cos_lon,  //
      cos_lon, -sin_lat * sin_lon, cos_lat * sin_lon,                //
      0.0, cos_lat, sin_lat;
  Pose out;
  out.translation = {(normal_m + pose.altitude_m) * cos_lat * cos_lon,
                     (normal_m + pose.altitude_m) * cos_lat * sin_lon,
                     (normal_m * (1.0 - kEccentricity2) + pose.altitude_m) * sin_lat};
  out.rotation = Eigen::Quaterniond(ecef_from_enu) *
                 Eigen::AngleAxisd(pose.yaw_rad, Eigen::Vector3d::UnitZ()) *
                 Eigen::AngleAxisd(pose.pitch_rad, Eigen::Vector3d::UnitY()) *
                 Eigen::AngleAxisd(pose.roll_rad, Eigen::Vector3d::UnitX());
  return out;
}

Trajectory read_oxts(const fs::path& drive,
                     const Frames& frames,
                     const Frames& beside,
                     const Pose& velo_from_imu,
                     std::int64_t start_ns,
                     std::vector<std::size_t>& absent,
                     std::vector<std::size_t>& disordered) {
  const fs::path times_file = drive / "oxts" / "timestamps.txt";
  std::vector<std::optional<std::int64_t>> times_ns = read_lines_ns(times_file);
  if (times_ns.size() <= frames.last) {
    throw_input_error(times_file.string(),
                      "lines",
                      fmt::format("{}", times_ns.size()),
                      fmt::format("at least {}, one per frame", frames.last + 1));
  }
  for (const std::size_t i : take_disordered(times_ns)) {
    if (frames.has(i)) disordered.push_back(i);
  }
  const Pose imu_from_velo = velo_from_imu.inverse();
  std::vector<TimedPose> poses;
  Pose world_from_ecef;
  for (std::size_t i = beside.first; i < times_ns.size() && i <= beside.last; ++i) {
    const fs::path record = drive / "oxts" / "data" / fmt::format("{:010}.txt", i);
    // Records around the frames only extend the trajectory; it ends at the first missing one.
    std::error_code failed;
    const bool is_record = fs::exists(record, failed);
    if (!frames.has(i) && !is_record) {
      if (i > frames.last) break;
      poses.clear();
      continue;
    }
    if (!is_record) absent.push_back(i);
    if (!is_record || !times_ns[i]) continue;  // lost; the trajectory is interpolated
    const Pose ecef_from_velo = ecef_from_imu(read_record(record)) * imu_from_velo;
    if (poses.empty()) world_from_ecef = ecef_from_velo.inverse();
    poses.push_back({static_cast<double>(*times_ns[i] - start_ns) * 1e-9, world_from_ecef * ecef_from_velo});
  }
  if (poses.empty()) {
    throw_input_error((drive / "oxts" / "data").string(),
                      "records",
                      fmt::format("none of {} to {}", frames.first, frames.last),
                      "at least one NNNNNNNNNN.txt with a time");
  }
  return with_context("reading " + times_file.string(), [&] { return Trajectory(std::move(poses)); });
}

Trajectory read_pose_file(const fs::path& file,
                          const std::vector<std::int64_t>& forward_ns,
                          std::int64_t start_ns,
                          const Frames& frames) {
  constexpr std::int64_t kDay_ns = 86'400'000'000'000;
  // smaller than that of a pose file of another drive
  constexpr std::int64_t kLargestMismatch_ns = 1'000'000'000;
  const auto entries = read_json_text(read_file(file), file.string(), [&](JsonObject& root) {
    root.ignore_other_keys();
    return root.objects("frames", [&](JsonObject& frame) {
      frame.ignore_other_keys();
      const std::int64_t last = static_cast<std::int64_t>(forward_ns.size()) - 1;
      const auto index = static_cast<std::size_t>(frame.integer("index", 0, last));
      const double of_day_s = frame.number("t_sweep_forward", 0.0, 86400.0);
      const std::int64_t midnight_ns = forward_ns[index] - (forward_ns[index] % kDay_ns + kDay_ns) % kDay_ns;
      const std::int64_t time_ns = midnight_ns + static_cast<std::int64_t>(std::llround(of_day_s * 1e9));
      if (std::abs(time_ns - forward_ns[index]) > kLargestMismatch_ns) {
        throw_input_error(file.string(),
                          frame.field("t_sweep_forward"),
                          fmt::format("{} s of the day", of_day_s),
                          fmt::format("{} s within 1 s, the recorded time of sweep {}",
                                      static_cast<double>(forward_ns[index] - midnight_ns) * 1e-9,
                                      index));
      }
      return std::pair(
          index, TimedPose{static_cast<double>(time_ns - start_ns) * 1e-9, read_world_from_velo(frame)});
    });
  });
  std::vector<TimedPose> poses;
  for (const auto& [index, pose] : entries) {
    if (frames.has(index)) poses.push_back(pose);
  }
  if (poses.empty()) {
    throw_input_error(file.string(),
                      "frames",
                      fmt::format("no pose of frames {} to {}", frames.first, frames.last),
                      "at least one");
  }
  return with_context("reading " + file.string(), [&] { return Trajectory(std::move(poses)); });
}

}  // namespace simuli::kitti
