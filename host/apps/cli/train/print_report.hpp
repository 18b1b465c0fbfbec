#pragma once
// What `simuli train` says at its end.
#include <Eigen/Core>
#include <optional>
#include <string>

#include "io/scene/training_record.hpp"
#include "optim/train/training.hpp"

namespace simuli::cli {

/// A training that has ended, with its scene written.
struct EndedTraining {
  const TrainingReport& training;
  const std::optional<HeldOutScores>& held_out;
  Eigen::Index camera_particles = 0, lidar_particles = 0;  // of the scene, as `simuli info` counts them
  std::string log, scene;                                  // as they were given
  std::string report;                                      // that was written; empty: none
};

/// On stdout, for people or as JSON.
void print_report(const EndedTraining& ended, bool json);

}  // namespace simuli::cli
