#include "bench/render/sensor_errors.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numbers>
#include <optional>
#include <random>

#include "host/core/base/error.hpp"
#include "host/device/render/scene/renderer.hpp"

namespace simuli::bench {
namespace {

using Eigen::Vector3d;

constexpr double kFloatUnit = 0x1p-24;  // relative rounding of one operation
constexpr int kOfEachCase = 12;         // number of particles, rendered one after the other
constexpr float kOpacityLogit = 2.2F;   // opacity 0.9

// Maximum error of the float build in units of rounding: ray direction, rotation to world and particle frame,
// matrix and centre, a few roundings each.
constexpr double kRoundings = 6.0;
// The rounding error of the sensor position grows with the distance from the scene origin; the difference to
// the particle's position is exact.
constexpr double kPlaceRoundings = 2.0;
// Errors of exp, squared distances up to 11 and 1 - T of rays with low opacity, without amplification.
constexpr double kTransmittanceFloor = 2e-5;
constexpr double kDistanceFloor = 5e-5;
// Rays within rounding of the edge of a particle's extent or box may hit in only one build.
constexpr double kDecidedOtherwise = 0.005;
// With many particles such a ray changes the particles behind; so one ray in a hundred is excluded.
constexpr double kSetShare = 0.99;
constexpr float kSetOpacityLogit = -2.2F;  // opacity 0.1: near particles hide no others
constexpr double kSetTransmittance = 1e-4;

/// Particles of one size at one range, and offsets of sensor and scene origin.
struct Extreme {
  const char* name;
  double range_m;
  Vector3d scale_m;
  double scene_offset_m = 0.0;  // from the scene origin to the sensor
  double world_offset_m = 0.0;  // from the world origin to the scene origin
};

std::vector<Extreme> all_cases() {
  const auto ball = [](double scale_m) { return Vector3d::Constant(scale_m); };
  return {
      {"range_2cm", 0.02, ball(0.001)},
      {"range_5cm", 0.05, ball(0.0025)},
      {"range_10m", 10.0, ball(0.1)},
      {"range_2km", 2000.0, ball(20.0)},
      {"range_10km", 9990.0, ball(20.0)},
      {"scale_0.01mm_at_10cm", 0.1, ball(1e-5)},
      {"scale_0.1mm_at_1m", 1.0, ball(1e-4)},
      {"scale_0.1mm_at_100m", 100.0, ball(1e-4)},
      {"scale_100m_at_1km", 1000.0, ball(100.0)},
      {"scale_100m_at_10m", 10.0, ball(100.0)},
      {"scale_1km_at_5km", 5000.0, ball(1e3)},
      {"disc_1m_by_0.1mm_at_10m", 10.0, {1.0, 1.0, 1e-4}},
      {"needle_1m_by_0.1mm_at_10m", 10.0, {1.0, 1e-4, 1e-4}},
      {"disc_1m_by_0.001mm_at_10m", 10.0, {1.0, 1.0, 1e-6}},
      {"needle_10m_by_0.01mm_at_10m", 10.0, {10.0, 1e-5, 1e-5}},
      {"world_1e6m_from_origin", 10.0, ball(0.1), 0.0, 1e6},
      {"world_1e7m_from_origin", 10.0, ball(0.1), 0.0, 1e7},
      {"scene_1km_from_origin", 10.0, ball(0.1), 1e3, 0.0},
      {"scene_10km_from_origin", 10.0, ball(0.1), 1e4, 1e6},
  };
}

/// Motion of a sensor during a frame: a camera window is read, or a LiDAR completes a revolution, in
/// `frame_s`.
struct Motion {
  const char* name;
  double camera_s, lidar_s;
  double speed_m_per_s = 0.0, turn_deg_per_s = 0.0;
  [[nodiscard]] bool moves() const { return speed_m_per_s > 0.0; }
};

constexpr Motion kMotions[] = {
    {"rest", 0.0, 0.1},
    {"moving", 0.02 * 64.0 / 1080.0, 0.1, 30.0, 90.0},  // 64 of 1080 rows read in 20 ms
    {"100_hz", 1e-4, 0.01, 30.0, 90.0},
    {"1_second", 1.0, 1.0, 30.0, 90.0},
    {"1000_degrees_per_s", 0.02 * 64.0 / 1080.0, 0.1, 30.0, 1000.0},
};

/// One resting or moving sensor: a window in the corner of a picture with a long focal length, or a full
/// revolution.
struct Rig {
  SetKind kind = SetKind::kCamera;
  Motion motion;
  Camera camera;
  Lidar lidar;
  LidarRays rays;

