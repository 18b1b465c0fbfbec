#pragma once
// Comparison of support with the errors that it predicts.
#include <array>
#include <cstddef>
#include <vector>

#include "host/device/render/scene/scene_on_device.hpp"
#include "host/device/support/support.hpp"
#include "io/log/log.hpp"

namespace simuli {

/// Whether a camera was trained on. A scene cannot know exposure and white balance of other cameras: their
/// errors are measured after removing the affine colour transform fitted to the supported pixels.
enum class Tint { kKnown, kUnknown };

/// Mean absolute difference over the channels of a pixel.
[[nodiscard]] double colour_error(const Image& rendered, const Image& truth, std::size_t pixel);

/// Support and error of sampled pixels or rays.
struct SupportSamples {
  std::vector<float> support;  // [n] in [0, 1]
  std::vector<float> error;  // [n] of a colour: mean of its channels; of a ray: m
  /// Adds every `step`-th sample of a recorded picture, at the camera's size, or of a sweep; a missing or
  /// spurious return counts as an error of kNoReturn_m. Throws Error{kInput} when a file cannot be read.
  void add_picture(SceneOnDevice& scene,
                   SupportOnDevice& support_on,
                   const Log& log,
                   const ImageFrame& frame,
                   const Camera& camera,
                   std::size_t step = 1,
                   Tint tint = Tint::kKnown);
  void add_sweep(SceneOnDevice& scene,
                 SupportOnDevice& support_on,
                 const Log& log,
                 const SweepFrame& frame,
                 std::size_t step = 1);
  void append(const SupportSamples& others);
  static constexpr float kNoReturn_m = 100.0F;
};

struct SupportReliability {
  /// Samples with support in [k / 10, (k + 1) / 10).
  struct Bin {
    std::size_t count = 0;
    double support = 0.0;  // mean
    double right = 0.0;  // share with an error below the limit
    double error = 0.0;    // mean
  };
  static constexpr std::size_t kBins = 10;
  std::size_t count = 0;
  double rank_correlation = 0.0;  // Spearman's, of support and negative error; 0 without variation
  double mean_support = 0.0, right = 0.0;
  double calibration_error = 0.0;  // mean of |support - right| over the bins, weighted by count
  std::array<Bin, kBins> bins{};
};
/// `limit`: kSupportColour or kSupportRange_m.
[[nodiscard]] SupportReliability reliability(const SupportSamples& samples, double limit);

}  // namespace simuli
