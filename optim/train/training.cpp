#include "optim/train/training.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/base/error.hpp"
#include "host/base/fields.hpp"
#include "host/base/version.hpp"
#include "host/runtime/cache/tuning.hpp"
#include "io/base/state_file.hpp"
#include "io/base/temporary.hpp"
#include "io/log/frame_files.hpp"
#include "optim/actors/complete_actors.hpp"
#include "optim/actors/find_actors.hpp"
#include "optim/fill/fill_behind.hpp"
#include "optim/init/initialize.hpp"
#include "optim/init/initialize_actors.hpp"
#include "optim/init/initialize_sets.hpp"
#include "optim/log/sensor_learning.hpp"
#include "optim/path/refined_path.hpp"
#include "optim/report/judgement.hpp"
#include "optim/stretch/stretch_parts.hpp"
#include "optim/support/record_support.hpp"
#include "optim/train/memory/memory.hpp"
#include "optim/train/memory/stretch_plan.hpp"
#include "optim/train/trainer.hpp"

namespace simuli {
static constexpr double kSight_m = 100.0;  // that LiDARs and pictures tell the distance of, about

/// What a device may have no room for beside the training: the scene is there all the same.
template <class F>
static void if_there_is_room(F&& make) {
  try {
    make();
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::kDevice) throw;
  }
}

static void fill(const Device& device, const Log& log, const TrainingOptions& options, SceneFile& file) {
  if (!options.fill.fill) return;
  const FillRecipe recipe{options.frames, options.init, options.train.render};
  if_there_is_room([&] { fill_behind_actors(device, log, recipe, file); });
}

/// What a training has made. Of a drive that is cut: the stretch that is being trained, and those that have
/// been.
struct Training::State {
  std::optional<DrivenPath> path;
  std::vector<Stretch> stretches{1};
  std::vector<int> ends;  // iterations of all stretches together behind each
  StretchParting parting(const TrainingOptions& options) const {
    return {*path, stretches, options.stretches.overlap_m};
  }

  std::size_t current = 0;
  Log log;  // of the current stretch
  std::unique_ptr<Trainer> trainer;
  GaussianSet unmet;  // joins what that has trained (SceneInit)
  StretchParts done;
  MeanRayDrop ray_drop;  // of those
  std::optional<Scene> merged;
  TrainStatus status;  // of all stretches together

  [[nodiscard]] bool is_cut() const { return stretches.size() > 1; }
  [[nodiscard]] int begun() const { return current == 0 ? 0 : ends[current - 1]; }
  [[nodiscard]] TrainStatus of_all(TrainStatus own) const {
    own.iteration += begun();
    own.planned = ends.back();
    return own;
  }
};

Training::Training(const Device& device, Log log, const TrainingOptions& options, Ranks& ranks)
    : ranks_(ranks),
      device_(device),
      log_(std::move(log)),
      log_hash_(simuli::log_hash(log_)),
      options_(checked(options)) {
  need_shards(ranks, options_);
  need_uncut(options_);
  // Ranks may be of one machine.
  if (!log_.files) log_.files = std::make_shared<FrameFiles>(frame_budget(options_) / ranks.size());
}

void Training::need_shards(const Ranks& ranks, const TrainingOptions& options) {
  const auto shards = static_cast<std::size_t>(options.train.shards.count);
  constexpr const char* kAllowed = "ranks: found {}, allowed up to {}, the frames of a step (shards)";
  if (ranks.size() > shards) throw Error(ErrorKind::kUsage, fmt::format(kAllowed, ranks.size(), shards));
}

Training::~Training() = default;

