#pragma once
// Kernel constants of a sensor in one frame.
#include <array>

#include "cl/shared/sensor_constants.h"
#include "host/core/scene/ray_drop.hpp"
#include "host/device/render/scene/sensor_rays.hpp"

namespace simuli {

struct SensorInFrame {
  shared::SensorConstants<double> constants{};
  bool moving = false;  // start and end differ
};

/// Returns the constants of one frame: model, poses, cuts, background, ray-drop function.
[[nodiscard]] SensorInFrame sensor_in_frame(const SensorRays& rays,
                                            const Pose& scene_from_sensor_start,
                                            const Pose& scene_from_sensor_end,
                                            const RenderOptions& options,
                                            const std::array<float, 3>& background,
                                            const RayDrop::Parameters& drop);

}  // namespace simuli
