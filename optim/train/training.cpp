#include "optim/train/training.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <string>
#include <utility>
#include <vector>

#include "host/core/base/error.hpp"
#include "host/core/base/fields.hpp"
#include "host/core/base/version.hpp"
#include "io/log/frame_files.hpp"
#include "io/log/sanitized_labels.hpp"
#include "optim/complete/record_support.hpp"
#include "optim/data/refined_path.hpp"
#include "optim/train/chunk/chunk_parts.hpp"
#include "optim/train/chunk_plan.hpp"
#include "optim/train/memory.hpp"
#include "optim/train/training_run.hpp"

namespace simuli {

static void pack(Packed& p, PathReport& v) {
  auto& [a, b, c, d, e, f, g, h, i] = v;
  p(a, b, c, d, e, f, g, h, i);
}
static void pack(Packed& p, RefinedLog& v) { p(v.log, v.report); }

struct Training::State {
  TrainingDrive drive;
  std::unique_ptr<TrainingRun> training_run;  // set by prepare()

  void choose_run(const Progress& progress);
  [[nodiscard]] TrainingRun& started() const {
    if (training_run && training_run->is_started()) return *training_run;
    throw Error(ErrorKind::kInternal, "training: found no start, allowed prepare() first");
  }
  [[nodiscard]] std::vector<RankField> rank_fields() const;
  [[nodiscard]] SceneFile completed(SceneFile file) const;
};

Training::Training(const Device& device, Log log, const TrainingOptions& options, Ranks& ranks) {
  const std::string hash = log_hash(log);
  state_ = std::make_unique<State>(State{{ranks, device, std::move(log), hash, checked(options)}, nullptr});
  TrainingDrive& drive = state_->drive;
  need_shards(ranks, drive.options);
  need_uncut(drive.options);
  // Ranks may share one machine.
  if (!drive.log.files)
    drive.log.files = std::make_shared<FrameFiles>(frame_budget(drive.options) / ranks.size());
}

void Training::need_shards(const Ranks& ranks, const TrainingOptions& options) {
  const auto shards = static_cast<std::size_t>(options.train.shards.count);
  constexpr const char* kAllowed = "ranks: found {}, allowed up to {}, the frames of a step (shards)";
  if (ranks.size() > shards) throw Error(ErrorKind::kUsage, fmt::format(kAllowed, ranks.size(), shards));
}

Training::~Training() = default;

const TrainingReport& Training::report() const { return state_->drive.report; }
const TrainingOptions& Training::options() const { return state_->drive.options; }

/// Returns the properties that must be equal on all ranks for equal bits.
std::vector<RankField> Training::State::rank_fields() const {
  const DeviceInfo& device = drive.device.info();
  std::vector<RankField> fields = {{"device", device.label()},
                                   {"device version", device.device_version},
                                   {"driver", device.driver_version},
                                   {"compute units", fmt::format("{}", device.compute_units)},
                                   {"log", fmt::format("{} {}", drive.log.name, drive.log_hash)},
                                   {"fixer", drive.options.fixer_command}};
  for (const std::string& line : lines_of(drive.options)) {
    const std::size_t equals = line.find('=');
    fields.push_back({line.substr(0, equals), line.substr(equals + 1)});
  }
  return fields;
}

/// Refines the ego poses of the drive, and decides whether to cut it into chunks.
void Training::State::choose_run(const Progress& progress) {
  if (training_run) return;
  need_same(drive.ranks, rank_fields());
  drive.report.labels = sanitize_labels(drive.log);
  if (drive.options.refine_path) {
    RefinedLog refined =
        drive.cache.get(drive.report.start, "refine path", drive.log, RefinedLog{drive.log, {}}, [&] {
          return with_refined_path(drive.log, progress);
        });
    drive.log = std::move(refined.log);
    drive.report.path = std::move(refined.report);
  }
  ChunkOptions options = drive.options.chunks;
  const bool plans = plans_chunks(drive.options);
  if (options.length_m > 0.0 || plans) {
    auto path = std::make_unique<DrivenPath>(drive.log);
    if (plans) {
      drive.report.chunks = plan_chunks(drive.device, drive.log, drive.options, *path);
      if (drive.report.chunks.count > 1) options.length_m = drive.report.chunks.length_m;
    }
    std::vector<DriveChunk> chunks = cut(*path, options);
    if (chunks.size() > 1) training_run = chunked_run(drive, std::move(path), std::move(chunks));
  }
  if (training_run) return;
  const TrainingOptions& o = drive.options;
  const auto tell = [&progress](const char* stage, std::size_t done) {
    if (progress) progress(stage, done, 1);
  };
  if (o.learn_sensors) {
    tell("learn sensors", 0);
    drive.log = drive.with_learned_sensors(drive.log, o.frames);
  }
  tell("find what moves", 0);
  drive.find_moving(drive.log, o.frames);
  training_run = std::make_unique<SingleRun>(drive, drive.log, o, drive.identity());
}

void Training::prepare(const Progress& progress) {
  if (state_->training_run) return;
  state_->choose_run(progress);
  state_->training_run->start(progress);
}

void Training::resume(const std::filesystem::path& checkpoint, const Progress& progress) {
  const std::string tail = chunk_lines(checkpoint);
  Trainer::need_settings(checkpoint, state_->drive.identity() + tail, state_->drive.options.train);
  state_->choose_run(progress);
  state_->training_run->resume(checkpoint, tail, progress);
}

void Training::save(const std::filesystem::path& checkpoint) { state_->started().save(checkpoint); }

const TrainingReport& Training::run(const Observer& on_step, const Checkpoints& checkpoints) {
  prepare();
  state_->drive.report.train = state_->started().run(on_step, checkpoints);
  const FrameSelection& frames = state_->drive.options.frames;
  std::vector<std::string>& warnings = state_->drive.report.train.warnings;
  const std::vector<std::string>& labels = state_->drive.report.labels;
  warnings.insert(warnings.end(), labels.begin(), labels.end());
  const std::vector<std::string>& damaged = state_->drive.report.start.damaged;
  warnings.insert(warnings.end(), damaged.begin(), damaged.end());
  for (const SensorUse& use : sensor_uses(state_->drive.log, HeldOutRule(state_->drive.log, frames))) {
    const auto& requested = frames.held_out_sensors;
    if (use.training > 0 || std::find(requested.begin(), requested.end(), use.sensor) != requested.end())
      continue;
    warnings.push_back(fmt::format("no frame of {} was trained on ({} held out)", use.sensor, use.held_out));
  }
  return report();
}

const TrainStatus& Training::status() const { return state_->started().status(); }
Scene Training::scene() const { return state_->started().scene(); }
SceneFile Training::result() const& { return state_->completed(state_->started().file()); }
SceneFile Training::result() && { return state_->completed(state_->started().take_file()); }

SceneFile Training::State::completed(SceneFile file) const {
  const TrainingOptions& o = drive.options;
  file.training = TrainingRecord{.log_name = drive.log.name,
                                 .log_hash = drive.log_hash,
                                 .frames = o.frames,
                                 .sensors = sensor_uses(drive.log, HeldOutRule(drive.log, o.frames)),
                                 .labels_left_out = drive.report.left_out,
                                 .iterations = training_run->status().iteration,
                                 .planned_iterations = training_run->status().planned,
                                 .quality = quality_of(o.train.render),
                                 .settings = lines_of(o),
                                 .version = version(),
                                 .device = drive.device.info().label(),
                                 .driver = drive.device.info().driver_version};
  if (!training_run->is_filled()) fill(drive.device, drive.log, o, file);
  if_there_is_room(
      [&] { file.support = record_support(drive.device, drive.log, file, o.frames, o.train.render); });
  return file;
}

}  // namespace simuli
