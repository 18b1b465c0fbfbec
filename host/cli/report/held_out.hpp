#pragma once
// Frames that training did not see, as the scene renders them, beside what was recorded.
#include <cstddef>
#include <vector>

#include "host/cli/base/pictures.hpp"
#include "host/render/scene/scene_on_device.hpp"
#include "io/log/log.hpp"
#include "io/picture/image.hpp"
#include "optim/eval/evaluate.hpp"

namespace simuli::cli {

/// Two pictures of one size.
struct PicturePair {
  Image rendered;
  Image recorded;
};

/// Frame `index` of log.images at options.image_scale.
[[nodiscard]] PicturePair camera_pair(SceneOnDevice& scene,
                                      const Log& log,
                                      std::size_t index,
                                      const EvalOptions& options);

/// Frame `index` of log.sweeps.
struct SweepPictures {
  LidarFrame rendered;
  Sweep recorded;
  /// Ranges as colours.
  PicturePair ranges;
};
[[nodiscard]] SweepPictures sweep_pair(SceneOnDevice& scene, const Log& log, std::size_t index);

/// |rendered - recorded| of each pixel, mean over the channels, kErrorGain times as bright.
[[nodiscard]] Image error_picture(const PicturePair& pair);
inline constexpr float kErrorGain = 4.0F;

/// Both sweeps from above, in the sensor's frame, forward to the right, `radius_m` to each side: recorded
/// returns blue, simulated ones orange, white where both are.
[[nodiscard]] Image birds_eye(const LidarModel& lidar, const SweepPictures& sweep, double radius_m);

/// At most `count` of `frames`, evenly spread.
[[nodiscard]] std::vector<std::size_t> some_of(const std::vector<std::size_t>& frames, std::size_t count);

}  // namespace simuli::cli
