// Training of a drive in chunks, one after the other, and merging them into one scene.
#include <algorithm>
#include <fmt/format.h>
#include <optional>
#include <utility>

#include "host/core/base/error.hpp"
#include "io/base/temporary.hpp"
#include "optim/init/initialize.hpp"
#include "optim/init/initialize_actors.hpp"
#include "optim/train/chunk/chunk_parts.hpp"
#include "optim/train/training_run.hpp"

namespace simuli {
namespace {

constexpr double kSight_m = 100.0;  // approximate distance up to which LiDARs and pictures determine depth

class ChunkedRun final : public TrainingRun {
 public:
  ChunkedRun(TrainingDrive& drive, std::unique_ptr<DrivenPath> path, std::vector<DriveChunk> chunks);

  void start(const Training::Progress& progress) override;
  void resume(const std::filesystem::path& checkpoint,
              const std::string& tail,
              const Training::Progress& progress) override;
  void save(const std::filesystem::path& checkpoint) override {
    if (piece_) piece_->save(checkpoint);
  }
  TrainReport run(const Training::Observer& on_step, const Checkpoints& checkpoints) override;

  [[nodiscard]] bool is_started() const override { return piece_ || merged_; }
  [[nodiscard]] const TrainStatus& status() const override { return status_; }
  [[nodiscard]] Scene scene() const override { return merged_ ? *merged_ : piece_->scene(); }
  [[nodiscard]] SceneFile file() const override {
    return merged_ ? drive_.file_of(*merged_) : piece_->file();
  }
  [[nodiscard]] SceneFile take_file() override {
    SceneFile taken = merged_ ? drive_.file_of(std::move(*merged_)) : piece_->file();
    piece_.reset();  // frees device memory for the next chunk
    merged_.emplace();
    return taken;
  }
  [[nodiscard]] bool is_filled() const override { return true; }

 private:
  [[nodiscard]] Log log_of_chunk(std::size_t index) const {
    return log_of(drive_.log, drive_.options.frames, *path_, chunks_[index], drive_.options.chunks);
  }
  [[nodiscard]] ChunkSplit parting() const { return {*path_, chunks_, drive_.options.chunks.overlap_m}; }
  [[nodiscard]] int begun() const { return current_ == 0 ? 0 : ends_[current_ - 1]; }
  /// Identity lines of the current chunk.
  [[nodiscard]] std::string identity() const {
    return drive_.identity() + chunk_lines(drive_.options.train.iterations, current_, chunks_.size());
  }
  [[nodiscard]] TrainingOptions options() const;
  /// Selects the frames of the current chunk, without particles yet.
  void take_chunk();
  void set_status(TrainStatus own);
  /// Ends a chunk. `file`: where it is stored; empty: in memory.
  void end_chunk(ChunkScene part, const std::filesystem::path& file);
  void read_done(const std::filesystem::path& file) { end_chunk(read_chunk(file, identity()), file); }
  void merge();

