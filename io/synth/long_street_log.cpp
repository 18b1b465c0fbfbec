// The long street as seen by the rig's sensors, written as a log folder.
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <numbers>
#include <utility>

#include "host/core/base/error.hpp"
#include "io/log/new_log.hpp"
#include "io/synth/long_street.hpp"
#include "io/synth/street_sensors.hpp"
#include "io/synth/street_world.hpp"

namespace simuli {
namespace {

using Eigen::Vector3d;

constexpr double kFastest_m_per_s = 50.0;

/// Returns the rig's speed, such that it has driven the length at the end of the last sweep.
double speed_of(const LongStreetOptions& o) { return o.length_m / (kStreetFramePeriod_s * o.frames); }

void check_long_options(const LongStreetOptions& o) {
  check_street(o.length_m >= 10.0 && o.length_m <= 1e5, "--length", o.length_m, "10 to 100000");
  check_street(o.frames >= 1 && o.frames <= 1'000'000, "--frames", o.frames, "1 to 1000000");
  check_street(
      speed_of(o) <= kFastest_m_per_s, "--length / (--frames / 10 s), m/s", speed_of(o), "at most 50");
  check_street(o.cameras >= 1 && o.cameras <= 4, "--cameras", o.cameras, "1 to 4");
  check_street(o.lidars >= 1 && o.lidars <= 3, "--lidars", o.lidars, "1 to 3");
  check_street_rig(o);
}

struct Mount {
  const char* name;
  double yaw_deg;
  Vector3d at_m;
  [[nodiscard]] Eigen::AngleAxisd yaw() const {
    return Eigen::AngleAxisd(yaw_deg * std::numbers::pi / 180.0, Vector3d::UnitZ());
  }
};

std::vector<LogCamera> cameras_of(const LongStreetOptions& o) {
  const std::array<Mount, 4> places{{{"front", 0.0, {1.4, 0.05, 1.5}},
                                     {"left", 65.0, {1.2, 0.5, 1.5}},
                                     {"right", -65.0, {1.2, -0.5, 1.5}},
                                     {"rear", 180.0, {-1.6, 0.0, 1.4}}}};
  std::vector<LogCamera> cameras;
  for (int i = 0; i < o.cameras; ++i) {
    const Mount& place = places[static_cast<std::size_t>(i)];
    LogCamera camera = street_front_camera(o.image_width, o.image_height, o.rolling_shutter);
    camera.model.name = place.name;
    camera.rig_from_camera = {(place.yaw() * camera.rig_from_camera.rotation).normalized(), place.at_m};
    cameras.push_back(std::move(camera));
  }
  return cameras;
}

std::vector<LogLidar> lidars_of(const LongStreetOptions& o) {
  const std::array<Mount, 3> places{{{"top", 0.0, {0.0, 0.0, 1.9}},
                                     {"front_low", 0.0, {2.0, 0.0, 0.6}},
                                     {"rear_low", 180.0, {-2.0, 0.0, 0.6}}}};
  std::vector<LogLidar> lidars;
  for (int i = 0; i < o.lidars; ++i) {
    const Mount& place = places[static_cast<std::size_t>(i)];
    LogLidar lidar = street_top_lidar(o.lidar_columns);
    std::visit([&](auto& model) { model.name = place.name; }, lidar.model);
    lidar.rig_from_lidar = {Eigen::Quaterniond(place.yaw()), place.at_m};
    lidars.push_back(std::move(lidar));
  }
  return lidars;
}

/// Returns the rig's pose on its lane at a time.
Pose rig_on(const LongStreet& street, const LongStreetOptions& o, double time_s) {
  const double driven_m = speed_of(o) * time_s;
  const Pose sway = street_sway(driven_m);
  const Pose road = street.world_from_street(driven_m, kStreetLane_m + sway.translation.y() + o.lane_shift_m);
  return {(road.rotation * sway.rotation).normalized(), road.translation};
}

/// Returns a car that drives from `start_m` at time 0 while it is on the street. Positive `lane_m`: oncoming.
Actor car_on(const LongStreet& street,
             const std::string& name,
             double start_m,
             double speed_m_per_s,
             double lane_m,
             double end_s,
             double length_m) {
  Actor car;
  car.name = name;
  car.kind = "car";
  car.size_m = {2.0 * kCarHalfLength_m, 2.0 * kCarHalfWidth_m, kCarHeight_m};
  const bool is_oncoming = lane_m > 0.0;
  const Eigen::AngleAxisd turned(is_oncoming ? std::numbers::pi : 0.0, Vector3d::UnitZ());
  const int keys = static_cast<int>(std::ceil(end_s / kStreetFramePeriod_s - 1e-9));
  for (int i = 0; i <= keys; ++i) {
    const double time_s = i * kStreetFramePeriod_s;
    const double s_m = start_m + (is_oncoming ? -speed_m_per_s : speed_m_per_s) * time_s;
    if (s_m < -LongStreet::kMargin_m || s_m > length_m + LongStreet::kMargin_m) {
      if (car.track.empty()) continue;
      break;
    }
    const Pose road = street.world_from_street(s_m, lane_m);
    car.track.push_back(
        {time_s, {(road.rotation * turned).normalized(), road * Vector3d(0.0, 0.0, 0.5 * kCarHeight_m)}});
  }
  return car;
}

/// Returns cars ahead in the rig's lane, which are not slower than the rig, and oncoming cars.
std::vector<Actor> traffic_on(const LongStreet& street, const LongStreetOptions& o) {
  std::vector<Actor> cars;
  if (!o.traffic) return cars;
  StreetDice dice(o.seed + 77);
  const double end_s = kStreetFramePeriod_s * o.frames, speed = speed_of(o);
  const auto add = [&](double start_m, double car_speed, double lane_m) {
    Actor car =
        car_on(street, fmt::format("car_{}", cars.size()), start_m, car_speed, lane_m, end_s, o.length_m);
    constexpr std::size_t kLeastKeys = 2;
    if (car.track.size() >= kLeastKeys) cars.push_back(std::move(car));
  };
  double ahead_m = 18.0, ahead_speed = speed;
  for (int i = 0; i < 3; ++i) {
    add(ahead_m, ahead_speed, kStreetLane_m);
    ahead_m += dice.between(22.0, 40.0);
    ahead_speed += dice.between(0.0, 0.04) * speed;
  }
  // Equal speeds, so that the rig meets oncoming cars throughout and they never collide.
  const double oncoming = dice.between(0.5, 0.9) * std::max(speed, 1.0);
  const double farthest_m = o.length_m + LongStreet::kMargin_m + oncoming * end_s;
  for (double start_m = 45.0; start_m < farthest_m; start_m += dice.between(60.0, 140.0)) {
    add(start_m, oncoming, -kStreetLane_m);
  }
  return cars;
}

Log log_on(const LongStreet& street, const LongStreetOptions& o) {
  Log log;
  log.folder = o.output;
  log.name = "long street";
  log.cameras = cameras_of(o);
  log.lidars = lidars_of(o);
  std::vector<TimedPose> poses;
  const int per_frame = 10;  // kStreetFramePeriod_s / kStreetPosePeriod_s
  for (int i = -kStreetPosesOutside; i <= o.frames * per_frame + kStreetPosesOutside; ++i) {
    const double time_s = i * kStreetPosePeriod_s;
    poses.push_back({time_s, rig_on(street, o, time_s)});
  }
  log.world_from_rig = Trajectory(std::move(poses));
  const double half_exposure_s = o.rolling_shutter ? 0.5 * kStreetReadOut_s : 0.0;
  for (int i = 0; i < o.frames; ++i) {
    const double start_s = i * kStreetFramePeriod_s, middle_s = start_s + 0.5 * kStreetFramePeriod_s;
    for (const LogCamera& camera : log.cameras) {
      log.images.push_back({camera.model.name,
                            fmt::format("images/{}_{:06d}.png", camera.model.name, i),
                            middle_s - half_exposure_s,
                            middle_s + half_exposure_s});
    }
    for (const LogLidar& lidar : log.lidars) {
      const std::string& name = name_of(lidar.model);
      log.sweeps.push_back(
          {name, fmt::format("sweeps/{}_{:06d}.exr", name, i), start_s, (i + 1) * kStreetFramePeriod_s});
    }
  }
  log.actors = traffic_on(street, o);
  return log;
}

}  // namespace

Log long_street_log(const LongStreetOptions& options) {
  check_long_options(options);
  return log_on(LongStreet(options.length_m, options.seed), options);
}

Log synth_long_street(const LongStreetOptions& options,
                      const std::function<void(std::size_t, std::size_t)>& progress) {
  check_long_options(options);
  LongStreet street(options.length_m, options.seed);
  Log log = log_on(street, options);
  street.set_traffic(log.actors);
  const Trajectory& path = log.world_from_rig;
  return make_log(options.output, log, [&] {
    for (int i = 0; i < options.frames; ++i) {
      const auto at = static_cast<std::size_t>(i);
      for (std::size_t c = 0; c < log.cameras.size(); ++c) {
        const ImageFrame& image = log.images[at * log.cameras.size() + c];
        write_image(log.folder / image.file,
                    render_street(
                        street, log.cameras[c], path, image.time_start_s, image.time_end_s, options.threads));
      }
      for (std::size_t l = 0; l < log.lidars.size(); ++l) {
        const SweepFrame& sweep = log.sweeps[at * log.lidars.size() + l];
        write_sweep(
            log.folder / sweep.file,
            scan_street(street, log.lidars[l], path, sweep.time_start_s, sweep.time_end_s, options.threads));
      }
      constexpr double kKept_m = 500.0;
      street.forget_beyond(speed_of(options) * kStreetFramePeriod_s * i, kKept_m);
      if (progress) progress(at + 1, static_cast<std::size_t>(options.frames));
    }
  });
}

}  // namespace simuli
