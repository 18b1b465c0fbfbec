#include "bench/paper/figure11.hpp"

#include <cmath>
#include <fmt/format.h>
#include <numbers>
#include <utility>

#include "bench/paper/drive_log.hpp"
#include "host/core/base/fields.hpp"
#include "io/synth/street.hpp"

namespace simuli::bench {
namespace {

namespace fs = std::filesystem;

/// Rotates the rig about its vertical axis to one side and back, half a second each: a constant rotation
/// would bend all pictures alike, and trainings would learn it as shape. The angular velocity changes between
/// frames and is constant within a frame.
Trajectory turning(const Trajectory& world_from_rig, double turn_rad_per_s) {
  constexpr double kPeriod_s = 1.0;
  std::vector<TimedPose> poses = world_from_rig.poses();
  for (TimedPose& p : poses) {
    const double from_middle_s = std::abs(std::remainder(p.time_s, kPeriod_s)) - 0.25 * kPeriod_s;
    const Eigen::AngleAxisd turn(turn_rad_per_s * from_middle_s, Eigen::Vector3d::UnitZ());
    p.pose.rotation = p.pose.rotation * turn;
  }
  return Trajectory(std::move(poses));
}

Drive record(const Figure11Options& options, const fs::path& folder) {
  StreetOptions street;
  street.output = folder;
  street.frames = options.frames;
  street.speed_m_per_s = options.speed_m_per_s;
  street.rolling_shutter = true;
  street.moving_car = false;  // the scene is static
  Log log = street_log(street);
  log.world_from_rig = turning(log.world_from_rig, options.turn_deg_per_s * std::numbers::pi / 180.0);
  write_frames(log, Street({.seed = street.seed, .car = std::nullopt}));
  return {"street", std::move(log), {"image_scale=1"}};
}

template <class Frame>
void hold_still(std::vector<Frame>& frames) {
  for (Frame& f : frames) f.time_start_s = f.time_end_s = 0.5 * (f.time_start_s + f.time_end_s);
}

/// Returns the log with instantaneous pictures.
Log still_pictures(Log log) {
  for (LogCamera& camera : log.cameras) camera.model.shutter = ShutterKind::kGlobal;
  hold_still(log.images);
  return log;
}

Log still_sweeps(Log log) {
  hold_still(log.sweeps);
  return log;
}

}  // namespace

std::vector<Row> run_figure11(const std::string& device_request,
                              const Figure11Options& options,
                              const Note& note) {
  const Device device = Device::best(device_request);
  note(fmt::format("device: {} (driver {})", device.info().label(), device.info().driver_version));
  const ScratchFolder scratch("simuli_bench");
  const Drive drive =
      options.log.empty() ? record(options, scratch.path()) : open_drive(options.log, scratch.path());
  const Log& log = drive.log;
  TrainingOptions training;
  // Path refinement has knots at the ends of sweeps, and frames without motion have zero duration.
  training.refine_path = false;
  training.train.iterations = options.iterations;
  training.train.render = paper_options();
  fields_of(training).apply(drive.settings, "settings");
  std::vector<Row> rows;
  const auto add = [&](const char* sensor, double modelled, double ignored, double rendered, double gained) {
    const char* unit = std::string(sensor) == "camera" ? "dB" : "cm";
    rows.push_back({fmt::format("figure11/{}/modelled", sensor), modelled, unit, 0.0});
    rows.push_back({fmt::format("figure11/{}/ignored", sensor), ignored, unit, 0.0});
    rows.push_back({fmt::format("figure11/{}/ignored_when_rendering", sensor), rendered, unit, 0.0});
    rows.push_back({fmt::format("figure11/{}/gained", sensor), gained, unit, 0.0});
    note(fmt::format("{} done", sensor));
  };
  const EvalOptions as_trained{.timed_renders = 1, .render = paper_options()};
  const auto psnr_db = [&](const Log& seen, const SceneFile& scene) {
    return compare(device, seen, scene, as_trained).psnr_db;
  };
  const auto distance_cm = [&](const Log& seen, const SceneFile& scene) {
    return 100.0 * compare(device, seen, scene, as_trained).lidar.distance_median_m;
  };
  const SceneFile scene = fit(device, log, training);
  {
    const Log still = still_pictures(log);
    const double modelled = psnr_db(log, scene), rendered = psnr_db(still, scene);
    const double ignored = psnr_db(still, fit(device, still, training));
    add("camera", modelled, ignored, rendered, modelled - ignored);
  }
  {
    const Log still = still_sweeps(log);
    const double modelled = distance_cm(log, scene), rendered = distance_cm(still, scene);
    const double ignored = distance_cm(still, fit(device, still, training));
    add("lidar", modelled, ignored, rendered, ignored - modelled);
  }
  return rows;
}

}  // namespace simuli::bench
