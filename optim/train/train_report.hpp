#pragma once
// What a training says of itself.
#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "optim/train/length_options.hpp"

namespace simuli {

/// How the training stands. Values are running means over about the last 20 frames; NaN before the first.
struct TrainStatus {
  int iteration = 0;  // done
  int planned = 0;    // as far as it is known: a training that decides itself may go on
  double psnr_db = 0.0;
  double distance_m = 0.0;     // mean over returned rays, expected distance, as it is taught (LidarLoss)
  double drop_accuracy = 0.0;  // share of rays
  std::uint32_t camera_particles = 0;
  std::uint32_t lidar_particles = 0;
};

struct TrainReport {
  TrainStatus last;
  int first_iteration = 0;  // that this run found done
  /// The best values of the first iterations of this run: where it started. NaN: of no frame.
  TrainStatus begin;
  std::size_t images = 0;  // trained on
  std::size_t sweeps = 0;
  Eigen::Index camera_particles = 0;
  Eigen::Index lidar_particles = 0;
  std::uint64_t relocated = 0;  // dead particles of both sets, put where the error is
  std::uint64_t grown = 0;      // particles of both sets that came new
  std::uint64_t pruned = 0;     // LiDAR particles that no training sweep needed
  double row_ranges_m = 0.0;  // largest correction of a row's range that training has found; prune.row_ranges
  double anchor_m = 0.0;      // mean distance of anchored camera particles seen last
  std::uint32_t rejected_gradients = 0;  // entries that were not finite and moved nothing; 0 in good order
  std::uint64_t unsound_particles = 0;   // not finite at the end: nobody sees them, the scene leaves them out
  std::uint32_t unsound_losses = 0;      // of frames, not finite
  bool stopped_early = false;            // max_seconds ran out first
  std::vector<LengthStage> stages;       // of a training that decides how long it goes on
  double seconds = 0.0;
  std::size_t ranks = 1;              // that have shared it
  std::uint64_t gathered_bytes = 0;   // that they have told each other of their shards, each counted once
  std::vector<std::string> warnings;  // a line each: what nobody should overlook (judge())
};

}  // namespace simuli
