#pragma once
// Depth of objects that pictures show and no LiDAR reaches (tree tops, upper floors): a plane sweep over
// pictures before and after with sufficient parallax; ahead of a moving camera parallax is small.
#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <vector>

#include "io/log/log.hpp"
#include "optim/init/initialize_actors.hpp"
#include "optim/init/sky.hpp"
#include "optim/init/points/points.hpp"

namespace simuli {

/// Points with depth from pictures only, for all cameras of a log.
struct PictureDepths {
  const Log& log;
  const std::vector<const ImageFrame*>& images;  // readable training images
  const Eigen::Vector3d& origin;  // origin of the scene
  double image_scale;
  double voxel_m;  // of the points; one point is added per voxel of twice the side
  const ActorPoints& actors;
  const SkyMasks& sky;  // of all images

  /// Adds points to `points` where the pictures of a camera show none, and returns their number. Calls `step`
  /// after each picture.
  std::size_t add_to(PointSet& points, const std::function<void()>& step) const;
};

}  // namespace simuli