  Rig(SetKind set_kind, const Motion& how);
  [[nodiscard]] std::string name() const {
    return fmt::format("{}_{}", kind == SetKind::kCamera ? "camera" : "lidar", motion.name);
  }
  [[nodiscard]] SensorRays on(const Device& device, const RenderOptions& options) const {
    return kind == SetKind::kCamera ? SensorRays(device, camera, options)
                                    : SensorRays(device, lidar, rays, options);
  }
  /// Returns the variance of the footprint per squared range.
  [[nodiscard]] double kappa() const {
    if (kind == SetKind::kCamera) return kPixelVariance_px2 / (camera.fx * camera.fx);
    const double tangent = std::tan(lidar.beam_divergence / 2.0);
    return lidar.divergence_variance * tangent * tangent;
  }
  /// Returns poses at the ends of the frame, around `centre`; near particles use less motion.
  [[nodiscard]] View view(const Vector3d& centre, double range_m) const;
  /// Computes origin and direction of a ray in the frame of `view`.
  void ray(const View& view, std::size_t index, Vector3d& origin, Vector3d& direction) const;
};

Rig::Rig(SetKind set_kind, const Motion& how) : kind(set_kind), motion(how) {
  camera.name = "window";
  camera.width = 96;
  camera.height = 64;
  camera.fx = camera.fy = 2000.0;
  camera.cx = -1500.0;  // 37 degrees off the axis
  camera.cy = -800.0;
  camera.shutter = how.moves() ? ShutterKind::kTopToBottom : ShutterKind::kGlobal;
  constexpr int kBeams = 16;
  constexpr double kDegree = std::numbers::pi / 180.0;
  lidar.name = "turn";
  for (int r = 0; r < kBeams; ++r) {
    LidarRow row;
    row.elevation = (10.0 - 2.0 * r) * kDegree;
    lidar.rows.push_back(row);
  }
  lidar.columns = 360;
  lidar.azimuth_first = std::numbers::pi;
  lidar.azimuth_span = 2.0 * std::numbers::pi;
  lidar.range_min = 0.01;
  lidar.range_max = 1.1e4;
  lidar.beam_divergence = 2e-3;
  lidar.sweep_s = how.lidar_s;
  rays = nominal_rays(lidar);
}

View Rig::view(const Vector3d& centre, double range_m) const {
  Eigen::Matrix3d looking;  // columns: camera x (right), y (down), z (forward) in the world
  looking << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  Pose start;
  if (kind == SetKind::kCamera) start.rotation = Eigen::Quaterniond(looking);
  Pose end = start;
  start.translation = end.translation = centre;
  if (motion.moves()) {
    const double seconds = kind == SetKind::kCamera ? motion.camera_s : motion.lidar_s;
    const double driven_m = std::min(motion.speed_m_per_s * seconds, 0.2 * range_m);
    const double turned_rad = motion.turn_deg_per_s * std::numbers::pi / 180.0 * seconds;
    end.translation += driven_m * Vector3d(0.98, 0.17, 0.1);
    end.rotation = Eigen::AngleAxisd(turned_rad, Vector3d(0.1, 0.2, 0.97).normalized()) * start.rotation;
  }
  const std::array<float, 3> empty =
      kind == SetKind::kCamera ? std::array<float, 3>{0, 0, 0} : std::array<float, 3>{0, -4, 4};
  return {start, end, empty};
}

void Rig::ray(const View& view, std::size_t index, Vector3d& origin, Vector3d& direction) const {
  double share = 0.0;
  if (kind == SetKind::kCamera) {
    const auto width = static_cast<std::size_t>(camera.width);
    const Eigen::Vector2d pixel(static_cast<double>(index % width) + 0.5,
                                static_cast<double>(index / width) + 0.5);
    direction = camera.unproject(pixel);
    share = camera.exposure_fraction(pixel);
  } else {
    direction = Lidar::direction(static_cast<double>(rays.azimuth[index]),
                                 static_cast<double>(rays.elevation[index]));
    share = static_cast<double>(rays.time_fraction[index]);
  }
  const Pose pose = interpolate(view.scene_from_sensor_start, view.scene_from_sensor_end, share);
  origin = pose.translation;
  direction = pose.rotation * direction;
}

double random_in(std::mt19937_64& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random() >> 11U) * 0x1p-53;
}

/// Returns a particle close to a random ray of the view.
GaussianSet particle_on_a_ray(const Rig& rig,
                              const View& view,
                              const Extreme& extreme,
                              std::mt19937_64& random) {
  const std::size_t rays = rig.kind == SetKind::kCamera ? std::size_t{96} * 64 : rig.lidar.ray_count();
  Vector3d origin, direction;
  rig.ray(view, random() % rays, origin, direction);
  GaussianSet set(rig.kind, 0, 1);
  const double thin = std::hypot(extreme.scale_m.minCoeff(), std::sqrt(rig.kappa()) * extreme.range_m);
  Vector3d mean = origin + extreme.range_m * direction;
  Eigen::Vector4d q;
  for (int k = 0; k < 4; ++k) q[k] = random_in(random, -1.0, 1.0);
  for (int k = 0; k < 3; ++k) mean[k] += thin * random_in(random, -0.5, 0.5);
  set.mean().row(0) = mean.cast<float>().transpose();
  set.log_scale().row(0) = extreme.scale_m.array().log().matrix().cast<float>().transpose();
  set.rotation().row(0) = q.cast<float>().transpose();
  set.opacity_logit()(0) = kOpacityLogit;
  set.sh(0).row(0) << 0.3F, 0.2F, -0.4F;
  return set;
}

bool all_finite(const RayResults& results) {
  const auto good = [](const std::vector<float>& values) {
    return std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); });
  };
  return good(results.feature[0]) && good(results.feature[1]) && good(results.feature[2]) &&
         good(results.transmittance) && good(results.distance) && good(results.median);
}

