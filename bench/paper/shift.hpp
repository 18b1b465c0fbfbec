#pragma once
#include <string>
#include <utility>
#include <vector>

#include "bench/paper/fit.hpp"
#include "bench/render/measure.hpp"
#include "io/picture/image.hpp"

namespace simuli::bench {

struct ShiftOptions {
  int iterations = 400;               // of the training
  std::vector<std::string> settings;  // "key=value" of the training, beside the defaults
  bool detailed = false;              // detailed_street() instead of the plain one
};

struct ShiftResult {
  std::vector<Row> rows;
  /// The middle picture of some places: its name, as rendered, the truth.
  struct Pair {
    std::string name;
    Image rendered, truth;
  };
  std::vector<Pair> pictures;
};

/// The street's scene from where it was never recorded, beside the truth there: the rig 0.5 to 3 m to either
/// side, 1 m higher, turned by 15 and 30 degrees to either side, and with another camera or LiDAR in its
/// place. All recorded frames are trained on.
///   shift/<place>/<psnr_db|ssim|distance_median_cm|raydrop_accuracy|chamfer_m>   means over all frames
///   shift/<place>/<never_seen|coarsely_seen|well_seen>/<share|psnr_db>   pixels by what the recorded
///     pictures show of them (seen.hpp), all pictures together
///   shift/<place>/psnr_of_seen_as_on_path_db   mean over all pictures, were what is seen as good as there
///   shift/<place|all>/support_<pixels|rays>/<mean|right|rank_correlation>   support beside true errors; the
///     latter over all places but the path itself, on which its constants were fitted
///   shift/all/support_<pixels|rays>/<0.0 ... 0.9>/<share|support|right>   the curve: of those whose support
///   is there shift/all/support_<pixels|rays>/cost   its time over that of a frame
/// -3 m leads through parked cars.
[[nodiscard]] ShiftResult run_shift(const std::string& device_request,
                                    const ShiftOptions& options,
                                    const Note& note);

}  // namespace simuli::bench
