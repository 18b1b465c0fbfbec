#pragma once
// Pictures of LiDAR ranges, and pictures side by side.
#include <array>
#include <vector>

#include "host/core/sensors/lidar_model.hpp"
#include "io/picture/image.hpp"

namespace simuli::cli {

/// Returns the colour at `place` in [0, 1] of a scale from light and warm to dark and cold.
[[nodiscard]] std::array<float, 3> colour_at(double place);

/// Returns ranges as colours on a logarithmic scale from range_min (warm) to range_max (cold); black: no
/// return; SweepCanvas::kNoRay: no ray, or a ray that the ego vehicle blocks. Near ranges are drawn over far
/// ranges.
[[nodiscard]] Image range_image(const LidarModel& lidar,
                                const LidarRays& rays,
                                const std::vector<float>& range);

/// Returns |range - truth| of rays with a return in both, as error_colour() of its share of kFullError_m;
/// blue: a return only in `truth`; green: a return only in `range`. Other rays as in range_image().
[[nodiscard]] Image range_error_image(const LidarModel& lidar,
                                      const LidarRays& rays,
                                      const std::vector<float>& range,
                                      const std::vector<float>& truth);
inline constexpr float kFullError_m = 1.0F;

/// Returns a colour from black for 0 to light for 1 and above.
[[nodiscard]] std::array<float, 3> error_colour(float error);

enum class Layout { kBeside, kBelow };
/// Returns two pictures of the same height side by side, or of the same width one below the other, with a
/// gap.
[[nodiscard]] Image joined(const Image& first, const Image& second, Layout layout);

}  // namespace simuli::cli
