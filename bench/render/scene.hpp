#pragma once
#include "host/scene/pose.hpp"
#include "host/sensors/camera.hpp"

namespace simuli::bench {

/// Half-way down the street of host/scene/particle_street.hpp, 1.6 m up, looking along it.
[[nodiscard]] Pose world_from_bench_camera();

/// 640 x 360 pixels, 80 degrees across.
[[nodiscard]] Camera bench_camera();

}  // namespace simuli::bench
