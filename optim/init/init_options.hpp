#pragma once
// What the first guess of a scene is told, and what it says of itself.
#include <cstddef>

#include "host/base/allowed.hpp"

namespace simuli {

struct InitOptions {
  double voxel_m = 0.1;
  double camera_voxel_px = 3.0;
  int camera_sh_degree = 2;
  int lidar_sh_degree = 1;
  std::size_t max_camera = 1'000'000;
  std::size_t max_lidar = 1'000'000;
  std::size_t max_shell = 100'000;
  double off_path_m = 3.0;
  int environment_width = 64;
  double shell_spacing_deg = 0.5;
  double shell_open_share = 0.5;
  double shell_distance_m = 0.0;
  double camera_scale = 0.5;
  double lidar_scale = 0.5;
  double lidar_voxel_rad = 0.01;
  double lidar_thin_m = 0.01;
  double flat_side_m = 0.8;
  double flat_m = 0.015;
  double flat_alike = 0.1;
  double min_scale_m = 0.03;
  double max_scale_m = 0.5;
  bool sweep_depth = true;
  int sweep_cell_px = 4;
  bool walls = true;           // see beyond/initialize_walls.hpp
  double lidar_walls_m = 3.0;  // see beyond/walls_upward.hpp
  bool drop_moving = true;     // see initialize_moving.hpp
  bool actors = true;
  double actor_min_travel_m = 1.0;
  double actor_voxel_m = 0.05;
  double actor_margin_m = 0.1;  // the road below stays outside
  bool register_tracks = true;  // see actor_tracks.hpp
  double dark_voxel_m = 0.1;    // see dark_surfaces.hpp
  double dark_still_m = 0.15;   // see dark_still.hpp
};

/// The keys that users set, with what is allowed and what it means (host/base/fields.hpp).
template <class F>
constexpr void visit_fields(InitOptions& o, F&& field) {
  field("init.voxel_m", o.voxel_m, range(1e-3, 50.0), "m, side of a voxel, each of which keeps one point");
  field("init.camera_voxel_px",
        o.camera_voxel_px,
        range(0.0, 64.0),
        "px, least width of the camera set's voxels in the closest training picture of them");
  field("init.camera_sh_degree",
        o.camera_sh_degree,
        range(0, 3),
        "of the camera set; coefficients above degree 0 start at zero");
  field("init.lidar_sh_degree", o.lidar_sh_degree, range(0, 3), "of the LiDAR set");
  field("init.max_camera",
        o.max_camera,
        at_least(0),
        "particles of the camera set on LiDAR points; the shell comes on top");
  field("init.max_lidar",
        o.max_lidar,
        at_least(0),
        "particles of the LiDAR set, at most: more are thinned, and said");
  field("init.max_shell",
        o.max_shell,
        at_least(0),
        "particles of the far shell, which stands for what no laser reaches; 0: none");
  field("init.shell_spacing_deg",
        o.shell_spacing_deg,
        range(0.05, 45.0),
        "degrees between shell particles, seen from the scene's origin");
  field("init.shell_open_share",
        o.shell_open_share,
        range(0.0, 1.0),
        "of the pictures of a direction, at least: that many must show something there that no laser reached "
        "for shell particles to stand there");
  field("init.shell_distance_m",
        o.shell_distance_m,
        zero_or(at_least(1.0)),
        "m of the far shell from the scene's origin; 0: three times the farthest point's, 200 at least");
  field("init.off_path_m",
        o.off_path_m,
        range(0.0, 100.0),
        "m that cameras may leave the recorded path by, to the sides and upwards: what they would see then, "
        "and no picture shows, is filled in where the laser met it, with the colours around; 0: nothing is");
  field("init.camera_scale",
        o.camera_scale,
        above(0.0, 10.0),
        "standard deviation of a camera particle over the distance to its neighbours");
  field("init.lidar_scale",
        o.lidar_scale,
        above(0.0, 10.0),
        "that of a LiDAR particle over the distance to the next one along the same axis");
  field("init.lidar_voxel_rad",
        o.lidar_voxel_rad,
        range(0.0, 1.0),
        "rad, side of a voxel of the LiDAR set over the nearest range it was seen from, at most: those of "
        "init.voxel_m double until then; 0: none does");
  field("init.lidar_thin_m",
        o.lidar_thin_m,
        above(0.0),
        "m, least standard deviation of a LiDAR particle across its surface");
  field("init.flat_side_m",
        o.flat_side_m,
        at_least(0.0),
        "m, side of the LiDAR set's voxels where returns are flat and alike, at most; 0: they don't grow");
  field("init.flat_m",
        o.flat_m,
        at_least(0.0),
        "m, standard deviation from their plane of what counts as flat");
  field("init.flat_alike",
        o.flat_alike,
        at_least(0.0),
        "standard deviation of intensity, of 1, of what counts as alike");
  field("init.min_scale_m", o.min_scale_m, above(0.0), "m, least standard deviation of a particle");
  field("init.max_scale_m",
        o.max_scale_m,
        above(0.0),
        "m, largest standard deviation; init.min_scale_m or more");
  field("init.sweep_depth", o.sweep_depth, "camera particles also where only pictures tell the depth");
  field("init.sweep_cell_px", o.sweep_cell_px, range(1, 64), "px of the training picture between those");
  field("init.walls",
        o.walls,
        "camera particles also on walls above the laser's reach, as far as pictures agree on them");
  field(
      "init.lidar_walls_m",
      o.lidar_walls_m,
      range(0.0, 50.0),
      "m by which walls go on above what the laser reached, for LiDARs that look higher, unless rays passed "
      "there; 0: none does");
  field("init.drop_moving", o.drop_moving, "leave out points that other sweeps look through");
  field("init.environment_width",
        o.environment_width,
        zero_or(even(range(8, 7200))),
        "texels around of the environment map; 0: none");
  field("init.actors", o.actors, "particles of their own for the log's actors; false: all is background");
  field("init.actor_min_travel_m",
        o.actor_min_travel_m,
        at_least(0.0),
        "m, actors that get less far stay background");
  field("init.actor_voxel_m", o.actor_voxel_m, range(1e-3, 100.0), "m, side of an actor's voxel");
  field(
      "init.actor_margin_m", o.actor_margin_m, at_least(0.0), "m by which boxes reach farther than labelled");
  field("init.dark_voxel_m",
        o.dark_voxel_m,
        zero_or(range(0.02, 1.0)),
        "m, side of the voxels in which actors' surfaces that return nothing are looked for; 0: not at all");
  field("init.dark_still_m",
        o.dark_still_m,
        zero_or(range(0.02, 1.0)),
        "m, the same of what stands still, where the ground would have answered the rays that drop; 0: not "
        "at all");
  field("init.register_tracks", o.register_tracks, "correct the actors' tracks by what the laser measured");
}

/// Error{kUsage} naming the key when one is outside its range.
void check(const InitOptions& options);

/// What the initialisation did, so that nothing is dropped without a number.
struct InitReport {
  std::size_t sweeps = 0;         // read
  std::size_t images = 0;         // read
  std::size_t points = 0;         // returns in those sweeps
  std::size_t voxels = 0;         // occupied
  std::size_t actor_points = 0;   // voxels of actors
  std::size_t dark_points = 0;    // voxels of surfaces that return nothing
  std::size_t moving_points = 0;  // voxels left out of both sets, because they moved
  std::size_t unseen_points = 0;  // voxels that no image sees, nor would off the path: not in the camera set
  std::size_t joined_points = 0;  // voxels that no picture shows apart from others
  std::size_t depth_points = 0;   // of pictures where no laser reached, voxels
  std::size_t wall_points = 0;    // on walls above the laser's reach
  std::size_t unmet_points = 0;   // on walls above the laser's reach, for LiDARs that look higher
  std::size_t lidar_cells = 0;    // voxels of the background's LiDAR set, grown where that costs nothing
  std::size_t lidar_thinned = 0;  // of those, left out to keep to max_lidar
  std::size_t camera_thinned = 0;
  std::size_t lidar_particles = 0;
  std::size_t camera_particles = 0;  // with the shell
  std::size_t filled_particles = 0;  // of the camera set, that no image sees
  std::size_t shell_particles = 0;
  double shell_distance_m = 0.0;
  double seconds = 0.0;

  /// Of two parts of a drive together; what both read counts twice.
  InitReport& operator+=(const InitReport& other);
};

}  // namespace simuli
