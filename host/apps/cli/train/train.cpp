#include <algorithm>
#include <array>
#include <charconv>
#include <cstdlib>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <functional>
#include <iostream>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/apps/cli/base/commands.hpp"
#include "host/apps/cli/base/interrupt.hpp"
#include "host/apps/cli/base/program.hpp"
#include "host/apps/cli/base/provenance.hpp"
#include "host/apps/cli/base/refuse.hpp"
#include "host/apps/cli/base/settings.hpp"
#include "host/apps/cli/report/report.hpp"
#include "host/apps/cli/report/training.hpp"
#include "host/apps/cli/train/launched_ranks.hpp"
#include "host/apps/cli/train/print_report.hpp"
#include "host/apps/cli/view/live_page.hpp"
#include "host/core/base/error.hpp"
#include "host/core/base/version.hpp"
#include "io/base/file.hpp"
#include "io/base/output.hpp"
#include "io/base/temporary.hpp"
#include "io/scene/scene_folder.hpp"
#include "optim/eval/held_out_scores.hpp"
#include "optim/train/chunk/chunk_parts.hpp"
#include "optim/train/ranks/ranks.hpp"
#include "optim/train/training.hpp"

namespace simuli::cli {
namespace {

struct TrainCommand {
  std::string log;
  std::string output;
  bool overwrite = false;
  bool new_start = false;
  std::vector<std::string> settings;
  std::vector<std::string> sensors;  // to train on; empty: all
  TrainingOptions options;
  TrainOutputs outputs;
  std::string report;  // file to write; empty: none
  int view_port = -1;  // of the viewer; negative: none
};

void take_iterations(const std::string& text, TrainOptions& options) {
  options.length.automatic = text == "auto";
  if (options.length.automatic) return;
  const Fields fields = fields_of(options);
  const Field& iterations = *fields.find("iterations");
  if (iterations.set(text)) return;
  throw_usage_error("--iterations", text, "auto, or " + iterations.allowed());
}

/// Parses "6GB", "512MiB" or a number of bytes.
std::size_t memory_size(const char* option, const std::string& text) {
  constexpr std::array<std::pair<const char*, double>, 8> kUnits{{{"", 1.0},
                                                                  {"B", 1.0},
                                                                  {"MB", 1e6},
                                                                  {"GB", 1e9},
                                                                  {"TB", 1e12},
                                                                  {"MiB", 1048576.0},
                                                                  {"GiB", 1073741824.0},
                                                                  {"TiB", 1099511627776.0}}};
  constexpr double kMost = 1e18;
  double number = 0.0;
  const char* const end = text.data() + text.size();
  const auto [rest, failed] = std::from_chars(text.data(), end, number, std::chars_format::fixed);
  const std::string unit(rest, end);
  const auto found =
      std::find_if(kUnits.begin(), kUnits.end(), [&](const auto& known) { return known.first == unit; });
  const bool is_size = failed == std::errc() && found != kUnits.end();
  if (const double bytes = is_size ? number * found->second : 0.0; bytes >= 1.0 && bytes <= kMost) {
    return static_cast<std::size_t>(bytes);
  }
  throw_usage_error(option, text, "a size above 0: 6GB, 512MiB, or bytes");
}

/// Scores the held-out frames, which are stored with the scene; the report uses all frames if none was held
/// out.
std::optional<HeldOutScores> score(const TrainCommand& command,
                                   const Device& device,
                                   SceneFile scene,
                                   const Log& log,
                                   const TrainedReport& trained,
                                   const Globals& globals) {
  const bool held_out = has_held_out(scene);
  if (!held_out && command.report.empty()) return {};
  EvalOptions options{.render = command.options.train.render};
  if (!held_out) options.held_out_every = 0;  // all frames
  Evaluation evaluation(device, std::move(scene), log, options);
  const EvalReport report = run_evaluation(evaluation, globals, command.output);
  if (!command.report.empty()) {
    write_report(
        command.report,
        {.title = fmt::format("simuli train: {} from {}", command.output, command.log), .trained = &trained},
        globals,
        evaluation,
        report);
  }
  return held_out ? scores_of(report) : std::optional<HeldOutScores>();
}

std::filesystem::path checkpoint_beside(const std::string& output) {
  std::filesystem::path file = std::filesystem::path(output).lexically_normal();
  if (!file.has_filename()) file = file.parent_path();
  return file += ".checkpoint";
}

/// Refuses outputs that cannot be written or would be overwritten, before any work. Then this process owns the
/// output.
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
                            ? "its checkpoint, a path that does not exist yet, or --overwrite"
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
    if (failed) throw_input_error(events.string(), "folder", failed.message(), "one that can be made");
    need_writable(events / "events");
  }
  for (const std::filesystem::path& path :
       {std::filesystem::path(command.output), checkpoint, std::filesystem::path(command.report)}) {
    if (!path.empty()) remove_stale_temporaries(path);
  }
  return lock;
}

