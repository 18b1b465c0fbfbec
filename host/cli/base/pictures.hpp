#pragma once
// What renders look like: pictures of ranges, and several beside each other.
#include <array>
#include <vector>

#include "host/sensors/lidar_model.hpp"
#include "io/picture/image.hpp"

namespace simuli::cli {

/// `place` in [0, 1] of a scale of colours from pale and warm to dark and cold.
[[nodiscard]] std::array<float, 3> colour_at(double place);

/// Ranges as colours: warm near, cold far, on a logarithmic scale from range_min to range_max; black: no
/// return. Beams from top to bottom, each kBeam_px tall; firings from left to right as seen from the sensor.
/// Rays of a list stand where they point to, equally many pixels per rad both ways, the nearest in front.
[[nodiscard]] Image range_image(const LidarModel& lidar,
                                const LidarRays& rays,
                                const std::vector<float>& range);
inline constexpr int kBeam_px = 4;

enum class Layout { kBeside, kBelow };
/// Two pictures of the same height beside each other, or of the same width one below the other, with a gap.
[[nodiscard]] Image joined(const Image& first, const Image& second, Layout layout);

}  // namespace simuli::cli
