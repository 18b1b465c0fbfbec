#pragma once
// Report part with views that were not recorded.
#include "host/apps/cli/draw/html_report.hpp"
#include "host/device/render/scene/scene_on_device.hpp"
#include "optim/eval/evaluation.hpp"

namespace simuli::cli {

/// Adds views at the middle one of the compared frames: an interactive cloud of the recorded sweep, the
/// rendered sweep and another LiDAR; depth; the rig beside its lane; an actor removed and moved; a wide lens.
/// Leaves out parts that the scene lacks. `scene`: evaluation.scene() on a device.
void add_unrecorded(HtmlReport& html, Evaluation& evaluation, SceneOnDevice& scene);

}  // namespace simuli::cli
