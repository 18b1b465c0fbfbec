#include "bench/paper/shift.hpp"

#include <fmt/format.h>
#include <numbers>
#include <optional>
#include <utility>

#include "bench/paper/seen.hpp"
#include "bench/street/detailed_street.hpp"
#include "host/core/base/stopwatch.hpp"
#include "io/synth/street.hpp"
#include "optim/base/frames.hpp"
#include "optim/complete/support_reliability.hpp"

namespace simuli::bench {
namespace {

/// Changes of the rig relative to the recording.
struct RigPlacement {
  std::string name;
  double left_m = 0.0, up_m = 0.0, turn_deg = 0.0;
  bool other_camera = false, other_lidar = false;
  bool is_shown = false;
};

std::vector<RigPlacement> places() {
  std::vector<RigPlacement> all;
  for (const double left_m : {0.0, 0.5, 1.0, 2.0, 3.0, -0.5, -1.0, -2.0, -3.0}) {
    const bool is_shown = left_m == 0.0 || left_m == 1.0 || left_m == 3.0;
    all.push_back({.name = fmt::format("left_{}_m", left_m), .left_m = left_m, .is_shown = is_shown});
  }
  all.push_back({.name = "up_1_m", .up_m = 1.0, .is_shown = true});
  for (const double turn_deg : {15.0, 30.0, -15.0, -30.0}) {
    const bool is_shown = turn_deg == 30.0;
    all.push_back(
        {.name = fmt::format("turned_{}_deg", turn_deg), .turn_deg = turn_deg, .is_shown = is_shown});
  }
  all.push_back({.name = "wider_camera", .other_camera = true, .is_shown = true});
  all.push_back({.name = "other_lidar", .other_lidar = true});
  return all;
}

Trajectory moved(const Trajectory& world_from_rig, const RigPlacement& place) {
  const double turn_rad = place.turn_deg * std::numbers::pi / 180.0;
  const Pose rig_from_moved{Eigen::Quaterniond(Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitZ())),
                            {0.0, place.left_m, place.up_m}};
  std::vector<TimedPose> poses = world_from_rig.poses();
  for (TimedPose& p : poses) p.pose = p.pose * rig_from_moved;
  return Trajectory(std::move(poses));
}

/// Returns the log of the same drive recorded with these changes.
Log record(const Street& street, Log log, const RigPlacement& place, const std::filesystem::path& folder) {
  log.folder = folder;
  log.world_from_rig = moved(log.world_from_rig, place);
  LogCamera& camera = log.cameras.front();
  LogLidar& lidar = log.lidars.front();
  if (place.other_camera) camera.model.fx *= 0.6, camera.model.fy *= 0.6;
  if (place.other_lidar) {
    Lidar other = builtin_lidar("velodyne_hdl32e");
    other.name = name_of(lidar.model);
    lidar.model = other;
  }
  write_frames(log, street);
  return log;
}

/// Returns the errors of all pictures by visibility.
SeenErrors errors_by_seen(const SeenBefore& seen_before, const Log& there, Evaluation& evaluation) {
  SeenErrors errors;
  for (std::size_t i = 0; i < there.images.size(); ++i) {
    const ImageFrame& image = there.images[i];
    const PicturePair pair = evaluation.picture(i);
    errors.add(pair.rendered,
               pair.recorded,
               seen_before.of(
                   there.camera(image.camera), there.world_from_rig, image.time_start_s, image.time_end_s));
  }
  return errors;
}

/// Whether the constants of support were fitted to these views.
bool is_fitted(const RigPlacement& place) { return place.name == "left_0_m"; }

/// Compares support with true errors, over all placements except the fitted one.
class SupportBesideErrors {
 public:
  SupportBesideErrors(const Device& device, const SceneFile& scene)
      : device_(device), scene_(device, borrowed(scene.scene)), support_(device, scene.support) {}

  void add(const RigPlacement& place, const Log& log, std::vector<Row>& rows) {
    constexpr std::size_t kEvery = 4, kStep = 5;  // frames; pixels and rays
    SupportSamples pixels, rays;
    for (std::size_t i = 0; i < log.images.size() && !place.other_lidar; i += kEvery) {
      pixels.add_picture(scene_, support_, log, log.images[i], log.camera(log.images[i].camera).model, kStep);
    }
    for (std::size_t i = 0; i < log.sweeps.size() && !place.other_camera; i += kEvery) {
      rays.add_sweep(scene_, support_, log, log.sweeps[i], kStep);
    }
    add_rows(place.name + "/support_pixels", reliability(pixels, kSupportColour), rows);
    add_rows(place.name + "/support_rays", reliability(rays, kSupportRange_m), rows);
    if (is_fitted(place)) return;
    pixels_.append(pixels);
    rays_.append(rays);
  }

  void finish(const Log& log, std::vector<Row>& rows) {
    add_curve("support_pixels", reliability(pixels_, kSupportColour), rows);
    add_curve("support_rays", reliability(rays_, kSupportRange_m), rows);
    const LogCamera& camera = log.cameras.front();
    const Shot shot = shot_of(log, log.images.front());
    add_cost("support_pixels", Sensor(camera.model), shot, rows);
    for (const int finer : {2, 4}) {
      const Camera larger = camera.model.resized(finer * camera.model.width, finer * camera.model.height);
      add_cost(fmt::format("support_pixels/{}_px_wide", larger.width), Sensor(larger), shot, rows);
    }
    add_cost("support_rays", Sensor(log.lidars.front().model), shot_of(log, log.sweeps.front()), rows);
  }

