// Implements the blending of tests/support/reference.hpp.
#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "host/core/base/error.hpp"
#include "tests/support/reference.hpp"

namespace simuli::reference {
namespace {

using Eigen::Vector3d;

constexpr double kMaxAlpha = 0.999;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Range of tau in which a sensor measures particles.
struct Range {
  double min_m = 0.01;
  double max_m = 1e6;
};

Range range_of(const Sensor& sensor) {
  if (sensor.kind == SetKind::kCamera) return {};
  return {sensor.lidar.range_min, sensor.lidar.range_max};
}

/// A conjunction of conditions with its distance from another outcome.
struct Decision {
  bool holds = true;
  double margin = kInfinity;

  /// `distance`: relative distance of the condition's two sides.
  void require(bool condition, double distance) {
    distance = std::abs(distance);
    if (holds && condition) {
      margin = std::min(margin, distance);
    } else if (holds) {
      holds = false;
      margin = distance;
    } else if (!condition) {
      margin = std::max(margin, distance);  // all failing conditions would have to change
    }
  }
};

/// Contribution of one particle to one ray.
struct Candidate {
  std::size_t particle = 0;
  double alpha = 0.0;
  double tau = 0.0;  // m
  double key = 0.0;  // order along the ray
  Vector3d feature = Vector3d::Zero();
  Decision included;
};

/// Returns the distance from a centre to the nearest pixel row of y's block of four: a box contains complete
/// blocks of rows.
double block_distance(double y, double mean) {
  const double first = std::floor(y / 4.0) * 4.0 + 0.5;
  return first + std::clamp(std::round(mean - first), 0.0, 3.0) - mean;
}

Candidate respond(
    const Ray& ray, const Vector3d& mean, const Footprint& f, const Sensor& sensor, const Options& options) {
  const Eigen::Matrix3d unit_from_scene =
      f.filtered_scale.cwiseInverse().asDiagonal() * f.scene_from_particle.transpose();
  const Vector3d o_g = unit_from_scene * (ray.origin - mean);
  const Vector3d d_g = unit_from_scene * ray.direction;
  const double q = o_g.cross(d_g).squaredNorm() / d_g.squaredNorm();

  Candidate c;
  c.tau = -o_g.dot(d_g) / d_g.dot(d_g);
  c.alpha = std::min(f.opacity * std::exp(-0.5 * q), kMaxAlpha);
  c.key = options.per_ray_order ? c.tau : f.range_key;
  c.included.require(c.alpha >= options.alpha_cut, c.alpha / options.alpha_cut - 1.0);
  const Range range = range_of(sensor);
  c.included.require(c.tau > range.min_m, c.tau / range.min_m - 1.0);
  c.included.require(c.tau < range.max_m, c.tau / range.max_m - 1.0);
  if (!options.ignore_box) {
    double dx = ray.x - f.mean.x();
    if (sensor.kind == SetKind::kLidar && std::abs(ray.x - f.other_x) < std::abs(dx)) dx = ray.x - f.other_x;
    double dy = ray.y - f.mean.y();
    if (sensor.kind == SetKind::kCamera) dy = block_distance(ray.y, f.mean.y());
    c.included.require(std::abs(dx) <= f.half_width.x(), std::abs(dx) / f.half_width.x() - 1.0);
    c.included.require(std::abs(dy) <= f.half_width.y(), std::abs(dy) / f.half_width.y() - 1.0);
  }
  return c;
}

/// Blends candidates in the order of the ray, ties by particle.
RayResult blend(std::vector<Candidate> candidates, const Options& options, const Vector3d& background) {
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return std::tie(a.key, a.particle) < std::tie(b.key, b.particle);
  });
  RayResult result;
  result.margin = kInfinity;
  result.median_margin = kInfinity;
  double last_key = -kInfinity;
  for (const Candidate& c : candidates) {
    result.margin = std::min(result.margin, c.included.margin);
    if (!c.included.holds) continue;
    result.margin = std::min(result.margin, (c.key - last_key) / std::abs(c.key));
    last_key = c.key;

    const double weight = c.alpha * result.transmittance;
    result.feature += weight * c.feature;
    result.distance += weight * c.tau;
    const double before = result.transmittance;
    result.transmittance *= 1.0 - c.alpha;
    if (before > 0.5 && result.transmittance <= 0.5) result.median_distance = c.tau;
    ++result.contributors;

    result.margin = std::min(result.margin, std::abs(result.transmittance / options.transmittance_cut - 1.0));
    result.median_margin = std::min(result.median_margin, std::abs(result.transmittance - 0.5));
    if (result.transmittance < options.transmittance_cut) break;
  }
  result.feature += result.transmittance * background;
  return result;
}

}  // namespace

std::vector<RayResult> render(const Particles& particles,
                              const Sensor& sensor,
                              const std::vector<Ray>& rays,
                              const std::vector<Footprint>& footprints,
                              const Options& options,
                              const Vector3d& background) {
  if (particles.size() != static_cast<Eigen::Index>(footprints.size())) {
    throw Error(ErrorKind::kInternal, "footprints of another number than particles");
  }
  std::vector<RayResult> results;
  for (const Ray& ray : rays) {
    std::vector<Candidate> candidates;
    for (std::size_t i = 0; i < footprints.size(); ++i) {
      if (!footprints[i].visible) continue;
      const Vector3d mean =
          particles.params.row(static_cast<Eigen::Index>(i)).segment<3>(kMeanRow).transpose();
      Candidate c = respond(ray, mean, footprints[i], sensor, options);
      c.particle = i;
      c.feature = options.per_ray_features
                      ? feature_of(particles, static_cast<Eigen::Index>(i), ray.direction)
                      : footprints[i].feature;
      candidates.push_back(c);
    }
    results.push_back(blend(std::move(candidates), options, background));
  }
  return results;
}

std::vector<RayResult> render(const Particles& particles,
                              const Sensor& sensor,
                              const Options& options,
                              const Vector3d& background) {
  return render(particles, sensor, rays(sensor), project(particles, sensor, options), options, background);
}

}  // namespace simuli::reference
