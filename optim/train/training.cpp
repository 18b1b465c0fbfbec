#include "optim/train/training.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <string>
#include <utility>
#include <vector>

#include "host/base/error.hpp"
#include "host/base/fields.hpp"
#include "host/base/version.hpp"
#include "host/render/options/quality.hpp"
#include "host/runtime/cache/tuning.hpp"
#include "optim/actors/complete_actors.hpp"
#include "optim/actors/find_actors.hpp"
#include "optim/init/initialize.hpp"
#include "optim/log/sensor_learning.hpp"
#include "optim/path/refined_path.hpp"
#include "optim/report/judgement.hpp"
#include "optim/support/record_support.hpp"
#include "optim/surfaces/dark_surfaces.hpp"
#include "optim/train/trainer.hpp"

namespace simuli {
namespace {

/// The bundle that these options of a training are.
std::string quality_of(const RenderOptions& options) {
  const std::vector<std::string> lines = lines_of(options);
  for (const Quality quality : {Quality::kBalanced, Quality::kDraft, Quality::kExact, Quality::kReference}) {
    if (lines_of(training_options_of(quality)) == lines) {
      return quality_names()[static_cast<std::size_t>(quality)];
    }
  }
  return "custom";
}

}  // namespace

struct Training::State {
  State(const Device& device, const Log& log, SceneInit start, const TrainingOptions& options, Ranks& ranks)
      : trainer(device, log, std::move(start.scene), options, std::move(start.moving), ranks) {}
  Trainer trainer;
};

Training::Training(const Device& device, Log log, const TrainingOptions& options, Ranks& ranks)
    : ranks_(ranks),
      device_(device),
      log_(std::move(log)),
      log_hash_(simuli::log_hash(log_)),
      options_(checked(options)) {
  need_shards(ranks, options_);
}

void Training::need_shards(const Ranks& ranks, const TrainingOptions& options) {
  const auto shards = static_cast<std::size_t>(options.train.shards.count);
  if (ranks.size() <= shards) return;
  throw Error(
      ErrorKind::kUsage,
      fmt::format("ranks: found {}, allowed up to {}, the frames of a step (shards)", ranks.size(), shards));
}

Training::~Training() = default;

const Training::State& Training::prepared() const {
  if (state_) return *state_;
  throw Error(ErrorKind::kInternal, "training: found no start, allowed prepare() first");
}

/// All that must be the same for it to be the same training, a line each.
std::string Training::identity() const {
  TrainingOptions same = options_;  // these two decide where a training ends
  same.train.iterations = 0;
  same.train.max_seconds = 0.0;
  const std::string fixer = options_.fixer_command.empty() ? "" : "fixer=" + options_.fixer_command + "\n";
  return fmt::format("log={} {}\n{}{}\n", log_.name, log_hash_, fixer, fmt::join(lines_of(same), "\n"));
}

/// What ranks must have alike to come to the same bits.
std::vector<RankField> Training::rank_fields() const {
  const DeviceInfo& device = device_.info();
  const DeviceTuning& tuning = tuning_of(device_);
  std::vector<RankField> fields = {
      {"device", device.label()},
      {"device version", device.device_version},
      {"driver", device.driver_version},
      {"compute units", fmt::format("{}", device.compute_units)},
      {"tuning", fmt::format("{} {} {} {}", tuning.lanes, tuning.vectors, tuning.work_items, tuning.group)},
      {"log", fmt::format("{} {}", log_.name, log_hash_)},
      {"fixer", options_.fixer_command}};
  for (const std::string& line : lines_of(options_)) {
    const std::size_t equals = line.find('=');
    fields.push_back({line.substr(0, equals), line.substr(equals + 1)});
  }
  return fields;
}

void Training::prepare(const Progress& progress) {
  if (state_) return;
  need_same(ranks_, rank_fields());
  RefinedLog refined = with_refined_path(std::move(log_), options_.path, progress);
  log_ = std::move(refined.log);
  report_.path = std::move(refined.report);
  log_ = with_learned_sensors(std::move(log_), options_.frames, options_.sensors);
  if (options_.actors.find && options_.init.actors) {
    const FoundActors found = find_actors(log_, options_.frames, options_.actors);
    CompletedActors completed = complete_actors(std::move(log_.actors), found.actors);
    log_.actors = std::move(completed.actors);
    report_.found = found.report;
    report_.found.added = completed.added;
    report_.found.continued = completed.continued;
  }
  SceneInit start = initialize_scene(log_, options_.frames, options_.init, progress);
  start.report.dark_points = add_dark_surfaces(log_, options_.frames, options_.init, start.scene);
  start.report.lidar_particles += start.report.dark_points;
  report_.init = start.report;
  state_ = std::make_unique<State>(device_, log_, std::move(start), options_, ranks_);
  state_->trainer.need_one_state(identity());
}

void Training::resume(const std::filesystem::path& checkpoint, const Progress& progress) {
  Trainer::need_settings(checkpoint, identity(), options_.train);
  prepare(progress);
  state_->trainer.resume(checkpoint, identity());
  state_->trainer.need_one_state(identity());
}

void Training::save(const std::filesystem::path& checkpoint) {
  static_cast<void>(prepared());
  state_->trainer.need_one_state(identity());
  if (ranks_.is_first()) state_->trainer.save(checkpoint, identity());
}

const TrainingReport& Training::run(const Observer& on_step, const Checkpoints& checkpoints) {
  prepare();
  int saved = -1;  // iteration
  report_.train = state_->trainer.run([&](const TrainStatus& status) {
    if (on_step) on_step(status);
    if (checkpoints.every <= 0 || status.iteration % checkpoints.every != 0) return;
    save(checkpoints.file);
    saved = status.iteration;
  });
  if (checkpoints.every > 0 && saved != status().iteration) save(checkpoints.file);
  if (checkpoints.every <= 0) state_->trainer.need_one_state(identity());
  Judgement judgement = judge(report_.train);
  report_.train.warnings = std::move(judgement.warnings);
  if (!judgement.failure.empty()) throw Error(ErrorKind::kNumeric, judgement.failure);
  return report_;
}

const TrainStatus& Training::status() const { return prepared().trainer.status(); }

Scene Training::scene() const { return prepared().trainer.scene(); }

SceneFile Training::result() const {
  SceneFile file{scene(), log_.cameras, log_.lidars, log_.world_from_rig, frame_spans(log_)};
  const Trainer& trainer = prepared().trainer;
  for (LogCamera& camera : file.cameras) {
    camera.rig_from_camera = moved_by(trainer.sensor_offsets(), camera.model.name, camera.rig_from_camera);
  }
  for (LogLidar& lidar : file.lidars) {
    lidar.model = trainer.lidar(name_of(lidar.model));
    lidar.rig_from_lidar = moved_by(trainer.sensor_offsets(), name_of(lidar.model), lidar.rig_from_lidar);
  }
  file.training = TrainingRecord{.log_name = log_.name,
                                 .log_hash = log_hash_,
                                 .frames = options_.frames,
                                 .iterations = status().iteration,
                                 .planned_iterations = status().planned,
                                 .quality = quality_of(options_.train.render),
                                 .settings = lines_of(options_),
                                 .version = version(),
                                 .device = device_.info().label(),
                                 .driver = device_.info().driver_version};
  try {
    file.support = record_support(device_, log_, file, options_.frames, options_.train.render);
  } catch (const Error& error) {
    // A device that has no room for it beside the training: the scene is there all the same.
    if (error.kind() != ErrorKind::kDevice) throw;
  }
  return file;
}

}  // namespace simuli
