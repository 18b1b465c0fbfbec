#pragma once
#include "host/core/base/pose.hpp"
#include "host/core/scene/gaussians.hpp"
#include "host/core/sensors/camera.hpp"
#include "host/device/render/scene/sensor_rays.hpp"

namespace simuli::bench {

/// Half-way down the street of bench/particles/particle_street.hpp, 1.6 m up, looking along it.
[[nodiscard]] Pose world_from_bench_camera();

/// That, or where the street's LiDAR is.
[[nodiscard]] Pose world_from_bench_sensor(SetKind kind);

/// 640 x 360 pixels, 80 degrees across.
[[nodiscard]] Camera bench_camera();

/// Rays of that camera, or of a generic64.
[[nodiscard]] SensorRays bench_rays(const Device& device, SetKind kind, const RenderOptions& options);

}  // namespace simuli::bench
