#pragma once
#include <cstdint>

#include "host/scene/gaussians.hpp"
#include "host/scene/pose.hpp"
#include "host/sensors/camera.hpp"

namespace simuli::bench {

/// A street of `count` flattened Gaussians: road and pavements, two rows of facades, boxes and poles,
/// 180 m long, scales of 3 to 15 cm, opacities 0.1 to 0.95. The same bits for the same arguments.
[[nodiscard]] GaussianSet street_particles(SetKind kind,
                                           int sh_degree,
                                           Eigen::Index count,
                                           std::uint64_t seed);

/// Half-way down that street, 1.6 m up: camera looking along it, and LiDAR.
[[nodiscard]] Pose world_from_bench_camera();
[[nodiscard]] Pose world_from_bench_lidar();

/// 640 x 360 pixels, 80 degrees across.
[[nodiscard]] Camera bench_camera();

}  // namespace simuli::bench
