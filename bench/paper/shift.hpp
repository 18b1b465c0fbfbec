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
  std::vector<std::string> settings;  // "key=value" of the training in addition to the defaults
  bool detailed = false;              // use detailed_street() instead of the plain street
};

struct ShiftResult {
  std::vector<Row> rows;
  /// Middle picture of a placement: name, rendered, ground truth.
  struct Pair {
    std::string name;
    Image rendered, truth;
  };
  std::vector<Pair> pictures;
};

/// Renders the street's scene for unrecorded rigs and compares with ground truth: 0.5 to 3 m to either side,
/// 1 m higher, rotated by 15 and 30 degrees to either side, and with another camera or LiDAR. The training
/// uses all recorded frames.
///   shift/<place>/<psnr_db|ssim|distance_median_cm|raydrop_accuracy|chamfer_m>   means over all frames
///   shift/<place>/<never_seen|coarsely_seen|well_seen>/<share|psnr_db>   pixels by their visibility in the
/// recorded pictures (seen.hpp), all pictures together
///   shift/<place>/psnr_of_seen_as_on_path_db   mean over all pictures if visible pixels had the error of the
/// recorded trajectory
///   shift/<place|all>/support_<pixels|rays>/<mean|right|rank_correlation>   support and true errors; all:
/// without the recorded trajectory, to which the constants were fitted
///   shift/all/support_<pixels|rays>/<0.0 ... 0.9>/<share|support|right>   curve over bins of support
///   shift/all/support_<pixels|rays>/cost   time relative to a frame
/// The placement at -3 m passes through parked cars.
[[nodiscard]] ShiftResult run_shift(const std::string& device_request,
                                    const ShiftOptions& options,
                                    const Note& note);

}  // namespace simuli::bench
