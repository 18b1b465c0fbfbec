#pragma once
// The embedded synthetic street: an analytic world of planes, boxes, cylinders and spheres with procedural
// colour, ray traced in double precision. Ground truth for range, colour, intensity and drops.
#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <functional>

#include "io/log.hpp"

namespace simuli {

/// What a ray meets first.
struct StreetHit {
  bool hit = false;
  double range = 0.0;          // m
  Eigen::Vector3d normal;      // unit, world
  Eigen::Vector3d colour;      // [0,1]; the sky's colour when nothing is hit
  double reflectance = 0.0;    // [0,1], LiDAR
  bool on_car = false;         // the moving car
};

class Street {
 public:
  /// The street as embedded; seed varies textures and furniture.
  explicit Street(std::uint64_t seed = 1);
  /// First hit of the ray from origin (world, m) along the unit direction at time_s, up to max_range.
  [[nodiscard]] StreetHit trace(const Eigen::Vector3d& origin,
                                const Eigen::Vector3d& direction,
                                double time_s,
                                double max_range) const;

 private:
  std::uint64_t seed_;
};

struct StreetOptions {
  std::filesystem::path output;
  int frames = 20;               // images per camera = sweeps
  double speed_m_per_s = 8.0;    // of the rig
  int image_width = 320;
  int image_height = 180;
  int lidar_columns = 900;
  bool moving_car = true;
  bool rolling_shutter = false;  // 20 ms top to bottom instead of a global shutter
  std::uint64_t seed = 1;
};

/// Renders the street into a log folder (complete or not at all).
Log synth_street(const StreetOptions& options,
                 const std::function<void(std::size_t, std::size_t)>& progress = {});

}  // namespace simuli
