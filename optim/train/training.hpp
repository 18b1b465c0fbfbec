#pragma once
// A scene from a log: the whole recipe of `simuli train`. Whoever trains with the same options gets the same
// scene, bit for bit, on the same device and build.
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
#include "optim/init/init_options.hpp"
#include "optim/data/path_report.hpp"
#include "optim/train/ranks/ranks.hpp"
#include "optim/train/train_report.hpp"
#include "optim/train/initialization_report.hpp"
#include "optim/train/training_options.hpp"

namespace simuli {

/// How a training went: its start, and what followed.
struct TrainingReport {
  InitializationReport start;
  ChunkPlan chunks;
  PathReport path;
  FindReport found;                   // zeros: not searched
  std::vector<std::string> labels;    // a line for each that was mended (sanitized_labels.hpp): warnings, too
  std::vector<std::string> left_out;  // names of labels that were
  InitReport init;
  TrainReport train;
};

/// Where a training is stored meanwhile.
struct Checkpoints {
  std::filesystem::path file;
  int every = 0;  // iterations; 0: never
};

///   Training training(Device::best(), read_log("drive.log"));
///   training.run();
///   write_scene("drive.scene", training.result());
class Training {
 public:
  /// How far a stage is: from 0 on, never back, of a total that stays.
  using Progress = std::function<void(const std::string& stage, std::size_t done, std::size_t total)>;
  using Observer = std::function<void(const TrainStatus&)>;

  /// `log` as it was read. Error{kUsage} for options outside their range, or more ranks than shards.
  /// `ranks` share the training's shards and must outlive it; every one has a training of the same device,
  /// log and options, and calls it alike. All come to the same scene.
  Training(const Device& device, Log log, const TrainingOptions& options = {}, Ranks& ranks = one_rank());
  /// Error{kUsage} when they are more than the options have shards.
  static void need_shards(const Ranks& ranks, const TrainingOptions& options);
  ~Training();
  Training(const Training&) = delete;
  Training& operator=(const Training&) = delete;

  /// Mends labels (sanitized_labels.hpp), refines the path (refined_path.hpp), learns what sweeps say of their
  /// LiDARs, finds what moves and has no label (find_actors.hpp, complete_actors.hpp), and places the first
  /// particles, unless that is done.
  /// Error{kInput} when no frame is left to train on or a file can't be read, Error{kDevice} when the device
  /// has no room for the training, RanksDiffer when a rank has another device, other settings or another log.
  void prepare(const Progress& progress = {});
  /// prepare(), and then goes on where a training of the same log and settings was saved. The number of
  /// iterations may be larger than it was: the rates of those that are left are the longer training's, so
  /// the result is well defined, but not that of a training which was longer from its first iteration on.
  /// Error{kInput}, before anything is prepared, when the file is no checkpoint or of another training.
  void resume(const std::filesystem::path& checkpoint, const Progress& progress = {});
  /// Stores all that decides how the training goes on, by rank 0 for all. Atomic. RanksDiffer, and nothing is
  /// stored, when the ranks have come to different bits.
  void save(const std::filesystem::path& checkpoint);
  /// prepare(), and then all iterations that are left, or as many as the training frames ask for
  /// (train.length.automatic). `on_step` is called after each; checkpoints are saved
  /// behind it, and at the end. Error{kNumeric} when it has diverged, so that there is no scene in it; what
  /// else speaks against it stands in TrainReport::warnings (judgement.hpp).
  const TrainingReport& run(const Observer& on_step = {}, const Checkpoints& checkpoints = {});

  // What there is from prepare() on.
  /// Of all chunks together, where the drive is cut into some; particles are those of the current one.
  [[nodiscard]] const TrainStatus& status() const;
  [[nodiscard]] const TrainingReport& report() const;
  [[nodiscard]] const TrainingOptions& options() const;
  /// The particles as trained so far; of a drive that is cut into chunks those of the current one, and of
  /// all in the end. Error{kInternal} before prepare().
  [[nodiscard]] Scene scene() const;
  /// The same with sensors and trajectory, mounted as was learned, how it was made, and what tells how well
  /// it knows what it shows (record_support.hpp), for which it renders the training frames.
  [[nodiscard]] SceneFile result() const&;
  /// The same without a second scene in memory, on host and device: what there was to train is gone then.
  [[nodiscard]] SceneFile result() &&;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace simuli
