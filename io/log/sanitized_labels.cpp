#include "io/log/sanitized_labels.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <fmt/format.h>
#include <numbers>
#include <utility>

#include "host/core/base/split.hpp"
#include "host/core/base/spread.hpp"

namespace simuli {
namespace {

using Eigen::Vector3d;

// Tolerances that no label of the street, 0013 and 0052 exceeds; short objects turn like people.
constexpr double kVehicle_m = 2.5;  // least length of objects that turn like vehicles
constexpr double kVehicleTurn_rad_per_s = 1.5, kTurn_rad_per_s = 6.0;
constexpr double kLabel_rad = 0.6;  // scatter of the headings of an object that does not turn
constexpr double kDriving_m_per_s = 1.0;
// Scatter of an object's positions, excess of a single label's speed over the median, and largest speed.
constexpr double kPosition_m = 1.5, kFaster_m_per_s = 15.0, kFastest_m_per_s = 100.0;
constexpr int kLeastDriving = 3;      // least majority of labels that drive in one direction
constexpr double kAboveRoof_m = 1.5;  // height of the ego vehicle's sensors
// Lanes are 3.5 m wide; 96/53/EC allows vehicles of up to 25.25 m. Trams and trains are 2.7 m wide.
constexpr double kWidestDriving_m = 5.0, kLongestDriving_m = 30.0, kLongestOnRails_m = 400.0;
constexpr double kDrives_m = 3.0;  // least travel of a moving object; static ones may be buildings

/// The headings of one labelled object.
class Headings {
 public:
  explicit Headings(Actor& actor)
      : track_(actor.track),
        most_rad_per_s_(actor.size_m.maxCoeff() >= kVehicle_m ? kVehicleTurn_rad_per_s : kTurn_rad_per_s) {}

  /// Reverses flipped headings; returns their number.
  std::size_t unflip() {
    std::size_t all = 0;
    for (std::size_t first = 0; first < track_.size();) {
      std::vector<std::size_t> flipped;  // relative to the first heading
      std::size_t end = first + 1;
      for (; end < track_.size() && most_rad(end - 1, end) < std::numbers::pi; ++end) {
        if (can_turn(end - 1, end)) continue;
        flip(end);
        // Later headings are compared with unchanged ones.
        if (can_turn(end - 1, end))
          flipped.push_back(end);
        else
          flip(end);
      }
      if (!flipped.empty()) all += settle(first, end, flipped.size());
      first = end;
    }
    return all;
  }

  /// Replaces single outliers; returns their number.
  std::size_t straighten() {
    const std::size_t count = track_.size();
    std::size_t all = 0;
    for (std::size_t k = 0; count > 2 && k < count; ++k) {
      const std::size_t before = k == 0 ? 1 : k - 1, after = k + 1 == count ? count - 2 : k + 1;
      if (can_turn(before, k) || can_turn(k, after)) continue;
      if (before == after ? !can_turn(before, k == 0 ? 2 : count - 3) : !can_turn(before, after)) continue;
      const double whole_s = track_[after].time_s - track_[before].time_s;
      const double share = before == after ? 0.0 : (track_[k].time_s - track_[before].time_s) / whole_s;
      rotation(k) =
          interpolate(track_[before].world_from_actor, track_[after].world_from_actor, share).rotation;
      ++all;
    }
    return all;
  }

  /// Returns the first heading that the object cannot reach from the previous one; 0: none.
  [[nodiscard]] std::size_t first_wrong() const {
    for (std::size_t k = 1; k < track_.size(); ++k) {
      if (!can_turn(k - 1, k)) return k;
    }
    return 0;
  }
  [[nodiscard]] double turn_rad(std::size_t a, std::size_t b) const {
    return track_[a].world_from_actor.rotation.angularDistance(track_[b].world_from_actor.rotation);
  }