const Training::State& Training::prepared() const {
  if (state_ && (state_->trainer || state_->merged)) return *state_;
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

std::string Training::own_identity() const {
  if (!state_->is_cut()) return identity();
  return identity() + stretch_lines(options_.train.iterations, state_->current, state_->stretches.size());
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
  prepare_log(progress);
  start(progress);
}

void Training::prepare_log(const Progress& progress) {
  need_same(ranks_, rank_fields());
  auto state = std::make_unique<State>();
  RefinedLog refined = with_refined_path(std::move(log_), options_.path, progress);
  log_ = std::move(refined.log);
  report_.path = std::move(refined.report);
  StretchOptions stretches = options_.stretches;
  if (stretches.length_m > 0.0 || plans_stretches(options_)) state->path.emplace(log_);
  if (plans_stretches(options_)) {
    report_.stretches = plan_stretches(device_, log_, options_, *state->path);
    if (report_.stretches.count > 1) stretches.length_m = report_.stretches.length_m;
  }
  if (stretches.length_m > 0.0) state->stretches = cut(*state->path, stretches);
  if (state->is_cut()) {
    state_ = std::move(state);
    prepare_stretches();
    return;
  }
  log_ = with_learned_sensors(std::move(log_), options_.frames, options_.sensors);
  find_moving(log_, options_.frames);
  state_ = std::move(state);
}

/// What moves in `seen`, all of the drive or a stretch, becomes the drive's.
void Training::find_moving(const Log& seen, const FrameSelection& frames) {
  if (!options_.actors.find || !options_.init.actors) return;
  FoundActors found = find_actors(seen, frames, options_.actors);
  CompletedActors completed = complete_actors(std::move(log_.actors), found.actors);
  log_.actors = std::move(completed.actors);
  found.report.added = completed.added;
  found.report.continued = completed.continued;
  report_.found += found.report;
}

/// What all stretches must know alike, from one stretch at a time: LiDARs as the first shows them, and what
/// moves, each found thing going on where the stretch before has lost it.
void Training::prepare_stretches() {
  State& state = *state_;
  const auto part = [&](const Stretch& stretch) {
    return log_of(log_, options_.frames, *state.path, stretch, options_.stretches);
  };
  const FrameSelection all = nothing_held_out(options_.frames);
  log_.lidars = with_learned_sensors(part(state.stretches.front()), all, options_.sensors).lidars;
  std::vector<std::size_t> frames;
  for (const Stretch& stretch : state.stretches) {
    const Log own = part(stretch);
    frames.push_back(own.images.empty() ? own.sweeps.size() : own.images.size());
    find_moving(own, all);
  }
  if (options_.init.actors) log_.actors = moving_actors(log_.actors, options_.init.actor_min_travel_m);
  state.ends = ends_of(options_.train.iterations, frames);
}

/// Of the current stretch: none of its frames is held out, and what sensors are is known from the first.
TrainingOptions Training::own_options() const {
  TrainingOptions own = options_;
  const State& state = *state_;
  if (!state.is_cut()) return own;
  const int iterations = state.ends[state.current] - state.begun();
  own.frames = nothing_held_out(options_.frames);
  own.init.actor_min_travel_m = 0.0;
  if (own.init.shell_distance_m == 0.0)
    own.init.shell_distance_m = shell_distance_m(state.path->farthest_m() + kSight_m);
  own.train.max_seconds *= static_cast<double>(iterations) / std::max(state.ends.back(), 1);
  own.train.iterations = iterations;
  // Each stretch moves what all before it have come to, the less the more these are.
  own.train.ray_drop.rate /= static_cast<double>(state.current + 1);
  if (state.current > 0) own.train.prune.row_ranges = false;
  return own;
}

void Training::start(const Progress& progress) {
  State& state = *state_;
  const TrainingOptions own = own_options();
  if (state.is_cut())
    state.log =
        log_of(log_, options_.frames, *state.path, state.stretches[state.current], options_.stretches);
  const Log& log = state.is_cut() ? state.log : log_;
  SceneInit begin = initialize_scene(log, own.frames, own.init, progress);
  report_.init += begin.report;
  state.unmet = std::move(begin.unmet);
  if (state.current > 0) begin.scene.ray_drop = state.ray_drop.mean();
  state.trainer = std::make_unique<Trainer>(device_, log, std::move(begin.scene), own, ranks_);
  state.trainer->need_one_state(own_identity());
  if (state.is_cut()) state.status = state.of_all(state.trainer->status());
}

void Training::resume(const std::filesystem::path& checkpoint, const Progress& progress) {
  const std::string tail = stretch_lines(checkpoint);
  Trainer::need_settings(checkpoint, identity() + tail, options_.train);
  if (!state_) prepare_log(progress);
  State& state = *state_;
  bool goes_on = true;
  if (state.is_cut() || !tail.empty()) {
    while (state.current < state.stretches.size() && own_identity() != identity() + tail) {
      const std::filesystem::path file = stretch_file(checkpoint, state.current);
      end_stretch(read_stretch(file, own_identity(), log_), file);
    }
    goes_on = state.current < state.stretches.size();
    if (!goes_on) {
      throw_input_error(
          checkpoint.string(), "stretch", tail, fmt::format("one of {}", state.stretches.size()));
    }
    if (const std::filesystem::path file = stretch_file(checkpoint, state.current);
        std::filesystem::exists(file)) {
      end_stretch(read_stretch(file, own_identity(), log_), file);
      goes_on = false;
    }
  }
  if (!state.merged) start(progress);
  if (goes_on) state.trainer->resume(checkpoint, own_identity());
  if (state.trainer) {
    state.trainer->need_one_state(own_identity());
    if (state.is_cut()) state.status = state.of_all(state.trainer->status());
  }
}

void Training::save(const std::filesystem::path& checkpoint) {
  if (!prepared().trainer) return;
  state_->trainer->need_one_state(own_identity());
  if (ranks_.is_first()) state_->trainer->save(checkpoint, own_identity());
}

TrainReport Training::run_one(const Observer& on_step, const Checkpoints& checkpoints) {
  State& state = *state_;
  int saved = -1;  // iteration
  TrainReport report = state.trainer->run([&](const TrainStatus& status) {
    if (state.is_cut()) state.status = state.of_all(status);
    if (on_step) on_step(this->status());
    if (checkpoints.every <= 0 || status.iteration % checkpoints.every != 0) return;
    save(checkpoints.file);
    saved = status.iteration;
  });
  if (checkpoints.every > 0 && saved != state.trainer->status().iteration) save(checkpoints.file);
  if (checkpoints.every <= 0) state.trainer->need_one_state(own_identity());
  Judgement judgement = judge(report);
  const std::string where =
      state.is_cut() ? fmt::format("stretch {} of {}: ", state.current + 1, state.stretches.size()) : "";
  for (const std::string& warning : judgement.warnings) report.warnings.push_back(where + warning);
  if (!judgement.failure.empty()) throw Error(ErrorKind::kNumeric, where + judgement.failure);
  return report;
}

const TrainingReport& Training::run(const Observer& on_step, const Checkpoints& checkpoints) {
  prepare();
  State& state = *state_;
  if (!state.is_cut()) {
    report_.train = run_one(on_step, checkpoints);
    return report_;
  }
  while (!state.merged) {
    if (!state.trainer) start({});
    std::filesystem::path own_file;
    if (!checkpoints.file.empty() && ranks_.is_first()) {  // what may be there is of another training
      own_file = stretch_file(checkpoints.file, state.current);
      remove_stale_temporaries(own_file);
      std::error_code absent;
      std::filesystem::remove(own_file, absent);
    }
    TrainReport report = run_one(on_step, checkpoints);
    SceneFile own = with_sensors(state.trainer->scene());
    state.trainer.reset();  // the device has room for what comes
    fill(device_, state.log, own_options(), own);
    StretchScene part{
        owned(std::move(own.scene), state.parting(options_), state.current), std::move(own.lidars), report};
    if (!own_file.empty()) write_stretch(own_file, own_identity(), part);
    end_stretch(std::move(part), own_file);
  }
  return report_;
}

void Training::end_stretch(StretchScene part, const std::filesystem::path& file) {
  State& state = *state_;
  state.log = {};
  if (state.current == 0) log_.lidars = part.lidars;
  const double share =
      static_cast<double>(state.ends[state.current] - state.begun()) / std::max(state.ends.back(), 1);
  add_stretch(report_.train, part.report, share);
  state.ray_drop.add(part);
  if (file.empty()) {
    state.done.keep(std::move(part));
  } else {
    part = {};
    state.done.keep(file, own_identity());
  }
  ++state.current;
  if (state.current < state.stretches.size()) return;
  const auto read = [&](std::size_t i) -> const StretchScene& { return state.done.part(i, log_); };
  state.merged = merged(state.done.count(), read, log_.actors, state.parting(options_));
  state.merged->camera_filter_px2 = camera_filter_px2(options_.train.render);
  state.done = {};
  TrainReport& all = report_.train;
  const HeldOutRule rule(log_, options_.frames);
  all.images = rule.training(log_.images).size();
  all.sweeps = rule.training(log_.sweeps).size();
  all.camera_particles = state.merged->camera.size();
  all.lidar_particles = state.merged->lidar.size();
  all.last.iteration = all.last.planned = state.ends.back();
  all.last.camera_particles = static_cast<std::uint32_t>(all.camera_particles);
  all.last.lidar_particles = static_cast<std::uint32_t>(all.lidar_particles);
  state.status = all.last;
}

const TrainStatus& Training::status() const {
  const State& state = prepared();
  return state.trainer && !state.is_cut() ? state.trainer->status() : state.status;
}

Scene Training::scene() const { return prepared().merged ? *state_->merged : state_->trainer->scene(); }

SceneFile Training::result() const& { return completed(with_sensors(scene())); }

SceneFile Training::result() && {
  static_cast<void>(prepared());
  SceneFile file = with_sensors(state_->merged ? std::move(*state_->merged) : state_->trainer->scene());
  state_->status = status();
  state_->trainer.reset();  // the device has room for what comes
  state_->merged.emplace();
  return completed(std::move(file));
}

SceneFile Training::with_sensors(Scene scene) const {
  SceneFile file{std::move(scene), log_.cameras, log_.lidars, log_.world_from_rig, frame_spans(log_)};
  if (const Trainer* const trainer = prepared().trainer.get()) {
    if (prepared().unmet.size() > 0) append(file.scene.lidar, prepared().unmet, 0);
    for (LogLidar& lidar : file.lidars) lidar.model = trainer->lidar(name_of(lidar.model));
  }
  return file;
}

SceneFile Training::completed(SceneFile file) const {
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
  if (!prepared().is_cut()) fill(device_, log_, options_, file);
  if_there_is_room(
      [&] { file.support = record_support(device_, log_, file, options_.frames, options_.train.render); });
  return file;
}

}  // namespace simuli
