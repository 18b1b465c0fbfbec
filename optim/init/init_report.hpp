#pragma once
#include <cstddef>

namespace simuli {

/// What the initialisation did, so that nothing is dropped without a number.
struct InitReport {
  std::size_t sweeps = 0;         // read
  std::size_t images = 0;         // read
  std::size_t points = 0;         // returns in those sweeps
  std::size_t voxels = 0;         // occupied
  std::size_t actor_points = 0;   // voxels of actors
  std::size_t moving_points = 0;  // voxels left out of both sets, because they moved
  std::size_t unseen_points = 0;  // voxels that no image sees: not in the camera set
  std::size_t depth_points = 0;   // of pictures where no laser reached, voxels
  std::size_t lidar_thinned = 0;  // voxels left out to keep to max_lidar
  std::size_t camera_thinned = 0;
  std::size_t lidar_particles = 0;
  std::size_t camera_particles = 0;  // with the shell
  std::size_t shell_particles = 0;
  double shell_distance_m = 0.0;
  double seconds = 0.0;
};

}  // namespace simuli
