#pragma once
// First guess of a scene from a log: LiDAR returns become particles, images give them colour, and what no
// laser reaches (sky, far buildings) becomes a far shell. METHOD section 12.
#include <cstddef>
#include <functional>

#include "host/scene/scene.hpp"
#include "io/log/frame_selection.hpp"
#include "io/log/log.hpp"
#include "optim/init/moving_space.hpp"

namespace simuli {

struct InitOptions {
  double voxel_m = 0.1;                // one point per voxel of this side
  int camera_sh_degree = 2;            // 0 to 3; coefficients above degree 0 start at zero
  int lidar_sh_degree = 1;             // 0 to 3
  std::size_t max_camera = 1'000'000;  // particles on LiDAR points; the shell comes on top
  std::size_t max_lidar = 1'000'000;   // particles
  std::size_t max_shell = 100'000;     // particles; 0: no shell
  int environment_width = 0;           // texels around, even; 0: no environment
  double shell_spacing_deg = 0.5;      // angle between shell particles, seen from the scene origin
  double camera_scale = 0.5;           // standard deviation of a particle over the distance to its neighbours
  double lidar_scale = 0.7;
  double min_scale_m = 0.03;  // limits of a particle's standard deviation
  double max_scale_m = 0.5;
  bool sweep_depth = true;          // place camera particles also where only pictures tell the depth
  int sweep_cell_px = 4;            // between them, in the training picture
  bool drop_moving = true;          // leave out points that other sweeps look through (initialize_moving.hpp)
  bool actors = true;               // give the log's actors particles of their own; false: all is background
  double actor_min_travel_m = 1.0;  // to those that get at least that far
  double actor_voxel_m = 0.05;
  double actor_margin_m = 0.1;  // by which boxes reach farther than labelled; the road below stays outside
  bool mirror_actors = false;   // vehicles: also the mirror image of each point
  bool register_tracks = true;  // correct the actors' tracks by what the laser measured (actor_tracks.hpp)
};

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