 private:
  Eigen::Quaterniond& rotation(std::size_t k) { return track_[k].world_from_actor.rotation; }
  void flip(std::size_t k) { rotation(k) = rotation(k) * Eigen::Quaterniond(0.0, 0.0, 0.0, 1.0); }
  [[nodiscard]] double most_rad(std::size_t a, std::size_t b) const {
    return kLabel_rad + most_rad_per_s_ * std::abs(track_[b].time_s - track_[a].time_s);
  }
  [[nodiscard]] bool can_turn(std::size_t a, std::size_t b) const { return turn_rad(a, b) <= most_rad(a, b); }

  /// The headings [first, end) agree, `flipped` of them were reversed: determines the common direction.
  std::size_t settle(std::size_t first, std::size_t end, std::size_t flipped) {
    int ahead = 0;
    for (std::size_t k = first; k < end; ++k) {
      const KeyPose &before = track_[std::max(k, first + 1) - 1], &after = track_[std::min(k + 1, end - 1)];
      const Vector3d velocity = (after.world_from_actor.translation - before.world_from_actor.translation) /
                                (after.time_s - before.time_s);
      const double forward = velocity.dot(rotation(k) * Vector3d::UnitX());
      ahead += forward > kDriving_m_per_s ? 1 : forward < -kDriving_m_per_s ? -1 : 0;
    }
    const std::size_t kept = end - first - flipped;
    const bool is_right = std::abs(ahead) >= kLeastDriving ? ahead > 0 : kept >= flipped;
    if (is_right) return flipped;
    for (std::size_t k = first; k < end; ++k) flip(k);
    return kept;
  }

  std::vector<KeyPose>& track_;
  double most_rad_per_s_;
};

void sanitize_headings(Actor& actor, std::vector<std::string>& said) {
  Headings headings(actor);
  const std::size_t flipped = headings.unflip();
  const std::size_t off = headings.straighten();
  const std::size_t count = actor.track.size();
  if (flipped > 0)
    said.push_back(
        fmt::format("label {}: {} of {} headings are reversed, corrected", actor.name, flipped, count));
  if (off > 0)
    said.push_back(fmt::format(
        "label {}: {} of {} headings are outliers, replaced by their neighbours", actor.name, off, count));
  if (const std::size_t k = headings.first_wrong(); k > 0)
    said.push_back(fmt::format("label {}: turns by {:.0f} degrees in {:.2f} s at {:.2f} s, left as it is",
                               actor.name,
                               headings.turn_rad(k - 1, k) * 180.0 / std::numbers::pi,
                               actor.track[k].time_s - actor.track[k - 1].time_s,
                               actor.track[k].time_s));
}

double distance_m(const std::vector<KeyPose>& track, std::size_t a, std::size_t b) {
  return (track[a].world_from_actor.translation - track[b].world_from_actor.translation).norm();
}

bool can_get(const std::vector<KeyPose>& track, std::size_t a, std::size_t b, double most_m_per_s) {
  return distance_m(track, a, b) <= kPosition_m + most_m_per_s * std::abs(track[b].time_s - track[a].time_s);
}

/// Whether the object cannot reach this position and return at that speed.
bool is_off(const std::vector<KeyPose>& track, std::size_t k, double most_m_per_s) {
  const std::size_t count = track.size();
  if (count < 3) return false;
  const std::size_t before = k == 0 ? 2 : k - 1, after = k + 1 == count ? count - 3 : k + 1;
  if (k == 0 || k + 1 == count) most_m_per_s = kFastest_m_per_s;  // at an end, braking resembles an outlier
  return !can_get(track, before, k, most_m_per_s) && !can_get(track, k, after, most_m_per_s) &&
         can_get(track, before, after, most_m_per_s);
}

void sanitize_positions(Actor& actor, std::vector<std::string>& said) {
  const std::vector<KeyPose> all = std::exchange(actor.track, {});
  std::vector<KeyPose>& track = actor.track;
  std::vector<double> speeds;
  for (std::size_t k = 1; k < all.size(); ++k)
    speeds.push_back(distance_m(all, k - 1, k) / (all[k].time_s - all[k - 1].time_s));
  const double most_m_per_s = upper_median(std::move(speeds)) + kFaster_m_per_s;
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (!is_off(all, k, most_m_per_s)) track.push_back(all[k]);
  }
  if (track.size() < all.size())
    said.push_back(fmt::format("label {}: {} of {} places are off those before and after, left out",
                               actor.name,
                               all.size() - track.size(),
                               all.size()));
  for (std::size_t k = 1; k < track.size(); ++k) {
    if (can_get(track, k - 1, k, kFastest_m_per_s)) continue;
    said.push_back(fmt::format("label {}: gets {:.0f} m far in {:.2f} s at {:.2f} s, left as it is",
                               actor.name,
                               distance_m(track, k - 1, k),
                               track[k].time_s - track[k - 1].time_s,
                               track[k].time_s));
    break;
  }
}

/// Whether the object is larger than any vehicle.
bool is_too_large(const Actor& actor) {
  if (actor.travel_m() < kDrives_m) return false;
  const std::string kind = lower(actor.kind);
  const bool is_on_rails = kind.find("tram") != std::string::npos || kind.find("train") != std::string::npos;
  const auto [width, length] = std::minmax({actor.size_m.x(), actor.size_m.y()});
  return width > kWidestDriving_m || length > (is_on_rails ? kLongestOnRails_m : kLongestDriving_m);
}

std::vector<Vector3d> sensors_on_rig(const Log& log) {
  std::vector<Vector3d> out;
  for (const LogCamera& camera : log.cameras) out.push_back(camera.rig_from_camera.translation);
  for (const LogLidar& lidar : log.lidars) out.push_back(lidar.rig_from_lidar.translation);
  return out;
}

}  // namespace

