#include "optim/calibration/camera/luminance.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "io/log/camera_mask.hpp"

namespace simuli::calibration {

Luminance::Luminance(const Image& image) : width_(image.width), height_(image.height) {
  values_.resize(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      float& value = values_[index(x, y)];
      if (image.at(x, y, 0) == kHiddenValue) {
        value = std::numeric_limits<float>::quiet_NaN();
      } else if (image.channels < 3) {
        value = image.at(x, y, 0);
      } else {
        value = 0.299F * image.at(x, y, 0) + 0.587F * image.at(x, y, 1) + 0.114F * image.at(x, y, 2);
      }
    }
  }
}

bool Luminance::all_open() const {
  return std::none_of(values_.begin(), values_.end(), [](float value) { return std::isnan(value); });
}

Luminance Luminance::blurred(double sigma_px) const {
  const int reach = static_cast<int>(std::ceil(3.0 * sigma_px));
  std::vector<float> weight;
  float sum = 0.0F;
  for (int k = -reach; k <= reach; ++k) {
    weight.push_back(static_cast<float>(std::exp(-0.5 * k * k / (sigma_px * sigma_px))));
    sum += weight.back();
  }
  for (float& w : weight) w /= sum;
  const auto along = [&](const Luminance& from, int step_x, int step_y) {
    Luminance to = from;
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x) {
        float value = 0.0F;
        for (int k = -reach; k <= reach; ++k) {
          value +=
              weight[static_cast<std::size_t>(k + reach)] *
              from.at(std::clamp(x + k * step_x, 0, width_ - 1), std::clamp(y + k * step_y, 0, height_ - 1));
        }
        to.values_[index(x, y)] = value;
      }
    }
    return to;
  };
  return along(along(*this, 1, 0), 0, 1);
}

}  // namespace simuli::calibration
