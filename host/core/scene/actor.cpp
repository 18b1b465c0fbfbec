#include "host/core/scene/actor.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <utility>

#include "host/core/base/close_names.hpp"
#include "host/core/base/error.hpp"

namespace simuli {
namespace {

void validate(const Deformation& d, const std::string& name, const std::string& where) {
  if (d.empty()) return;
  for (const int n : d.nodes) {
    if (n >= 2 && n <= kMostDeformationNodes) continue;
    throw_input_error(where,
                      name + ": deformation.nodes",
                      fmt::format("{}", n),
                      fmt::format("2 to {} along each side", kMostDeformationNodes));
  }
  const std::size_t row = 3 * d.node_count();
  if (d.offsets_m.size() % row != 0 || d.knots() > kMostDeformationKnots) {
    throw_input_error(where,
                      name + ": deformation.offsets",
                      fmt::format("{} numbers", d.offsets_m.size()),
                      fmt::format("{} of each of 1 to {} knots", row, kMostDeformationKnots));
  }
  if (!(std::isfinite(d.start_s) && std::isfinite(d.interval_s) && d.interval_s > 0.0)) {
    throw_input_error(where,
                      name + ": deformation.interval_s",
                      fmt::format("{} s from {} s", d.interval_s, d.start_s),
                      "finite and above 0");
  }
  const bool sound =
      std::all_of(d.offsets_m.begin(), d.offsets_m.end(), [](double o) { return std::abs(o) < 1e3; });
  if (!sound) throw_input_error(where, name + ": deformation.offsets", "NaN or 1 km", "less");
}

}  // namespace

std::size_t Deformation::node_count() const {
  return static_cast<std::size_t>(nodes[0]) * static_cast<std::size_t>(nodes[1]) *
         static_cast<std::size_t>(nodes[2]);
}

std::size_t Deformation::knots() const { return empty() ? 0 : offsets_m.size() / (3 * node_count()); }

Deformation::KnotShares Deformation::shares(double time_s) const {
  const auto last = static_cast<double>(knots() - 1);
  double u = (time_s - start_s) / interval_s;
  if (last > 0.0) {
    u = std::abs(std::remainder(u, 2.0 * last));
  } else {
    u = 0.0;
  }
  const double whole = std::min(std::floor(u), std::max(last - 1.0, 0.0)), f = u - whole;
  KnotShares out;
  for (int k = 0; k < 4; ++k) {
    out.knot[static_cast<std::size_t>(k)] = static_cast<std::size_t>(std::clamp(whole + (k - 1), 0.0, last));
  }
  const double r = 1.0 - f;
  out.share = {r * r * r / 6.0,
               (3.0 * f * f * f - 6.0 * f * f + 4.0) / 6.0,
               (3.0 * r * r * r - 6.0 * r * r + 4.0) / 6.0,
               f * f * f / 6.0};
  return out;
}

std::vector<double> Deformation::at(double time_s) const {
  if (empty()) return {};
  const KnotShares at = shares(time_s);
  const std::size_t row = 3 * node_count();
  std::vector<double> out(row, 0.0);
  for (std::size_t k = 0; k < 4; ++k) {
    const double* const knot = offsets_m.data() + at.knot[k] * row;
    for (std::size_t i = 0; i < row; ++i) out[i] += at.share[k] * knot[i];
  }
  return out;
}

std::vector<double> DeformationView::at(double share) const {
  std::vector<double> out(start_m.size());
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = (1.0 - share) * start_m[i] + share * end_m[i];
  return out;
}

Eigen::Vector3d deformation_at(const std::array<int, 3>& nodes,
                               const Eigen::Vector3d& half_m,
                               const std::vector<double>& offsets_m,
                               const Eigen::Vector3d& p) {
  std::array<std::size_t, 3> cell{};
  std::array<double, 3> within{};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto axis = static_cast<Eigen::Index>(k);
    const double cells = nodes[k] - 1;
    const double at = std::clamp(0.5 * cells * (p(axis) / half_m(axis) + 1.0), 0.0, cells);
    const double first = std::min(std::floor(at), cells - 1.0);
    cell[k] = static_cast<std::size_t>(first);
    within[k] = at - first;
  }
  Eigen::Vector3d out = Eigen::Vector3d::Zero();
  const auto length = static_cast<std::size_t>(nodes[0]), width = static_cast<std::size_t>(nodes[1]);
  for (std::size_t corner = 0; corner < 8; ++corner) {
    const std::array<std::size_t, 3> far{corner & 1U, corner >> 1U & 1U, corner >> 2U};
    double weight = 1.0;
    for (std::size_t k = 0; k < 3; ++k) weight *= far[k] == 1 ? within[k] : 1.0 - within[k];
    const std::size_t node = ((cell[2] + far[2]) * width + cell[1] + far[1]) * length + cell[0] + far[0];
    out += weight * Eigen::Vector3d(offsets_m.data() + 3 * node);
  }
  return out;
}

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
  // Surfaces in boxes are searched in cells of 0.1 m; road users are smaller than this.
  constexpr double kLongest_m = 200.0, kMost_m3 = 1e5;
  if (!(actor.size_m.allFinite() && actor.size_m.minCoeff() > 0.0 && actor.size_m.maxCoeff() <= kLongest_m &&
        actor.size_m.prod() <= kMost_m3)) {
    throw_input_error(where,
                      actor.name + ": size",
                      fmt::format("{} x {} x {} m", actor.size_m.x(), actor.size_m.y(), actor.size_m.z()),
                      fmt::format("above 0, at most {} m a side and {} m3", kLongest_m, kMost_m3));
  }
  if (actor.track.empty()) throw_input_error(where, actor.name + ": track", "no pose", "at least one");
  for (std::size_t i = 0; i < actor.track.size(); ++i) {
    const KeyPose& key = actor.track[i];
    const auto field = [&] { return fmt::format("{}: track[{}]", actor.name, i); };
    const bool finite = std::isfinite(key.time_s) && key.world_from_actor.translation.allFinite() &&
                        key.world_from_actor.rotation.coeffs().allFinite() && key.shift_m.allFinite() &&
                        key.turn_rad.allFinite();
    if (!finite) throw_input_error(where, field(), "NaN or Inf", "finite numbers");
    const double far_m = (key.world_from_actor.translation + key.shift_m).cwiseAbs().maxCoeff();
    if (!(far_m <= kFarthestPosition_m))
      throw_input_error(
          where, field(), fmt::format("a place at {} m", far_m), fmt::format("up to {} m", kFarthestPosition_m));
    if (i > 0 && !(key.time_s > actor.track[i - 1].time_s)) {
      throw_input_error(where,
                        field(),
                        fmt::format("{} s after {} s", key.time_s, actor.track[i - 1].time_s),
                        "strictly increasing times");
    }
  }
  validate(actor.deformation, actor.name, where);
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
  // Of many names lists the similar ones; all of them where none is similar.
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
      const Deformation& shape = actor.deformation;
      if (!shape.empty()) {
        view.deformation = {shape.nodes, 0.5 * actor.size_m, shape.at(time_start_s), shape.at(time_end_s)};
      }
    }
    views.push_back(std::move(view));
  }
  return views;
}

}  // namespace simuli
