#include "host/core/scene/edit.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <utility>

#include "host/core/base/error.hpp"
#include "host/core/base/names.hpp"
#include "host/core/scene/occluders.hpp"

namespace simuli {
namespace {

/// Rows of a set's particles with that owner number (GaussianSet::actor).
std::vector<Eigen::Index> rows_of(const GaussianSet& set, std::uint32_t number) {
  std::vector<Eigen::Index> rows;
  for (std::size_t i = 0; i < set.actor.size(); ++i) {
    if (set.actor[i] == number) rows.push_back(static_cast<Eigen::Index>(i));
  }
  return rows;
}

void remove_particles(GaussianSet& set, std::uint32_t number) {
  Eigen::Index kept = 0;
  for (Eigen::Index i = 0; i < set.size() && !set.actor.empty(); ++i) {
    const std::uint32_t actor = set.actor[static_cast<std::size_t>(i)];
    if (actor == number) continue;
    set.params.row(kept) = set.params.row(i).eval();
    set.actor[static_cast<std::size_t>(kept)] = actor > number ? actor - 1 : actor;
    ++kept;
  }
  if (set.actor.empty()) return;
  set.params.conservativeResize(kept, Eigen::NoChange);
  set.actor.resize(static_cast<std::size_t>(kept));
  if (std::all_of(set.actor.begin(), set.actor.end(), [](std::uint32_t a) { return a == 0; })) {
    set.actor.clear();
  }
}

/// Appends an actor without particles.
void add_empty(Scene& scene, Actor actor) {
  make_room_for_actor(scene, scene.camera);
  make_room_for_actor(scene, scene.lidar);
  scene.actors.push_back(std::move(actor));
}

/// Appends the particles of `from` with owner `number` to `to`, with owner `as`.
void copy_particles(const GaussianSet& from, std::uint32_t number, GaussianSet& to, std::uint32_t as) {
  const std::vector<Eigen::Index> rows = rows_of(from, number);
  if (rows.empty()) return;
  if (to.actor.empty()) to.actor.assign(static_cast<std::size_t>(to.size()), 0);
  const Eigen::Index shared = std::min(from.params.cols(), to.params.cols());
  const Eigen::Index first = to.size();
  Eigen::MatrixXf copies = Eigen::MatrixXf::Zero(static_cast<Eigen::Index>(rows.size()), to.params.cols());
  for (std::size_t k = 0; k < rows.size(); ++k) {
    copies.row(static_cast<Eigen::Index>(k)).head(shared) = from.params.row(rows[k]).head(shared);
  }
  to.params.conservativeResize(first + copies.rows(), Eigen::NoChange);
  to.params.bottomRows(copies.rows()) = copies;
  to.actor.resize(static_cast<std::size_t>(to.size()), as);
}

std::uint32_t number_of(const std::vector<Actor>& actors, const std::string& name) {
  return static_cast<std::uint32_t>(find_actor(actors, name) + 1);
}

void need_new_name(const Scene& scene, const std::string& name) {
  need_name(name, "edit", "the new actor's name");
  if (!has_actor(scene.actors, name)) return;
  throw Error(ErrorKind::kUsage, fmt::format("actor: found the name \"{}\", allowed one that is new", name));
}

// Defines the effect of each edit on a track, for scenes and for single frames.

void change(Actor& actor, const ActorEdit::Remove&) { actor.track.clear(); }

void change(Actor& actor, const ActorEdit::Move& move) {
  if (!move.by_m.allFinite()) {
    throw Error(ErrorKind::kUsage, fmt::format("move {}: found NaN or Inf, allowed finite", actor.name));
  }
  for (KeyPose& key : actor.track) {
    key.world_from_actor.translation += key.corrected().rotation * move.by_m;
  }
}

void change(Actor& actor, const ActorEdit::Turn& turn) {
  if (!std::isfinite(turn.yaw_rad)) {
    throw Error(ErrorKind::kUsage, fmt::format("turn {}: found NaN or Inf, allowed finite", actor.name));
  }
  const Eigen::Quaterniond left(Eigen::AngleAxisd(turn.yaw_rad, Eigen::Vector3d::UnitZ()));
  for (KeyPose& key : actor.track) {
    key.world_from_actor.rotation = (key.world_from_actor.rotation * left).normalized();
  }
}

void change(Actor& actor, const ActorEdit::Retime& retime) {
  // Beyond these, nanosecond times of a track coincide.
  constexpr double kFastest = 1e3, kLatest_s = 1e6;
  if (!(retime.rate >= 1.0 / kFastest && retime.rate <= kFastest && std::abs(retime.delay_s) <= kLatest_s)) {
    throw Error(ErrorKind::kUsage,
                fmt::format("retime {}: found {} times as fast, {} s later, allowed {} to {}, within {} s",
                            actor.name,
                            retime.rate,
                            retime.delay_s,
                            1.0 / kFastest,
                            kFastest,
                            kLatest_s));
  }
  if (actor.track.empty()) return;
  const double start_s = actor.track.front().time_s;
  for (KeyPose& key : actor.track) {
    key.time_s = start_s + retime.delay_s + (key.time_s - start_s) / retime.rate;
  }
  Deformation& shape = actor.deformation;
  shape.start_s = start_s + retime.delay_s + (shape.start_s - start_s) / retime.rate;
  shape.interval_s /= retime.rate;
}

void change(Actor& actor, const ActorEdit::Retrack& retrack) {
  Actor moved = actor;
  moved.track = retrack.track;
  validate(moved, "track");
  // Starts with the recorded motion.
  if (!actor.track.empty())
    moved.deformation.start_s += moved.track.front().time_s - actor.track.front().time_s;
  actor = std::move(moved);
}

void change_track(std::vector<Actor>& actors, const std::string& name, const ActorEdit::Change& what) {
  Actor& actor = actors[find_actor(actors, name)];
  std::visit([&](const auto& one) { change(actor, one); }, what);
}

}  // namespace

std::vector<Actor> edited(std::vector<Actor> actors, const std::vector<ActorEdit>& edits) {
  for (const ActorEdit& edit : edits) change_track(actors, edit.actor, edit.change);
  return actors;
}

void remove_actor(Scene& scene, const std::string& name) {
  const std::uint32_t number = number_of(scene.actors, name);
  remove_particles(scene.camera, number);
  remove_particles(scene.lidar, number);
  scene.actors.erase(scene.actors.begin() + (number - 1));
}

void edit_actor(Scene& scene, const ActorEdit& edit) {
  if (std::holds_alternative<ActorEdit::Remove>(edit.change)) {
    remove_actor(scene, edit.actor);
  } else {
    scene.actors = edited(scene.actors, {edit});
  }
}

void move_actor(Scene& scene, const std::string& name, const Eigen::Vector3d& by_m) {
  change_track(scene.actors, name, ActorEdit::Move{by_m});
}

void turn_actor(Scene& scene, const std::string& name, double yaw_rad) {
  change_track(scene.actors, name, ActorEdit::Turn{yaw_rad});
}

void resize_actor(Scene& scene, const std::string& name, double factor) {
  const std::uint32_t number = number_of(scene.actors, name);
  if (!(factor > 0.0 && std::isfinite(factor))) {
    throw Error(ErrorKind::kUsage,
                fmt::format("resize {}: found {} times, allowed above 0 and finite", name, factor));
  }
  Actor resized = scene.actors[number - 1];
  resized.size_m *= factor;
  validate(resized, "resize");  // as when it is read back
  for (GaussianSet* set : {&scene.camera, &scene.lidar}) {
    const auto log_factor = static_cast<float>(std::log(factor));
    for (const Eigen::Index row : rows_of(*set, number)) {
      set->mean().row(row) *= static_cast<float>(factor);
      set->log_scale().row(row).array() += log_factor;
    }
  }
  Actor& actor = scene.actors[number - 1];
  change(actor, ActorEdit::Move{{0.0, 0.0, 0.5 * (factor - 1.0) * actor.size_m.z()}});
  actor.size_m *= factor;
  for (double& offset_m : actor.deformation.offsets_m) offset_m *= factor;
}

void retime_actor(Scene& scene, const std::string& name, double rate, double delay_s) {
  change_track(scene.actors, name, ActorEdit::Retime{rate, delay_s});
}

void retrack_actor(Scene& scene, const std::string& name, std::vector<KeyPose> track) {
  change_track(scene.actors, name, ActorEdit::Retrack{std::move(track)});
}

void duplicate_actor(Scene& scene, const std::string& name, const std::string& copy_name) {
  const std::uint32_t number = number_of(scene.actors, name);
  need_new_name(scene, copy_name);
  Actor copy = scene.actors[number - 1];
  copy.name = copy_name;
  add_empty(scene, std::move(copy));
  const auto as = static_cast<std::uint32_t>(scene.actors.size());
  for (GaussianSet* set : {&scene.camera, &scene.lidar}) {
    const GaussianSet from = *set;
    copy_particles(from, number, *set, as);
  }
}

const std::string& original_of(const ActorCopies& copies, const std::string& name) {
  const auto copy = copies.find(name);
  return copy == copies.end() ? name : copy->second;
}

void add_copy(ActorCopies& copies, const std::string& name, const std::string& copy_name) {
  copies[copy_name] = std::string(original_of(copies, name));
}

void add_actor(Scene& scene, const Scene& other, const std::string& name, const std::string& new_name) {
  const std::uint32_t number = number_of(other.actors, name);
  need_new_name(scene, new_name);
  Actor actor = other.actors[number - 1];
  actor.name = new_name;
  add_empty(scene, std::move(actor));
  const auto as = static_cast<std::uint32_t>(scene.actors.size());
  copy_particles(other.camera, number, scene.camera, as);
  copy_particles(other.lidar, number, scene.lidar, as);
}

}  // namespace simuli
