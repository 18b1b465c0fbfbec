#pragma once
#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "host/core/scene/actor.hpp"
#include "host/core/scene/appearance.hpp"
#include "host/core/scene/gaussians.hpp"
#include "host/core/scene/pixel_footprint.hpp"
#include "host/core/scene/ray_drop.hpp"
#include "host/core/scene/visibility_sets.hpp"

namespace simuli {

/// A trained scene: two particle sets that share nothing but the origin, and what the camera's pictures have
/// beside particles.
struct Scene {
  std::string name;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  // world, m; particle means are offsets from it
  GaussianSet camera{SetKind::kCamera, 0, 0};
  GaussianSet lidar{SetKind::kLidar, 0, 0};
  EnvironmentMap environment;  // of the camera set; empty: camera_background in all directions
  ColorGrids color_grids;      // of the camera set; empty: colours as they are
  std::vector<Actor> actors;
  std::vector<VisibilitySet> visibility_sets;  // of the camera set: what is each seen from its own chunk of the drive alone
  /// Actors as they were recorded, rigid, that hide what nothing else shows: see occluders.hpp.
  std::vector<Actor> occluders;
  std::vector<RayDrop> ray_drop;  // of the LiDARs that it was trained on; none: of hit and drop logits alone
  /// Seen where transmittance is left: colour in [0,1] for the camera set; intensity, hit logit and
  /// drop logit for the LiDAR set (a ray through empty space returns nothing).
  std::array<float, 3> camera_background{0.0F, 0.0F, 0.0F};
  std::array<float, 3> lidar_background{0.0F, -4.0F, 4.0F};
  /// px^2, variance of a pixel's footprint that the camera set was trained with, and is drawn with.
  double camera_filter_px2 = kPixelVariance_px2;
};

}  // namespace simuli
