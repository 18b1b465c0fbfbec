#pragma once
// What renders look like: pictures of ranges, and several beside each other.
#include <array>
#include <vector>

#include "host/core/sensors/lidar_model.hpp"
#include "io/picture/image.hpp"

namespace simuli::cli {

/// `place` in [0, 1] of a scale of colours from pale and warm to dark and cold.
[[nodiscard]] std::array<float, 3> colour_at(double place);

/// Ranges as colours: warm near, cold far, on a logarithmic scale from range_min to range_max; black: no
/// return; SweepCanvas::kNoRay: there is no ray, or none that gets past the vehicle. The nearest in front.
[[nodiscard]] Image range_image(const LidarModel& lidar,
                                const LidarRays& rays,
                                const std::vector<float>& range);

/// |range - truth| of rays that return in both, as error_colour() of its share of kFullError_m; blue: they
/// return in truth alone; green: not in truth. Else as range_image().
[[nodiscard]] Image range_error_image(const LidarModel& lidar,
                                      const LidarRays& rays,
                                      const std::vector<float>& range,
                                      const std::vector<float>& truth);
inline constexpr float kFullError_m = 1.0F;

/// From black for 0 to pale for 1 and more.
[[nodiscard]] std::array<float, 3> error_colour(float error);

enum class Layout { kBeside, kBelow };
/// Two pictures of the same height beside each other, or of the same width one below the other, with a gap.
[[nodiscard]] Image joined(const Image& first, const Image& second, Layout layout);

}  // namespace simuli::cli
