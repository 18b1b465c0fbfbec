#include "host/apps/cli/view/view_command.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <set>

#include "host/apps/cli/base/quoted.hpp"
#include "host/apps/cli/base/refuse.hpp"
#include "host/core/base/error.hpp"
#include "host/core/scene/mounting.hpp"
#include "io/base/json_reader.hpp"
#include "io/log/sensor_file.hpp"

namespace simuli::cli {
namespace {

std::set<std::string> actors_of(const Edits& edits) {
  std::set<std::string> names(edits.remove.begin(), edits.remove.end());
  for (const auto* const some : {&edits.resize, &edits.track, &edits.retime, &edits.move, &edits.turn}) {
    for (const std::string& edit : *some) names.insert(edit.substr(0, edit.find(':')));
  }
  return names;
}

/// Returns the layer's name in --outputs.
std::string output_of(ViewLayer layer) {
  switch (layer) {
    case ViewLayer::kDepth:
      return "distance";
    case ViewLayer::kOpacity:
      return "opacity";
    case ViewLayer::kSupport:
      return "support";
    default:
      return "";
  }
}

}  // namespace

std::string command_of(const ViewRequest& request,
                       double time_s,
                       const Sensor& sensor,
                       const SensorPlace& place,
                       const ViewSource& source,
                       const std::vector<std::string>& added) {
  const bool is_camera = sensor.is_camera();
  std::string line = "simuli render";
  std::string which = request.sensor;
  if (request.height) {  // a free camera: the command writes its file first
    which = "view_" + sensor.name() + ".json";
    const std::string file = Json::parse(text_of(sensor_file_of(sensor))).dump();
    line = fmt::format("printf %s {} >{} && {}", shell_word(file), which, line);
  }
  const auto add = [&line](const std::string& option, const std::string& value) {
    line += ' ' + option + ' ' + shell_word(value);
  };
  line += ' ' + shell_word(source.scene);
  add("--sensor", which);
  add("--times", fmt::format("{}:{}:1", time_s, time_s));
  if (is_camera) {
    const double scale = static_cast<double>(request.width) / static_cast<double>(sensor.columns());
    add("--duration", "0");
    if (scale != 1.0) add("--scale", fmt::format("{}", scale));
  }
  add("--quality", request.quality);
  if (is_camera && request.layer == ViewLayer::kUnseen) line += " --mark-unseen";
  const std::string output = output_of(request.layer);
  if (is_camera && !output.empty()) add("--outputs", "rgb," + output);
  if (place.only_left) {
    if (request.rig_shift_m.y() != 0.0) add("--lane-shift", fmt::format("{}", request.rig_shift_m.y()));
  } else {
    const Mounting m =
        is_camera ? Mounting::of_camera(place.rig_from_sensor) : Mounting::of_lidar(place.rig_from_sensor);
    line += fmt::format(" --mount={},{},{},{},{},{}",
                        m.position_m.x(),
                        m.position_m.y(),
                        m.position_m.z(),
                        m.roll_deg,
                        m.pitch_deg,
                        m.yaw_deg);
  }

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
