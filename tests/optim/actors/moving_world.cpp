#include "tests/optim/actors/moving_world.hpp"

#include <cmath>
#include <limits>

namespace simuli::test {
namespace {

using Eigen::Vector3d;

constexpr double kSensor_m = 1.8;
constexpr double kPeriod_s = 0.1;

/// Returns the distance at which a ray enters the box from (-x/2, -y/2, 0) to (x/2, y/2, z); infinite without
/// a hit.
double entry_m(const Vector3d& size, const Vector3d& origin, const Vector3d& direction) {
  double enter = 0.0, leave = std::numeric_limits<double>::infinity();
  for (Eigen::Index k = 0; k < 3; ++k) {
    const double low = k < 2 ? -0.5 * size(k) : 0.0, high = k < 2 ? 0.5 * size(k) : size(k);
    if (direction(k) == 0.0) {
      if (origin(k) < low || origin(k) > high) return std::numeric_limits<double>::infinity();
      continue;
    }
    const double a = (low - origin(k)) / direction(k), b = (high - origin(k)) / direction(k);
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return enter <= leave && enter > 0.0 ? enter : std::numeric_limits<double>::infinity();
}

std::vector<WorldBox> street() {
  std::vector<WorldBox> out;
  for (const double side : {-1.0, 1.0}) {
    for (int k = -3; k < 8; ++k) {
      const double x = 12.0 * k + (side > 0.0 ? 4.0 : 0.0);
      out.push_back(standing_box({11.0, 1.0, 6.0}, {x, side * (9.5 + 0.3 * (k % 3)), 0.0}));
      out.push_back(standing_box({0.3, 0.3, 5.0}, {x + 6.0, side * 7.0, 0.0}));
      if (k % 2 == 0) {
        const Pose parked{Eigen::Quaterniond::Identity(), {x + 2.0, side * 5.8, 0.0}};
        for (WorldBox& box : car([parked](double) { return parked; })) {
          box.drives = false;
          out.push_back(std::move(box));
        }
      }
    }
  }
  return out;
}

}  // namespace

WorldBox standing_box(const Vector3d& size_m, const Vector3d& base_m) {
  return {size_m, [base_m](double) { return Pose{Eigen::Quaterniond::Identity(), base_m}; }, false};
}

std::vector<WorldBox> car(const Motion2d& world_from_car) {
  const auto part = [&](const Vector3d& size, const Vector3d& base) {
    return WorldBox{size,
                    [world_from_car, base](double time_s) {
                      return world_from_car(time_s) * Pose{Eigen::Quaterniond::Identity(), base};
                    },
                    true};
  };
  return {part({4.2, 1.8, 0.7}, {0.0, 0.0, 0.25}),
          part({2.2, 1.6, 0.55}, {-0.4, 0.0, 0.95}),
          part({0.2, 2.0, 0.15}, {0.6, 0.0, 0.9})};
}

Actor label_of(const Vector3d& size_m, const Motion2d& world_from_body, double end_s) {
  Actor out;
  out.name = "label";
  out.kind = "car";
  out.size_m = size_m;
  for (int k = 0; 0.1 * k <= end_s + 1e-9; ++k) {
    const Pose pose =
        world_from_body(0.1 * k) * Pose{Eigen::Quaterniond::Identity(), {0.0, 0.0, 0.5 * size_m.z()}};
    out.track.push_back({0.1 * k, pose});
  }
  return out;
}

Log write_world(const MovingWorld& world, const std::filesystem::path& folder) {
  Log log;
  log.folder = folder;
  log.name = "world";
  Lidar lidar = builtin_lidar("generic64");
  lidar.columns = 720;
  log.lidars.push_back({lidar, {}});
  std::vector<TimedPose> path;
  for (int i = 0; i <= world.sweeps; ++i) {
    const double time_s = kPeriod_s * i;
    path.push_back(
        {time_s, {Eigen::Quaterniond::Identity(), {world.speed_m_per_s * time_s, 0.0, kSensor_m}}});
  }
  log.world_from_rig = Trajectory(path);
  std::vector<WorldBox> boxes = street();
  boxes.insert(boxes.end(), world.boxes.begin(), world.boxes.end());
  std::vector<Pose> standing;
  for (const WorldBox& box : boxes) standing.push_back(box.world_from_box(0.0));
  std::filesystem::create_directories(folder / "sweeps");
  for (int i = 0; i < world.sweeps; ++i) {
    const SweepFrame frame{
        lidar.name, "sweeps/" + std::to_string(i) + ".exr", kPeriod_s * i, kPeriod_s * (i + 1)};
    Sweep sweep{nominal_rays(lidar), {}, {}};
    for (std::size_t r = 0; r < sweep.rays.azimuth.size(); ++r) {
      const double time_s = kPeriod_s * (i + static_cast<double>(sweep.rays.time_fraction[r]));
      const std::size_t row = r / static_cast<std::size_t>(lidar.columns);
      const Pose world_from_lidar = log.world_from_rig.at(time_s);
      const Vector3d origin = world_from_lidar * lidar.origin(static_cast<int>(row), sweep.rays.azimuth[r]);
      const Vector3d direction = Lidar::direction(sweep.rays.azimuth[r], sweep.rays.elevation[r]);
      double range_m = direction.z() < 0.0 ? -origin.z() / direction.z() : lidar.range_max + 1.0;
      for (std::size_t b = 0; b < boxes.size(); ++b) {
        const Pose world_from_box = boxes[b].drives ? boxes[b].world_from_box(time_s) : standing[b];
        const Vector3d away = world_from_box.translation - origin;
        if ((away - away.dot(direction) * direction).norm() > boxes[b].size_m.norm()) continue;
        const Pose to_box = world_from_box.inverse();
        range_m = std::min(range_m, entry_m(boxes[b].size_m, to_box * origin, to_box.rotation * direction));
      }
      const bool returned = range_m >= lidar.range_min && range_m <= lidar.range_max;
      sweep.range.push_back(returned ? static_cast<float>(range_m) : 0.0F);
      sweep.intensity.push_back(returned ? 0.5F : 0.0F);
    }
    write_sweep(folder / frame.file, sweep);
    log.sweeps.push_back(frame);
  }
  write_log(log);
  return log;
}

}  // namespace simuli::test
