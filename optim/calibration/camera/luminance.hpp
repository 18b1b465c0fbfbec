#pragma once
// Pictures as calibration looks at them: one number per pixel, NaN where a mask hides it (kHiddenValue).
#include <cstddef>
#include <vector>

#include "io/picture/image.hpp"

namespace simuli::calibration {

class Luminance {
 public:
  Luminance() = default;
  explicit Luminance(const Image& image);
  /// Blurred by a Gaussian of sigma_px > 0; beyond the border the picture goes on as its last pixels. What
  /// anything hidden would flow into is hidden, too.
  [[nodiscard]] Luminance blurred(double sigma_px) const;
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] float at(int x, int y) const { return values_[index(x, y)]; }
  /// Whether nothing is hidden.
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
