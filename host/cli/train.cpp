#include <fmt/format.h>
#include <fmt/ranges.h>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "host/cli/base/commands.hpp"
#include "host/cli/base/settings.hpp"
#include "host/cli/report/report.hpp"
#include "host/cli/report/training.hpp"
#include "host/cli/view/view_server.hpp"
#include "io/scene/scene_folder.hpp"
#include "optim/log/own_vehicle.hpp"
#include "optim/log/range_bias.hpp"

namespace simuli::cli {
namespace {

struct TrainCommand {
  std::string log;
  std::string output;
  std::vector<std::string> settings;
  InitOptions init;
  TrainOptions train;
  TrainOutputs outputs;
  std::string report;  // file to write; empty: none
  int view_port = -1;  // of the viewer; below 0: none

  /// What --set sets.
  Fields fields() {
    Fields all = fields_of(train);
    all.part("", init);
    return all;
  }
};

void print_report(const TrainedScene& trained, const TrainCommand& command, bool json) {
  const TrainReport& r = trained.training;
  if (json) {
    const nlohmann::ordered_json out = {{"scene", command.output},
                                        {"iterations", r.last.iteration},
                                        {"stopped_early", r.stopped_early},
                                        {"images", r.images},
                                        {"sweeps", r.sweeps},
                                        {"camera_particles", r.camera_particles},
                                        {"lidar_particles", r.lidar_particles},
                                        {"depth_points", trained.init.depth_points},
                                        {"moving_points", trained.init.moving_points},
                                        {"train_psnr_db", r.last.psnr_db},
                                        {"train_distance_m", r.last.distance_m},
                                        {"train_drop_accuracy", r.last.drop_accuracy},
                                        {"relocated", r.relocated},
                                        {"grown", r.grown},
                                        {"anchor_m", r.anchor_m},
                                        {"anchor_seconds", r.anchor_seconds},
                                        {"densify_seconds", r.densify_seconds},
                                        {"rejected_gradients", r.rejected_gradients},
                                        {"unsound_particles", r.unsound_particles},
                                        {"unsound_losses", r.unsound_losses},
                                        {"init_seconds", trained.init.seconds},
                                        {"seconds", r.seconds}};
    std::cout << out.dump(2) << '\n';
    return;
  }
  std::cout << fmt::format("scene {}\n  {} iterations on {} images and {} sweeps, {:.1f} s + {:.1f} s\n",
                           command.output,
                           r.last.iteration,
                           r.images,
                           r.sweeps,
                           trained.init.seconds,
                           r.seconds)
            << fmt::format("  camera set {} particles ({} of them the far shell), LiDAR set {} particles\n",
                           r.camera_particles,
                           trained.init.shell_particles,
                           r.lidar_particles)
            << fmt::format(
                   "  {} relocated, {} new; anchors {:.1f} cm away; share of the time: anchoring {:.1f} %, "
                   "densification {:.1f} %\n",
                   r.relocated,
                   r.grown,
                   100.0 * r.anchor_m,
                   100.0 * r.anchor_seconds / r.seconds,
                   100.0 * r.densify_seconds / r.seconds)
            << fmt::format(
                   "  left out: {} points that moved, {} thinned from the LiDAR set, {} from the "
                   "camera set, {} that no image saw\n",
                   trained.init.moving_points,
                   trained.init.lidar_thinned,
                   trained.init.camera_thinned,
                   trained.init.unseen_points);
}

/// With what held-out frames say; of all frames when none was held out.
void write_train_report(const TrainCommand& command,
                        const Device& device,
                        const Log& log,
                        const TrainedScene& trained,
                        const Globals& globals) {
  EvalOptions eval;
  eval.image_scale = command.train.image_scale;
  eval.held_out_every = command.train.held_out_every;
  eval.render = command.train.render;
  const EvalReport report = evaluate_scene(device, log, trained.file.scene, eval, globals);
  write_report(command.report,
               fmt::format("simuli train: {} from {}", command.output, command.log),
               globals,
               log,
               trained.file.scene,
               eval,
               report,
               &trained);
}

void train(TrainCommand command, const Globals& globals) {
  command.train.render = training_options_of(globals.quality);
  command.fields().apply(command.settings);
  command.init.image_scale = command.train.image_scale;
  command.init.held_out_every = command.train.held_out_every;
  command.init.seed = command.train.seed;
  (void)checked(command.train);
  check(command.init);
  Log log = read_log(command.log);
  if (command.init.range_bias) log = with_range_bias(std::move(log), command.init.held_out_every);
  if (command.init.own_vehicle) log = with_blind_arcs(std::move(log), command.init.held_out_every);
  const Device device = Device::best(globals.device);
  if (globals.verbose) {
    std::cerr << fmt::format(
        "simuli: {}; {}\n", device.info().label(), fmt::join(command.fields().lines(), " "));
  }
  std::filesystem::path& checkpoint = command.outputs.checkpoints.file;
  checkpoint = std::filesystem::path(command.output).lexically_normal();
  if (!checkpoint.has_filename()) checkpoint = checkpoint.parent_path();
  checkpoint += ".checkpoint";
  std::unique_ptr<ViewSession> session;
  std::unique_ptr<ViewServer> server;
  if (command.view_port >= 0) {
    SceneFile file;
    file.scene.name = log.name;
    file.cameras = log.cameras;
    file.lidars = log.lidars;
    file.world_from_rig = log.world_from_rig;
    session = std::make_unique<ViewSession>(globals, std::move(file));
    ServerOptions options;
    options.port = command.view_port;
    server = std::make_unique<ViewServer>(*session, options);
    std::cerr << fmt::format("simuli: the training in the browser: {}\n", server->url());
    command.outputs.view = session.get();
  }
  const TrainedScene trained =
      train_scene(device, log, command.init, command.train, globals, command.outputs);
  write_scene(command.output, trained.file);
  std::error_code ignored;  // nobody needs it any more, and the scene is there
  std::filesystem::remove(checkpoint, ignored);
  if (!command.report.empty()) write_train_report(command, device, log, trained, globals);
  print_report(trained, command, globals.json);
}

}  // namespace

void add_train(Command app, const Globals& globals) {
  const auto command = std::make_shared<TrainCommand>();
  Command sub = app.command("train", "fit a scene to a log");
  sub.option("LOG", command->log, "log folder").required();
  sub.option("-o,--output", command->output, "scene folder to write").required();
  const auto add = [&](const char* name, auto& value, const char* text) {
    sub.option(name, value, text).with_default();
  };
  add("--iterations", command->train.iterations, "one image each, a sweep every lidar_every");
  add("--max-seconds", command->train.max_seconds, "stop training early after this time; 0: never");
  add("--scale", command->train.image_scale, "size of the training pictures over the recorded");
  add("--held-out", command->train.held_out_every, "keep every N-th frame for evaluation; 0: none");
  add("--seed", command->train.seed, "of the frames' order and of thinning");
  add("--checkpoint-every",
      command->outputs.checkpoints.every,
      "iterations between states in OUTPUT.checkpoint; 0: none");
  sub.flag("--resume", command->outputs.checkpoints.resume, "go on from OUTPUT.checkpoint, if it is there");
  sub.option("--report", command->report, "HTML file to write: curves, metrics, pictures, sweeps, times");
  sub.option("--view", command->view_port, "port of a page that shows the training; 0: any free one")
      .range(0, 65535);
  sub.option("--tensorboard", command->outputs.event_folder, "folder for TensorBoard's event file");
  const auto fields = [command, &globals] {
    command->train.render = training_options_of(globals.quality);
    return command->fields();
  };
  add_settings(sub, command->settings, globals, fields, "KEY=VALUE...; help: lists the keys");
  sub.run([command, &globals] { train(*command, globals); });
}

}  // namespace simuli::cli
