#pragma once
// Distances in a picture from others taken before and after: a plane sweep (Collins, A Space-Sweep Approach to
// True Multi-Image Matching, 1996) with semi-global smoothing (Hirschmüller, Stereo Processing by Semiglobal
// Matching and Mutual Information, 2008).
#include <Eigen/Core>
#include <vector>

#include "io/picture/image.hpp"
#include "optim/init/initialize_views.hpp"
#include "optim/init/sky.hpp"

namespace simuli {

/// A picture prepared for the sweep: grey at half size, so that small shifts of fine leaves do not count as
/// differences.
struct SweepPicture {
  static constexpr int kPixel_px = 2;  // side of its pixels, in pixels of the original
  ImageView view;
  Image grey;          // 1 channel
  int full_width = 0;  // px, of the original
  int full_height = 0;
  SkyMask sky = {};  // of the original
};
[[nodiscard]] SweepPicture sweep_picture(const ImageView& view, const Image& image, SkyMask sky = {});

inline constexpr double kSweepNearest_m = 3.0;
inline constexpr double kSweepFarthest_m = 100.0;

/// Returns at most one point in the scene frame for each block of 2 x 2 pixels of `picture`: the best-matching
/// pixel among those in empty cells of `coverage` with empty neighbours whose patch at least two of `others`
/// show at the same distance, up to kSweepFarthest_m. Ambiguous pixels take the farthest distance; pixels
/// ambiguous at most distances and sky give no point. `coverage` refers to the full-size picture.
[[nodiscard]] std::vector<Eigen::Vector3d> sweep_depths(const SweepPicture& picture,
                                                        const std::vector<const SweepPicture*>& others,
                                                        const Coverage& coverage);

}  // namespace simuli
