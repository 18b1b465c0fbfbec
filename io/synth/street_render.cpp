// The synthetic street as seen by a camera and a LiDAR of a driving rig, written as a log folder.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <fmt/format.h>
#include <mutex>
#include <numbers>
#include <thread>
#include <utility>

#include "host/core/base/error.hpp"
#include "io/log/new_log.hpp"
#include "io/synth/street.hpp"
#include "io/synth/street_sensors.hpp"

namespace simuli {
namespace {

using Eigen::Vector3d;

constexpr double kSeeFar_m = 2e4;

constexpr double radians(double degrees) { return degrees * std::numbers::pi / 180.0; }

void check_options(const StreetOptions& o) {
  check_street(o.frames >= 1 && o.frames <= 10000, "--frames", o.frames, "1 to 10000");
  check_street(o.speed_m_per_s >= 0.0 && o.speed_m_per_s <= 50.0, "--speed", o.speed_m_per_s, "0 to 50");
  check_street_rig(o);
  const double driven_m = o.speed_m_per_s * kStreetFramePeriod_s * o.frames;
  check_street(driven_m <= Street::kLength_m, "--frames * --speed / 10", driven_m, "at most 260 m of street");
}

Trajectory drive(const StreetOptions& o) {
  std::vector<TimedPose> poses;
  const int per_frame = 10;  // kStreetFramePeriod_s / kStreetPosePeriod_s
  const Pose rig_from_shifted{Eigen::Quaterniond::Identity(), {0.0, o.lane_shift_m, 0.0}};
  for (int i = -kStreetPosesOutside; i <= o.frames * per_frame + kStreetPosesOutside; ++i) {
    const double time_s = i * kStreetPosePeriod_s;
    const double x = o.speed_m_per_s * time_s;
    const Pose sway = street_sway(x);
    const Pose world_from_rig{sway.rotation, {x, kStreetLane_m + sway.translation.y(), 0.0}};
    poses.push_back({time_s, world_from_rig * rig_from_shifted});
  }
  return Trajectory(std::move(poses));
}

/// Calls work(row) for every row on several threads. Rows write to separate memory, so the result does not
/// depend on the threads. Rethrows the first exception.
template <class Work>
void for_each_row(int rows, int threads, const Work& work) {
  const int cores = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  const int workers = std::min(rows, threads > 0 ? threads : cores);
  std::atomic<int> next{0};
  std::mutex failure_lock;
  std::exception_ptr failure;
  const auto run = [&] {
    try {
      for (int row = next++; row < rows; row = next++) work(row);
    } catch (...) {
      next = rows;
      const std::lock_guard<std::mutex> hold(failure_lock);
      if (!failure) failure = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> pool;
    for (int i = 1; i < workers; ++i) pool.emplace_back(run);
    run();
  }
  if (failure) std::rethrow_exception(failure);
}

}  // namespace

StreetContents StreetOptions::contents() const {
  return {.seed = seed,
          .car = moving_car ? std::optional(car) : std::nullopt,
          .walker = walking_person ? std::optional(walker) : std::nullopt,
          .detail = detail};
}

Pose street_sway(double driven_m) {
  const double phase = 2.0 * std::numbers::pi * driven_m / 45.0;
  const double sway_m = 0.3;
  const double heading = std::atan(sway_m * std::cos(phase) * 2.0 * std::numbers::pi / 45.0);
  const double pitch = radians(0.3) * std::sin(0.35 * driven_m);
  const double roll = radians(0.4) * std::sin(0.21 * driven_m + 1.0);
  const Eigen::Quaterniond rotation = Eigen::AngleAxisd(heading, Vector3d::UnitZ()) *
                                      Eigen::AngleAxisd(pitch, Vector3d::UnitY()) *
                                      Eigen::AngleAxisd(roll, Vector3d::UnitX());
  return {rotation, {0.0, sway_m * std::sin(phase), 0.0}};
}

LogCamera street_front_camera(int width, int height, bool rolling_shutter) {
  LogCamera camera;
  const double focal_px = 0.5 * width / std::tan(radians(40.0));  // 80 degrees wide
  camera.model = {"front",
                  width,
                  height,
                  focal_px,
                  focal_px,
                  0.5 * width,
                  0.5 * height,
                  rolling_shutter ? ShutterKind::kTopToBottom : ShutterKind::kGlobal};
  Eigen::Matrix<double, 3, 4> rig_from_camera;
  rig_from_camera << 0.0, 0.0, 1.0, 1.4,  // z forward is rig x
      -1.0, 0.0, 0.0, 0.05,               // x right is rig -y
      0.0, -1.0, 0.0, 1.5;                // y down is rig -z
  camera.rig_from_camera = Pose::from_matrix(rig_from_camera);
  return camera;
}

LogLidar street_top_lidar(int columns) {
  Lidar model;
  model.name = "top";
  model.columns = columns;
  model.azimuth_first =
      std::numbers::pi;  // clockwise from the back, so that the front is scanned at mid-sweep
  model.azimuth_span = 2.0 * std::numbers::pi;
  model.spin = SpinDirection::kClockwise;
  model.range_min = 0.9;
  model.range_max = 100.0;
  constexpr int kRows = 32;
  for (int r = 0; r < kRows; ++r) {
    LidarRow row;
    row.elevation = radians(5.0 - 30.0 * r / (kRows - 1));
    row.vertical_offset = 0.06 - 0.12 * r / (kRows - 1);  // the emitters span 12 cm vertically
    row.horizontal_offset = r % 2 == 0 ? 0.02 : -0.02;    // two columns of emitters
    row.azimuth_offset = r % 2 == 0 ? radians(0.5) : radians(-0.5);
    model.rows.push_back(row);
  }
  return {std::move(model), Pose{Eigen::Quaterniond::Identity(), {0.0, 0.0, 1.9}}};
}

Log street_log(const StreetOptions& options) {
  check_options(options);
  Log log;
  log.folder = options.output;
  log.name = "street";
  log.cameras.push_back(
      street_front_camera(options.image_width, options.image_height, options.rolling_shutter));
  log.lidars.push_back(street_top_lidar(options.lidar_columns));
  log.world_from_rig = drive(options);
  const double half_exposure_s = options.rolling_shutter ? 0.5 * kStreetReadOut_s : 0.0;
  for (int i = 0; i < options.frames; ++i) {
    const double start_s = i * kStreetFramePeriod_s;
    const double middle_s = start_s + 0.5 * kStreetFramePeriod_s;
    log.images.push_back({"front",
                          fmt::format("images/front_{:06d}.png", i),
                          middle_s - half_exposure_s,
                          middle_s + half_exposure_s});
    log.sweeps.push_back(
        {"top", fmt::format("sweeps/top_{:06d}.exr", i), start_s, (i + 1) * kStreetFramePeriod_s});
  }
  const double end_s = options.frames * kStreetFramePeriod_s;
  if (options.moving_car) log.actors.push_back(options.car.actor(0.0, end_s));
  if (options.walking_person) log.actors.push_back(options.walker.actor(0.0, end_s));
  return log;
}

Image render_street(const TracedWorld& street,
                    const LogCamera& camera,
                    const Trajectory& world_from_rig,
                    double time_start_s,
                    double time_end_s,
                    int threads) {
  constexpr int kSide = 2;  // samples per pixel and axis
  const Camera& model = camera.model;
  Image image(model.width, model.height, 3);
  for_each_row(model.height, threads, [&](int y) {
    for (int x = 0; x < model.width; ++x) {
      const double fraction = model.exposure_fraction({x + 0.5, y + 0.5});
      const double time_s = time_start_s + fraction * (time_end_s - time_start_s);
      const Pose world_from_camera = world_from_rig.at(time_s) * camera.rig_from_camera;
      Vector3d sum = Vector3d::Zero();
      int traced = 0;
      for (int sample = 0; sample < kSide * kSide; ++sample) {
        const double across = x + (sample % kSide + 0.5) / kSide;
        const double down = y + (sample / kSide + 0.5) / kSide;
        const Vector3d direction = world_from_camera.rotation * model.unproject({across, down});
        if (direction.isZero(0.0)) continue;  // outside the lens's domain
        sum += street.trace(world_from_camera.translation, direction.normalized(), time_s, kSeeFar_m).colour;
        ++traced;
      }
      for (int c = 0; c < 3; ++c) image.at(x, y, c) = static_cast<float>(sum[c] / std::max(traced, 1));
    }
  });
  return image;
}

Sweep scan_street(const TracedWorld& street,
                  const LogLidar& lidar,
                  const Trajectory& world_from_rig,
                  double time_start_s,
                  double time_end_s,
                  int threads) {
  const LidarModel& model = lidar.model;
  Sweep sweep;
  sweep.rays = nominal_rays(model);
  sweep.range.resize(ray_count(model));
  sweep.intensity.resize(ray_count(model));
  const int columns = sweep.rays.columns;
  for_each_row(sweep.rays.rows, threads, [&](int r) {
    for (int c = 0; c < columns; ++c) {
      // Uses the stored, rounded angles and time, so that the file's values are exact.
      const std::size_t i =
          static_cast<std::size_t>(r) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(c);
      const auto azimuth = static_cast<double>(sweep.rays.azimuth[i]);
      const auto elevation = static_cast<double>(sweep.rays.elevation[i]);
      const auto fraction = static_cast<double>(sweep.rays.time_fraction[i]);
      const double time_s = time_start_s + fraction * (time_end_s - time_start_s);
      const Pose world_from_lidar = world_from_rig.at(time_s) * lidar.rig_from_lidar;
      const Vector3d direction = world_from_lidar.rotation * Lidar::direction(azimuth, elevation);
      const StreetReturn back = street.lidar_return(world_from_lidar * ray_origin(model, sweep.rays, i),
                                                    direction.normalized(),
                                                    time_s,
                                                    range_min(model),
                                                    range_max(model));
      sweep.range[i] = static_cast<float>(back.range);
      sweep.intensity[i] = static_cast<float>(back.intensity);
    }
  });
  return sweep;
}

Log synth_street(const StreetOptions& options,
                 const std::function<void(std::size_t, std::size_t)>& progress) {
  Log log = street_log(options);
  const Street street(options.contents());
  const LogCamera& camera = log.cameras.front();
  const LogLidar& lidar = log.lidars.front();
  const Trajectory& path = log.world_from_rig;
  return make_log(options.output, log, [&] {
    for (std::size_t i = 0; i < log.images.size(); ++i) {
      const ImageFrame& image = log.images[i];
      write_image(log.folder / image.file,
                  render_street(street, camera, path, image.time_start_s, image.time_end_s, options.threads));
      const SweepFrame& sweep = log.sweeps[i];
      write_sweep(log.folder / sweep.file,
                  scan_street(street, lidar, path, sweep.time_start_s, sweep.time_end_s, options.threads));
      if (progress) progress(i + 1, log.images.size());
    }
  });
}

}  // namespace simuli
