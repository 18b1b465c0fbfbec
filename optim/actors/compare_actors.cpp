#include "optim/actors/compare_actors.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>

namespace simuli {
namespace {

constexpr double kBeside_m = 1.0;
constexpr std::size_t kLeastTimes = 3;

double at_share(std::vector<double> values, double share) {
  const auto place =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

/// Poses of the found actor in the label's frame, at its key times within the label's duration.
std::vector<Pose> common_poses(const Actor& label, const Actor& found) {
  std::vector<Pose> out;
  for (const KeyPose& key : found.track) {
    if (key.time_s < label.track.front().time_s || key.time_s > label.track.back().time_s) continue;
    out.push_back(label.at(key.time_s).inverse() * key.corrected());
  }
  return out;
}

void measure(const std::vector<Pose>& label_from_found, ActorMatch& match) {
  std::array<std::vector<double>, 3> at;
  std::vector<double> turns;
  for (const Pose& p : label_from_found) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      at[axis].push_back(p.translation(static_cast<Eigen::Index>(axis)));
    const Eigen::Vector3d x = p.rotation * Eigen::Vector3d::UnitX();
    turns.push_back(std::atan2(x.y(), x.x()));
  }
  for (std::size_t axis = 0; axis < 3; ++axis)
    match.offset_m(static_cast<Eigen::Index>(axis)) = at_share(at[axis], 0.5);
  match.turned_rad = at_share(turns, 0.5);
  std::vector<double> apart, turned;
  for (std::size_t k = 0; k < turns.size(); ++k) {
    apart.push_back((label_from_found[k].translation - match.offset_m).norm());
    turned.push_back(std::abs(std::remainder(turns[k] - match.turned_rad, 2.0 * M_PI)));
  }
  match.centre_m = at_share(apart, 0.5);
  match.centre_p90_m = at_share(apart, 0.9);
  match.heading_rad = at_share(turned, 0.5);
}

}  // namespace

std::optional<ActorMatch> match_actor(const Actor& labelled, const Actor& found) {
  const std::vector<Pose> label_from_found = common_poses(labelled, found);
  const auto inside = static_cast<std::size_t>(
      std::count_if(label_from_found.begin(), label_from_found.end(), [&](const Pose& p) {
        return (p.translation.array().abs() <= 0.5 * labelled.size_m.array() + kBeside_m).all();
      }));
  if (inside < kLeastTimes || 2 * inside < label_from_found.size()) return std::nullopt;
  ActorMatch match;
  match.labelled = labelled.name;
  match.labelled_s = labelled.track.back().time_s - labelled.track.front().time_s;
  match.labelled_size_m = labelled.size_m;
  match.found = found.name;
  match.found_size_m = found.size_m;
  match.times = inside;
  measure(label_from_found, match);
  return match;
}

ActorComparison compare_actors(const std::vector<Actor>& labelled,
                               const std::vector<Actor>& found,
                               double min_travel_m) {
  ActorComparison out;
  std::set<std::string> used;
  for (const Actor& label : labelled) {
    if (label.travel_m() < min_travel_m) continue;
    ActorMatch best;
    best.labelled = label.name;
    best.labelled_s = label.track.back().time_s - label.track.front().time_s;
    best.labelled_size_m = label.size_m;
    for (const Actor& actor : found) {
      auto match = match_actor(label, actor);
      if (match && match->times > best.times) best = *std::move(match);
    }
    if (best.times > 0) used.insert(best.found);
    out.labels.push_back(std::move(best));
  }
  for (const Actor& actor : found) {
    if (used.count(actor.name) == 0) out.others.push_back(actor.name);
  }
  return out;
}

}  // namespace simuli
