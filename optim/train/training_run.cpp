#include "optim/train/training_run.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <utility>

#include "host/core/base/error.hpp"
#include "host/core/base/fields.hpp"
#include "optim/actors/complete_actors.hpp"
#include "optim/actors/find_actors.hpp"
#include "optim/complete/inpaint_disocclusions.hpp"
#include "optim/data/sensor_learning.hpp"
#include "optim/init/initialize.hpp"
#include "optim/init/initialize_sets.hpp"
#include "optim/train/judgement.hpp"

namespace simuli {

static void pack(Packed& p, FoundActors& v) { p.all(v, v.actors, v.standing, v.report); }
static void pack(Packed& p, SceneInit& v) { p.all(v, v.scene, v.unmet, v.report); }

void if_there_is_room(const std::function<void()>& make) {
  try {
    make();
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::kDevice) throw;
  }
}

void fill(const Device& device, const Log& log, const TrainingOptions& options, SceneFile& file) {
  if (!options.inpaint_behind_actors) return;
  const InpaintRecipe recipe{options.frames, options.init, options.train.render};
  if_there_is_room([&] { inpaint_behind_actors(device, log, recipe, file); });
}

std::string TrainingDrive::identity() const {
  TrainingOptions same = options;  // both decide only where a training ends
  same.train.iterations = 0;
  same.train.max_seconds = 0.0;
  const std::string fixer = options.fixer_command.empty() ? "" : "fixer=" + options.fixer_command + "\n";
  return fmt::format("log={} {}\n{}{}\n", log.name, log_hash, fixer, fmt::join(lines_of(same), "\n"));
}

Log TrainingDrive::with_learned_sensors(const Log& seen, const FrameSelection& frames) {
  return cache.get(
      report.start,
      "learn sensors",
      seen,
      seen,
      [&](const auto& read) { return simuli::with_learned_sensors(seen, read); },
      frames);
}

void TrainingDrive::find_moving(const Log& seen, const FrameSelection& frames) {
  if (!options.find_actors || !options.init.actors) return;
  FoundActors found = cache.get(
      report.start,
      "find what moves",
      seen,
      FoundActors{},
      [&](const auto&... read) { return find_actors(seen, read...); },
      frames,
      options.actors);
  for (const std::string& name : found.standing) {
    report.labels.push_back(
        fmt::format("label {}: its content is static while the box moves: left out", name));
    report.left_out.push_back(name);
  }
  CompletedActors completed = complete_actors(std::move(log.actors), found);
  log.actors = std::move(completed.actors);
  found.report.added = completed.added;
  found.report.continued = completed.continued;
  report.found += found.report;
}

SceneFile TrainingDrive::file_of(Scene scene) const {
  SceneFile file{std::move(scene), log.cameras, log.lidars, log.world_from_rig, frame_spans(log)};
  aim_color_grids(file);
  return file;
}

SingleRun::SingleRun(TrainingDrive& drive,
                     const Log& log,
                     TrainingOptions options,
                     std::string identity,
                     std::string name,
                     std::vector<RayDrop> ray_drop)
    : drive_(drive),
      log_(log),
      options_(std::move(options)),
      identity_(std::move(identity)),
      name_(std::move(name)),
      ray_drop_(std::move(ray_drop)) {}

void SingleRun::start(const Training::Progress& progress) {
  place_particles(progress);
  trainer_->need_one_state(identity_);
}

void SingleRun::place_particles(const Training::Progress& progress) {
  const auto tell = [&progress](std::size_t done, std::size_t total) {
    if (progress) progress("initialise", done, total);
  };
  SceneInit begin = drive_.cache.get(
      drive_.report.start,
      "initialise",
      log_,
      SceneInit{},
      [&](const auto&... read) { return initialize_scene(log_, read..., tell); },
      options_.frames,
      options_.init);
  drive_.report.init += begin.report;
  unmet_ = std::move(begin.unmet);
  if (!ray_drop_.empty()) begin.scene.ray_drop = ray_drop_;
  trainer_ = std::make_unique<Trainer>(drive_.device, log_, std::move(begin.scene), options_, drive_.ranks);
}

void SingleRun::resume(const std::filesystem::path& checkpoint,
                       const std::string& tail,
                       const Training::Progress& progress) {
  if (!tail.empty()) throw_input_error(checkpoint.string(), "stretch", tail, "a run without chunks");
  if (!trainer_) place_particles(progress);
  trainer_->resume(checkpoint, identity_);
  trainer_->need_one_state(identity_);
}

void SingleRun::save(const std::filesystem::path& checkpoint) {
  if (!trainer_) return;
  trainer_->need_one_state(identity_);
  if (drive_.ranks.is_first()) trainer_->save(checkpoint, identity_);
}

TrainReport SingleRun::run(const Training::Observer& on_step, const Checkpoints& checkpoints) {
  int saved = -1;  // iteration
  TrainReport report = trainer_->run([&](const TrainStatus& status) {
    if (on_step) on_step(status);
    if (checkpoints.every <= 0 || status.iteration % checkpoints.every != 0) return;
    save(checkpoints.file);
    saved = status.iteration;
  });
  if (checkpoints.every > 0 && saved != trainer_->status().iteration) save(checkpoints.file);
  if (checkpoints.every <= 0) trainer_->need_one_state(identity_);
  Judgement judgement = judge(report);
  for (const std::string& warning : judgement.warnings) report.warnings.push_back(name_ + warning);
  if (!judgement.failure.empty()) throw Error(ErrorKind::kNumeric, name_ + judgement.failure);
  return report;
}

SceneFile SingleRun::file() const {
  if (!trainer_) return drive_.file_of({});
  SceneFile file = drive_.file_of(trainer_->scene());
  if (unmet_.size() > 0) append(file.scene.lidar, unmet_, 0);
  for (LogLidar& lidar : file.lidars) lidar.model = trainer_->lidar(name_of(lidar.model));
  return file;
}

SceneFile SingleRun::take_file() {
  SceneFile taken = file();
  last_ = status();
  trainer_.reset();
  return taken;
}

}  // namespace simuli
