#pragma once
// Depth of what pictures see and no laser reaches (tree tops, upper floors): a plane sweep over pictures
// taken before and after, so far apart that they tell of it: ahead of a camera that drives on, things hardly
// move.
#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <vector>

#include "io/log/log.hpp"
#include "io/picture/image.hpp"
#include "optim/init/initialize_actors.hpp"
#include "optim/init/initialize_views.hpp"
#include "optim/init/sky.hpp"
#include "optim/points/points.hpp"

namespace simuli {

/// A picture made ready for the sweep: half its size, grey, since a small shift of fine leaves would
/// otherwise look like a difference.
struct SweepPicture {
  ImageView view;
  Image grey;          // 1 channel
  int full_width = 0;  // px, before it was halved
  int full_height = 0;
  SkyMask sky = {};  // of it then
};
[[nodiscard]] SweepPicture sweep_picture(const ImageView& view, const Image& image, SkyMask sky = {});

/// A point of the scene frame for each cell of `coverage` that is empty with its neighbours and whose
/// surroundings at least two of `others` show at one and the same distance, up to kSweepFarthest_m. Cells
/// that look alike at many distances count as farther away and have none, nor has sky. `coverage` is of the picture
/// before it was halved.
[[nodiscard]] std::vector<Eigen::Vector3d> sweep_depths(const SweepPicture& picture,
                                                        const std::vector<const SweepPicture*>& others,
                                                        const Coverage& coverage);

inline constexpr double kSweepNearest_m = 3.0;
inline constexpr double kSweepFarthest_m = 100.0;

/// Points where only pictures tell the depth, of all cameras of a log.
struct PictureDepths {
  const Log& log;
  const std::vector<const ImageFrame*>& images;  // that may be read
  const Eigen::Vector3d& origin;                 // of the scene
  double image_scale;
  double voxel_m;  // side of the points' voxels; one point is added per voxel of twice the side
  int cell_px;     // between two depths
  const ActorPoints& actors;
  const SkyMasks& sky;  // of all of them

  /// Adds to `points` what the pictures of each camera show where no point is, and returns how many it added.
  /// `step` is called after each picture.
  std::size_t add_to(PointSet& points, const std::function<void()>& step) const;
};

}  // namespace simuli
