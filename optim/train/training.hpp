#pragma once
// Trains a scene from a log: the complete recipe of `simuli train`. The same options give the same bits on the
// same device and build.
#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "host/device/runtime/device.hpp"
#include "io/log/log.hpp"
#include "io/scene/scene_folder.hpp"
#include "optim/actors/finding_options.hpp"
#include "optim/data/path_report.hpp"
#include "optim/init/init_options.hpp"
#include "optim/train/ranks/ranks.hpp"
#include "optim/train/train_report.hpp"
#include "optim/train/training_options.hpp"

namespace simuli {

/// Report of a training: initialisation and optimisation.
struct TrainingReport {
  InitializationReport start;
  ChunkPlan chunks;
  PathReport path;
  FindReport found;  // zeros: not searched
  std::vector<std::string>
      labels;  // one line per sanitised label (sanitized_labels.hpp); repeated as warnings
  std::vector<std::string> left_out;  // names of labels that were left out
  InitReport init;
  TrainReport train;
};

/// Where and how often a training is saved.
struct Checkpoints {
  std::filesystem::path file;
  int every = 0;  // iterations; 0: never
};

///   Training training(Device::best(), read_log("drive.log"));
///   training.run();
///   write_scene("drive.scene", training.result());
class Training {
 public:
  /// Reports the progress of a stage: `done` of `total`, never decreasing.
  using Progress = std::function<void(const std::string& stage, std::size_t done, std::size_t total)>;
  using Observer = std::function<void(const TrainStatus&)>;

  /// `log` as it was read. Throws Error{kUsage} for options outside their range, or more ranks than shards.
  /// `ranks` share the shards and must outlive this object; each rank has a training with the same device, log
  /// and options and makes the same calls. All produce the same scene.
  Training(const Device& device, Log log, const TrainingOptions& options = {}, Ranks& ranks = one_rank());
  /// Throws Error{kUsage} when there are more ranks than shards.
  static void need_shards(const Ranks& ranks, const TrainingOptions& options);
  ~Training();
  Training(const Training&) = delete;
  Training& operator=(const Training&) = delete;

  /// Sanitises labels (sanitized_labels.hpp), refines ego poses (refined_path.hpp), learns LiDAR parameters
  /// from sweeps, finds unlabelled moving objects (find_actors.hpp, complete_actors.hpp), and initialises the
  /// particles, unless already done. Throws Error{kInput} when no training frame is left or a file cannot be
  /// read, Error{kDevice} when the device lacks memory, RanksDiffer when a rank has another device, other
  /// settings or another log.
  void prepare(const Progress& progress = {});
  /// Calls prepare() and continues a saved training of the same log and settings. The number of iterations may
  /// be larger than before: the remaining iterations follow the longer schedule, so the result is well defined
  /// but differs from a training that had this length from the start. Throws Error{kInput}, before any
  /// preparation, when the file is no checkpoint or belongs to another training.
  void resume(const std::filesystem::path& checkpoint, const Progress& progress = {});
  /// Saves the training state, by rank 0 for all. Atomic. Throws RanksDiffer, and saves nothing, when the ranks
  /// have different bits.
  void save(const std::filesystem::path& checkpoint);
  /// Calls prepare() and runs the remaining iterations, or as many as an automatic length needs
  /// (train.length.automatic). Calls `on_step` after each iteration, then saves due checkpoints, also at the
  /// end. Throws Error{kNumeric} when training has diverged; other doubts are in TrainReport::warnings
  /// (judgement.hpp).
  const TrainingReport& run(const Observer& on_step = {}, const Checkpoints& checkpoints = {});

  // Valid after prepare(). Status of all chunks together where the drive is cut; particle counts are those of
  // the current chunk.
  [[nodiscard]] const TrainStatus& status() const;
  [[nodiscard]] const TrainingReport& report() const;
  [[nodiscard]] const TrainingOptions& options() const;
  /// Returns the current particles; of a cut drive those of the current chunk, and of all chunks at the end.
  /// Throws Error{kInternal} before prepare().
  [[nodiscard]] Scene scene() const;
  /// Returns the scene with sensors, trajectory, learned mountings, the training record and the support map
  /// (record_support.hpp), for which it renders the training frames.
  [[nodiscard]] SceneFile result() const&;
  /// Returns the same without a second copy of the scene in host or device memory; the training cannot
  /// continue.
  [[nodiscard]] SceneFile result() &&;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace simuli
