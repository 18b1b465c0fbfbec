#pragma once
// Support beside the errors that it estimates.
#include <array>
#include <cstddef>
#include <vector>

#include "host/device/render/scene/scene_on_device.hpp"
#include "host/device/support/support.hpp"
#include "io/log/log.hpp"

namespace simuli {

/// Whether training saw a camera's pictures. Of one that it never saw no scene can know exposure and white balance:
/// its errors are told once the affine transform of colours in which the supported pixels agree has been taken off.
enum class Tint { kKnown, kUnknown };

/// Mean of |channels| of a pixel.
[[nodiscard]] double colour_error(const Image& rendered, const Image& truth, std::size_t pixel);

/// What support said of pixels or rays, and how wrong they were.
struct SupportSamples {
  std::vector<float> support;  // [n] in [0, 1]
  std::vector<float> error;    // [n] of a colour the mean of its channels; of a ray m
  /// Adds those of a recorded picture, at the camera's size, or of a sweep: a ray that returns where none
  /// does, or the other way round, is off by kNoReturn_m. Every `step`-th of them. Error{kInput} when a file
  /// can't be read.
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
  /// Of those whose support is in [k / 10, (k + 1) / 10).
  struct Bin {
    std::size_t count = 0;
    double support = 0.0;  // mean
    double right = 0.0;    // share whose error is below the limit
    double error = 0.0;    // mean
  };
  static constexpr std::size_t kBins = 10;
  std::size_t count = 0;
  double rank_correlation = 0.0;  // Spearman's, of support and the error's opposite; 0 without a difference
  double mean_support = 0.0, right = 0.0;
  double calibration_error = 0.0;  // mean of |support - right| over the bins, by their counts
  std::array<Bin, kBins> bins{};
};
/// `limit`: kSupportColour or kSupportRange_m.
[[nodiscard]] SupportReliability reliability(const SupportSamples& samples, double limit);

}  // namespace simuli
