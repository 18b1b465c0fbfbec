#include "host/apps/cli/view/view_command.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <set>

#include "host/apps/cli/base/quoted.hpp"
#include "host/apps/cli/base/refuse.hpp"
#include "host/core/base/error.hpp"

namespace simuli::cli {
namespace {

/// As a shell reads it back.
std::string shell_word(const std::string& word) {
  const auto is_plain = [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') ||
           std::string_view("_-./:,@=+").find(c) != std::string_view::npos;
  };
  if (!word.empty() && std::all_of(word.begin(), word.end(), is_plain)) return word;
  return quoted(word);
}

std::set<std::string> actors_of(const Edits& edits) {
  std::set<std::string> names(edits.remove.begin(), edits.remove.end());
  for (const auto* const some : {&edits.resize, &edits.track, &edits.retime, &edits.move, &edits.turn}) {
    for (const std::string& edit : *some) names.insert(edit.substr(0, edit.find(':')));
  }
  return names;
}

}  // namespace

std::string command_of(const ViewRequest& request,
                       double time_s,
                       const Sensor& sensor,
                       const ViewSource& source,
                       const std::vector<std::string>& added) {
  const Eigen::Vector3d& shift = request.rig_shift_m;
  const bool is_turned = sensor.is_camera() && (request.yaw_rad != 0.0 || request.pitch_rad != 0.0);
  if (shift.x() != 0.0 || shift.z() != 0.0 || is_turned ||
      (sensor.is_camera() && request.scene_from_camera)) {
    throw_usage_error(
        "command", "another place or direction", "the recorded path, and a shift to the left of it");
  }
  const bool is_marked = request.layer == ViewLayer::kUnseen;
  const bool is_support = request.layer == ViewLayer::kSupport;
  if (request.layer != ViewLayer::kColour && !is_marked && !is_support)
    throw_usage_error("command", "a layer", "colour, unseen, support");
  std::string line = "simuli render";
  const auto add = [&line](const std::string& option, const std::string& value) {
    line += ' ' + option + ' ' + shell_word(value);
  };
  line += ' ' + shell_word(source.scene);
  add("--sensor", request.sensor);
  add("--times", fmt::format("{}:{}:1", time_s, time_s));
  if (sensor.is_camera()) {
    const double scale = static_cast<double>(request.width) / static_cast<double>(sensor.columns());
    add("--duration", "0");
    if (scale != 1.0) add("--scale", fmt::format("{}", scale));
  }
  add("--quality", request.quality);
  if (is_marked && sensor.is_camera()) line += " --mark-unseen";
  if (is_support && sensor.is_camera()) add("--outputs", "rgb,support");
  if (shift.y() != 0.0) add("--lane-shift", fmt::format("{}", shift.y()));

  const std::set<std::string> edited_before = actors_of(source.edits);
  const auto edit = [&](const std::string& option, const std::string& actor, const std::string& how) {
    if (edited_before.count(actor) > 0) {
      throw_usage_error("command",
                        "an edit of " + actor + ", which the viewer's command line edits, too",
                        "one of the two");
    }
    add(option, how.empty() ? actor : actor + ':' + how);
  };
  const auto options = [&](const std::vector<std::string>& lines) {
    for (const std::string& option : lines) {
      const std::size_t space = option.find(' ');
      add(option.substr(0, space), option.substr(space + 1));
    }
  };
  options(lines_of(source.edits));
  for (const std::string& option : added) {
    const std::size_t space = option.find(' '), colon = option.find(':');
    if (option.substr(0, space) == "--duplicate") {
      edit("--duplicate", option.substr(space + 1, colon - space - 1), option.substr(colon + 1));
    } else {
      options({option});
    }
  }
  for (const auto& [name, how] : request.retimed)
    edit("--retime", name, fmt::format("{}:{}", how[0], how[1]));
  for (const auto& [name, by] : request.moved) {
    edit("--move", name, fmt::format("{},{},{}", by.x(), by.y(), by.z()));
  }
  for (const auto& [name, by_deg] : request.turned_deg) edit("--turn", name, fmt::format("{}", by_deg));
  for (const std::string& name : request.removed) edit("--remove", name, "");
  add("-o", "view");
  return line;
}

}  // namespace simuli::cli
