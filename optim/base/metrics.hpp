#pragma once
// Metrics of METHOD section 13, in double on the host. Names contain the units.
#include <Eigen/Core>
#include <vector>

#include "io/picture/image.hpp"

namespace simuli {

/// Returns the peak signal-to-noise ratio in dB of pictures in [0,1] of equal size; +inf for identical
/// pictures. Negative values in `truth` are unknown (camera_mask.hpp) and ignored; NaN when all are.
[[nodiscard]] double psnr_db(const Image& rendered, const Image& truth);
/// kQuadratic also models another camera's tone curve.
enum class Tone { kAffine, kQuadratic };
/// Returns `rendered` after the colour transform (3 x 4 on three channels and 1; kQuadratic 3 x 7, also on
/// their squares) that is nearest to `truth` in least squares, clipped to [0,1]; known pixels have the weight
/// `weight[pixel]`, or 1 without weights.
[[nodiscard]] Image colour_corrected(const Image& rendered,
                                     const Image& truth,
                                     const std::vector<float>& weight = {},
                                     Tone tone = Tone::kAffine);
/// psnr_db() of colour_corrected(): independent of exposure and white balance. At least psnr_db().
[[nodiscard]] double psnr_corrected_db(const Image& rendered, const Image& truth);
/// Returns SSIM: 11x11 Gaussian window of sigma 1.5, valid region only, K1 = 0.01, K2 = 0.03, mean over
/// channels. Ignores windows with unknown pixels; NaN when all have some. Throws Error{kInput} when a side is
/// below 11 pixels.
[[nodiscard]] double ssim(const Image& rendered, const Image& truth);

/// Returns FLIP (Andersson et al. 2020), the mean over known pixels of the visible difference, 0 to 1, at 67
/// pixels per degree. NaN for other than three channels.
[[nodiscard]] double flip(const Image& rendered, const Image& truth);
/// Throws Error{kInput} with `metric` unless both pictures have the same size, sides of at least `min_side_px`,
/// and matching values.
void check_pair(const char* metric, const Image& rendered, const Image& truth, int min_side_px);

/// A simulated and a recorded sweep, ray by ray. Range 0 in `truth_range`: no return.
struct SweepComparison {
  std::vector<float> range;      // m, simulated
  std::vector<float> intensity;  // [0,1], simulated
  std::vector<float> drop;  // simulated ray-drop probability
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
  double raydrop_trivial = 0.0;  // accuracy of predicting that every ray returns
  double drop_recall = 0.0;  // share of rays without return that are predicted to drop
  double drop_precision = 0.0;  // share of predicted drops without return
  double chamfer_m2 = 0.0;         // (sum_P min |p-g|^2 + sum_G min |g-p|^2) / |G|
  double chamfer_m = 0.0;          // (mean_P min |p-g| + mean_G min |g-p|) / 2
};

/// Uses exact nearest neighbours (k-d tree). P: rays with drop <= 0.5; G: rays that returned. NaN: Chamfer
/// values without predicted or true points, medians without returned rays, recall without dropped rays,
/// precision without predicted drops.
[[nodiscard]] SweepMetrics compare_sweep(const SweepComparison& sweep);

/// Returns the mean of the two middle values for an even number; NaN without values.
[[nodiscard]] double median(std::vector<double> values);

}  // namespace simuli
