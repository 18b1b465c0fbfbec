#include <algorithm>
#include <fmt/format.h>
#include <memory>
#include <string>
#include <vector>

#include "host/cli/base/commands.hpp"
#include "host/cli/base/edits.hpp"
#include "host/cli/base/settings.hpp"
#include "host/cli/report/report.hpp"
#include "host/cli/report/training.hpp"
#include "io/scene/scene_folder.hpp"

namespace simuli::cli {
namespace {

struct EvalCommand {
  std::string scene;
  std::string log;
  std::vector<std::string> settings;
  Edits edits;
  EvalOptions options;
  std::string report;  // file to write; empty: none
};

/// The log with its sensors where the scene has them: training may have learned better.
Log mounted(Log log, const SceneFile& scene) {
  for (LogCamera& camera : log.cameras) {
    const LogCamera* const known = scene.find_camera(camera.model.name);
    if (known != nullptr) camera.rig_from_camera = known->rig_from_camera;
  }
  for (LogLidar& lidar : log.lidars) {
    const LogLidar* const known = scene.find_lidar(name_of(lidar.model));
    if (known == nullptr) continue;
    lidar.rig_from_lidar = known->rig_from_lidar;
    auto* const model = std::get_if<Lidar>(&lidar.model);
    if (model == nullptr) continue;
    const Lidar& trained = known->with_rows();
    model->blind = trained.blind;
    const std::size_t rows = std::min(model->rows.size(), trained.rows.size());
    for (std::size_t row = 0; row < rows; ++row) model->rows[row].range_bias = trained.rows[row].range_bias;
  }
  return log;
}

void eval(EvalCommand command, const Globals& globals) {
  command.options.render = options_of(globals.quality);
  fields_of(command.options).apply(command.settings);
  check(command.options);
  SceneFile file = read_scene(command.scene);
  apply(command.edits, file.scene);
  const Log log = mounted(read_log(command.log), file);
  const Device device = Device::best(globals.device);
  const EvalReport report = evaluate_scene(device, log, file.scene, command.options, globals);
  if (!command.report.empty()) {
    write_report(command.report,
                 fmt::format("simuli eval: {} on {}", command.scene, command.log),
                 globals,
                 log,
                 file.scene,
                 command.options,
                 report,
                 nullptr);
  }
  print_eval(report, globals.json);
}

}  // namespace

void add_eval(Command app, const Globals& globals) {
  const auto command = std::make_shared<EvalCommand>();
  Command sub = app.command("eval", "compare a scene with the frames it was not trained on");
  sub.option("SCENE", command->scene, "scene folder").required();
  sub.option("LOG", command->log, "log folder that the scene was trained on").required();
  const auto add = [&](const char* name, auto& value, const char* text) {
    sub.option(name, value, text).with_default();
  };
  add("--scale", command->options.image_scale, "size of the compared pictures over the recorded");
  add("--held-out", command->options.held_out_every, "every N-th frame, as in training; 0: all frames");
  add("--repeats", command->options.timed_renders, "timed renders of each sensor");
  const auto fields = [command, &globals] {
    command->options.render = options_of(globals.quality);
    return fields_of(command->options);
  };
  add_settings(sub, command->settings, globals, fields, "KEY=VALUE...; help: lists the keys");
  sub.option("--report", command->report, "HTML file to write: metrics, pictures, sweeps, times");
  add_edit_options(sub, command->edits);
  sub.run([command, &globals] { eval(*command, globals); });
}

}  // namespace simuli::cli
