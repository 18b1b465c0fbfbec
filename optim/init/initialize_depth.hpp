#pragma once
// Depth of what pictures see and no laser reaches (tree tops, upper floors): a plane sweep over pictures
// taken before and after, so far apart that they tell of it: ahead of a camera that drives on, things hardly
// move.
#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <vector>

#include "io/log/log.hpp"
#include "optim/init/initialize_actors.hpp"
#include "optim/init/sky.hpp"
#include "optim/init/points/points.hpp"

namespace simuli {

/// Points where only pictures tell the depth, of all cameras of a log.
struct PictureDepths {
  const Log& log;
  const std::vector<const ImageFrame*>& images;  // that may be read
  const Eigen::Vector3d& origin;                 // of the scene
  double image_scale;
  double voxel_m;  // side of the points' voxels; one point is added per voxel of twice the side
  const ActorPoints& actors;
  const SkyMasks& sky;  // of all of them

  /// Adds to `points` what the pictures of each camera show where no point is, and returns how many it added.
  /// `step` is called after each picture.
  std::size_t add_to(PointSet& points, const std::function<void()>& step) const;
};

}  // namespace simuli
