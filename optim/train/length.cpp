#include "optim/train/length.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

namespace simuli {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kStageValues = 5;
constexpr int kFewestIterations = 100;  // learning rates do not decay in fewer

/// Returns the mean of the finite values; NaN without any.
double mean_of(const std::vector<double>& values) {
  double sum = 0.0, count = 0.0;
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    sum += value;
    count += 1.0;
  }
  return sum / count;
}

}  // namespace

TrainLength::TrainLength(const LengthOptions& options,
                         std::size_t epoch,
                         std::size_t images,
                         std::size_t sweeps)
    : options_(options), squares_(images, kNaN), losses_(sweeps, kNaN) {
  const double wanted =
      std::max<double>(kFewestIterations, std::ceil(options.first_epochs * static_cast<double>(epoch)));
  first_ = static_cast<int>(std::min<double>(wanted, options.most));
}

int TrainLength::end_stage(int iterations) {
  LengthStage stage{iterations, mean_of(squares_), mean_of(losses_), kNaN, kNaN};
  bool goes_on = true;
  if (!stages_.empty()) {
    const LengthStage& before = stages_.back();
    const double doublings = std::log2(static_cast<double>(iterations) / before.iterations);
    stage.gain_db = 10.0 * std::log10(before.square / stage.square) / doublings;
    stage.gain_share = 1.0 - std::pow(stage.lidar_loss / before.lidar_loss, 1.0 / doublings);
    goes_on = stage.gain_db >= options_.gain_db || stage.gain_share >= options_.gain_share;
  }
  stages_.push_back(stage);
  if (!goes_on || iterations >= options_.most) return 0;
  return std::min(options_.most, static_cast<int>(std::ceil(options_.growth * iterations)));
}

std::vector<double> TrainLength::state() const {
  std::vector<double> out = squares_;
  out.insert(out.end(), losses_.begin(), losses_.end());
  for (const LengthStage& s : stages_) {
    const double stage[kStageValues] = {
        static_cast<double>(s.iterations), s.square, s.lidar_loss, s.gain_db, s.gain_share};
    out.insert(out.end(), std::begin(stage), std::end(stage));
  }
  return out;
}

bool TrainLength::set_state(std::span<const double> state) {
  const std::size_t frames = squares_.size() + losses_.size();
  if (state.size() < frames || (state.size() - frames) % kStageValues != 0) return false;
  const auto squares = state.first(squares_.size()), losses = state.subspan(squares.size(), losses_.size());
  squares_.assign(squares.begin(), squares.end());
  losses_.assign(losses.begin(), losses.end());
  stages_.clear();
  for (std::size_t i = frames; i < state.size(); i += kStageValues) {
    stages_.push_back({static_cast<int>(state[i]), state[i + 1], state[i + 2], state[i + 3], state[i + 4]});
  }
  return true;
}

}  // namespace simuli
