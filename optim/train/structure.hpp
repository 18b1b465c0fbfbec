#pragma once
// What holds particles in place and what changes their number: anchors, relocation, growth, noise.
#include <cstddef>
#include <cstdint>
#include <optional>

#include "host/device/render/scene/renderer.hpp"
#include "host/device/render/train/anchor.hpp"
#include "host/device/render/train/densify.hpp"
#include "optim/train/train_report.hpp"
#include "optim/base/state.hpp"
#include "optim/train/train_options.hpp"
#include "optim/train/trained_set.hpp"

namespace simuli {

/// Iterations in which each picture is looked at once; where there is none, each sweep.
[[nodiscard]] std::size_t epoch_of(const TrainOptions& options, std::size_t images, std::size_t sweeps);

class Structure {
 public:
  // Of anchors, after the paper.
  static constexpr std::uint32_t kAnchorNeighbours = 50;  // candidates of each particle
  static constexpr double kAnchorReach_m = 2.0;           // farther from any LiDAR particle (sky): free

  /// Iterations from one time that particles are added to the next; `epoch` as of epoch_of().
  [[nodiscard]] static int densify_every(const DensifyOptions& options, std::size_t epoch);

  /// All of them must outlive it; `seed` of what is drawn.
  Structure(const Device& device,
            const TrainOptions& options,
            std::size_t epoch,
            std::uint64_t seed,
            TrainedSet& camera,
            TrainedSet& lidar);

  /// Whether frames are to tell errors in this iteration, for where particles of the set are missing.
  [[nodiscard]] bool collects_errors(SetNumber number, int iteration) const;
  /// The stage that takes them; there is one when collects_errors().
  [[nodiscard]] DensifyStage& errors() { return *densify_; }

  /// Before the steps of an iteration, when it is its turn or LiDAR particles have gone.
  void find_anchors(int iteration, bool lidar_pruned);
  /// To the camera set's gradients of the particles that the pass shows.
  void add_anchor_gradient(const Pass& pass, int iteration);
  /// Behind those of all shards' passes, with the keys of what any of them shows: what one of them chose for
  /// a particle holds for all ranks.
  void settle_anchors(const Buffer<std::uint32_t>& keys, int iteration);
  /// Moves the particles of the frame of `keys` at random.
  void jitter(TrainedSet& set,
              SetNumber number,
              const LearningRates& rates,
              const Buffer<std::uint32_t>& keys,
              int iteration,
              double progress);
  /// Behind the steps of an iteration, when it is its turn; `iteration`: done.
  void densify(int iteration);

  void report(TrainReport& report) const;
  void add_state(StateList& list);

 private:
  void anchor(const Buffer<std::uint32_t>& keys, double weight, int iteration);
  [[nodiscard]] std::uint32_t growth(SetNumber number) const;

  const TrainOptions& options_;
  int densify_every_;  // iterations
  std::uint64_t seed_;
  TrainedSet &camera_, &lidar_;
  double camera_start_, lidar_start_;    // particles
  std::optional<AnchorStage> anchor_;    // when camera particles are anchored
  std::optional<DensifyStage> densify_;  // when particles are relocated
  std::uint64_t relocated_ = 0, grown_ = 0;
};

}  // namespace simuli
