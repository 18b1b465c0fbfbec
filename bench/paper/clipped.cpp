#include "bench/paper/clipped.hpp"

#include <array>
#include <cmath>
#include <fmt/format.h>
#include <numbers>
#include <random>
#include <string>
#include <utility>

#include "host/device/render/scene/renderer.hpp"

namespace simuli::bench {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kRange_m = 5.0;

constexpr std::array<std::pair<Projection, const char*>, 3> kProjections{
    {{Projection::kUnscented, "unscented"},
     {Projection::kLinearized, "linearized"},
     {Projection::kMonteCarlo, "monte_carlo"}}};

/// A sensor, its motion in a frame, and the directions of particles in its frame.
struct Place {
  std::string name;
  SetKind kind = SetKind::kCamera;
  Camera camera{};
  Lidar lidar{};
  View view{};
  double azimuth_rad = 0.0;  // maximum angle to either side of x (LiDAR) or z (camera)
  double lowest_rad = 0.0, highest_rad = 0.0;

  [[nodiscard]] SensorRays on(const Device& device, const RenderOptions& options) const {
    if (kind == SetKind::kCamera) return {device, camera, options};
    return {device, lidar, nominal_rays(lidar), options};
  }
};

Camera camera_of(LensKind kind, double focal_px) {
  Camera camera{};
  camera.name = "clipped";
  camera.width = 320;
  camera.height = 200;
  camera.fx = camera.fy = focal_px;
  camera.cx = 160.0;
  camera.cy = 100.0;
  if (kind != LensKind::kPinhole) camera.lens = Lens(kind, {0.0, 0.0, 0.0, 0.0, kPi});
  return camera;
}

Place moving(Place place, const Eigen::Vector3d& step_m, const Eigen::Vector3d& axis, double turn_rad) {
  place.name += "_moving";
  // Symmetric about the middle of the frame, at which particles are placed.
  const Eigen::Quaterniond half(Eigen::AngleAxisd(0.5 * turn_rad, axis));
  place.view.scene_from_sensor_start = {half.conjugate(), -0.5 * step_m};
  place.view.scene_from_sensor_end = {half, 0.5 * step_m};
  place.camera.shutter = ShutterKind::kTopToBottom;
  return place;
}

std::vector<Place> places(const Lidar& lidar) {
  Place spinning{.name = "lidar", .kind = SetKind::kLidar, .lidar = lidar};
  spinning.azimuth_rad = 3.0;
  spinning.lowest_rad = -0.3;
  spinning.highest_rad = 0.05;
  Place pinhole{.name = "pinhole", .camera = camera_of(LensKind::kPinhole, 134.0)};
  pinhole.azimuth_rad = 0.8;
  pinhole.highest_rad = 0.5;
  pinhole.lowest_rad = -0.5;
  Place fisheye{.name = "fisheye", .camera = camera_of(LensKind::kOpencvFisheye, 320.0 / kPi)};
  fisheye.azimuth_rad = 1.4;
  fisheye.highest_rad = 0.8;
  fisheye.lowest_rad = -0.8;
  const Eigen::Vector3d forward = Eigen::Vector3d::UnitZ(), down = Eigen::Vector3d::UnitY();
  return {spinning,
          moving(spinning, 3.0 * Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitZ(), 0.15),
          pinhole,
          moving(pinhole, forward, down, 0.07),
          fisheye};
}

/// Returns a long particle in a random direction, whose length is `size` times its range.
GaussianSet long_particle(const Place& place, double size, std::mt19937_64& random) {
  const auto in = [&random](double low, double high) {
    return low + (high - low) * static_cast<double>(random() >> 11U) * 0x1p-53;
  };
  GaussianSet set(place.kind, 0, 1);
  const Eigen::Vector3d d =
      Lidar::direction(in(-place.azimuth_rad, place.azimuth_rad), in(place.lowest_rad, place.highest_rad));
  const bool camera = place.kind == SetKind::kCamera;
  const Eigen::Vector3d mean = kRange_m * (camera ? Eigen::Vector3d(-d.y(), -d.z(), d.x()) : d);
  set.mean().row(0) = mean.cast<float>().transpose();
  const auto length = static_cast<float>(std::log(size * kRange_m));
  const auto width = static_cast<float>(std::log(0.2 * size * kRange_m));
  set.log_scale().row(0) << length, width, width;
  for (int k = 0; k < 4; ++k) set.rotation()(0, k) = static_cast<float>(in(-1.0, 1.0));
  return set;  // logit 0: opacity 0.5
}

/// Returns the light that all rays gather from each particle.
std::vector<double> gathered(const Device& device,
                             const Place& place,
                             const RenderOptions& options,
                             const std::vector<GaussianSet>& particles) {
  Renderer renderer(device, options);
  const SensorRays rays = place.on(device, options);
  std::vector<double> sums;
  for (const GaussianSet& set : particles) {
    const RayResults seen =
        renderer.render(ParticleBuffers(device, set, options.precision), rays, place.view).results();
    double sum = 0.0;
    for (const float left : seen.transmittance) sum += 1.0 - static_cast<double>(left);
    sums.push_back(sum);
  }
  return sums;
}

}  // namespace

void add_clipped(const Device& device, const Lidar& lidar, const Note& note, std::vector<Row>& rows) {
  constexpr int kParticles = 40;
  constexpr std::array<double, 4> kSizes{0.05, 0.1, 0.2, 0.3};
  for (const Place& place : places(lidar)) {
    std::mt19937_64 random(3);
    std::vector<GaussianSet> particles;
    for (const double size : kSizes) {
      for (int k = 0; k < kParticles; ++k) particles.push_back(long_particle(place, size, random));
    }
    RenderOptions exact;
    exact.extent = Extent::kExact;
    const std::vector<double> whole = gathered(device, place, exact, particles);
    for (const auto& [projection, name] : kProjections) {
      RenderOptions options = paper_options();
      options.projection = projection;
      const std::vector<double> found = gathered(device, place, options, particles);
      for (std::size_t s = 0; s < kSizes.size(); ++s) {
        double all = 0.0, lost = 0.0, square = 0.0;
        const std::size_t first = s * kParticles, last = first + kParticles;
        for (std::size_t k = first; k < last; ++k) {
          all += whole[k];
          lost += whole[k] - found[k];
        }
        for (std::size_t k = first; k < last; ++k)
          square += std::pow(whole[k] * (1.0 - lost / all) - found[k], 2);
        rows.push_back(
            {fmt::format("table8_clipped/{}/{}/size_{:.0f}_percent", place.name, name, 100.0 * kSizes[s]),
             100.0 * lost / all,
             "%",
             100.0 * std::sqrt(square * kParticles / (kParticles - 1)) / all});
      }
    }
    note("table8_clipped/" + place.name);
  }
}

}  // namespace simuli::bench
