#pragma once
// Fits the two particle sets of a scene to a log: one image per iteration, a sweep every few, Adam on each
// set.
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/render/scene/renderer.hpp"
#include "host/render/train/shard_sum.hpp"
#include "host/scene/scene.hpp"
#include "io/log/log.hpp"
#include "optim/fixer/fixed_views.hpp"
#include "optim/length/length.hpp"
#include "optim/ranks/ranks.hpp"
#include "optim/report/train_report.hpp"
#include "optim/state/state.hpp"
#include "optim/train/schedule.hpp"
#include "optim/train/structure.hpp"
#include "optim/train/trained_drop.hpp"
#include "optim/train/trained_look.hpp"
#include "optim/train/trained_set.hpp"
#include "optim/train/training_options.hpp"
#include "optim/train/truth.hpp"

namespace simuli {

/// Mean that forgets: about the last 20 values count.
struct RunningMean {
  double sum = 0.0;
  double weight = 0.0;
  void add(double value);
  /// NaN before the first value.
  [[nodiscard]] double value() const;
};

/// One training. The same device, build, log, scene and options give the same bits, unless max_seconds
/// stops it, however many ranks share it.
class Trainer {
 public:
  /// Error{kUsage} for options outside their range, Error{kInput} when the log has no frame to train on.
  /// `log` must outlive the trainer.
  /// `ranks` must outlive it, too: all of them have a trainer of the same arguments, and call it alike.
  Trainer(const Device& device,
          const Log& log,
          Scene scene,
          const TrainingOptions& options,
          Ranks& ranks = one_rank());

  /// One iteration: a step on the camera set, and on the LiDAR set when it is its turn; each only when it has
  /// frames and particles. Error{kInput} when a frame can't be read. What is not a finite number moves
  /// nothing and is counted (TrainReport): training goes on.
  void step();
  /// All iterations that are left; `on_step` is called after each.
  TrainReport run(const std::function<void(const TrainStatus&)>& on_step = {});

  /// Stores all that decides how this training goes on; atomic. `settings`: a line for each thing that must
  /// be the same for it to be the same training, but for the number of iterations.
  void save(const std::filesystem::path& file, const std::string& settings);
  /// Goes on where a trainer of the same log, start and options was saved: with the same bits, on the same
  /// device and build. This one may have more iterations: their rates then follow its own, longer schedule.
  /// Error{kInput} when the file is of another training, of more iterations, or not as it was written.
  void resume(const std::filesystem::path& file, const std::string& settings);
  /// Error{kInput} when the file is no checkpoint, or of other settings: what resume() would say, before the
  /// start has been made.
  static void need_settings(const std::filesystem::path& file,
                            const std::string& settings,
                            const TrainOptions& options);

  /// RanksDiffer when a rank's state has other bits than rank 0's.
  void need_one_state(const std::string& settings);

  [[nodiscard]] const TrainStatus& status() const { return status_; }
  /// A LiDAR of the log, with the range biases of its rows that have been found.
  [[nodiscard]] const LidarModel& lidar(const std::string& name) const { return truth_.lidar(name); }
  /// The scene as trained so far, without particles that are not finite.
  [[nodiscard]] Scene scene() const;

  Trainer(const Trainer&) = delete;
  Trainer& operator=(const Trainer&) = delete;

 private:
  /// What a step on a set has of its own, whatever the frame.
  struct Turn {
    TrainedSet& set;
    SetNumber number;
    const LearningRates& rates;
    double progress;
    double colour_epsilon;  // of the harmonics
    bool errors;            // are collected
  };
  /// Of a frame: whose it is, and when.
  struct FrameTimes {
    std::string sensor;
    double start_s = 0.0, end_s = 0.0;
  };
  /// A frame that was rendered, with its losses' gradients, and what they came to.
  struct Shown {
    Pass pass;
    std::vector<double> losses;
  };
  [[nodiscard]] Turn camera_turn(double progress);
  [[nodiscard]] Turn lidar_turn(double progress);
  [[nodiscard]] Shown show_picture(const Turn& turn, std::size_t index);
  [[nodiscard]] Shown show_depth(std::size_t index);
  /// `number`: of all such pictures, for what is drawn.
  [[nodiscard]] Shown show_beside(std::size_t index, std::uint64_t number);
  /// `taught`: where the drop function goes that the sweep teaches, when it is not to change; null: it does.
  [[nodiscard]] Shown show_sweep(const Turn& turn,
                                 std::size_t index,
                                 std::vector<TrainedDrop::Function>* taught);
  void note_picture(std::size_t index, std::span<const double> losses);
  void note_sweep(std::size_t index, std::span<const double> losses);
  void read_ahead();
  void step_camera(double progress);
  void step_lidar(double progress);
  /// The camera set along a sweep's rays.
  void step_depth(double progress);
  /// The camera set as it is seen from beside a picture: what the picture shows there of the LiDAR set's
  /// surfaces.
  void step_beside(double progress);

