#pragma once
// Training runs: the whole drive in one run, or chunk by chunk.
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "io/log/log.hpp"
#include "io/scene/scene_folder.hpp"
#include "optim/train/ranks/ranks.hpp"
#include "optim/train/chunk/chunks.hpp"
#include "optim/train/initialization_cache.hpp"
#include "optim/train/trainer.hpp"
#include "optim/train/training.hpp"

namespace simuli {

/// Inputs common to all kinds of training runs.
struct TrainingDrive {
  Ranks& ranks;
  Device device;
  Log log;  // after prepare() with refined ego poses, learned LiDAR parameters and found actors
  std::string log_hash;  // of the log as read
  TrainingOptions options;
  TrainingReport report = {};
  InitializationCache cache = InitializationCache(options.cache_initialization);

  /// Returns the properties that identify a training, one line each.
  [[nodiscard]] std::string identity() const;
  /// Returns the log or a chunk of it with LiDAR parameters learned from its training sweeps.
  [[nodiscard]] Log with_learned_sensors(const Log& seen, const FrameSelection& frames);
  /// Adds the moving objects found in `seen` (the log or a chunk) to the log's actors.
  void find_moving(const Log& seen, const FrameSelection& frames);
  [[nodiscard]] SceneFile file_of(Scene scene) const;
};

/// The part of a training after preparation; functions as in Training.
class TrainingRun {
 public:
  virtual ~TrainingRun() = default;
  TrainingRun() = default;
  TrainingRun(const TrainingRun&) = delete;
  TrainingRun& operator=(const TrainingRun&) = delete;

  /// Initialises the particles and their colours.
  virtual void start(const Training::Progress& progress) = 0;
  /// Calls start() and continues from the checkpoint, whose settings are the drive's followed by `tail`.
  virtual void resume(const std::filesystem::path& checkpoint,
                      const std::string& tail,
                      const Training::Progress& progress) = 0;
  virtual void save(const std::filesystem::path& checkpoint) = 0;
  virtual TrainReport run(const Training::Observer& on_step, const Checkpoints& checkpoints) = 0;

  [[nodiscard]] virtual bool is_started() const = 0;
  [[nodiscard]] virtual const TrainStatus& status() const = 0;
  [[nodiscard]] virtual Scene scene() const = 0;
  /// Returns scene() with the learned sensors and everything that is merged into the trained scene.
  [[nodiscard]] virtual SceneFile file() const = 0;
  /// Returns the same and releases the training's device memory.
  [[nodiscard]] virtual SceneFile take_file() = 0;
  /// Whether file() already contains the result of fill().
  [[nodiscard]] virtual bool is_filled() const = 0;
};

/// Trains the particles of a whole log: the drive's or a chunk's.
class SingleRun final : public TrainingRun {
 public:
  /// `drive` and `log` (the drive's or a chunk's) must outlive this object. `identity`: lines that identify it.
  /// `name`: prefix of progress messages. `ray_drop`: known ray-drop functions; may be empty.
  SingleRun(TrainingDrive& drive,
                   const Log& log,
                   TrainingOptions options,
                   std::string identity,
                   std::string name = {},
                   std::vector<RayDrop> ray_drop = {});

  void start(const Training::Progress& progress) override;
  void resume(const std::filesystem::path& checkpoint,
              const std::string& tail,
              const Training::Progress& progress) override;
  void save(const std::filesystem::path& checkpoint) override;
  TrainReport run(const Training::Observer& on_step, const Checkpoints& checkpoints) override;
  [[nodiscard]] bool is_started() const override { return trainer_ || last_; }
  [[nodiscard]] const TrainStatus& status() const override { return trainer_ ? trainer_->status() : *last_; }
  [[nodiscard]] Scene scene() const override { return trainer_ ? trainer_->scene() : Scene{}; }
  [[nodiscard]] SceneFile file() const override;
  [[nodiscard]] SceneFile take_file() override;
  [[nodiscard]] bool is_filled() const override { return false; }

 private:
  void place_particles(const Training::Progress& progress);

  TrainingDrive& drive_;
  const Log& log_;
  TrainingOptions options_;
  std::string identity_, name_;
  std::vector<RayDrop> ray_drop_;
  GaussianSet unmet_;  // initial particles that are merged into the trained scene (SceneInit)
  std::unique_ptr<Trainer> trainer_;
  std::optional<TrainStatus> last_;  // status after the scene was taken
};

/// Makes a run for two or more `chunks` of `path`, the log's path.
[[nodiscard]] std::unique_ptr<TrainingRun> chunked_run(TrainingDrive& drive,
                                                                  std::unique_ptr<DrivenPath> path,
                                                                  std::vector<DriveChunk> chunks);

/// Runs `make`, ignoring a lack of device memory: the scene exists without its result.
void if_there_is_room(const std::function<void()>& make);
/// Inpaints disocclusions behind actors if the options ask for it and the device has memory.
void fill(const Device& device, const Log& log, const TrainingOptions& options, SceneFile& file);

}  // namespace simuli
