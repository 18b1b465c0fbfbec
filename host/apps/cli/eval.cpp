#include <fmt/format.h>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/apps/cli/base/commands.hpp"
#include "host/apps/cli/base/edits.hpp"
#include "host/apps/cli/base/provenance.hpp"
#include "host/apps/cli/base/settings.hpp"
#include "host/apps/cli/report/eval_support.hpp"
#include "host/apps/cli/report/report.hpp"
#include "host/apps/cli/report/training.hpp"
#include "io/base/output.hpp"
#include "io/scene/scene_folder.hpp"

namespace simuli::cli {
namespace {

struct EvalCommand {
  std::string scene;
  std::string log;
  std::vector<std::string> settings;
  Edits edits;
  EvalOptions options;
  double scale = 1.0;  // used only if given
  int held_out = 0;
  double held_out_middle = 0.0, held_out_last = 0.0;
  std::vector<std::string> held_out_sensors;
  std::string report;    // path of the HTML report; empty: none
  bool support = false;  // add statistics of support
};

void eval(EvalCommand command, const Globals& globals) {
  command.options.render = options_of(globals.quality);
  fields_of(command.options).apply(command.settings);
  check(command.options);
  if (!command.report.empty()) need_writable(command.report);
  SceneFile file = read_scene_and_report(command.scene);
  warn_unlike_training(file, command.options.render);
  apply(command.edits, file);
  Log log = read_log(command.log);
  const Device device = Device::best(globals.device);
  Evaluation evaluation(device, std::move(file), std::move(log), command.options);
  const EvalFrames& frames = evaluation.frames();
  if (frames.kind == FrameKind::kOtherLog) {
    std::cerr << fmt::format("simuli: the scene was trained on another log, {} ({}): {}\n",
                             evaluation.scene().training->log_name,
                             evaluation.scene().training->log_hash,
                             frames.label());
  }
  std::optional<EvalSupport> support;  // first: throws for a scene without support
  if (command.support) support = eval_support(evaluation);
  const EvalReport report = run_evaluation(evaluation, globals);
  for (const std::string& line : report.warnings) std::cerr << "simuli: warning: " << line << '\n';
  if (!command.report.empty()) {
    write_report(command.report,
                 {.title = fmt::format("simuli eval: {} on {}", command.scene, command.log),
                  .edits = lines_of(command.edits)},
                 globals,
                 evaluation,
                 report);
  }
  print_eval(report, evaluation.scene(), globals.json, support ? &*support : nullptr);
}

}  // namespace

void add_eval(Command app, const Globals& globals) {
  const auto command = std::make_shared<EvalCommand>();
  Command sub = app.command("eval", "compare a scene with frames of a log, by default held-out frames");
  sub.option("SCENE", command->scene, "scene folder, or splats: .ply, .spz, .glb").required();
  sub.option("LOG", command->log, "log folder of the training or of another drive").required();
  const Option scale =
      sub.option("--scale", command->scale, "size of the compared pictures relative to the recorded pictures")
          .shown_as("FLOAT", "as in training");
  const Option held_out =
      sub.option("--held-out", command->held_out, "every N-th frame of each sensor, 0: all")
          .shown_as("INT", "frames held out in training; all frames of another log");
  const Option held_out_middle = sub.option("--held-out-middle",
                                            command->held_out_middle,
                                            "frames of this share of the trajectory around its middle")
                                     .shown_as("FLOAT", "as --held-out");
  const Option held_out_last =
      sub.option(
             "--held-out-last", command->held_out_last, "frames of this share of the trajectory at its end")
          .shown_as("FLOAT", "as --held-out");
  const Option held_out_sensor =
      sub.option("--held-out-sensor", command->held_out_sensors, "all frames of this camera or LiDAR")
          .one_at_a_time()
          .shown_as(
              "NAME",
              "as --held-out; may be repeated; given options of these four replace the selection of the "
              "training");
  sub.option("--repeats", command->options.timed_renders, "timed renders of each sensor").with_default();
  const auto fields = [command, &globals] {
    command->options.render = options_of(globals.quality);
    return fields_of(command->options);
  };
  add_settings(sub, command->settings, globals, fields, "KEY=VALUE...; help: lists the keys");
  sub.option("--report",
             command->report,
             "HTML file to write: metrics, curves, pictures, point clouds, settings, times");
  sub.flag(
      "--support", command->support, "also evaluate how well support (docs/RENDERS.md) predicts the errors");
  add_edit_options(sub, command->edits);
  sub.run([=, &globals] {
    if (scale.is_given()) command->options.image_scale = command->scale;
    if (held_out.is_given()) command->options.held_out_every = command->held_out;
    if (held_out_middle.is_given()) command->options.held_out_middle = command->held_out_middle;
    if (held_out_last.is_given()) command->options.held_out_last = command->held_out_last;
    if (held_out_sensor.is_given()) command->options.held_out_sensors = command->held_out_sensors;
    eval(*command, globals);
  });
}

}  // namespace simuli::cli
