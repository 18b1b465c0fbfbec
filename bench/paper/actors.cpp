#include "bench/paper/actors.hpp"

#include <cmath>
#include <cstddef>
#include <fmt/format.h>
#include <numbers>
#include <random>
#include <utility>

#include "host/core/base/spread.hpp"
#include "host/core/scene/edit.hpp"
#include "host/device/render/scene/readings.hpp"
#include "io/synth/street.hpp"
#include "optim/base/evaluate_actors.hpp"
#include "optim/base/frames.hpp"
#include "optim/eval/sweep_pair.hpp"

namespace simuli::bench {
namespace {

using Eigen::Vector3d;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kMovedLeft_m = -2.0;  // to the middle of the road; parked cars are on the other side
constexpr double kFaster = 2.0;
constexpr double kNoisyMargin_m = 0.5;  // enlarges boxes so that they contain the car in spite of the noise

/// Records the street with the car on this track, or without a car, as a log in `folder`.
Log record(const ActorsOptions& options, const std::filesystem::path& folder, const StreetCar* car) {
  StreetOptions street;
  street.output = folder;
  street.frames = options.frames;
  street.moving_car = car != nullptr;
  if (car != nullptr) street.car = *car;
  return synth_street(street);
}

/// Errors of held-out rays that hit the car in `log`, relative to `empty`, the street without the car.
struct WhereItWas {
  double error_m = 0.0;  // median |d^ - d|
  double ghosts = 0.0;   // share of rays with a background that return from the car's position
};
WhereItWas where_it_was(const Device& device, const Log& log, const Log& empty, const Scene& scene) {
  SceneOnDevice on_device(device, borrowed(scene), RenderOptions{});
  std::vector<double> errors;
  double parted = 0.0, ghosts = 0.0;
  for (const std::size_t index : HeldOutRule(log, FrameSelection{}).held_out(log.sweeps)) {
    const SweepFrame& frame = log.sweeps[index];
    const SweepPair pair = render_sweep(on_device, log, frame);
    const std::vector<float> behind = render_sweep(on_device, empty, empty.sweeps[index]).recorded.range;
    View view = view_of(log, scene, frame);
    view.actors = actors_during(log.actors, frame.time_start_s, frame.time_end_s, scene.origin);
    const auto on = returns_on_actors(
        ActorBoxes(log.actors, view), log.lidar(frame.lidar).model, pair.recorded.rays, pair.recorded.range);
    for (std::size_t i = 0; i < on.size(); ++i) {
      if (on[i] == ActorBoxes::kNone) continue;
      const double range = behind[i];
      if (range > 0.0) errors.push_back(std::abs(best_distance(pair.simulated, i) - range));
      if (range > 0.0 && range - pair.recorded.range[i] < SweepPair::kSame_m) continue;
      parted += 1.0;
      ghosts += is_met(pair, i) ? 1.0 : 0.0;
    }
  }
  if (errors.empty()) return {std::nan(""), std::nan("")};
  return {upper_median(std::move(errors)), ghosts / parted};
}

/// Spread of key pose errors, without their mean in the car's frame.
struct TrackError {
  double shift_m = 0.0;
  double turn_rad = 0.0;
};
TrackError track_error(const Actor& actor, const Actor& truth) {
  std::vector<Vector3d> shifts, turns;
  Vector3d mean_shift = Vector3d::Zero(), mean_turn = Vector3d::Zero();
  const auto count = static_cast<double>(actor.track.size());
  for (std::size_t k = 0; k < actor.track.size(); ++k) {
    const Pose true_from_found = truth.track[k].corrected().inverse() * actor.track[k].corrected();
    const Eigen::AngleAxisd turn(true_from_found.rotation);
    shifts.push_back(true_from_found.translation);
    turns.emplace_back(turn.angle() * turn.axis());
    mean_shift += shifts.back() / count;
    mean_turn += turns.back() / count;
  }
  TrackError error;
  for (std::size_t k = 0; k < shifts.size(); ++k) {
    error.shift_m += (shifts[k] - mean_shift).squaredNorm() / count;
    error.turn_rad += (turns[k] - mean_turn).squaredNorm() / count;
  }
  return {std::sqrt(error.shift_m), std::sqrt(error.turn_rad)};
}

Log with_noise(Log log, const ActorsOptions& options) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  for (KeyPose& key : log.actors.front().track) {
    key.world_from_actor.translation += options.noise_m * Vector3d(normal(random), normal(random), 0.0);
    key.world_from_actor.rotation =
        Eigen::AngleAxisd(options.noise_deg * kDegree * normal(random), Vector3d::UnitZ()) *
        key.world_from_actor.rotation;
  }
  return log;
}

}  // namespace

