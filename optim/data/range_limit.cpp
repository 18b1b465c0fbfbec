#include <algorithm>
#include <cmath>
#include <variant>
#include <vector>

#include "io/log/frame_files.hpp"
#include "optim/base/frames.hpp"
#include "optim/data/sensor_learning.hpp"

namespace simuli {
namespace {

constexpr double kLast_m = 1.0;
constexpr std::size_t kFewest = 50;  // returns in the last metre
constexpr double kLeastShare = 0.5;  // relative to the metre before
constexpr double kStep_m = 0.1;      // limits are rounded

}  // namespace

std::optional<double> find_range_limit(const Log& log, const LogLidar& lidar, const FrameSelection& frames) {
  std::vector<float> far;  // returns in the last two metres so far
  float largest = 0.0F;
  for (const std::size_t index : HeldOutRule(log, frames).training(log.sweeps)) {
    const SweepFrame& frame = log.sweeps[index];
    if (frame.lidar != name_of(lidar.model)) continue;
    const Sweep sweep = read_sweep(log, frame, lidar.model);
    for (const float range : sweep.range) largest = std::max(largest, range);
    const double nearest = static_cast<double>(largest) - 2.0 * kLast_m;
    const auto is_near = [nearest](float range) { return range == 0.0F || range < nearest; };
    far.insert(far.end(), sweep.range.begin(), sweep.range.end());
    far.erase(std::remove_if(far.begin(), far.end(), is_near), far.end());
  }
  const auto last = static_cast<std::size_t>(std::count_if(
      far.begin(), far.end(), [&](float range) { return range >= static_cast<double>(largest) - kLast_m; }));
  const std::size_t before = far.size() - last;
  if (last < kFewest || static_cast<double>(last) < kLeastShare * static_cast<double>(before)) return {};
  return kStep_m * (std::floor(static_cast<double>(largest) / kStep_m) + 1.0);
}

Log with_range_limit(Log log, const FrameSelection& frames) {
  for (LogLidar& lidar : log.lidars) {
    const std::optional<double> limit = find_range_limit(log, lidar, frames);
    if (!limit) continue;
    std::visit([&](auto& model) { model.range_max = std::min(model.range_max, *limit); }, lidar.model);
  }
  return log;
}

}  // namespace simuli
