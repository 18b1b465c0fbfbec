#pragma once
// Final output of `simuli train`.
#include <Eigen/Core>
#include <optional>
#include <string>

#include "io/scene/training_record.hpp"
#include "optim/train/training.hpp"

namespace simuli::cli {

/// A finished training whose scene was written.
struct EndedTraining {
  const TrainingReport& training;
  const std::optional<HeldOutScores>& held_out;
  Eigen::Index camera_particles = 0, lidar_particles = 0;  // of the scene, as in `simuli info`
  std::string log, scene;                                  // as given
  std::string report;                                      // written report; empty: none
};

/// Prints to stdout, as text or as JSON.
void print_report(const EndedTraining& ended, bool json);

}  // namespace simuli::cli
