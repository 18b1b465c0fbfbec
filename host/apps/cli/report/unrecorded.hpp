#pragma once
// The part of a report that no recording has.
#include "host/apps/cli/draw/html_report.hpp"
#include "host/device/render/scene/scene_on_device.hpp"
#include "optim/eval/evaluation.hpp"

namespace simuli::cli {

/// Of a frame in the middle of the compared ones: a point cloud to turn, of the recorded sweep, the same
/// rendered and another LiDAR; depth; the rig beside its lane; an actor gone and moved; a wide lens. What is
/// not in the scene is left out. `scene`: evaluation.scene() on a device.
void add_unrecorded(HtmlReport& html, Evaluation& evaluation, SceneOnDevice& scene);

}  // namespace simuli::cli