/// Float and double builds of one device.
class Builds {
 public:
  explicit Builds(const Device& device)
      : device_(device),
        float_(device, options_of(Precision::kFloat)),
        double_(device, options_of(Precision::kDouble)) {}
  struct Pair {
    RayResults single, precise;
  };
  Pair render(const GaussianSet& set, const View& view) {
    return {render(float_, set, view), render(double_, set, view)};
  }
  void use(const Rig& rig) {
    float_rays_.emplace(rig.on(device_, float_.options()));
    double_rays_.emplace(rig.on(device_, double_.options()));
  }

 private:
  static RenderOptions options_of(Precision precision) {
    RenderOptions options = paper_options();
    options.precision = precision;
    return options;
  }
  RayResults render(Renderer& renderer, const GaussianSet& set, const View& view) {
    const Precision precision = renderer.options().precision;
    const ParticleBuffers particles(device_, set, precision);
    return renderer.render(particles, precision == Precision::kFloat ? *float_rays_ : *double_rays_, view)
        .results();
  }

  Device device_;
  Renderer float_, double_;
  std::optional<SensorRays> float_rays_, double_rays_;
};

/// Largest errors over the rays of a case.
struct Worst {
  double transmittance = 0.0;
  double distance = 0.0;
  std::size_t hit = 0;
  std::size_t otherwise = 0;
  bool finite = true;
  void add(const Builds::Pair& pair, double range_m);
};

void Worst::add(const Builds::Pair& pair, double range_m) {
  const auto& [single, precise] = pair;
  finite = finite && all_finite(single) && all_finite(precise);
  for (std::size_t i = 0; i < single.rays; ++i) {
    const bool here = single.transmittance[i] < 1.0F, there = precise.transmittance[i] < 1.0F;
    hit += there ? 1U : 0U;
    if (here != there) ++otherwise;
    if (!(here && there)) continue;
    const double true_m = static_cast<double>(precise.expected_distance(i));
    const double error_m = std::abs(static_cast<double>(single.expected_distance(i)) - true_m);
    transmittance = std::max(transmittance,
                             std::abs(static_cast<double>(single.transmittance[i]) -
                                      static_cast<double>(precise.transmittance[i])));
    distance = std::max(distance, error_m / std::max(true_m, range_m));
  }
}

/// Collects rows and checks them against their bounds.
class Table {
 public:
  explicit Table(ExtremesReport& report) : report_(report) {}
  void add(const std::string& name, double value, double bound, const char* unit) {
    report_.rows.push_back({name + "_error", value, unit, 0.0});
    report_.rows.push_back({name + "_bound", bound, unit, 0.0});
    if (!(value <= bound)) fail(name, value, bound);
  }
  void fail(const std::string& name, double value, double bound) {
    report_.broken.push_back(fmt::format("{}: found {:.3g}, allowed at most {:.3g}", name, value, bound));
  }
  void need(bool holds, const std::string& what) {
    if (!holds) report_.broken.push_back(what);
  }
  void share(const std::string& name, double value, double bound) {
    report_.rows.push_back({name, value, "of rays", 0.0});
    if (!(value <= bound)) fail(name, value, bound);
  }

 private:
  ExtremesReport& report_;
};

