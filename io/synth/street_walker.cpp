#include "io/synth/street_walker.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace simuli {
namespace {

using Eigen::Vector3d;

constexpr double kHip_m = 0.90, kHipSide_m = 0.10, kThigh_m = 0.44, kShank_m = 0.42;
constexpr double kShoulder_m = 1.36, kShoulderSide_m = 0.23, kArm_m = 0.58;
constexpr double kLegSwing_rad = 0.42, kArmSwing_rad = 0.35, kKnee_rad = 0.7;
constexpr double kHeight_m = 1.74;
constexpr Eigen::Index kX = 0;

/// A ball swept from `from` to `to`.
struct Capsule {
  Vector3d from, to;
  double radius = 0.0;
  Vector3d albedo;
  double reflectance = 0.0;
  double bands_m = 0.0;  // width of darker bands across it; 0: none
};

/// Returns the downward direction rotated forward by the angle.
Vector3d swung(double angle_rad) { return {std::sin(angle_rad), 0.0, -std::cos(angle_rad)}; }

std::array<Capsule, 8> body_at(const StreetWalker& walker, double time_s) {
  const Vector3d skin(0.72, 0.52, 0.42), shirt(0.78, 0.16, 0.14), trousers(0.20, 0.26, 0.44);
  std::array<Capsule, 8> out{
      Capsule{{0.0, 0.0, 0.98}, {0.0, 0.0, 1.32}, 0.17, shirt, 0.5, 0.08},
      Capsule{{0.0, 0.0, 1.60}, {0.01, 0.0, 1.62}, 0.115, skin, 0.45, 0.0},
  };
  for (std::size_t side = 0; side < 2; ++side) {
    const double left = side == 0 ? 1.0 : -1.0;
    const double phase = 2.0 * std::numbers::pi * (walker.strides_per_s * time_s + (side == 0 ? 0.0 : 0.5));
    const double hip = kLegSwing_rad * std::sin(phase);
    // The knee bends while the leg swings forward.
    const double knee = kKnee_rad * std::max(0.0, std::cos(phase));
    const Vector3d hip_at(0.0, left * kHipSide_m, kHip_m);
    const Vector3d knee_at = hip_at + kThigh_m * swung(hip);
    const Vector3d foot_at = knee_at + kShank_m * swung(hip - knee);
    const Vector3d shoulder(0.0, left * kShoulderSide_m, kShoulder_m);
    const Vector3d hand = shoulder + kArm_m * swung(-kArmSwing_rad * std::sin(phase));
    out[2 + 3 * side] = {hip_at, knee_at, 0.085, trousers, 0.35, 0.11};
    out[3 + 3 * side] = {knee_at, foot_at, 0.065, trousers, 0.35, 0.11};
    out[4 + 3 * side] = {shoulder, hand, 0.05, shirt, 0.5, 0.08};
  }
  return out;
}

/// Intersects the ray with the capsule from outside; along: m from its start.
bool meet(const Capsule& c, const Vector3d& origin, const Vector3d& direction, double& range, double& along) {
  const Vector3d axis = c.to - c.from, arm = origin - c.from;
  const double axis2 = axis.squaredNorm();
  bool met = false;
  const auto take = [&](double at, double place) {
    if (!(at > 0.0 && at < range)) return;
    range = at;
    along = place * std::sqrt(axis2);
    met = true;
  };
  const auto roots = [](double a, double b, double k, double& first) {
    const double d = b * b - a * k;
    if (d < 0.0 || a <= 0.0) return false;
    first = (-b - std::sqrt(d)) / a;
    return true;
  };
  const double d_axis = direction.dot(axis) / axis2, a_axis = arm.dot(axis) / axis2;
  const Vector3d d_across = direction - d_axis * axis, a_across = arm - a_axis * axis;
  double first = 0.0;
  if (roots(d_across.squaredNorm(),
            d_across.dot(a_across),
            a_across.squaredNorm() - c.radius * c.radius,
            first)) {
    const double place = a_axis + first * d_axis;
    if (place >= 0.0 && place <= 1.0) take(first, place);
  }
  for (const double end : {0.0, 1.0}) {
    const Vector3d from_end = arm - end * axis;
    if (roots(1.0, direction.dot(from_end), from_end.squaredNorm() - c.radius * c.radius, first))
      take(first, end);
  }
  return met;
}

}  // namespace

Pose StreetWalker::world_from_walker(double time_s) const {
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(heading_rad, Vector3d::UnitZ()));
  const Vector3d feet(start_m.x(), start_m.y(), 0.0);
  return {turn, feet + speed_m_per_s * time_s * (turn * Vector3d::Unit(kX))};
}

Actor StreetWalker::actor(double start_s, double end_s) const {
  constexpr double kKeyPeriod_s = 0.1;
  Actor out;
  out.name = "person";
  out.kind = "pedestrian";
  out.size_m = {1.04, 0.60, kHeight_m};
  const int keys = static_cast<int>(std::ceil((end_s - start_s) / kKeyPeriod_s - 1e-9));
  for (int i = 0; i <= keys; ++i) {
    const double time_s = start_s + i * kKeyPeriod_s;
    Pose middle = world_from_walker(time_s);
    middle.translation.z() += 0.5 * kHeight_m;
    out.track.push_back({time_s, middle});
  }
  return out;
}

WalkerHit meet_walker(const StreetWalker& walker,
                      const Vector3d& origin,
                      const Vector3d& direction,
                      double time_s,
                      double range) {
  const Pose walker_from_world = walker.world_from_walker(time_s).inverse();
  const Vector3d o = walker_from_world * origin, d = walker_from_world.rotation * direction;
  WalkerHit hit;
  // Most rays miss a sphere around the person.
  const Vector3d to_middle = Vector3d(0.0, 0.0, 0.5 * kHeight_m) - o;
  if ((to_middle - to_middle.dot(d) * d).squaredNorm() > 1.1 * 1.1) return hit;
  double nearest = range, along = 0.0;
  const std::array<Capsule, 8> body = body_at(walker, time_s);
  for (const Capsule& part : body) {
    if (!meet(part, o, d, nearest, along)) continue;
    const Vector3d axis = (part.to - part.from).normalized(), point = o + nearest * d;
    const double length = (part.to - part.from).norm();
    const double place = std::clamp((point - part.from).dot(axis), 0.0, length);
    hit.hit = true;
    hit.range = nearest;
    hit.normal = walker_from_world.rotation.conjugate() * (point - part.from - place * axis).normalized();
    const bool dark = part.bands_m > 0.0 && std::fmod(along, 2.0 * part.bands_m) > part.bands_m;
    hit.albedo = part.albedo * (dark ? 0.6 : 1.0);
    hit.reflectance = part.reflectance * (dark ? 0.8 : 1.0);
  }
  return hit;
}

}  // namespace simuli