 private:
  static void add_rows(const std::string& name, const SupportReliability& found, std::vector<Row>& rows) {
    if (found.count == 0) return;
    const auto add = [&](const char* metric, double value) {
      rows.push_back({fmt::format("shift/{}/{}", name, metric), value, "of 1", 0.0});
    };
    add("mean", found.mean_support);
    add("right", found.right);
    add("rank_correlation", found.rank_correlation);
  }
  static void add_curve(const std::string& name, const SupportReliability& found, std::vector<Row>& rows) {
    add_rows("all/" + name, found, rows);
    for (std::size_t k = 0; k < SupportReliability::kBins; ++k) {
      const SupportReliability::Bin& bin = found.bins[k];
      const auto add = [&](const char* metric, double value) {
        rows.push_back({fmt::format("shift/all/{}/{:.1f}/{}", name, 0.1 * static_cast<double>(k), metric),
                        value,
                        "of 1",
                        0.0});
      };
      add("share",
          static_cast<double>(bin.count) / static_cast<double>(std::max<std::size_t>(found.count, 1)));
      add("support", bin.support);
      add("right", bin.right);
    }
  }
  /// Measures the time of support relative to a frame whose results stay on the device.
  void add_cost(const std::string& name, const Sensor& sensor, const Shot& shot, std::vector<Row>& rows) {
    constexpr int kTimes = 15;
    std::vector<double> frames, supports;
    for (int i = 0; i < kTimes; ++i) {
      const Stopwatch frame_watch;
      const Frame frame = scene_.render(sensor, shot);
      frame.wait();
      frames.push_back(frame_watch.seconds());
      const Stopwatch support_watch;
      (void)support_.of(frame, scene_.scene());
      supports.push_back(support_watch.seconds());
    }
    rows.push_back({fmt::format("shift/all/{}/cost", name),
                    median(std::move(supports)) / median(std::move(frames)),
                    "of a frame",
                    0.0});
  }

  Device device_;
  SceneOnDevice scene_;
  SupportOnDevice support_;
  SupportSamples pixels_, rays_;
};

}  // namespace

ShiftResult run_shift(const std::string& device_request, const ShiftOptions& options, const Note& note) {
  const Device device = Device::best(device_request);
  note(fmt::format("device: {} (driver {})", device.info().label(), device.info().driver_version));
  const ScratchFolder scratch("simuli_bench");
  StreetOptions street;
  street.output = scratch.path() / "street.log";
  if (options.detailed) street.detail = &detailed_street();
  const Log log = synth_street(street);
  std::vector<std::string> settings = options.settings;
  settings.push_back("image_scale=1");
  settings.push_back("held_out_every=0");  // scores use other placements
  settings.push_back(fmt::format("iterations={}", options.iterations));
  const SceneFile scene = fit(device, log, training_options("", settings));
  note(fmt::format("trained on the street, {} iterations", options.iterations));

  const Street world(street.contents());
  const SeenBefore seen_before(world, street.contents().car, log);
  std::optional<SeenErrors> on_path;
  ShiftResult result;
  SupportBesideErrors support(device, scene);
  const EvalOptions all{.image_scale = 1.0, .held_out_every = 0, .timed_renders = 1};
  for (const RigPlacement& place : places()) {
    const Log there = record(world, log, place, scratch.path() / place.name);
    Evaluation evaluation(device, scene, there, all);
    const EvalReport report = evaluation.run();
    const auto add = [&](const std::string& metric, double value, const char* unit) {
      result.rows.push_back({fmt::format("shift/{}/{}", place.name, metric), value, unit, 0.0});
    };
    if (!place.other_lidar) {
      add("psnr_db", report.psnr_db, "dB");
      add("ssim", report.ssim, "of 1");
      const SeenErrors errors = errors_by_seen(seen_before, there, evaluation);
      if (!on_path) on_path = errors;  // the first placement
      for (const auto& [kind, seen] : {std::pair("never_seen", Seen::kNever),
                                       std::pair("coarsely_seen", Seen::kCoarsely),
                                       std::pair("well_seen", Seen::kWell)}) {
        add(fmt::format("{}/share", kind), errors.share(seen), "of 1");
        if (errors.share(seen) > 0.0) add(fmt::format("{}/psnr_db", kind), errors.psnr_db(seen), "dB");
      }
      add("psnr_of_seen_as_on_path_db", errors.psnr_of_seen_as_in_db(*on_path), "dB");
    }
    if (!place.other_camera) {
      add("distance_median_cm", 100.0 * report.lidar.distance_median_m, "cm");
      add("raydrop_accuracy", report.lidar.raydrop_accuracy, "of 1");
      add("chamfer_m", report.lidar.chamfer_m, "m");
    }
    support.add(place, there, result.rows);
    if (place.is_shown) {
      PicturePair pair = evaluation.picture(there.images.size() / 2);
      result.pictures.push_back({place.name, std::move(pair.rendered), std::move(pair.recorded)});
    }
    note(fmt::format("{}: {:.1f} dB, {:.2f} cm, ray drop {:.3f}",
                     place.name,
                     report.psnr_db,
                     100.0 * report.lidar.distance_median_m,
                     report.lidar.raydrop_accuracy));
  }
  support.finish(log, result.rows);
  return result;
}

}  // namespace simuli::bench
