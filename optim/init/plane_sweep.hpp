#pragma once
// Distances in a picture from others taken before and after: a plane sweep (Collins, A Space-Sweep Approach to True
// Multi-Image Matching, 1996), each pixel with its neighbours' word (Hirschmüller, Stereo Processing by Semiglobal
// Matching and Mutual Information, 2008).
#include <Eigen/Core>
#include <vector>

#include "io/picture/image.hpp"
#include "optim/init/initialize_views.hpp"
#include "optim/init/sky.hpp"

namespace simuli {

/// A picture made ready for the sweep: half its size, grey, since a small shift of fine leaves would
/// otherwise look like a difference.
struct SweepPicture {
  static constexpr int kPixel_px = 2;  // side of one of its pixels, in those of the picture it is of
  ImageView view;
  Image grey;          // 1 channel
  int full_width = 0;  // px, before it was halved
  int full_height = 0;
  SkyMask sky = {};  // of it then
};
[[nodiscard]] SweepPicture sweep_picture(const ImageView& view, const Image& image, SkyMask sky = {});

inline constexpr double kSweepNearest_m = 3.0;
inline constexpr double kSweepFarthest_m = 100.0;

/// A point of the scene frame for each block of 2 x 2 pixels of `picture`: the pixel that `others` show best of those
/// whose cell of `coverage` is empty with its neighbours and whose surroundings at least two of `others` show at one and
/// the same distance, up to kSweepFarthest_m. Pixels that
/// look alike at many distances count as farther away; there is no point of what looks alike at most of them, nor of
/// sky. `coverage` is of the picture before it was halved.
[[nodiscard]] std::vector<Eigen::Vector3d> sweep_depths(const SweepPicture& picture,
                                                        const std::vector<const SweepPicture*>& others,
                                                        const Coverage& coverage);

}  // namespace simuli
