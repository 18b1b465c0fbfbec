#pragma once
// Pictures that show a scene's frame beside the recorded one.
#include <cstddef>
#include <vector>

#include "host/core/sensors/lidar_model.hpp"
#include "optim/eval/evaluation.hpp"

namespace simuli::cli {

/// Ranges as colours.
[[nodiscard]] PicturePair range_pictures(const LidarModel& lidar, const LidarPair& sweep);

/// |rendered - recorded| of each pixel, mean over the channels, kErrorGain times as bright.
[[nodiscard]] Image error_picture(const PicturePair& pair);
inline constexpr float kErrorGain = 4.0F;

/// At most `count` of `frames`, evenly spread.
[[nodiscard]] std::vector<std::size_t> some_of(const std::vector<std::size_t>& frames, std::size_t count);

}  // namespace simuli::cli
