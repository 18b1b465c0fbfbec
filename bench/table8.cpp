#include "bench/table8.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <random>
#include <utility>

#include "io/street.hpp"
#include "optim/frames.hpp"

namespace simuli::bench {
namespace {

struct Named {
  Projection projection;
  const char* name;
};
// The yardstick first.
constexpr std::array<Named, 3> kProjections{{{Projection::kMonteCarlo, "monte_carlo"},
                                             {Projection::kUnscented, "unscented"},
                                             {Projection::kLinearized, "linearized"}}};
constexpr int kTimedSweeps = 7;

RenderOptions render_with(Projection projection) {
  RenderOptions options;
  options.projection = projection;
  return options;
}

/// Device time of the projection of held-out sweeps.
Spread projection_ms(const Device& profiled, const Log& log, const Scene& scene, Projection projection) {
  const std::vector<std::size_t> frames = select_frames(log.sweeps, EvalOptions{}.held_out_every, true);
  Renderer renderer(profiled, render_with(projection));
  const ParticleBuffers particles(profiled, scene.lidar, Precision::kFloat);
  std::vector<double> samples;
  for (int i = -1; i < kTimedSweeps; ++i) {
    const SweepFrame& frame = log.sweeps[frames[static_cast<std::size_t>(i + 1) % frames.size()]];
    profiled.profile().reset();
    static_cast<void>(render_sweep(renderer, particles, log, scene, frame));
    double ms = 0.0;
    for (const ProfileRow& row : profiled.profile().rows()) {
      if (row.kernel == "project") ms += row.total_ms;
    }
    if (i >= 0) samples.push_back(ms);  // the first launch compiles
  }
  return spread_of(std::move(samples));
}

struct Metric {
  const char* name;
  double SweepMetrics::*value;
  const char* unit;
};
constexpr std::array<Metric, 5> kMetrics{{{"medl2_m2", &SweepMetrics::medl2_m2, "m^2"},
                                          {"mean_rel_l2", &SweepMetrics::mean_rel_l2, "of 1"},
                                          {"intensity_rmse", &SweepMetrics::intensity_rmse, "of 1"},
                                          {"raydrop_accuracy", &SweepMetrics::raydrop_accuracy, "of rays"},
                                          {"chamfer_m2", &SweepMetrics::chamfer_m2, "m^2"}}};

/// The table of one size of particles: trained with each projection, and with one for all.
class Table {
 public:
  Table(const Device& device, const Device& profiled, const Log& log, const Table8Options& options, Note note)
      : device_(device), profiled_(profiled), log_(log), options_(options), note_(std::move(note)) {}

  void run(const std::string& name, double voxel_m, std::vector<Row>& rows) {
    InitOptions init;
    init.voxel_m = voxel_m;
    init.max_scale_m = std::max(init.max_scale_m, voxel_m);
    init.max_shell = 0;
    init.sweep_depth = false;
    const Scene start = initialize_scene(log_, init).scene;
    note_(fmt::format("{}: {} particles", name, start.lidar.size()));
    Scene unscented;
    SweepMetrics yardstick;
    for (const Named& p : kProjections) {
      TrainOptions train;
      train.iterations = options_.iterations;
      train.render = render_with(p.projection);
      Scene scene = trained(device_, log_, start, train);
      add(fmt::format("{}/{}", name, p.name), scene, p.projection, yardstick, rows);
      if (p.projection == Projection::kUnscented) unscented = std::move(scene);
    }
    for (const Named& p : kProjections) {
      add(fmt::format("{}_render/{}", name, p.name), unscented, p.projection, yardstick, rows);
    }
  }

 private:
  void add(const std::string& base,
           const Scene& scene,
           Projection projection,
           SweepMetrics& yardstick,
           std::vector<Row>& rows) {
    EvalOptions options;
    options.render = render_with(projection);
    options.timed_renders = 1;
    const SweepMetrics found = evaluate(device_, log_, scene, options).lidar;
    if (projection == Projection::kMonteCarlo) yardstick = found;
    double worst = 0.0;
    for (const Metric& m : kMetrics) {
      rows.push_back({fmt::format("{}/{}", base, m.name), found.*m.value, m.unit, 0.0});
      worst = std::max(worst, std::abs(found.*m.value / (yardstick.*m.value) - 1.0));
    }
    rows.push_back({base + "/worst_difference", 100.0 * worst, "%", 0.0});
    const Spread ms = projection_ms(profiled_, log_, scene, projection);
    rows.push_back({base + "/projection_ms", ms.median, "ms", ms.half_iqr});
    note_(base);
  }

