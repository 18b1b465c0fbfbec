#include "optim/train/schedule.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/core/base/splitmix.hpp"
#include "host/device/render/train/adam.hpp"

namespace simuli {

std::uint64_t counter_hash(std::uint64_t seed, std::uint64_t stream, std::uint64_t counter) {
  return splitmix(splitmix(splitmix(seed) ^ stream) ^ counter);
}

FrameOrder::FrameOrder(std::vector<std::size_t> frames, std::uint64_t seed, std::uint64_t stream)
    : frames_(std::move(frames)), seed_(seed), stream_(stream) {
  if (!frames_.empty()) shuffle(0);
}

void FrameOrder::shuffle(std::uint64_t epoch) {
  epoch_ = epoch;
  shuffled_ = frames_;
  // Fisher-Yates shuffle. The modulo bias is at most frames / 2^64.
  for (std::size_t i = shuffled_.size(); i > 1; --i) {
    const std::uint64_t draw = counter_hash(seed_, stream_, epoch * frames_.size() + i - 1);
    std::swap(shuffled_[i - 1], shuffled_[draw % i]);
  }
}

std::size_t FrameOrder::at(std::uint64_t iteration) {
  const std::uint64_t epoch = iteration / frames_.size();
  if (epoch != epoch_) shuffle(epoch);
  return shuffled_[iteration % frames_.size()];
}

std::vector<double> row_epsilons(int sh_degree, double colour_epsilon) {
  std::vector<double> row(static_cast<std::size_t>(param_rows(sh_degree)), kAdamEpsilon);
  for (std::size_t k = 0; k < kLogScaleRow; ++k) row[k] += 0.1 * colour_epsilon;
  for (std::size_t k = kShRow; k < row.size(); ++k) row[k] += colour_epsilon;
  return row;
}

LearningRates paced(LearningRates rates, int iterations) {
  constexpr double kSettled = 1500.0, kMost = 3.0;
  rates.log_scale *= std::clamp(std::cbrt(kSettled / std::max(iterations, 1)), 1.0, kMost);
  return rates;
}

std::vector<double> row_rates(const LearningRates& rates, int sh_degree, double progress) {
  const double cooled = std::max(0.0, progress - (1.0 - kCoolDown)) / kCoolDown;
  const double last = 1.0 - (1.0 - rates.last_share) * cooled;
  const double share = last * std::pow(rates.final_share, progress);
  std::vector<double> row(static_cast<std::size_t>(param_rows(sh_degree)), share * rates.sh_rest);
  const auto set = [&row](int first, int count, double rate) {
    std::fill_n(row.begin() + first, count, rate);
  };
  set(kMeanRow, 3, last * rates.mean_m * std::pow(rates.mean_final_m / rates.mean_m, progress));
  set(kLogScaleRow, 3, share * rates.log_scale);
  set(kRotationRow, 4, share * rates.rotation);
  set(kOpacityRow, 1, share * rates.opacity);
  set(kShRow, 3, share * rates.sh);
  return row;
}

}  // namespace simuli
