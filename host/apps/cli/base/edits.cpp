#include "host/apps/cli/base/edits.hpp"

#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <iostream>

#include "host/apps/cli/base/numbers.hpp"
#include "host/apps/cli/base/refuse.hpp"
#include "host/core/base/angles.hpp"
#include "host/core/base/error.hpp"
#include "host/core/base/names.hpp"
#include "host/core/base/split.hpp"
#include "host/core/record/mirror.hpp"
#include "host/core/scene/edit.hpp"
#include "io/base/file.hpp"
#include "io/scene/splat_scene.hpp"
#include "io/splat/splat_file.hpp"

namespace simuli::cli {
namespace {

namespace fs = std::filesystem;

/// Splits `text` at ':' into `least` to `most` non-empty parts. Names may contain ':': the first part is the
/// longest name in `actors`, or all excess parts.
std::vector<std::string> parts_of(const char* option,
                                  const std::string& text,
                                  std::size_t least,
                                  std::size_t most,
                                  const char* allowed,
                                  const std::vector<Actor>& actors = {}) {
  std::vector<std::string> parts = split(text, ':');
  const auto begin_of = [&](std::size_t n) {
    return fmt::format("{}", fmt::join(parts.begin(), parts.begin() + static_cast<std::ptrdiff_t>(n), ":"));
  };
  std::size_t in_first = parts.size() > most ? parts.size() - most + 1 : 1;
  for (std::size_t n = in_first + 1; n < parts.size(); ++n) {
    if (has_actor(actors, begin_of(n))) in_first = n;
  }
  parts[in_first - 1] = begin_of(in_first);
  parts.erase(parts.begin(), parts.begin() + static_cast<std::ptrdiff_t>(in_first - 1));
  for (const std::string& part : parts) {
    if (part.empty()) refuse(option, text, allowed);
  }
  if (parts.size() < least || parts.size() > most) refuse(option, text, allowed);
  return parts;
}

double number(const char* option, const std::string& text, const char* allowed) {
  return parse_numbers(option, text, 1, ',', allowed).front();
}

}  // namespace

Mounting parse_mounting(const char* option, const std::string& text) {
  const std::vector<double> values =
      parse_numbers(option, text, 6, ',', "X,Y,Z,ROLL,PITCH,YAW, finite numbers, m and degrees");
  const Eigen::Map<const Eigen::Vector<double, 6>> v(values.data());
  return {v.head<3>(), v[3], v[4], v[5]};
}

SceneFile read_scene_and_report(const std::filesystem::path& path) {
  SceneFile scene = read_scene(path);
  for (const std::string& note : scene.splats.notes()) std::cerr << fmt::format("simuli: note: {}\n", note);
  return scene;
}

void add_edit_options(Command sub, Edits& edits) {
  const auto add = [&](const char* name, std::vector<std::string>& to, const char* text) {
    return sub.option(name, to, text);
  };
  add("--add",
      edits.add,
      "SCENE:ACTOR[:NAME], an actor of another scene, which then needs a --track. SPLAT:NAME, a .ply or "
      ".spz, placed at the start of the trajectory; --resize, --move, --turn or --track change it");
  add("--duplicate", edits.duplicate, "ACTOR:NAME, a copy of an actor");
  add("--mirror",
      edits.mirror,
      "ACTOR with one recorded side: mirrors it to the other side; no effect if both sides were recorded");
  add("--resize", edits.resize, "ACTOR:FACTOR, scales the actor; its position remains");
  add("--track", edits.track, "ACTOR:LOG[:ACTOR], uses the track of an actor of that log or scene");
  add("--retime", edits.retime, "ACTOR:RATE[:DELAY_S], plays the track RATE times as fast and DELAY_S later");
  add("--move", edits.move, "ACTOR:FORWARD,LEFT,UP, moves the actor, m in the actor's frame");
  add("--turn", edits.turn, "ACTOR:DEGREES, turns the actor to its left about its up axis");
  add("--class", edits.classes, "ACTOR:CLASS, sets the class in labels: car, truck, pedestrian, ...");
  add("--remove", edits.remove, "ACTOR, removes the actor");
}

std::vector<std::string> lines_of(const Edits& edits) {
  std::vector<std::string> lines;
  const auto append = [&](const char* name, const std::vector<std::string>& given) {
    for (const std::string& edit : given) lines.push_back(fmt::format("{} {}", name, edit));
  };
  append("--add", edits.add);
  append("--duplicate", edits.duplicate);
  append("--mirror", edits.mirror);
  append("--resize", edits.resize);
  append("--track", edits.track);
  append("--retime", edits.retime);
  append("--move", edits.move);
  append("--turn", edits.turn);
  append("--class", edits.classes);
  append("--remove", edits.remove);
  return lines;
}

Pose standing_pose(const Trajectory& world_from_rig) {
  const Pose& start = world_from_rig.poses().front().pose;
  const Eigen::Vector3d ahead = start.rotation * Eigen::Vector3d::UnitX();
  const Eigen::AngleAxisd level(std::atan2(ahead.y(), ahead.x()), Eigen::Vector3d::UnitZ());
  return {Eigen::Quaterniond(level), start.translation};
}

ActorCopies copies_of(const Edits& edits) {
  ActorCopies copies;
  for (const std::string& edit : edits.duplicate) {
    const auto parts = parts_of("--duplicate", edit, 2, 2, "ACTOR:NAME");
    add_copy(copies, parts[0], parts[1]);
  }
  return copies;
}

void apply(const Edits& edits, SceneFile& file) {
  Scene& scene = file.scene;
  for (const std::string& edit : edits.add) {
    constexpr const char* kAllowed = "SCENE:ACTOR, SCENE:ACTOR:NAME or SPLAT:NAME";
    const auto parts = parts_of("--add", edit, 2, 3, kAllowed);
    if (is_splat_file(parts[0])) {
      if (parts.size() != 2) refuse("--add", edit, kAllowed);
      if (file.world_from_rig.poses().empty()) {
        throw_input_error("--add " + edit, "trajectory", "no poses", "a scene with a trajectory");
      }
      need_name(parts[1], "--add " + edit, "name");
      const Pose base = standing_pose(file.world_from_rig);
      add_actor(scene, as_actor(read_scene_and_report(parts[0]).scene, parts[1], base), parts[1], parts[1]);
      continue;
    }
    add_actor(scene, read_scene_and_report(parts[0]).scene, parts[1], parts.back());
  }
  for (const std::string& edit : edits.duplicate) {
    const auto parts = parts_of("--duplicate", edit, 2, 2, "ACTOR:NAME");
    duplicate_actor(scene, parts[0], parts[1]);
  }
  for (const std::string& name : edits.mirror) {
    if (file.support == nullptr) {
      throw_usage_error("--mirror",
                        fmt::format("\"{}\" of a scene without data on the recorded sides of actors", name),
                        "an actor of a scene with these data: train the scene again");
    }
    if (!mirror_actor(scene, *file.support, name, original_of(copies_of(edits), name))) {
      std::cerr << fmt::format("simuli: --mirror {}: both or none of its sides were recorded: unchanged\n",
                               name);
    }
  }
  for (const std::string& edit : edits.resize) {
    constexpr const char* kAllowed = "ACTOR:FACTOR, a finite number above 0";
    const auto parts = parts_of("--resize", edit, 2, 2, kAllowed);
    resize_actor(scene, parts[0], number("--resize", parts[1], kAllowed));
  }
  for (const std::string& edit : edits.track) {
    const auto parts = parts_of("--track", edit, 2, 3, "ACTOR:LOG or ACTOR:LOG:ACTOR", scene.actors);
    const bool is_scene = is_there(std::filesystem::path(parts[1]) / "scene.json");
    const std::vector<Actor> actors =
        is_scene ? read_scene(parts[1]).scene.actors : read_log(parts[1]).actors;
    const std::string& name = parts.size() > 2 ? parts[2] : parts[0];
    retrack_actor(scene, parts[0], actors[find_actor(actors, name)].track);
  }
  for (const std::string& edit : edits.retime) {
    constexpr const char* kAllowed = "ACTOR:RATE or ACTOR:RATE:DELAY_S, finite numbers";
    const auto parts = parts_of("--retime", edit, 2, 3, kAllowed, scene.actors);
    const double delay_s = parts.size() > 2 ? number("--retime", parts[2], kAllowed) : 0.0;
    retime_actor(scene, parts[0], number("--retime", parts[1], kAllowed), delay_s);
  }
  for (const std::string& edit : edits.move) {
    constexpr const char* kAllowed = "ACTOR:FORWARD,LEFT,UP in metres";
    const auto parts = parts_of("--move", edit, 2, 2, kAllowed);
    const std::vector<double> by_m = parse_numbers("--move", parts[1], 3, ',', kAllowed);
    move_actor(scene, parts[0], Eigen::Map<const Eigen::Vector3d>(by_m.data()));
  }
  for (const std::string& edit : edits.turn) {
    constexpr const char* kAllowed = "ACTOR:DEGREES, a finite number";
    const auto parts = parts_of("--turn", edit, 2, 2, kAllowed);
    turn_actor(scene, parts[0], number("--turn", parts[1], kAllowed) * kDegree);
  }
  for (const std::string& edit : edits.classes) {
    const auto parts = parts_of("--class", edit, 2, 2, "ACTOR:CLASS");
    need_name(parts[1], "--class " + edit, "class");
    scene.actors[find_actor(scene.actors, parts[0])].kind = parts[1];
  }
  for (const std::string& name : edits.remove) remove_actor(scene, name);
}

}  // namespace simuli::cli