/// Returns the scene that the page shows before there are particles.
SceneFile without_particles(const Log& log) {
  SceneFile file;
  file.scene.name = log.name;
  file.cameras = log.cameras;
  file.lidars = log.lidars;
  file.world_from_rig = log.world_from_rig;
  return file;
}

/// Applies --sensors: holds out all frames of the other sensors.
void take_sensors(TrainCommand& command, const Log& log) {
  if (command.sensors.empty()) return;
  std::vector<std::string>& held_out = command.options.frames.held_out_sensors;
  for (std::string& other : other_sensors(log, command.sensors, "--sensors")) {
    if (std::find(held_out.begin(), held_out.end(), other) == held_out.end()) held_out.push_back(other);
  }
}

using OpenDevice = std::function<Device()>;

/// Runs a rank that writes no output.
void share(TrainCommand command, const OpenDevice& open, const Globals& globals, Ranks& ranks) {
  ranks.wait_for_all();  // the first rank has locked the output and written the log
  const Log log = read_log(command.log);
  take_sensors(command, log);
  const Device device = open();
  command.outputs.event_folder.clear();
  command.outputs.ranks = &ranks;
  Training training(device, log, command.options, ranks);
  static_cast<void>(run_training(training, device, globals, command.outputs));
}

void train(TrainCommand command, const OpenDevice& open, const Globals& globals, Ranks& ranks) {
  if (!ranks.is_first()) return share(std::move(command), open, globals, ranks);
  TrainingOptions& options = command.options;
  const Log log = read_log(command.log);
  take_sensors(command, log);
  const std::unique_ptr<OutputLock> lock = take_output(command);
  ranks.wait_for_all();
  const Device device = open();
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
  command.outputs.ranks = &ranks;
  command.outputs.frames = uses_text(sensor_uses(log, HeldOutRule(log, options.frames)));
  Training training(device, log, options, ranks);
  TrainedReport trained;
  trained.history = run_training(training, device, globals, command.outputs);
  trained.report = training.report();
  SceneFile scene = trained_scene(std::move(training), globals);
  write_scene(command.output, scene);
  const auto camera_particles = scene.scene.camera.size(), lidar_particles = scene.scene.lidar.size();
  if (command.outputs.checkpoints.every == 0) {
    std::error_code ignored;  // an error is irrelevant here: the scene is complete
    const std::filesystem::path& checkpoint = command.outputs.checkpoints.file;
    std::filesystem::remove(checkpoint, ignored);
    for (std::size_t i = 0; std::filesystem::remove(chunk_file(checkpoint, i), ignored); ++i) {
    }
  }
  const std::optional<HeldOutScores> held_out =
      score(command, device, std::move(scene), log, trained, globals);
  print_report({.training = trained.report,
                .held_out = held_out,
                .camera_particles = camera_particles,
                .lidar_particles = lidar_particles,
                .log = command.log,
                .scene = command.output,
                .report = command.report},
               globals.json);
}

/// Runs a rank of a launcher. Only the first rank prints errors that all ranks have.
void train_launched(const TrainCommand& command,
                    const OpenDevice& open,
                    const Globals& globals,
                    LaunchedRanks& ranks) {
  const auto end = [&ranks](int exit_code, const std::string& line) {
    // The launcher ends the remaining ranks when one has ended; print the line before.
    if (ranks.is_first()) std::cerr << "simuli: " << line << std::endl;
    ranks.finish();
    throw Ended(exit_code, "");
  };
  try {
    need_same(ranks,
              {{"build", fmt::format("{} {} {}", version(), globals.commit, build_id())},
               {"shards", fmt::format("{}", command.options.train.shards.count)}});
    try {
      Training::need_shards(ranks, command.options);
    } catch (const Error& error) {  // all ranks get the same error
      end(error.exit_code(), error.what());
    }
    train(command, open, globals, ranks);
    ranks.finish();
  } catch (const RanksDiffer& differ) {
    end(kRanksDifferExit, differ.what());
  } catch (const Interrupted& interrupted) {
    end(kInterruptedExit, interrupted.what());
  } catch (const Error& error) {
    if (ranks.is_first()) throw;
    throw Error(error.kind(), fmt::format("rank {}: {}", ranks.rank(), error.what()));
  }
}

