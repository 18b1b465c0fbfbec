#pragma once
// What frames say of a scene: means over them, and the same errors by range and by kind of object.
#include <array>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "optim/base/metrics.hpp"

namespace simuli {

/// Values where nothing was compared.
inline constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

/// What is recorded at some distance from the sensor, of all frames together.
struct RangeScores {
  /// Where the ranges begin, m; each ends where the next one begins, the last one never.
  static constexpr std::array kFrom_m{0.0, 10.0, 20.0, 40.0, 80.0};

  std::size_t returns = 0;               // recorded there
  double distance_median_m = kNoNumber;  // of their |d^ - d|
  double distance_mean_m = kNoNumber;
  double share_dropped = kNoNumber;    // of them: the scene says that nothing comes back
  std::size_t returns_of_nothing = 0;  // rays that recorded nothing and return from there in the scene
  std::size_t pixels = 0;              // on which a recorded return falls that is this far from the camera
  double psnr_db = kNoNumber;          // of these alone
};

/// What is recorded of actors of one kind, or of everything else, of all frames together.
struct KindScores {
  static constexpr const char* kBackground = "background";

  std::string kind;        // as the log's actors have it, or kBackground
  std::size_t pixels = 0;  // that look at a box of that kind first, or at none
  double psnr_db = kNoNumber;
  std::size_t returns = 0;  // in such a box, or in none
  double distance_median_m = kNoNumber;
  double share_met = kNoNumber;  // of these rays: they return from the same place in the scene (is_met())
};

/// One frame by itself.
struct FrameScore {
  std::size_t index = 0;  // among the log's pictures, or its sweeps
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
  SweepMetrics metrics;  // of rays that meet the world
  double expected_median_m = kNoNumber;
  double share_own = kNoNumber;  // of all rays that are fired: meet the own vehicle
};

/// Means over frames. NaN where there is no such frame; a sweep whose value is NaN (nothing predicted,
/// nothing returned) is left out of that mean and counted.
struct EvalScores {
  std::size_t images = 0;
  std::size_t sweeps = 0;
  double psnr_db = kNoNumber;
  double ssim = kNoNumber;
  double flip = kNoNumber;
  double psnr_corrected_db = kNoNumber;           // once the best affine transform corrects each one's tint
  SweepMetrics lidar;                             // of best_distance()
  double distance_expected_median_m = kNoNumber;  // the same median error with expected distances alone
  double share_own = kNoNumber;                   // of the rays: meet the own vehicle, not compared
  /// Of the log's actors alone, NaN without any: PSNR of all pixels that look at their boxes (pooled over the
  /// pictures, whatever the scene makes of them), median |d^ - d| of the returns inside, and the share of
  /// those rays that return from the same place in the scene (is_met()): of an actor that was taken away, its
  /// ghost.
  double actor_psnr_db = kNoNumber;
  double actor_distance_median_m = kNoNumber;
  double actor_share_met = kNoNumber;
  std::size_t actor_pixels = 0;
  std::size_t actor_returns = 0;
  std::size_t sweeps_without_chamfer = 0;
  std::size_t sweeps_without_distance = 0;
  std::size_t sweeps_without_drops = 0;            // left out of the mean of recalls
  std::size_t sweeps_without_predicted_drops = 0;  // and of precisions
  std::vector<RangeScores> ranges;                 // [RangeScores::kFrom_m]
  std::vector<KindScores> kinds;  // in the order of the log's moving actors, the background last; or empty
};

}  // namespace simuli
