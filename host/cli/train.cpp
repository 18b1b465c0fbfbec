#include <fmt/format.h>
#include <fmt/ranges.h>
#include <iostream>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "host/base/error.hpp"
#include "host/cli/base/commands.hpp"
#include "host/cli/base/json_text.hpp"
#include "host/cli/base/settings.hpp"
#include "host/cli/report/report.hpp"
#include "host/cli/report/training.hpp"
#include "host/cli/view/live_page.hpp"
#include "io/base/output.hpp"
#include "io/base/regular_file.hpp"
#include "io/base/temporary.hpp"
#include "io/scene/scene_folder.hpp"
#include "io/scene/scene_output.hpp"
#include "optim/train/training.hpp"

namespace simuli::cli {
namespace {

struct TrainCommand {
  std::string log;
  std::string output;
  bool overwrite = false;
  std::vector<std::string> settings;
  TrainingOptions options;
  TrainOutputs outputs;
  std::string report;  // file to write; empty: none
  int view_port = -1;  // of the viewer; below 0: none
};

nlohmann::ordered_json json_of(const std::vector<LengthStage>& stages) {
  nlohmann::ordered_json out = nlohmann::ordered_json::array();
  for (const LengthStage& s : stages) {
    out.push_back({{"iterations", s.iterations},
                   {"square", s.square},
                   {"lidar_loss", s.lidar_loss},
                   {"gain_db", s.gain_db},
                   {"gain_share", s.gain_share}});
  }
  return out;
}

std::string stages_text(const std::vector<LengthStage>& stages) {
  std::string text;
  for (const LengthStage& s : stages) {
    text += fmt::format("  {} iterations", s.iterations);
    if (&s != &stages.front()) {
      text += fmt::format(": per doubling {:+.2f} dB of training pictures, LiDAR loss {:+.1f} %",
                          s.gain_db,
                          -100.0 * s.gain_share);
    }
    text += '\n';
  }
  return text;
}

void take_iterations(const std::string& text, TrainOptions& options) {
  options.length.automatic = text == "auto";
  if (options.length.automatic) return;
  const Fields fields = fields_of(options);
  const Field& iterations = *fields.find("iterations");
  if (iterations.set(text)) return;
  throw Error(ErrorKind::kUsage,
              fmt::format("--iterations: found {}, allowed auto, or {}", text, iterations.allowed()));
}

/// A line, or none where nothing was asked for.
std::string path_text(const PathReport& path) {
  if (path.sweeps == 0)
    return path.reason.empty() ? "" : fmt::format("  path as recorded: {}\n", path.reason);
  const std::string fit = fmt::format("surfaces {:.2f} cm thick, {:.2f} cm on the refined path",
                                      100.0 * path.recorded_m,
                                      100.0 * path.refined_m);
  if (!path.used)
    return fmt::format("  path as recorded: {} ({}; {:.1f} s)\n", path.reason, fit, path.seconds);
  return fmt::format(
      "  path refined by up to {:.1f} cm: {}; {:.1f} s\n", 100.0 * path.largest_change_m, fit, path.seconds);
}

void print_report(const TrainingReport& report, const TrainCommand& command, bool json) {
  const TrainReport& r = report.train;
  const InitReport& init = report.init;
  const FindReport& found = report.found;
  const PathReport& path = report.path;
  if (json) {
    const nlohmann::ordered_json out = {{"scene", command.output},
                                        {"iterations", r.last.iteration},
                                        {"stopped_early", r.stopped_early},
                                        {"stages", json_of(r.stages)},
                                        {"images", r.images},
                                        {"sweeps", r.sweeps},
                                        {"camera_particles", r.camera_particles},
                                        {"lidar_particles", r.lidar_particles},
                                        {"path_refined", path.used},
                                        {"path_recorded_m", path.recorded_m},
                                        {"path_refined_m", path.refined_m},
                                        {"path_largest_change_m", path.largest_change_m},
                                        {"path_seconds", path.seconds},
                                        {"found_actors", found.actors},
                                        {"added_actors", found.added},
                                        {"continued_labels", found.continued},
                                        {"moving_returns", found.moving_returns},
                                        {"moving_returns_on_actors", found.moving_on_actors},
                                        {"find_seconds", found.seconds},
                                        {"depth_points", init.depth_points},
                                        {"moving_points", init.moving_points},
                                        {"train_psnr_db", r.last.psnr_db},
                                        {"train_distance_m", r.last.distance_m},
                                        {"train_drop_accuracy", r.last.drop_accuracy},
                                        {"relocated", r.relocated},
                                        {"grown", r.grown},
                                        {"pruned", r.pruned},
                                        {"row_ranges_m", r.row_ranges_m},
                                        {"lidar_cells", init.lidar_cells},
                                        {"lidar_thinned", init.lidar_thinned},
                                        {"anchor_m", r.anchor_m},
                                        {"anchor_seconds", r.anchor_seconds},
                                        {"densify_seconds", r.densify_seconds},
                                        {"rejected_gradients", r.rejected_gradients},
                                        {"unsound_particles", r.unsound_particles},
                                        {"unsound_losses", r.unsound_losses},
                                        {"warnings", r.warnings},
                                        {"init_seconds", init.seconds},
                                        {"seconds", r.seconds}};
    std::cout << json_text(out) << '\n';
    return;
  }
  std::cout
      << fmt::format("scene {}\n  {} iterations on {} images and {} sweeps, {:.1f} s + {:.1f} s\n",
                     command.output,
                     r.last.iteration,
                     r.images,
                     r.sweeps,
                     init.seconds,
                     r.seconds)
      << stages_text(r.stages) << path_text(path)
      << (found.sweeps == 0
              ? ""
              : fmt::format("  {} moving things found in {:.1f} s, with {} of {} returns that moved; {} of "
                            "them have no label, {} labels go on where they had ended\n",
                            found.actors,
                            found.seconds,
                            found.moving_on_actors,
                            found.moving_returns,
                            found.added,
                            found.continued))
      << fmt::format(
             "  camera set {} particles ({} of them the far shell, {} where only the laser saw what is "
             "there), LiDAR set {} particles ({} of them on actors' surfaces that return nothing)\n",
             r.camera_particles,
             init.shell_particles,
             init.filled_particles,
             r.lidar_particles,
             init.dark_points)
      << fmt::format(
             "  {} relocated, {} new, {} pruned; ranges of rows corrected by up to {:.1f} cm; anchors {:.1f} "
             "cm away; share of the time: anchoring "
             "{:.1f} %, densification {:.1f} %\n",
             r.relocated,
             r.grown,
             r.pruned,
             100.0 * r.row_ranges_m,
             100.0 * r.anchor_m,
             100.0 * r.anchor_seconds / r.seconds,
             100.0 * r.densify_seconds / r.seconds)
      << fmt::format(
             "  left out: {} points that moved, {} thinned from the LiDAR set, {} from the "
             "camera set, {} that no image saw, {} that none shows apart from others\n",
             init.moving_points,
             init.lidar_thinned,
             init.camera_thinned,
             init.unseen_points,
             init.joined_points);
}

/// With what held-out frames say; of all frames when none was held out.
void write_train_report(const TrainCommand& command,
                        const Device& device,
                        SceneFile scene,
                        Log log,
                        const TrainedReport& trained,
                        const Globals& globals) {
  Evaluation evaluation(device, std::move(scene), std::move(log), {.render = command.options.train.render});
  const EvalReport report = run_evaluation(evaluation, globals);
  write_report(
      command.report,
      {.title = fmt::format("simuli train: {} from {}", command.output, command.log), .trained = &trained},
      globals,
      evaluation,
      report);
}

std::filesystem::path checkpoint_beside(const std::string& output) {
  std::filesystem::path file = std::filesystem::path(output).lexically_normal();
  if (!file.has_filename()) file = file.parent_path();
  return file += ".checkpoint";
}

/// Refuses before any work what would be lost or could not be written at its end. The output is this
/// process's from here on.
std::unique_ptr<OutputLock> take_output(const TrainCommand& command) {
  const std::filesystem::path& checkpoint = command.outputs.checkpoints.file;
  const bool resumes = command.outputs.resume && is_there(checkpoint);
  if (std::error_code failed; resumes && !std::filesystem::is_regular_file(checkpoint, failed)) {
    throw_input_error(checkpoint.string(), "file", "something that is no file", "the state of a training");
  }
  auto lock = std::make_unique<OutputLock>(command.output);
  if (!command.overwrite && !resumes) {
    if (is_there(command.output)) {
      throw_input_error(command.output,
                        "folder",
                        "something of that name",
                        command.outputs.resume
                            ? "its checkpoint beside it, a path that does not exist yet, or "
                              "--overwrite"
                            : "a path that does not exist yet, or --overwrite");
    }
    if (is_there(checkpoint)) {
      throw_input_error(checkpoint.string(),
                        "file",
                        "the state of a training that has not ended",
                        "--resume, or --overwrite");
    }
  }
  need_scene_output(command.output);
  if (!command.report.empty()) need_writable(command.report);
  const std::filesystem::path& events = command.outputs.event_folder;
  if (!events.empty()) {
    std::error_code failed;
    std::filesystem::create_directories(events, failed);
    need_writable(events / "events");
  }
  for (const std::filesystem::path& path :
       {std::filesystem::path(command.output), checkpoint, std::filesystem::path(command.report)}) {
    if (!path.empty()) remove_stale_temporaries(path);
  }
  return lock;
}

/// What a page shows before there are particles.
SceneFile without_particles(const Log& log) {
  SceneFile file;
  file.scene.name = log.name;
  file.cameras = log.cameras;
  file.lidars = log.lidars;
  file.world_from_rig = log.world_from_rig;
  return file;
}

void train(TrainCommand command, const Globals& globals) {
  TrainingOptions& options = command.options;
  options.train.render = training_options_of(globals.quality);
  fields_of(options).apply(command.settings);
  static_cast<void>(checked(options));
  Checkpoints& checkpoints = command.outputs.checkpoints;
  checkpoints.file = checkpoint_beside(command.output);
  const Log log = read_log(command.log);
  const std::unique_ptr<OutputLock> lock = take_output(command);
  const Device device = Device::best(globals.device);
  if (globals.verbose) {
    std::cerr << fmt::format(
        "simuli: {}; {}\n", device.info().label(), fmt::join(fields_of(options).lines(), " "));
  }
  std::unique_ptr<LivePage> page;
  if (command.view_port >= 0) {
    page = open_live_page(globals, without_particles(log), command.view_port);
    std::cerr << fmt::format("simuli: the training in the browser: {}\n", page->url());
    command.outputs.view = page.get();
  }
  Training training(device, log, options);
  TrainedReport trained;
  trained.history = run_training(training, device, globals, command.outputs);
  trained.report = training.report();
  SceneFile scene = training.result();
  write_scene(command.output, scene);
  if (checkpoints.every == 0) {
    std::error_code ignored;  // nobody needs it any more, and the scene is there
    std::filesystem::remove(checkpoints.file, ignored);
  }
  if (!command.report.empty()) {
    write_train_report(command, device, std::move(scene), log, trained, globals);
  }
  print_report(trained.report, command, globals.json);
}

}  // namespace

void add_train(Command app, const Globals& globals) {
  const auto command = std::make_shared<TrainCommand>();
  Command sub = app.command("train", "fit a scene to a log");
  sub.option("LOG", command->log, "log folder").required().reads();
  sub.option("-o,--output", command->output, "scene folder to write").required().makes(".checkpoint");
  const auto add = [&](const char* name, auto& value, const char* text) {
    sub.option(name, value, text).with_default();
  };
  sub.option(
         "--iterations",
         [command](const std::string& text) { take_iterations(text, command->options.train); },
         "one image each, a sweep every lidar_every; auto: until the training frames gain little")
      .shown_as("INT|auto", fmt::format("{}", command->options.train.iterations));
  add("--max-seconds", command->options.train.max_seconds, "stop training early after this time; 0: never");
  add("--scale", command->options.frames.image_scale, "size of the training pictures over the recorded");
  add("--held-out", command->options.frames.held_out_every, "keep every N-th frame for evaluation; 0: none");
  add("--held-out-last",
      command->options.frames.held_out_last,
      "keep the frames of that share of the path, at its end, for evaluation, too");
  add("--seed", command->options.frames.seed, "of the frames' order and of thinning");
  sub.option("--checkpoint-every",
             command->outputs.checkpoints.every,
             "iterations between states in OUTPUT.checkpoint, the last of which is kept; 0: none")
      .range(0, std::numeric_limits<int>::max())
      .with_default();
  sub.flag("--overwrite", command->overwrite, "replace the scene, or the checkpoint, that is there");
  sub.flag("--resume",
           command->outputs.resume,
           "go on from OUTPUT.checkpoint, if it is there; with more --iterations also from the end of a "
           "training that has kept it: the rates of what is left are those of the longer training")
      .goes_on();
  sub.option("--fixer",
             command->options.fixer_command,
             "program, with arguments, that mends pictures from beside the path for the scene to learn from: "
             "docs/FIXERS.md");
  sub.option("--report", command->report, "HTML file to write: curves, metrics, pictures, sweeps, times")
      .makes();
  sub.option("--view", command->view_port, "port of a page that shows the training; 0: any free one")
      .range(0, 65535);
  sub.option("--tensorboard", command->outputs.event_folder, "folder for TensorBoard's event file").makes();
  const auto fields = [command, &globals] {
    command->options.train.render = training_options_of(globals.quality);
    return fields_of(command->options);
  };
  add_settings(sub, command->settings, globals, fields, "KEY=VALUE...; help: lists the keys");
  sub.run([command, &globals] { train(*command, globals); });
}

}  // namespace simuli::cli