void train_on_ranks(TrainCommand command, const Globals& globals) {
  TrainingOptions& options = command.options;
  options.cache_initialization = !command.new_start;
  options.train.render = training_options_of(globals.quality);
  fields_of(options).apply(command.settings);
  static_cast<void>(checked(options));
  command.outputs.checkpoints.file = checkpoint_beside(command.output);
  const std::vector<std::string> devices = devices_of(globals.device);
  const Environment environment = [](const char* name) { return std::getenv(name); };
  if (const std::unique_ptr<LaunchedRanks> launched = launched_ranks(environment)) {
    const std::string own = device_of_rank(devices, environment);
    return train_launched(
        command, [own] { return Device::best(own); }, globals, *launched);
  }
  if (devices.size() == 1) {
    return train(
        std::move(command), [&] { return Device::best(devices.front()); }, globals, one_rank());
  }
  // Opened in sequence: some drivers do not support concurrent queries of devices.
  std::vector<Device> opened;
  for (const std::string& device : devices) opened.push_back(Device::best(device));
  try {
    run_rank_threads(opened.size(), [&](Ranks& ranks) {
      train(
          command, [&] { return opened[ranks.rank()]; }, globals, ranks);
    });
  } catch (const RanksDiffer& differ) {
    throw Ended(kRanksDifferExit, differ.what());
  }
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
  sub.option(
         "--iterations",
         [command](const std::string& text) { take_iterations(text, command->options.train); },
         "training steps, one picture each, a sweep every lidar_every; auto: until the training scores "
         "converge")
      .shown_as("INT|auto", fmt::format("{}", command->options.train.iterations));
  add("--max-seconds", command->options.train.max_seconds, "stop training early after this time; 0: never");
  add("--scale",
      command->options.frames.image_scale,
      "size of the training pictures relative to the "
      "recorded ones");
  add("--held-out",
      command->options.frames.held_out_every,
      "keep every N-th frame of each sensor for evaluation; 0: none");
  add("--held-out-middle",
      command->options.frames.held_out_middle,
      "also hold out the frames on this share of the trajectory, around its middle");
  add("--held-out-last",
      command->options.frames.held_out_last,
      "also hold out the frames on this share of the trajectory, at its end");
  sub.option("--held-out-sensor",
             command->options.frames.held_out_sensors,
             "camera or LiDAR whose frames are all held out for evaluation")
      .one_at_a_time()
      .shown_as("NAME", "none; any number of times");
  sub.option(
         "--sensors", command->sensors, "cameras and LiDARs to train on; frames of the others are held out")
      .one_at_a_time()
      .shown_as("NAME", "all; any number of times");
  add("--seed", command->options.frames.seed, "seed of the frames' order and of subsampling");
  const auto add_memory = [&](const char* name, auto set, const char* text) {
    sub.option(
           name, [name, set](const std::string& size) { set(memory_size(name, size)); }, text)
        .shown_as("SIZE", "not limited");
  };
  add_memory(
      "--host-memory",
      [command](std::size_t bytes) { command->options.chunks.host_memory_bytes = bytes; },
      "limit of the training's host memory, for example 6GB: a long drive is split into chunks that fit "
      "(host_memory_bytes)");
  add_memory(
      "--device-memory",
      [command](std::size_t bytes) { command->options.train.memory_bytes = bytes; },
      "limit of the training's device memory, likewise (memory_bytes)");
  sub.option("--checkpoint-every",
             command->outputs.checkpoints.every,
             "iterations between checkpoints in OUTPUT.checkpoint, of which the last is kept; 0: none")
      .range(0, std::numeric_limits<int>::max())
      .with_default();
  sub.flag("--overwrite", command->overwrite, "replace an existing scene or checkpoint");
  sub.flag("--resume",
           command->outputs.resume,
           "continue from OUTPUT.checkpoint, if it exists; with more --iterations also from the end of a "
           "training: the remaining learning rates are those of the longer training");
  sub.flag(
      "--no-cache",
      command->new_start,
      "compute the initialisation and do not cache it; otherwise the initialisation of a training with the "
      "same log and settings is reused from ~/.cache/simuli (SIMULI_CACHE_DIR)");
  sub.option("--fixer",
             command->options.fixer_command,
             "program, with arguments, that enhances off-trajectory pictures, which the scene is then "
             "trained on: docs/FIXERS.md");
  sub.option("--report", command->report, "HTML file to write: curves, metrics, pictures, sweeps, times");
  sub.option("--view", command->view_port, "port of a page that shows the training; 0: any free port")
      .range(0, 65535);
  sub.option("--tensorboard", command->outputs.event_folder, "folder for TensorBoard's event file");
  const auto fields = [command, &globals] {
    command->options.train.render = training_options_of(globals.quality);
    return fields_of(command->options);
  };
  add_settings(sub, command->settings, globals, fields, "KEY=VALUE...; help: lists the keys");
  sub.run([command, &globals] { train_on_ranks(*command, globals); });
}

}  // namespace simuli::cli
