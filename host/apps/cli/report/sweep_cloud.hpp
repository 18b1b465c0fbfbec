#pragma once
// Report parts with a LiDAR that the recording lacks and sweeps as interactive clouds.
#include "host/apps/cli/draw/html_report.hpp"
#include "host/device/render/scene/scene_on_device.hpp"
#include "optim/eval/evaluation.hpp"

namespace simuli::cli {

/// Adds the middle one of the compared sweeps as recorded and as rendered, and the points and ranges of another
/// LiDAR at that pose, in the rig's frame at the sweep's start. Adds nothing for a scene or a log without
/// LiDAR.
void add_sweep_cloud(HtmlReport& html, Evaluation& evaluation, SceneOnDevice& scene);

}  // namespace simuli::cli
