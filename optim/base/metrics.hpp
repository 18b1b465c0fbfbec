#pragma once
// Metrics of METHOD section 13, in double on the host. Every unit is in the name.
#include <Eigen/Core>
#include <vector>

#include "io/picture/image.hpp"

namespace simuli {

/// Peak signal-to-noise ratio in dB of pictures in [0,1] of equal size; identical pictures give +inf. Values
/// below 0 in `truth` are not known (camera_mask.hpp) and have no part in it; NaN where none is known.
[[nodiscard]] double psnr_db(const Image& rendered, const Image& truth);
/// kQuadratic: another camera's tone curve, too.
enum class Tone { kAffine, kQuadratic };
/// `rendered` through the transform of its colours (3 x 4 for three channels, of these and 1; kQuadratic 3 x 7, of
/// their squares, too) that brings it nearest to `truth` in least squares, clipped to [0,1]; a pixel that is known
/// counts `weight[pixel]`, or 1 without any.
[[nodiscard]] Image colour_corrected(const Image& rendered,
                                     const Image& truth,
                                     const std::vector<float>& weight = {},
                                     Tone tone = Tone::kAffine);
/// psnr_db() of colour_corrected(): what is not a matter of exposure and white balance. At least psnr_db().
[[nodiscard]] double psnr_corrected_db(const Image& rendered, const Image& truth);
/// SSIM, 11x11 Gaussian window of sigma 1.5, valid region only, K1 = 0.01, K2 = 0.03, mean over channels. A
/// window with anything that is not known is left out; NaN where all are. Error{kInput} when a side is below
/// 11 pixels.
[[nodiscard]] double ssim(const Image& rendered, const Image& truth);

/// FLIP (Andersson et al. 2020), mean over the pixels that are known: how different both look, 0 to 1, to who looks at 67
/// pixels a degree. NaN for other than three channels.
[[nodiscard]] double flip(const Image& rendered, const Image& truth);
/// Error{kInput} of `metric` unless both have one size, of sides of `min_side_px` or more, and the values for it.
void check_pair(const char* metric, const Image& rendered, const Image& truth, int min_side_px);

/// One simulated sweep beside the recorded one, ray by ray. Range 0 in `truth_range`: no return.
struct SweepComparison {
  std::vector<float> range;      // m, simulated
  std::vector<float> intensity;  // [0,1], simulated
  std::vector<float> drop;       // probability that the ray returns nothing, simulated
  std::vector<float> truth_range;
  std::vector<float> truth_intensity;
  std::vector<Eigen::Vector3f> origin;     // m, world from the scene origin
  std::vector<Eigen::Vector3f> direction;  // unit
};

struct SweepMetrics {
  double distance_median_m = 0.0;  // median |d^ - d| over returned rays
  double medl2_m2 = 0.0;           // median (d^ - d)^2 over returned rays
  double mean_rel_l2 = 0.0;        // mean ((d^ - d)/d)^2 over returned rays
  double intensity_rmse = 0.0;     // over returned rays
  double raydrop_accuracy = 0.0;   // over all rays, threshold 0.5
  double raydrop_trivial = 0.0;    // what "every ray returns" scores there
  double drop_recall = 0.0;        // share of the rays without a return that are said to drop
  double drop_precision = 0.0;     // share of the rays said to drop that have no return
  double chamfer_m2 = 0.0;         // (sum_P min |p-g|^2 + sum_G min |g-p|^2) / |G|
  double chamfer_m = 0.0;          // (mean_P min |p-g| + mean_G min |g-p|) / 2
};

/// Exact nearest neighbours (k-d tree). P: rays with drop <= 0.5; G: rays that returned. With no
/// predicted or no true point the Chamfer values are NaN, as are the medians with no returned ray, the recall
/// with no dropped one and the precision with none that is said to drop.
[[nodiscard]] SweepMetrics compare_sweep(const SweepComparison& sweep);

/// Mean of the two middle values when their number is even; NaN of nothing.
[[nodiscard]] double median(std::vector<double> values);

}  // namespace simuli
