#pragma once
// Pictures of a rendered frame beside the recorded one.
#include <cstddef>
#include <vector>

#include "host/core/sensors/lidar_model.hpp"
#include "optim/eval/evaluation.hpp"

namespace simuli::cli {

/// Returns ranges as colours.
[[nodiscard]] PicturePair range_pictures(const LidarModel& lidar, const LidarPair& sweep);

/// Returns |rendered - recorded| of each pixel, averaged over the channels, kErrorGain times as bright.
[[nodiscard]] Image error_picture(const PicturePair& pair);
inline constexpr float kErrorGain = 4.0F;

/// Returns at most `count` of `frames`, evenly spaced.
[[nodiscard]] std::vector<std::size_t> some_of(const std::vector<std::size_t>& frames, std::size_t count);

}  // namespace simuli::cli
