#pragma once
// Status and report of a training.
#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "optim/train/length_options.hpp"

namespace simuli {

/// Status of a training. Values are running means over about the last 20 frames; NaN before the first.
struct TrainStatus {
  int iteration = 0;  // completed iterations
  int planned = 0;    // planned iterations as known so far; an automatic training may extend them
  double psnr_db = 0.0;
  double distance_m =
      0.0;  // mean absolute error of the expected distance over returned rays, as in LidarLoss
  double drop_accuracy = 0.0;  // share of rays with the right ray-drop decision
  std::uint32_t camera_particles = 0;
  std::uint32_t lidar_particles = 0;
};

struct TrainReport {
  TrainStatus last;
  int first_iteration = 0;  // iterations done before this run
  /// Best values within the first iterations of this run; NaN without frames.
  TrainStatus begin;
  std::size_t images = 0;  // training pictures
  std::size_t sweeps = 0;
  Eigen::Index camera_particles = 0;
  Eigen::Index lidar_particles = 0;
  std::uint64_t relocated = 0;           // dead particles of both sets moved to regions of high error
  std::uint64_t grown = 0;               // particles added to both sets
  std::uint64_t pruned = 0;              // LiDAR particles removed because no training sweep needed them
  double row_ranges_m = 0.0;             // largest learned correction of a row's range; prune.row_ranges
  double anchor_m = 0.0;                 // mean distance of anchored camera particles at the last evaluation
  std::uint32_t rejected_gradients = 0;  // non-finite gradient entries, which were ignored; normally 0
  std::uint64_t unsound_particles =
      0;  // particles with non-finite parameters at the end, which the scene leaves out
  std::uint32_t unsound_losses = 0;  // frames with non-finite losses
  bool stopped_early = false;        // max_seconds was reached
  std::vector<LengthStage> stages;   // of a training of automatic length
  double seconds = 0.0;
  std::size_t ranks = 1;              // ranks that shared the training
  std::uint64_t gathered_bytes = 0;   // bytes exchanged between ranks, each counted once
  std::vector<std::string> warnings;  // one line each, about a doubtful result (judge())
};

/// Use of the initialisation cache by a training.
struct InitializationReport {
  double saved_s = 0.0;              // time in s that the cached steps took originally
  std::vector<std::string> damaged;  // one line for each unreadable file, which is computed again
};

}  // namespace simuli