void run_case(Builds& builds, const Rig& rig, const Extreme& extreme, Table& table) {
  std::mt19937_64 random(7);
  const Vector3d offset = extreme.scene_offset_m * Vector3d(0.6, -0.8, 0.0);
  // As in all readers: world poses minus the scene origin, in double.
  const Vector3d origin = extreme.world_offset_m * Vector3d(0.5, 0.8, 0.0);
  const Vector3d place = offset + Vector3d(0.3, -0.2, 1.6);  // position of the sensor in the scene
  View view = rig.view(origin + place, extreme.range_m);
  view.scene_from_sensor_start.translation -= origin;
  view.scene_from_sensor_end.translation -= origin;
  Worst worst;
  for (int k = 0; k < kOfEachCase; ++k) {
    const GaussianSet set = particle_on_a_ray(rig, view, extreme, random);
    worst.add(builds.render(set, view), extreme.range_m);
  }
  // Rounding in standard deviations grows as particles become thinner relative to their distance.
  const double widened = std::sqrt(rig.kappa()) * extreme.range_m;
  const double thin = std::hypot(extreme.scale_m.minCoeff(), widened);
  const double wide = std::hypot(extreme.scale_m.maxCoeff(), widened);
  const double rounding_m = kFloatUnit * (kRoundings * extreme.range_m + kPlaceRoundings * place.norm());
  const std::string base = fmt::format("extremes/{}/{}", rig.name(), extreme.name);
  table.need(worst.finite, base + ": a value is not finite");
  table.need(worst.hit > 0, base + ": no ray hits any particle");
  table.add(base + "/transmittance", worst.transmittance, kTransmittanceFloor + rounding_m / thin, "of 1");
  // At a grazing angle the shift along a particle exceeds the shift across it by its aspect ratio.
  table.add(base + "/distance",
            worst.distance,
            kDistanceFloor + rounding_m / extreme.range_m * (wide / thin),
            "relative");
  table.share(base + "/decided_otherwise",
              static_cast<double>(worst.otherwise) / static_cast<double>(std::max<std::size_t>(worst.hit, 1)),
              kDecidedOtherwise);
}

/// Renders all cases near the scene origin together, except cases that would fill the view.
void run_set(Builds& builds, const Rig& rig, Table& table) {
  std::mt19937_64 random(11);
  const View view = rig.view({0.3, -0.2, 1.6}, 0.25);
  std::vector<GaussianSet> parts;
  for (const Extreme& extreme : all_cases()) {
    if (extreme.scene_offset_m > 0.0 || extreme.scale_m.maxCoeff() > 50.0) continue;
    for (int k = 0; k < kOfEachCase; ++k) parts.push_back(particle_on_a_ray(rig, view, extreme, random));
  }
  GaussianSet set(rig.kind, 0, static_cast<Eigen::Index>(parts.size()));
  for (std::size_t k = 0; k < parts.size(); ++k) {
    set.params.row(static_cast<Eigen::Index>(k)) = parts[k].params.row(0);
  }
  set.opacity_logit().setConstant(kSetOpacityLogit);
  const Builds::Pair pair = builds.render(set, view);
  std::vector<double> errors;
  for (std::size_t i = 0; i < pair.single.rays; ++i) {
    errors.push_back(std::abs(static_cast<double>(pair.single.transmittance[i]) -
                              static_cast<double>(pair.precise.transmittance[i])));
  }
  const auto place = static_cast<std::ptrdiff_t>(kSetShare * static_cast<double>(errors.size()));
  std::nth_element(errors.begin(), errors.begin() + place, errors.end());
  const std::string base = fmt::format("extremes/{}/all_of_them", rig.name());
  table.need(all_finite(pair.single) && all_finite(pair.precise), base + ": a value is not finite");
  table.add(base + "/transmittance_p99", errors[static_cast<std::size_t>(place)], kSetTransmittance, "of 1");
}

}  // namespace

ExtremesReport run_extremes(const std::string& device_request,
                            const std::function<void(const std::string&)>& note) {
  const Device device = Device::best(device_request);
  if (!device.info().fp64) {
    throw Error(ErrorKind::kDevice,
                fmt::format("bench --extremes: found {} without double precision, allowed a device with fp64",
                            device.info().label()));
  }
  note(fmt::format("device: {} (driver {})", device.info().label(), device.info().driver_version));
  ExtremesReport report;
  Table table(report);
  Builds builds(device);
  for (const SetKind kind : {SetKind::kCamera, SetKind::kLidar}) {
    for (const Motion& motion : kMotions) {
      const Rig rig(kind, motion);
      builds.use(rig);
      for (const Extreme& extreme : all_cases()) run_case(builds, rig, extreme, table);
      run_set(builds, rig, table);
    }
  }
  return report;
}

}  // namespace simuli::bench