  // The same with several frames a step (trainer_shards.cpp).
  struct ShardPart;
  [[nodiscard]] bool has_shards() const { return options_.shards.count > 1; }
  void step_camera_shards(double progress);
  void step_lidar_shards(double progress);
  void step_depth_shards(double progress);
  void step_beside_shards(double progress);
  /// A step of the camera set on frames that show nothing but their losses, one of each shard.
  void descend_shards(double progress, const std::function<Shown(std::size_t shard)>& show);
  /// The frames of turn `turn`, from 0, of a set, in the order of shards.
  [[nodiscard]] std::vector<std::size_t> shard_frames(FrameOrder& order, int turn) const;
  /// What `frame` says of each shard, all of which this rank has in the end; sum_ has their gradients' mean.
  /// `frame` gives sum_ a shard's gradients.
  using ShardFrame = std::function<ShardPart(std::size_t shard)>;
  [[nodiscard]] std::vector<ShardPart> run_shards(TrainedSet& set, bool errors, const ShardFrame& frame);
  /// The parts of all ranks, in the order of shards; sum_ has its total then.
  [[nodiscard]] std::vector<ShardPart> gather_shards(const std::vector<ShardPart>& own);
  /// The gradients that stand with the set, of what the pass shows.
  void add_shard(std::size_t shard, const TrainedSet& set, const Pass& pass);
  /// What differentiate() and the losses make of a shard.
  [[nodiscard]] ShardPart part_of(const Turn& turn, Shown& shown, std::size_t shard);
  /// The step of a set by the parts of all shards.
  void descend_shards(const Turn& turn,
                      const std::vector<ShardPart>& parts,
                      const std::vector<FrameTimes>& frames);
  /// Has pictures from beside the path mended, and the camera set learn from one of them.
  void mend();
  void step_mended(const FixedView& mended, double progress);
  /// From the loss of the pass to the gradients of the set, and errors, added to `error`.
  void differentiate(const Turn& turn, Pass& pass, RealBuffer& error);
  /// From the loss of the pass to the set's step: what both sets do, in its order.
  void descend(const Turn& turn, Pass& pass, const FrameTimes& frame);
  /// One step on the particles of the frame of `keys`.
  static void take_step(const Turn& turn, const RealBuffer& grads, const Buffer<std::uint32_t>& keys);
  [[nodiscard]] bool prunes(int iteration) const;
  /// Takes out what no training sweep needs of the LiDAR set, and corrects the rows' ranges.
  void look_over_sweeps();
  /// What the frame says of the actors: their poses and shapes, behind the particles' own step.
  void step_actors(const Turn& turn, Pass& pass, const FrameTimes& frame);
  /// Whether the loss of a frame is a finite number; counts it when it is not.
  bool is_sound(double loss);
  StateList state(const std::string& settings);
  /// Sees what its end says, when a stage is done of a training that decides how long it goes on.
  void end_stage();

  const Log& log_;
  Ranks& ranks_;
  Scene scene_;
  TrainOptions options_;
  Device device_;
  Renderer renderer_;
  TruthCache truth_;
  TrainedSet camera_, lidar_;
  TrainedLook look_;
  TrainedDrop drop_;
  Structure structure_;
  std::uint64_t seed_;
  // Of step_beside(): the picture's surfaces, and by camera what it shows of those beside.
  SeenSurfaces surfaces_;
  std::map<std::string, RayValues> beside_;
  std::optional<ShardSum> sum_;  // of the shards of a step, where there are several
  Ranks::Bytes message_;         // to other ranks; its memory is used again
  FrameOrder images_, sweeps_;
  TrainLength length_;
  FixedViews mended_;
  RunningMean square_, distance_, right_;
  TrainStatus status_;
  std::uint32_t unsound_losses_ = 0;
  std::uint64_t pruned_ = 0;
  std::uint64_t gathered_bytes_ = 0;
};

}  // namespace simuli
