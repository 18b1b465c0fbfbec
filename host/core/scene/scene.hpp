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

/// A trained scene: two particle sets with a common origin, and the appearance of pictures.
struct Scene {
  std::string name;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  // world, m; particle means are offsets from it
  GaussianSet camera{SetKind::kCamera, 0, 0};
  GaussianSet lidar{SetKind::kLidar, 0, 0};
  EnvironmentMap environment;  // of the camera set; empty: camera_background in all directions
  ColorGrids color_grids;  // of the camera set; empty: none
  std::vector<Actor> actors;
  std::vector<VisibilitySet> visibility_sets;  // of the camera set, each visible from its chunk of the drive
  /// Actors as recorded, rigid, with disoccluded and inpainted sets: see occluders.hpp.
  std::vector<Actor> occluders;
  std::vector<RayDrop> ray_drop;  // of the training LiDARs; empty: hit and drop logits only
  /// Background behind the remaining transmittance: colour in [0,1] for the camera set; intensity, hit logit
  /// and drop logit for the LiDAR set (a ray through empty space does not return).
  std::array<float, 3> camera_background{0.0F, 0.0F, 0.0F};
  std::array<float, 3> lidar_background{0.0F, -4.0F, 4.0F};
  /// px^2, variance of the pixel footprint for training and rendering the camera set.
  double camera_filter_px2 = kPixelVariance_px2;
};

}  // namespace simuli
