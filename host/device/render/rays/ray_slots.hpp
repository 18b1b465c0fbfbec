#pragma once
// Functions common to ray_grid.cpp and ray_list_grid.cpp.
#include <Eigen/Core>
#include <string>
#include <vector>

#include "host/device/render/rays/lidar_tiles.hpp"
#include "host/device/render/rays/ray_grid.hpp"

namespace simuli::ray_slots {

/// Allocates the grid's slots for its tiles, without rays. Throws Error{kInput} above 2^30 slots.
void allocate(RayGrid& grid);

/// Sets a LiDAR's tiles: frame, tables, constants of x, and slots without rays.
void set_tiles(RayGrid& grid, const LidarTiles& tiling);

/// Sets the ray of a slot, in the sensor frame. `time`: its share of the frame.
void set_ray(RayGrid& grid,
             std::size_t slot,
             std::size_t ray,
             const Eigen::Vector3d& direction,
             const Eigen::Vector3d& origin,
             double time);

/// Fills the lookup table from elevation to rows. lowest, highest: [rows] rad, elevations of each row's rays,
/// both descending.
void fill_elevation_table(RayGrid& grid,
                          const std::vector<double>& lowest,
                          const std::vector<double>& highest);

/// Returns the footprint's variance per squared metre of range, from the full divergence angle and k of METHOD
/// section 8.
[[nodiscard]] double beam_variance(double beam_divergence, double divergence_variance);

/// Returns the square root of rays per sr, for a number of rays between two elevations over a span of azimuths,
/// rad.
[[nodiscard]] double rays_per_rad(std::size_t rays, double lowest, double highest, double span);

}  // namespace simuli::ray_slots