  Device device_, profiled_;
  const Log& log_;
  Table8Options options_;
  Note note_;
};

/// A long particle of random direction, `size` of its range in length, somewhere about the sensor.
GaussianSet long_particle(double size, std::mt19937_64& random) {
  const auto in = [&random](double low, double high) {
    return low + (high - low) * static_cast<double>(random() >> 11U) * 0x1p-53;
  };
  constexpr double kRange_m = 5.0;
  GaussianSet set(SetKind::kLidar, 0, 1);
  const Eigen::Vector3d mean = kRange_m * Lidar::direction(in(-3.0, 3.0), in(-0.3, 0.05));
  set.mean().row(0) = mean.cast<float>().transpose();
  const double length = std::log(size * kRange_m), width = std::log(0.2 * size * kRange_m);
  set.log_scale().row(0) << static_cast<float>(length), static_cast<float>(width), static_cast<float>(width);
  for (int k = 0; k < 4; ++k) set.rotation()(0, k) = static_cast<float>(in(-1.0, 1.0));
  return set;  // logit 0: opacity 0.5
}

/// What a ray gathers of one particle that nothing clips, in double (METHOD section 7).
double alpha_of(const GaussianSet& set,
                const Eigen::Vector3d& origin,
                const Eigen::Vector3d& direction,
                double kappa) {
  const Eigen::Vector3d mean = set.mean().row(0).transpose().cast<double>();
  const Eigen::RowVector4d q = set.rotation().row(0).cast<double>();
  const Eigen::Quaterniond turn = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized();
  const Eigen::Array3d scale = set.log_scale().row(0).transpose().cast<double>().array().exp();
  const Eigen::Array3d filtered = (scale.square() + kappa * mean.squaredNorm()).sqrt();
  const Eigen::Vector3d o = (turn.conjugate() * (origin - mean)).array() / filtered;
  const Eigen::Vector3d d = (turn.conjugate() * direction).array() / filtered;
  if (!(o.dot(d) < 0.0)) return 0.0;  // behind
  return 0.5 * std::exp(-0.5 * o.cross(d).squaredNorm() / d.squaredNorm());
}

/// Share of what rays gather of single long particles that each projection's box cuts off.
void add_clipped(const Device& device, const Lidar& lidar, std::vector<Row>& rows) {
  constexpr int kParticles = 40;
  const LidarRays nominal = nominal_rays(lidar, 0.1);
  for (const double size : {0.05, 0.1, 0.2, 0.3}) {
    for (const Named& p : kProjections) {
      const RenderOptions options = render_with(p.projection);
      Renderer renderer(device, options);
      const SensorRays rays(device, lidar, nominal, options);
      const double kappa = rays.grid().constants[SIM_S_KAPPA];
      std::mt19937_64 random(3);
      double whole = 0.0, found = 0.0;
      for (int k = 0; k < kParticles; ++k) {
        const GaussianSet set = long_particle(size, random);
        renderer.render(ParticleBuffers(device, set, options.precision), rays, View{});
        const std::vector<float> left = renderer.results().transmittance;
        for (std::size_t i = 0; i < left.size(); ++i) {
          const auto azimuth = static_cast<double>(nominal.azimuth[i]);
          const auto row = static_cast<int>(i / static_cast<std::size_t>(nominal.columns));
          const double alpha = alpha_of(set,
                                        lidar.origin(row, azimuth),
                                        Lidar::direction(azimuth, static_cast<double>(nominal.elevation[i])),
                                        kappa);
          if (!(alpha >= options.alpha_cut)) continue;
          whole += alpha;
          found += 1.0 - static_cast<double>(left[i]);
        }
      }
      rows.push_back({fmt::format("table8_clipped/{}/size_{:.0f}_percent", p.name, 100.0 * size),
                      100.0 * (1.0 - found / whole),
                      "%",
                      0.0});
    }
  }
}

}  // namespace

std::vector<Row> run_table8(const std::string& device_request,
                            const Table8Options& options,
                            const Note& note) {
  const Device device = Device::best(device_request);
  // Profiling keeps every event: a device of its own, not the one that trains.
  const Device profiled = Device::best(device_request, {.profiling = true});
  note(fmt::format("device: {} (driver {})", device.info().label(), device.info().driver_version));
  const ScratchFolder scratch;
  Log log;
  if (options.log.empty()) {
    StreetOptions street;
    street.output = scratch.path() / "street.log";
    street.image_width = street.image_height = 8;  // no picture is looked at
    street.moving_car = false;                     // the scene is static
    log = synth_street(street);
  } else {
    log = read_log(options.log);
  }
  log.images.clear();
  std::vector<Row> rows;
  Table table(device, profiled, log, options, note);
  table.run("table8", options.voxel_m, rows);
  table.run("table8_coarse", options.coarse_voxel_m, rows);
  if (!log.lidars.empty()) add_clipped(device, log.lidars.front().model, rows);
  return rows;
}

}  // namespace simuli::bench
