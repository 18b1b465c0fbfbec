#pragma once
// Parts of a report.
#include <cstddef>
#include <vector>

#include "host/apps/cli/draw/html_report.hpp"
#include "host/core/sensors/lidar_model.hpp"
#include "host/device/render/scene/scene_on_device.hpp"
#include "optim/eval/evaluation.hpp"

namespace simuli::cli {

// Errors by frame and by range, as curves.

/// Adds errors along the drive, one curve per sensor, and errors by range to a report.
void add_curves(HtmlReport& html, const EvalReport& report);

// Report parts with a LiDAR that the recording lacks and sweeps as interactive clouds.

/// Adds the middle one of the compared sweeps as recorded and as rendered, and the points and ranges of another
/// LiDAR at that pose, in the rig's frame at the sweep's start. Adds nothing for a scene or a log without
/// LiDAR.
void add_sweep_cloud(HtmlReport& html, Evaluation& evaluation, SceneOnDevice& scene);

// Report part with views that were not recorded.

/// Adds views at the middle one of the compared frames: an interactive cloud of the recorded sweep, the
/// rendered sweep and another LiDAR; depth; the rig beside its lane; an actor removed and moved; a wide lens.
/// Leaves out parts that the scene lacks. `scene`: evaluation.scene() on a device.
void add_unrecorded(HtmlReport& html, Evaluation& evaluation, SceneOnDevice& scene);

// Pictures of a rendered frame beside the recorded one.

/// Returns ranges as colours.
[[nodiscard]] PicturePair range_pictures(const LidarModel& lidar, const LidarPair& sweep);

/// Returns |rendered - recorded| of each pixel, averaged over the channels, kErrorGain times as bright.
[[nodiscard]] Image error_picture(const PicturePair& pair);
inline constexpr float kErrorGain = 4.0F;

/// Returns at most `count` of `frames`, evenly spaced.
[[nodiscard]] std::vector<std::size_t> some_of(const std::vector<std::size_t>& frames, std::size_t count);

}  // namespace simuli::cli
