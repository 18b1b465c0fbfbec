#pragma once
// LiDARs of a report that no recording has, and sweeps as points to turn.
#include "host/apps/cli/draw/html_report.hpp"
#include "host/device/render/scene/scene_on_device.hpp"
#include "optim/eval/evaluation.hpp"

namespace simuli::cli {

/// A part of a report: the sweep in the middle of the compared ones as recorded and as rendered, and what
/// another LiDAR sees from there, in the rig's frame at the sweep's start; that LiDAR's ranges. Nothing of a
/// scene, or a log, without LiDAR.
void add_sweep_cloud(HtmlReport& html, Evaluation& evaluation, SceneOnDevice& scene);

}  // namespace simuli::cli