std::vector<std::string> sanitize_labels(Log& log) {
  std::vector<std::string> said;
  const std::vector<Vector3d> sensors = sensors_on_rig(log);
  const auto is_on_rig = [&](const Actor& actor, const KeyPose& key) {
    const Trajectory& path = log.world_from_rig;
    if (!path.covers(key.time_s)) return false;
    const Pose actor_from_rig = key.world_from_actor.inverse() * path.at(key.time_s);
    const Vector3d half = 0.5 * actor.size_m;
    return std::any_of(sensors.begin(), sensors.end(), [&](const Vector3d& p_rig) {
      const Vector3d p = actor_from_rig * p_rig;
      return std::abs(p.x()) <= half.x() && std::abs(p.y()) <= half.y() && p.z() >= -half.z() &&
             p.z() <= half.z() + kAboveRoof_m;
    });
  };
  std::vector<Actor> kept;
  for (Actor& actor : log.actors) {
    const std::size_t count = actor.track.size();
    std::erase_if(actor.track, [&](const KeyPose& key) { return is_on_rig(actor, key); });
    const std::size_t own = count - actor.track.size();
    if (2 * own >= count && own > 0) {
      said.push_back(
          fmt::format("label {}: contains the sensors at {} of {} poses, as the ego vehicle does: left out",
                      actor.name,
                      own,
                      count));
      continue;
    }
    if (is_too_large(actor)) {
      said.push_back(
          fmt::format("label {}: found {:.1f} x {:.1f} m, which drives, allowed at most {} x {} m: left out",
                      actor.name,
                      actor.size_m.x(),
                      actor.size_m.y(),
                      kLongestDriving_m,
                      kWidestDriving_m));
      continue;
    }
    if (own > 0)
      said.push_back(
          fmt::format("label {}: {} of {} poses hold the sensors, left out", actor.name, own, count));
    sanitize_positions(actor, said);
    sanitize_headings(actor, said);
    kept.push_back(std::move(actor));
  }
  log.actors = std::move(kept);
  return said;
}

}  // namespace simuli
