#pragma once
#include "host/core/base/pose.hpp"
#include "host/core/scene/gaussians.hpp"
#include "host/core/sensors/camera.hpp"
#include "host/device/render/scene/sensor_rays.hpp"

namespace simuli::bench {

/// Returns a pose half-way along the street of bench/particles/particle_street.hpp, 1.6 m high, with a view
/// along the street.
[[nodiscard]] Pose world_from_bench_camera();

/// Returns the pose of the bench camera or of the street's LiDAR.
[[nodiscard]] Pose world_from_bench_sensor(SetKind kind);

/// Returns a camera of 640 x 360 pixels with a horizontal field of view of 80 degrees.
[[nodiscard]] Camera bench_camera();

/// Returns the rays of the bench camera or of a generic64.
[[nodiscard]] SensorRays bench_rays(const Device& device, SetKind kind, const RenderOptions& options);

}  // namespace simuli::bench