  TrainingDrive& drive_;
  std::unique_ptr<DrivenPath> path_;
  std::vector<DriveChunk> chunks_;
  std::vector<int> ends_;  // iterations of all chunks up to the end of each
  std::size_t current_ = 0;
  Log log_;                         // of the current chunk
  std::optional<SingleRun> piece_;  // run of the current chunk
  ChunkParts done_;
  MeanRayDrop ray_drop_;  // of the finished chunks
  std::optional<Scene> merged_;
  TrainReport report_;
  TrainStatus status_;  // of all chunks together
};

/// Parameters common to all chunks are determined chunk by chunk: LiDARs from the first, and moving objects
/// continued from the chunk before.
ChunkedRun::ChunkedRun(TrainingDrive& drive, std::unique_ptr<DrivenPath> path, std::vector<DriveChunk> chunks)
    : drive_(drive), path_(std::move(path)), chunks_(std::move(chunks)) {
  const TrainingOptions& o = drive.options;
  const FrameSelection all = nothing_held_out(o.frames);
  if (o.learn_sensors) drive.log.lidars = drive.with_learned_sensors(log_of_chunk(0), all).lidars;
  std::vector<std::size_t> frames;
  for (std::size_t i = 0; i < chunks_.size(); ++i) {
    const Log own = log_of_chunk(i);
    frames.push_back(own.images.empty() ? own.sweeps.size() : own.images.size());
    drive.find_moving(own, all);
  }
  if (o.init.actors) drive.log.actors = moving_actors(drive.log.actors, o.init.actor_min_travel_m);
  ends_ = ends_of(o.train.iterations, frames);
}

/// Returns the options of the current chunk: no frame is held out, and sensors are known from the first chunk.
TrainingOptions ChunkedRun::options() const {
  TrainingOptions own = drive_.options;
  own.train.appearance.color_grids = ColorGridsOf::kNone;  // chunks would differ in colour
  const int iterations = ends_[current_] - begun();
  own.frames = nothing_held_out(own.frames);
  own.init.actor_min_travel_m = 0.0;
  if (own.init.shell_distance_m == 0.0)
    own.init.shell_distance_m = shell_distance_m(path_->farthest_m() + kSight_m);
  own.train.max_seconds *= static_cast<double>(iterations) / std::max(ends_.back(), 1);
  own.train.iterations = iterations;
  // Each chunk moves the mean of the ray-drop functions less, the more chunks preceded it.
  own.train.ray_drop.rate /= static_cast<double>(current_ + 1);
  if (current_ > 0) own.train.prune.row_ranges = false;
  return own;
}

void ChunkedRun::set_status(TrainStatus own) {
  status_ = own;
  status_.iteration += begun();
  status_.planned = ends_.back();
}

void ChunkedRun::take_chunk() {
  log_ = log_of_chunk(current_);
  piece_.emplace(drive_,
                 log_,
                 options(),
                 identity(),
                 fmt::format("chunk {} of {}: ", current_ + 1, chunks_.size()),
                 current_ > 0 ? ray_drop_.mean() : std::vector<RayDrop>{});
}

void ChunkedRun::start(const Training::Progress& progress) {
  take_chunk();
  piece_->start(progress);
  set_status(piece_->status());
}

void ChunkedRun::resume(const std::filesystem::path& checkpoint,
                        const std::string& tail,
                        const Training::Progress& progress) {
  while (current_ < chunks_.size() && identity() != drive_.identity() + tail) {
    read_done(chunk_file(checkpoint, current_));
  }
  if (current_ == chunks_.size()) {
    throw_input_error(checkpoint.string(), "stretch", tail, fmt::format("one of {}", chunks_.size()));
  }
  const std::filesystem::path file = chunk_file(checkpoint, current_);
  const bool is_done = std::filesystem::exists(file);
  if (is_done) read_done(file);
  if (merged_) return;
  if (is_done) return start(progress);
  take_chunk();
  piece_->resume(checkpoint, {}, progress);
  set_status(piece_->status());
}

TrainReport ChunkedRun::run(const Training::Observer& on_step, const Checkpoints& checkpoints) {
  while (!merged_) {
    if (!piece_) start({});
    std::filesystem::path file;
    if (!checkpoints.file.empty() && drive_.ranks.is_first()) {  // a file there may be of another training
      file = chunk_file(checkpoints.file, current_);
      remove_stale_temporaries(file);
      std::error_code absent;
      std::filesystem::remove(file, absent);
    }
    const TrainReport report = piece_->run(
        [&](const TrainStatus& own) {
          set_status(own);
          if (on_step) on_step(status_);
        },
        checkpoints);
    SceneFile own = piece_->file();
    piece_.reset();  // frees device memory for the next chunk
    fill(drive_.device, log_, options(), own);
    ChunkScene part{owned(std::move(own.scene), parting(), current_), std::move(own.lidars), report};
    if (!file.empty()) write_chunk(file, identity(), part);
    end_chunk(std::move(part), file);
  }
  return report_;
}

void ChunkedRun::end_chunk(ChunkScene part, const std::filesystem::path& file) {
  log_ = {};
  if (current_ == 0) drive_.log.lidars = part.lidars;
  const double share = static_cast<double>(ends_[current_] - begun()) / std::max(ends_.back(), 1);
  add_chunk(report_, part.report, share);
  ray_drop_.add(part);
  if (file.empty()) {
    done_.keep(std::move(part));
  } else {
    part = {};
    done_.keep(file, identity());
  }
  ++current_;
  if (current_ == chunks_.size()) merge();
}

void ChunkedRun::merge() {
  const auto read = [&](std::size_t i) -> const ChunkScene& { return done_.part(i); };
  merged_ = merged(done_.count(), read, drive_.log.actors, parting());
  merged_->camera_filter_px2 = camera_filter_px2(drive_.options.train.render);
  done_ = {};
  const HeldOutRule rule(drive_.log, drive_.options.frames);
  report_.images = rule.training(drive_.log.images).size();
  report_.sweeps = rule.training(drive_.log.sweeps).size();
  report_.camera_particles = merged_->camera.size();
  report_.lidar_particles = merged_->lidar.size();
  report_.last.iteration = report_.last.planned = ends_.back();
  report_.last.camera_particles = static_cast<std::uint32_t>(report_.camera_particles);
  report_.last.lidar_particles = static_cast<std::uint32_t>(report_.lidar_particles);
  status_ = report_.last;
}

}  // namespace

std::unique_ptr<TrainingRun> chunked_run(TrainingDrive& drive,
                                         std::unique_ptr<DrivenPath> path,
                                         std::vector<DriveChunk> chunks) {
  return std::make_unique<ChunkedRun>(drive, std::move(path), std::move(chunks));
}

}  // namespace simuli
