#include "bench/paper/figure10.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numbers>
#include <utility>

#include "host/device/render/scene/readings.hpp"
#include "io/synth/street.hpp"
#include "optim/base/frames.hpp"
#include "optim/base/metrics.hpp"
#include "optim/eval/sweep_pair.hpp"

namespace simuli::bench {
namespace {

namespace fs = std::filesystem;

constexpr double kDivergence_rad = 3e-3;  // full angle
constexpr int kRingRays = 6;              // rays around the central ray of a beam
constexpr double kRingRadius = 0.7;       // relative to the beam's radius
constexpr float kOffPole_m = 0.1F;  // a ray is on a pole if its range without poles is longer by this length

/// Returns the nearest return in each beam, from scans by the central rays and by the rays around them.
Sweep scan_by_beams(const Street& street,
                    const LogLidar& lidar,
                    const Trajectory& path,
                    const SweepFrame& f) {
  Sweep sweep = scan_street(street, lidar, path, f.time_start_s, f.time_end_s);
  for (int k = 0; k < kRingRays; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / kRingRays;
    const double reach = kRingRadius * 0.5 * kDivergence_rad;
    Lidar model = lidar.with_rows();
    for (LidarRow& row : model.rows) {
      row.elevation += reach * std::sin(angle);
      row.azimuth_offset += reach * std::cos(angle) / std::cos(row.elevation);
    }
    const LogLidar aside{std::move(model), lidar.rig_from_lidar};
    const Sweep other = scan_street(street, aside, path, f.time_start_s, f.time_end_s);
    for (std::size_t i = 0; i < sweep.range.size(); ++i) {
      const bool nearer =
          other.range[i] > 0.0F && (sweep.range[i] == 0.0F || other.range[i] < sweep.range[i]);
      if (!nearer) continue;
      sweep.range[i] = other.range[i];
      sweep.intensity[i] = other.intensity[i];
    }
  }
  return sweep;
}

struct Recording {
  Log log;                                 // only sweeps
  std::vector<std::vector<bool>> on_pole;  // [sweeps][rays]
};

Recording record(const Figure10Options& options, const fs::path& folder) {
  StreetOptions street;
  street.output = folder;
  street.frames = options.frames;
  Recording out{street_log(street), {}};
  out.log.images.clear();
  auto& lidar = std::get<Lidar>(out.log.lidars[0].model);
  lidar.beam_divergence = kDivergence_rad;
  lidar.divergence_variance = 0.25;  // the complete beam is within two standard deviations
  const Street with({.seed = street.seed, .car = std::nullopt, .thin_poles = true});
  const Street without({.seed = street.seed, .car = std::nullopt});
  fs::create_directories(folder / "sweeps");
  for (const SweepFrame& f : out.log.sweeps) {
    const Sweep sweep = scan_by_beams(with, out.log.lidars[0], out.log.world_from_rig, f);
    const Sweep bare = scan_by_beams(without, out.log.lidars[0], out.log.world_from_rig, f);
    std::vector<bool>& on_pole = out.on_pole.emplace_back(sweep.range.size());
    for (std::size_t i = 0; i < on_pole.size(); ++i) {
      const float behind = bare.range[i] > 0.0F ? bare.range[i] : 1e9F;
      on_pole[i] = sweep.range[i] > 0.0F && behind > sweep.range[i] + kOffPole_m;
    }
    write_sweep(folder / f.file, sweep);
  }
  return out;
}

struct Errors {
  double pole_m = 0.0;
  double pole_found = 0.0;
  double all_m = 0.0;
  std::size_t pole_rays = 0;
};

Errors measure(const Device& device,
               const Log& log,
               const std::vector<std::vector<bool>>& on_pole,
               const Scene& scene,
               const RenderOptions& options,
               const FrameSelection& frames) {
  constexpr double kFound_m = 0.1;
  SceneOnDevice on_device(device, borrowed(scene), options);
  std::vector<double> poles, all;
  for (const std::size_t index : HeldOutRule(log, frames).held_out(log.sweeps)) {
    const SweepPair pair = render_sweep(on_device, log, log.sweeps[index]);
    for (std::size_t i = 0; i < pair.recorded.range.size(); ++i) {
      const double range = pair.recorded.range[i];
      if (!(range > 0.0)) continue;
      const double error = std::abs(best_distance(pair.simulated, i) - range);
      all.push_back(error);
      if (on_pole[index][i]) poles.push_back(error);
    }
  }
  Errors out;
  out.pole_rays = poles.size();
  const auto found = std::count_if(poles.begin(), poles.end(), [](double e) { return e < kFound_m; });
  out.pole_found = static_cast<double>(found) / static_cast<double>(std::max<std::size_t>(1, poles.size()));
  out.pole_m = median(std::move(poles));
  out.all_m = median(std::move(all));
  return out;
}

}  // namespace

std::vector<Row> run_figure10(const std::string& device_request,
                              const Figure10Options& options,
                              const Note& note) {
  const Device device = Device::best(device_request);
  note(fmt::format("device: {} (driver {})", device.info().label(), device.info().driver_version));
  const ScratchFolder scratch("simuli_bench");
  const Recording recording = record(options, scratch.path());
  note(fmt::format("recorded {} sweeps", recording.log.sweeps.size()));
  struct Variant {
    const char* name;
    bool filter;
    bool compensation;
  };
  std::vector<Row> rows;
  for (const Variant& v : {Variant{"none", false, false},
                           Variant{"filter", true, false},
                           Variant{"filter_compensated", true, true}}) {
    Log log = recording.log;
    if (!v.filter) std::get<Lidar>(log.lidars[0].model).beam_divergence = 0.0;
    TrainingOptions training;
    training.init.voxel_m = 0.05;
    TrainOptions& train = training.train;
    train.iterations = options.iterations;
    train.render = paper_options();
    train.lidar_every = 1;
    train.render.lidar_compensation = v.compensation;
    const Scene scene = fit(device, log, training).scene;
    const Errors e = measure(device, log, recording.on_pole, scene, train.render, training.frames);
    rows.push_back({fmt::format("figure10/{}/pole_error", v.name), 100.0 * e.pole_m, "cm", 0.0});
    rows.push_back({fmt::format("figure10/{}/pole_found", v.name), e.pole_found, "of 1", 0.0});
    rows.push_back({fmt::format("figure10/{}/all_error", v.name), 100.0 * e.all_m, "cm", 0.0});
    note(fmt::format("{} done: {} held-out rays on poles", v.name, e.pole_rays));
  }
  return rows;
}

}  // namespace simuli::bench
