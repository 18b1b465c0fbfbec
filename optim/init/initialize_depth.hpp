#pragma once
// Depth of what pictures see and no laser reaches (tree tops, upper floors): a plane sweep over the pictures
// taken just before and after.
#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "io/picture/image.hpp"
#include "optim/init/initialize_views.hpp"

namespace simuli {

/// A picture made ready for the sweep: half its size, grey, since a small shift of fine leaves would
/// otherwise look like a difference.
struct SweepPicture {
  ImageView view;
  Image grey;          // 1 channel
  int full_width = 0;  // px, before it was halved
  int full_height = 0;
};
[[nodiscard]] SweepPicture sweep_picture(const ImageView& view, const Image& image);

/// A point of the scene frame for each cell of `coverage` that is empty with its neighbours and whose
/// surroundings at least two of `others` show at one and the same distance, up to kSweepFarthest_m. Cells
/// that look alike at many distances (sky) count as farther away and have none. `coverage` is of the picture
/// before it was halved.
[[nodiscard]] std::vector<Eigen::Vector3d> sweep_depths(const SweepPicture& picture,
                                                        const std::vector<const SweepPicture*>& others,
                                                        const Coverage& coverage);

inline constexpr double kSweepNearest_m = 3.0;
inline constexpr double kSweepFarthest_m = 100.0;

}  // namespace simuli
