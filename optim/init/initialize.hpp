#pragma once
// First guess of a scene from a log: LiDAR returns become particles, images give them colour, and what no
// laser reaches (sky, far buildings) becomes a far shell. METHOD section 12.
#include <cstddef>
#include <functional>

#include "host/scene/scene.hpp"
#include "io/log/frame_selection.hpp"
#include "io/log/log.hpp"
#include "optim/init/init_options.hpp"
#include "optim/init/moving_space.hpp"

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

struct SceneInit {
  Scene scene;
  MovingSpace moving;  // empty unless drop_moving
  InitReport report;
};

/// Reads the training sweeps and images of `log` that `frames` selects, one at a time, and builds both
/// particle sets of the static background and of the actors (sweeps are read twice to drop what moved). The
/// camera set is made for pictures of that size. The same log and options give the same bits. The scene's origin is the mean position of the trajectory in whole metres.
/// `progress(done, total)` is called after each file. Throws Error{kUsage} for options outside their range,
/// Error{kInput} when no frame is left for training or a file can't be read.
[[nodiscard]] SceneInit initialize_scene(const Log& log,
                                         const FrameSelection& frames,
                                         const InitOptions& options,
                                         const std::function<void(std::size_t, std::size_t)>& progress = {});

}  // namespace simuli
