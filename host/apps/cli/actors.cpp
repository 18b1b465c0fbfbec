#include <cmath>
#include <fmt/format.h>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/apps/cli/base/commands.hpp"
#include "host/apps/cli/base/counted.hpp"
#include "host/apps/cli/base/json_text.hpp"
#include "host/apps/cli/base/settings.hpp"
#include "host/core/base/angles.hpp"
#include "host/core/base/error.hpp"
#include "host/core/base/fields.hpp"
#include "host/core/base/one_line.hpp"
#include "io/base/output.hpp"
#include "optim/actors/compare_actors.hpp"
#include "optim/actors/complete_actors.hpp"
#include "optim/actors/find_actors.hpp"
#include "optim/data/sensor_learning.hpp"

namespace simuli::cli {
namespace {

using Json = nlohmann::ordered_json;

struct ActorsCommand {
  std::string log;
  std::string output;
  std::string labelled;
  bool keeps_labels = false;
  FrameSelection frames{.held_out_every = 0};
  std::vector<std::string> settings;
  ActorFinding options;
};

Json json_of(const Eigen::Vector3d& v) { return Json::array({v.x(), v.y(), v.z()}); }

/// Returns the length of the track from key to key in m.
double track_length_m(const Actor& actor) {
  double length = 0.0;
  for (std::size_t k = 1; k < actor.track.size(); ++k) {
    length += (actor.track[k].world_from_actor.translation - actor.track[k - 1].world_from_actor.translation)
                  .norm();
  }
  return length;
}

Json json_of(const Actor& actor) {
  return {{"name", actor.name},
          {"size_m", json_of(actor.size_m)},
          {"first_s", actor.track.front().time_s},
          {"last_s", actor.track.back().time_s},
          {"poses", actor.track.size()},
          {"way_m", track_length_m(actor)},
          {"first_position_m", json_of(actor.track.front().world_from_actor.translation)},
          {"last_position_m", json_of(actor.track.back().world_from_actor.translation)}};
}

Json json_of(const ActorMatch& m) {
  Json json = {{"labelled", m.labelled}, {"labelled_s", m.labelled_s}, {"found", nullptr}};
  if (m.found.empty()) return json;
  json["found"] = m.found;
  json["times"] = m.times;
  json["offset_m"] = json_of(m.offset_m);
  json["centre_median_m"] = m.centre_m;
  json["centre_p90_m"] = m.centre_p90_m;
  json["turned_deg"] = m.turned_rad / kDegree;
  json["heading_median_deg"] = m.heading_rad / kDegree;
  json["labelled_size_m"] = json_of(m.labelled_size_m);
  json["found_size_m"] = json_of(m.found_size_m);
  return json;
}

std::string size_text(const Eigen::Vector3d& size) {
  return fmt::format("{:.1f} x {:.1f} x {:.1f} m", size.x(), size.y(), size.z());
}

std::string text_of(const FoundActors& found) {
  const FindReport& r = found.report;
  std::string text = fmt::format(
      "{} in {}, {:.1f} s\n", counted(r.actors, "moving thing"), counted(r.sweeps, "sweep"), r.seconds);
  for (const Actor& actor : found.actors) {
    text += fmt::format("  {:<10} {}, {:.1f} to {:.1f} s in {} poses, track of {:.1f} m\n",
                        actor.name,
                        size_text(actor.size_m),
                        actor.track.front().time_s,
                        actor.track.back().time_s,
                        actor.track.size(),
                        track_length_m(actor));
  }
  text += fmt::format("  {} moving returns, {} of them on these; {} chains of clusters\n",
                      r.moving_returns,
                      r.moving_on_actors,
                      r.chains);
  for (const std::string& name : found.standing)
    text += fmt::format("  {}: the points in this moving label are static\n", name);
  return text;
}

std::string text_of(const ActorComparison& comparison) {
  std::string text;
  for (const ActorMatch& m : comparison.labels) {
    if (m.found.empty()) {
      text += fmt::format("  {}: missed ({:.1f} s)\n", m.labelled, m.labelled_s);
      continue;
    }
    text += fmt::format(
        "  {}: {}, {} times in {:.1f} s; centre {:.3f} m median, {:.3f} m 90 % after the common offset "
        "({:.2f}, {:.2f}, {:.2f}) m; heading {:.2f} deg median after {:.2f} deg; {}, labelled {}\n",
        m.labelled,
        m.found,
        m.times,
        m.labelled_s,
        m.centre_m,
        m.centre_p90_m,
        m.offset_m.x(),
        m.offset_m.y(),
        m.offset_m.z(),
        m.heading_rad / kDegree,
        m.turned_rad / kDegree,
        size_text(m.found_size_m),
        size_text(m.labelled_size_m));
  }
  for (const std::string& name : comparison.others) text += fmt::format("  {}: without a label\n", name);
  return text;
}

void actors(const ActorsCommand& command, const Globals& globals) {
  Log log = read_log(command.log);
  if (!command.output.empty()) need_new_path(command.output);  // fails before the search
  std::optional<Log> labelled;
  if (!command.labelled.empty()) labelled = read_log(command.labelled);
  const FoundActors found =
      find_actors(with_blind_arcs(log, command.frames), command.frames, command.options);
  std::optional<CompletedActors> completed;
  if (command.keeps_labels) completed = complete_actors(std::move(log.actors), found);
  if (!command.output.empty()) {
    log.actors = completed ? completed->actors : found.actors;
    copy_log(log, command.output);
  }
  std::optional<ActorComparison> comparison;
  if (labelled) comparison = compare_actors(labelled->actors, found.actors, kLeastFoundTravel_m);
  if (globals.json) {
    Json json = {{"sweeps", found.report.sweeps},
                 {"moving_returns", found.report.moving_returns},
                 {"moving_returns_on_actors", found.report.moving_on_actors},
                 {"returns_on_actors", found.report.returns_on_actors},
                 {"chains", found.report.chains},
                 {"seconds", found.report.seconds},
                 {"standing_labels", found.standing},
                 {"actors", Json::array()}};
    for (const Actor& actor : found.actors) json["actors"].push_back(json_of(actor));
    if (comparison) {
      json["labelled"] = Json::array();
      for (const ActorMatch& match : comparison->labels) json["labelled"].push_back(json_of(match));
      json["without_label"] = comparison->others;
    }
    if (completed) {
      json["added"] = completed->added;
      json["continued"] = completed->continued;
    }
    if (!command.output.empty()) json["log"] = command.output;
    std::cout << json_text(json) << '\n';
    return;
  }
  std::cout << text_of(found);
  if (comparison) std::cout << text_of(*comparison);
  if (completed)
    std::cout << fmt::format(
        "  {} of them have no label; {} labels were extended\n", completed->added, completed->continued);
  if (!command.output.empty()) std::cout << fmt::format("log {} written\n", on_one_line(command.output));
}

}  // namespace

void add_actors(Command app, const Globals& globals) {
  const auto command = std::make_shared<ActorsCommand>();
  Command sub = app.command("actors", "find moving objects of a log from its LiDAR");
  sub.option("LOG", command->log, "log folder").required();
  sub.option("-o,--output",
             command->output,
             "log folder to write, with the found actors instead of the log's; default: report only");
  sub.flag("--keep-labels",
           command->keeps_labels,
           "keep the log's actors, as a training does: objects without a label are added, and objects found "
           "before or after a label extend it");
  sub.option("--compare", command->labelled, "log with labels for a comparison with the found actors");
  sub.option("--held-out",
             command->frames.held_out_every,
             "hold out every N-th sweep, as a training does; 0: none")
      .with_default();
  const auto fields = [command] { return fields_of(command->options); };
  add_settings(sub, command->settings, globals, fields, "KEY=VALUE...; help: lists the keys");
  sub.run([command, &globals] {
    fields_of(command->options).apply(command->settings);
    actors(*command, globals);
  });
}

}  // namespace simuli::cli
