#include "host/scene/actor.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "host/base/close_names.hpp"
#include "host/base/error.hpp"

namespace simuli {

Pose KeyPose::corrected() const {
  const double angle = turn_rad.norm();
  const Eigen::Vector3d axis = angle > 0.0 ? Eigen::Vector3d(turn_rad / angle) : Eigen::Vector3d::UnitZ();
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(angle, axis));
  return {(turn * world_from_actor.rotation).normalized(), world_from_actor.translation + shift_m};
}

bool Actor::is_there(double time_s) const {
  return !track.empty() && time_s >= track.front().time_s - kReach_s &&
         time_s <= track.back().time_s + kReach_s;
}

KeyShare Actor::key_share(double time_s) const {
  if (track.size() < 2) return {};
  const auto next =
      std::upper_bound(track.begin() + 1, track.end() - 1, time_s, [](double t, const KeyPose& key) {
        return t < key.time_s;
      });
  const auto key = static_cast<std::size_t>(next - track.begin()) - 1;
  const double from_s = track[key].time_s;
  return {key, (time_s - from_s) / (track[key + 1].time_s - from_s)};
}

Pose Actor::at(double time_s) const {
  const KeyShare at = key_share(time_s);
  const Pose first = track[at.key].corrected();
  return track.size() < 2 ? first : interpolate(first, track[at.key + 1].corrected(), at.share);
}

double Actor::travel_m() const {
  double farthest = 0.0;
  for (const KeyPose& key : track) {
    const Eigen::Vector3d moved =
        key.world_from_actor.translation - track.front().world_from_actor.translation;
    farthest = std::max(farthest, moved.norm());
  }
  return farthest;
}

void validate(const Actor& actor, const std::string& where) {
  if (actor.name.empty()) throw_input_error(where, "name", "none", "a name of its own");
  if (!(actor.size_m.allFinite() && actor.size_m.minCoeff() > 0.0)) {
    throw_input_error(where,
                      actor.name + ": size",
                      fmt::format("{} x {} x {} m", actor.size_m.x(), actor.size_m.y(), actor.size_m.z()),
                      "finite and above 0");
  }
  if (actor.track.empty()) throw_input_error(where, actor.name + ": track", "no pose", "at least one");
  for (std::size_t i = 0; i < actor.track.size(); ++i) {
    const KeyPose& key = actor.track[i];
    const auto field = [&] { return fmt::format("{}: track[{}]", actor.name, i); };
    const bool finite = std::isfinite(key.time_s) && key.world_from_actor.translation.allFinite() &&
                        key.world_from_actor.rotation.coeffs().allFinite() && key.shift_m.allFinite() &&
                        key.turn_rad.allFinite();
    if (!finite) throw_input_error(where, field(), "NaN or Inf", "finite numbers");
    if (i > 0 && !(key.time_s > actor.track[i - 1].time_s)) {
      throw_input_error(where,
                        field(),
                        fmt::format("{} s after {} s", key.time_s, actor.track[i - 1].time_s),
                        "strictly increasing times");
    }
  }
}

bool has_actor(const std::vector<Actor>& actors, const std::string& name) {
  return std::any_of(actors.begin(), actors.end(), [&](const Actor& actor) { return actor.name == name; });
}

std::size_t find_actor(const std::vector<Actor>& actors, const std::string& name) {
  std::vector<std::string> known;
  for (std::size_t i = 0; i < actors.size(); ++i) {
    if (actors[i].name == name) return i;
    known.push_back(actors[i].name);
  }
  // Of many, those that resemble it; all of them where nobody would see the one that is meant otherwise.
  constexpr std::size_t kFew = 8;
  const std::string meant = did_you_mean(name, known);
  std::string allowed = fmt::format("{}", fmt::join(known, ", "));
  if (known.empty()) allowed = "none: there are no actors";
  if (known.size() > kFew && !meant.empty()) allowed = fmt::format("one of {} actors", known.size());
  throw Error(ErrorKind::kUsage, fmt::format("actor: found \"{}\", {}allowed {}", name, meant, allowed));
}

std::vector<ActorView> actors_during(const std::vector<Actor>& actors,
                                     double time_start_s,
                                     double time_end_s,
                                     const Eigen::Vector3d& scene_origin) {
  std::vector<ActorView> views;
  views.reserve(actors.size());
  for (const Actor& actor : actors) {
    ActorView view;
    view.is_there = actor.is_there(0.5 * (time_start_s + time_end_s));
    if (view.is_there) {
      view.scene_from_actor_start = actor.at(time_start_s);
      view.scene_from_actor_end = actor.at(time_end_s);
      view.scene_from_actor_start.translation -= scene_origin;
      view.scene_from_actor_end.translation -= scene_origin;
    }
    views.push_back(view);
  }
  return views;
}

}  // namespace simuli
