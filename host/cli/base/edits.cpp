#include "host/cli/base/edits.hpp"

#include <charconv>
#include <cmath>
#include <fmt/format.h>

#include "host/base/angles.hpp"
#include "host/base/error.hpp"
#include "host/scene/edit.hpp"
#include "io/scene/scene_folder.hpp"

namespace simuli::cli {
namespace {

[[noreturn]] void refuse(const char* option, const std::string& found, const char* allowed) {
  throw Error(ErrorKind::kUsage, fmt::format("{}: found \"{}\", allowed {}", option, found, allowed));
}

std::vector<std::string> split(const std::string& text, char at) {
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == at) {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

/// `text` parted at ':' into `least` to `most` parts that say something.
std::vector<std::string> parts_of(
    const char* option, const std::string& text, std::size_t least, std::size_t most, const char* allowed) {
  std::vector<std::string> parts = split(text, ':');
  for (const std::string& part : parts) {
    if (part.empty()) refuse(option, text, allowed);
  }
  if (parts.size() < least || parts.size() > most) refuse(option, text, allowed);
  return parts;
}

double number(const char* option, const std::string& text, const char* allowed) {
  double value = 0.0;
  const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
  if (result.ec != std::errc{} || result.ptr != text.data() + text.size() || !std::isfinite(value)) {
    refuse(option, text, allowed);
  }
  return value;
}

}  // namespace

void add_edit_options(Command sub, Edits& edits) {
  const auto add = [&](const char* name, std::vector<std::string>& to, const char* text) {
    sub.option(name, to, text);
  };
  add("--add", edits.add, "SCENE:ACTOR[:NAME], an actor of another scene; then give it a --track");
  add("--duplicate", edits.duplicate, "ACTOR:NAME, a second one of the same");
  add("--resize", edits.resize, "ACTOR:FACTOR, so many times as large; it stands where it stood");
  add("--track", edits.track, "ACTOR:LOG[:ACTOR], the track of an actor of that log instead of its own");
  add("--retime", edits.retime, "ACTOR:RATE[:DELAY_S], its track RATE times as fast, DELAY_S later");
  add("--move", edits.move, "ACTOR:FORWARD,LEFT,UP, metres in the actor's own frame");
  add("--turn", edits.turn, "ACTOR:DEGREES, to its left, about its own up");
  add("--remove", edits.remove, "ACTOR, take it away");
}

std::vector<std::string> lines_of(const Edits& edits) {
  std::vector<std::string> lines;
  const auto tell = [&](const char* name, const std::vector<std::string>& given) {
    for (const std::string& edit : given) lines.push_back(fmt::format("{} {}", name, edit));
  };
  tell("--add", edits.add);
  tell("--duplicate", edits.duplicate);
  tell("--resize", edits.resize);
  tell("--track", edits.track);
  tell("--retime", edits.retime);
  tell("--move", edits.move);
  tell("--turn", edits.turn);
  tell("--remove", edits.remove);
  return lines;
}

void apply(const Edits& edits, Scene& scene) {
  for (const std::string& edit : edits.add) {
    const auto parts = parts_of("--add", edit, 2, 3, "SCENE:ACTOR or SCENE:ACTOR:NAME");
    add_actor(scene, read_scene(parts[0]).scene, parts[1], parts.back());
  }
  for (const std::string& edit : edits.duplicate) {
    const auto parts = parts_of("--duplicate", edit, 2, 2, "ACTOR:NAME");
    duplicate_actor(scene, parts[0], parts[1]);
  }
  for (const std::string& edit : edits.resize) {
    constexpr const char* kAllowed = "ACTOR:FACTOR, a finite number above 0";
    const auto parts = parts_of("--resize", edit, 2, 2, kAllowed);
    resize_actor(scene, parts[0], number("--resize", parts[1], kAllowed));
  }
  for (const std::string& edit : edits.track) {
    const auto parts = parts_of("--track", edit, 2, 3, "ACTOR:LOG or ACTOR:LOG:ACTOR");
    const std::vector<Actor> actors = read_log(parts[1]).actors;
    const std::string& name = parts.size() > 2 ? parts[2] : parts[0];
    retrack_actor(scene, parts[0], actors[find_actor(actors, name)].track);
  }
  for (const std::string& edit : edits.retime) {
    constexpr const char* kAllowed = "ACTOR:RATE or ACTOR:RATE:DELAY_S, finite numbers";
    const auto parts = parts_of("--retime", edit, 2, 3, kAllowed);
    const double delay_s = parts.size() > 2 ? number("--retime", parts[2], kAllowed) : 0.0;
    retime_actor(scene, parts[0], number("--retime", parts[1], kAllowed), delay_s);
  }
  for (const std::string& edit : edits.move) {
    constexpr const char* kAllowed = "ACTOR:FORWARD,LEFT,UP in metres";
    const auto parts = parts_of("--move", edit, 2, 2, kAllowed);
    const std::vector<std::string> by = split(parts[1], ',');
    if (by.size() != 3) refuse("--move", edit, kAllowed);
    Eigen::Vector3d by_m;
    for (std::size_t k = 0; k < 3; ++k) {
      by_m[static_cast<Eigen::Index>(k)] = number("--move", by[k], kAllowed);
    }
    move_actor(scene, parts[0], by_m);
  }
  for (const std::string& edit : edits.turn) {
    constexpr const char* kAllowed = "ACTOR:DEGREES, a finite number";
    const auto parts = parts_of("--turn", edit, 2, 2, kAllowed);
    turn_actor(scene, parts[0], number("--turn", parts[1], kAllowed) * kDegree);
  }
  for (const std::string& name : edits.remove) remove_actor(scene, name);
}

}  // namespace simuli::cli
