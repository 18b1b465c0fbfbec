#pragma once
// What the makers of ray grids share (ray_grid.cpp, ray_list_grid.cpp).
#include <Eigen/Core>
#include <string>
#include <vector>

#include "host/device/render/rays/lidar_tiles.hpp"
#include "host/device/render/rays/ray_grid.hpp"

namespace simuli::ray_slots {

/// Sizes the grid's slot arrays for its tiles, all without a ray. Error{kInput} above 2^30 slots.
void allocate(RayGrid& grid);

/// Takes a LiDAR's tiles over: frame, tables, constants of x, and slots without a ray.
void set_tiles(RayGrid& grid, const LidarTiles& tiling);

/// Puts a ray of the sensor frame into a slot. `time`: its share of the frame.
void set_ray(RayGrid& grid,
             std::size_t slot,
             std::size_t ray,
             const Eigen::Vector3d& direction,
             const Eigen::Vector3d& origin,
             double time);

/// Fills the look-up of rows by elevation. lowest, highest: [rows] rad, the elevations of each row's rays,
/// neither rising from row to row.
void fill_elevation_table(RayGrid& grid,
                          const std::vector<double>& lowest,
                          const std::vector<double>& highest);

/// The footprint's variance per squared metre of range, from a full angle and k of METHOD section 8.
[[nodiscard]] double beam_variance(double beam_divergence, double divergence_variance);

/// Square root of rays per sr: of so many between two elevations, over a span of azimuths, rad.
[[nodiscard]] double rays_per_rad(std::size_t rays, double lowest, double highest, double span);

}  // namespace simuli::ray_slots
