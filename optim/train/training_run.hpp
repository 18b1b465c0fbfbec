#pragma once
// How the log of a training becomes a scene: the drive in one piece, or one chunk of it after the other.
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

/// What a training is of, whichever training_run it takes.
struct TrainingDrive {
  Ranks& ranks;
  Device device;
  Log log;  // from prepare() on on its refined path, with what was learned of its LiDARs, and with found
            // actors
  std::string log_hash;  // as read
  TrainingOptions options;
  TrainingReport report = {};
  InitializationCache cache = InitializationCache(options.cache_initialization);

  /// All that must be the same for it to be the same training, a line each.
  [[nodiscard]] std::string identity() const;
  /// The log or a chunk of it with what its training sweeps say of its LiDARs.
  [[nodiscard]] Log with_learned_sensors(const Log& seen, const FrameSelection& frames);
  /// What moves in `seen`, all of the log or a chunk, becomes the log's.
  void find_moving(const Log& seen, const FrameSelection& frames);
  [[nodiscard]] SceneFile file_of(Scene scene) const;
};

/// What Training asks for from the first particles on: its functions of these names.
class TrainingRun {
 public:
  virtual ~TrainingRun() = default;
  TrainingRun() = default;
  TrainingRun(const TrainingRun&) = delete;
  TrainingRun& operator=(const TrainingRun&) = delete;

  /// Places the first particles and gives them their colours.
  virtual void start(const Training::Progress& progress) = 0;
  /// start(), and then goes on from the checkpoint, whose settings are the drive's and `tail` behind them.
  virtual void resume(const std::filesystem::path& checkpoint,
                      const std::string& tail,
                      const Training::Progress& progress) = 0;
  virtual void save(const std::filesystem::path& checkpoint) = 0;
  virtual TrainReport run(const Training::Observer& on_step, const Checkpoints& checkpoints) = 0;

  [[nodiscard]] virtual bool is_started() const = 0;
  [[nodiscard]] virtual const TrainStatus& status() const = 0;
  [[nodiscard]] virtual Scene scene() const = 0;
  /// scene() with the drive's sensors as they were learned, and all that joins what was trained.
  [[nodiscard]] virtual SceneFile file() const = 0;
  /// The same, and there is nothing to train any more: the device has room.
  [[nodiscard]] virtual SceneFile take_file() = 0;
  /// Whether file() has what fill() adds.
  [[nodiscard]] virtual bool is_filled() const = 0;
};

/// Trains the particles of a log all at once: the drive's, or a chunk's.
class SingleRun final : public TrainingRun {
 public:
  /// `drive` and `log`, the drive's or a chunk's, must outlive it. `identity`: of what it trains. `name`:
  /// stands in front of what is said of it. `ray_drop`: what is known of the LiDARs' drops; empty: nothing.
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
  GaussianSet unmet_;  // joins what has been trained (SceneInit)
  std::unique_ptr<Trainer> trainer_;
  std::optional<TrainStatus> last_;  // when its scene has been taken
};

/// `chunks`: two or more, of `path`, which is the log's.
[[nodiscard]] std::unique_ptr<TrainingRun> chunked_run(TrainingDrive& drive,
                                                                  std::unique_ptr<DrivenPath> path,
                                                                  std::vector<DriveChunk> chunks);

/// What a device may have no room for beside the training: the scene is there all the same.
void if_there_is_room(const std::function<void()>& make);
/// Fills what nobody has seen behind actors, where the options say so and there is room.
void fill(const Device& device, const Log& log, const TrainingOptions& options, SceneFile& file);

}  // namespace simuli
