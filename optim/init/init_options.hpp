#pragma once
// Options and report of the initialisation.
#include <cstddef>

#include "host/core/base/allowed.hpp"

namespace simuli {

struct InitOptions {
  double voxel_m = 0.1;
  int camera_sh_degree = 2;
  int lidar_sh_degree = 1;  // intensities and drops depend little on direction
  std::size_t max_camera = 1'000'000;
  std::size_t max_lidar = 1'000'000;
  std::size_t max_shell = 100'000;  // particles of the far shell; a sphere of kShellSpacing_deg has 165 000
  double off_path_m = 3.0;
  int environment_width = 64;
  double shell_distance_m = 0.0;  // from the scene's origin; 0: chosen from the farthest point
  double max_scale_m = 0.5;       // standard deviation of a particle
  bool sweep_depth = true;
  bool walls = true;           // see initialize_walls.hpp
  double lidar_walls_m = 3.0;  // see walls_upward.hpp
  bool drop_moving = true;     // see initialize_moving.hpp
  bool actors = true;
  double actor_min_travel_m = 1.0;
  double actor_margin_m = 0.1;  // excludes the road below
  bool register_tracks = true;  // see actor_tracks.hpp
  bool dark_surfaces = true;    // see dark_surfaces.hpp
};

/// The setting keys with allowed values and help (host/core/base/fields.hpp).
template <class F>
constexpr void visit_fields(InitOptions& o, F&& field) {
  field.group("Start");
  field("init.voxel_m",
        o.voxel_m,
        range(1e-3, 50.0),
        "Side of the start's voxels in m; each keeps one point. Larger: fewer particles, faster, coarser.");
  field("init.max_camera",
        o.max_camera,
        at_least(0),
        "Most particles the camera set starts with; more are thinned at random. Lower it to save memory.");
  field("init.max_lidar",
        o.max_lidar,
        at_least(0),
        "Most particles the LiDAR set starts with; more are thinned at random. Lower it to save memory.");
  field("init.camera_sh_degree",
        o.camera_sh_degree,
        range(0, 3),
        "Degree of the spherical harmonics of colours. Lower: less memory, no highlights.");
  field("init.environment_width",
        o.environment_width,
        zero_or(even(range(8, 7200))),
        "Width of the sky's texture in texels. Larger: finer sky; 0: no texture, one colour.");
  field("init.sweep_depth",
        o.sweep_depth,
        "Start camera particles also where only pictures show depth (a plane sweep). false: faster start, "
        "worse beyond the laser's reach.");
  field("init.walls",
        o.walls,
        "Continue walls above the laser's reach as far as pictures agree on them. false: faster start.");
  field("init.lidar_walls_m",
        o.lidar_walls_m,
        range(0.0, 50.0),
        "Height in m by which walls are extended above the highest beam, for LiDARs with higher beams; 0: "
        "they end there.");
  field("init.off_trajectory_m",
        o.off_path_m,
        range(0.0, 100.0),
        "Distance in m that cameras may leave the recorded path by. Surfaces that come into sight there get "
        "particles coloured like their surroundings; 0: none.");
  field("init.dark_surfaces",
        o.dark_surfaces,
        "Place LiDAR particles on glass and black paint, found by the rays that they swallow. false: for "
        "LiDARs whose rays drop at random.");
  field.group("Actors");
  field("init.actors",
        o.actors,
        "Model moving objects as actors with particles of their own. false: everything is background.");
  field("actors.least_travel_m",
        o.actor_min_travel_m,
        at_least(0.0),
        "Least distance in m that a labelled actor travels; others are background.");
  field("init.register_tracks",
        o.register_tracks,
        "Correct the actors' labelled tracks by their LiDAR returns. false: labels are exact.");
  field.internal(o.lidar_sh_degree);
  field.internal(o.max_shell);
  field.internal(o.shell_distance_m);
  field.internal(o.max_scale_m);
  field.internal(o.actor_margin_m);
  field.internal(o.drop_moving);
}

/// Counts of the initialisation, including everything that it left out.
struct InitReport {
  std::size_t sweeps = 0;         // read
  std::size_t images = 0;         // read
  std::size_t points = 0;         // returns in those sweeps
  std::size_t voxels = 0;         // occupied
  std::size_t actor_points = 0;   // voxels of actors
  std::size_t dark_points = 0;    // voxels of surfaces that return nothing
  std::size_t moving_points = 0;  // voxels of moving objects, left out of both sets
  std::size_t unseen_points =
      0;  // voxels invisible in all images, also off the trajectory: not in the camera set
  std::size_t joined_points = 0;  // voxels that no picture resolves
  std::size_t depth_points = 0;   // voxels from multi-view depth where no LiDAR reached
  std::size_t wall_points = 0;    // on walls above the LiDARs' field of view
  std::size_t ground_points = 0;  // on the ground around the rig outside the LiDARs' field of view
  std::size_t unmet_points = 0;   // on walls above the field of view, for LiDARs with a higher one
  std::size_t lidar_cells = 0;    // cells of the background's LiDAR set, merged where possible without loss
  std::size_t lidar_thinned = 0;  // of these, left out to keep max_lidar
  std::size_t camera_thinned = 0;
  std::size_t lidar_particles = 0;
  std::size_t camera_particles = 0;  // including the far shell
  std::size_t filled_particles = 0;  // of the camera set, invisible in all images
  std::size_t shell_particles = 0;
  double shell_distance_m = 0.0;
  double seconds = 0.0;

  /// Adds the report of another part of a drive; data read by both parts count twice.
  InitReport& operator+=(const InitReport& other);
};

}  // namespace simuli
