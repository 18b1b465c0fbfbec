#pragma once
// Pictures for calibration: one number per pixel, NaN where masked (kHiddenValue).
#include <cstddef>
#include <vector>

#include "io/picture/image.hpp"

namespace simuli::calibration {

class Luminance {
 public:
  Luminance() = default;
  explicit Luminance(const Image& image);
  /// Returns the picture blurred by a Gaussian of sigma_px > 0, with extended borders. Pixels that masked ones
  /// would affect are masked.
  [[nodiscard]] Luminance blurred(double sigma_px) const;
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] float at(int x, int y) const { return values_[index(x, y)]; }
  /// Whether no pixel is masked.
  [[nodiscard]] bool all_open() const;
  /// [height][width], top row first.
  [[nodiscard]] const float* data() const { return values_.data(); }

 private:
  [[nodiscard]] std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  }

  int width_ = 0;
  int height_ = 0;
  std::vector<float> values_;
};

}  // namespace simuli::calibration
