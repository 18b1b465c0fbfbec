#pragma once
// Scores of a scene: means over frames, and errors by range and by kind of object.
#include <array>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "optim/base/metrics.hpp"

namespace simuli {

/// Value of scores without data.
inline constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

/// Scores of objects within a range interval from the sensor, over all frames.
struct RangeScores {
  /// Starts of the range intervals, m; each ends at the next start, the last is unbounded.
  static constexpr std::array kFrom_m{0.0, 10.0, 20.0, 40.0, 80.0};

  std::size_t returns = 0;               // recorded there
  double distance_median_m = kNoNumber;  // median of |d^ - d|
  double distance_mean_m = kNoNumber;
  double share_dropped = kNoNumber;  // share of these that the scene drops
  std::size_t returns_of_nothing = 0;  // rays without recorded return that return from there in the scene
  std::size_t pixels = 0;  // pixels with a recorded return at that distance from the camera
  double psnr_db = kNoNumber;  // of these pixels
};

/// Scores of actors of one kind, or of the background, over all frames.
struct KindScores {
  static constexpr const char* kBackground = "background";

  std::string kind;  // as in the log's actors, or kBackground
  std::size_t pixels = 0;  // whose first box is of that kind, or that see no box
  double psnr_db = kNoNumber;
  std::size_t returns = 0;  // in such a box, or in none
  double distance_median_m = kNoNumber;
  double share_met = kNoNumber;  // share of these rays that return from the same position in the scene (is_met())
};

/// Scores of one frame.
struct FrameScore {
  std::size_t index = 0;  // index into the log's pictures or sweeps
  std::string sensor;
  double time_s = 0.0;  // of its start
};
struct PictureScore : FrameScore {
  double psnr_db = kNoNumber;
  double ssim = kNoNumber;
  double flip = kNoNumber;
  double psnr_corrected_db = kNoNumber;
};
struct SweepScore : FrameScore {
  SweepMetrics metrics;  // of rays that hit the world
  double expected_median_m = kNoNumber;
  double share_own = kNoNumber;  // share of all fired rays that hit the ego vehicle
};

/// Means over frames. NaN without such frames; sweeps with a NaN value (nothing predicted, nothing returned)
/// are left out of that mean and counted.
struct EvalScores {
  std::size_t images = 0;
  std::size_t sweeps = 0;
  double psnr_db = kNoNumber;
  double ssim = kNoNumber;
  double flip = kNoNumber;
  double psnr_corrected_db = kNoNumber;  // after the best affine colour transform of each picture
  SweepMetrics lidar;                             // of best_distance()
  double distance_expected_median_m = kNoNumber;  // the same median error with expected distances only
  double share_own = kNoNumber;  // share of rays that hit the ego vehicle, which are not compared
  /// Scores of the log's actors, NaN without any: PSNR of all pixels that see their boxes (pooled over
  /// pictures, whatever the scene shows there), median |d^ - d| of the returns inside, and the share of these
  /// rays that return from the same position in the scene (is_met()): for a removed actor this measures its
  /// ghost.
  double actor_psnr_db = kNoNumber;
  double actor_distance_median_m = kNoNumber;
  double actor_share_met = kNoNumber;
  std::size_t actor_pixels = 0;
  std::size_t actor_returns = 0;
  std::size_t sweeps_without_chamfer = 0;
  std::size_t sweeps_without_distance = 0;
  std::size_t sweeps_without_drops = 0;  // left out of the mean of recalls
  std::size_t sweeps_without_predicted_drops = 0;  // left out of the mean of precisions
  std::vector<RangeScores> ranges;                 // [RangeScores::kFrom_m]
  std::vector<KindScores> kinds;  // in the order of the log's moving actors, the background last; may be empty
};

}  // namespace simuli