std::vector<Row> run_actors(const std::string& device_request,
                            const ActorsOptions& options,
                            const Note& note) {
  const Device device = Device::best(device_request);
  note(fmt::format("device: {} (driver {})", device.info().label(), device.info().driver_version));
  const ScratchFolder scratch("simuli_bench");
  const StreetCar car;
  const Log log = record(options, scratch.path() / "street", &car);
  std::vector<Row> rows;
  const auto add = [&](const std::string& name, double value, const char* unit) {
    rows.push_back({"actors/" + name, value, unit, 0.0});
    note(fmt::format("actors/{} {:.4g} {}", name, value, unit));
  };
  const auto add_report = [&](const std::string& name, const EvalReport& report) {
    add(name + "/psnr_in_box", report.actor_psnr_db, "dB");
    add(name + "/distance_in_box", 100.0 * report.actor_distance_median_m, "cm");
    add(name + "/share_met", 100.0 * report.actor_share_met, "%");
  };

  TrainingOptions training;
  training.frames.image_scale = 1.0;
  training.train.iterations = options.iterations;
  TrainingOptions still = training;
  still.init.actors = false;
  add_report("without", compare(device, log, fit(device, log, still)));
  const SceneFile scene = fit(device, log, training);
  add_report("with", compare(device, log, scene));

  {
    StreetCar moved_car = car;
    moved_car.lane_m += kMovedLeft_m;
    SceneFile moved = scene;
    move_actor(moved.scene, "car", {0.0, kMovedLeft_m, 0.0});
    add_report("moved", compare(device, record(options, scratch.path() / "moved", &moved_car), moved));
  }
  {
    StreetCar fast_car = car;
    fast_car.speed_m_per_s *= kFaster;
    const Log fast_log = record(options, scratch.path() / "faster", &fast_car);
    SceneFile faster = scene;
    retime_actor(faster.scene, "car", kFaster, 0.0);
    // The track ends in the middle of the log: extends it with constant velocity.
    Actor& actor = faster.scene.actors.front();
    KeyPose last = actor.track.back();
    last.time_s = fast_log.actors.front().track.back().time_s;
    last.world_from_actor = actor.at(last.time_s);
    actor.track.push_back(last);
    add_report("faster", compare(device, fast_log, faster));
  }
  {
    Log empty = record(options, scratch.path() / "removed", nullptr);
    empty.actors = log.actors;  // the car's boxes
    SceneFile removed = scene;
    remove_actor(removed.scene, "car");
    add("removed/psnr_where_it_was", compare(device, empty, removed).actor_psnr_db, "dB");
    const WhereItWas after = where_it_was(device, log, empty, removed.scene);
    add("removed/distance_behind", 100.0 * after.error_m, "cm");
    add("removed/ghost_share", 100.0 * after.ghosts, "%");
  }
  {
    const Log noisy = with_noise(log, options);
    training.init.actor_margin_m = kNoisyMargin_m;
    add_report("noise/kept", compare(device, log, fit(device, noisy, training)));
    training.train.actor_poses.learn = true;
    const SceneFile learned = fit(device, noisy, training);
    add_report("noise/learned", compare(device, log, learned));
    const TrackError before = track_error(noisy.actors.front(), log.actors.front());
    const TrackError after = track_error(learned.scene.actors.front(), log.actors.front());
    add("noise/shift_before", 100.0 * before.shift_m, "cm");
    add("noise/shift_after", 100.0 * after.shift_m, "cm");
    add("noise/shift_won_back", 100.0 * (1.0 - after.shift_m / before.shift_m), "%");
    add("noise/turn_before", before.turn_rad / kDegree, "degrees");
    add("noise/turn_after", after.turn_rad / kDegree, "degrees");
    add("noise/turn_won_back", 100.0 * (1.0 - after.turn_rad / before.turn_rad), "%");
  }
  return rows;
}

}  // namespace simuli::bench
