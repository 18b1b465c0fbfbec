#pragma once
// A LiDAR of either kind: with rows (host/core/sensors/lidar.hpp) or as a list of rays
// (host/core/sensors/ray_list.hpp).
#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <variant>

#include "host/core/sensors/lidar.hpp"
#include "host/core/sensors/ray_list.hpp"

namespace simuli {

using LidarModel = std::variant<Lidar, RayList>;

[[nodiscard]] const std::string& name_of(const LidarModel& model);
/// Rows and columns of its sweeps on disk and in memory: a list is one row of all its rays.
[[nodiscard]] std::size_t row_count(const LidarModel& model);
[[nodiscard]] std::size_t ray_count(const LidarModel& model);
/// Nearest and farthest return, m.
[[nodiscard]] double range_min(const LidarModel& model);
[[nodiscard]] double range_max(const LidarModel& model);

/// Seconds that one frame takes.
[[nodiscard]] double sweep_s(const LidarModel& model);

/// The rays of one frame as the model has them.
[[nodiscard]] LidarRays nominal_rays(const LidarModel& model);
/// Origin of a ray in the sensor frame, m; `rays` are the model's nominal or measured ones.
[[nodiscard]] Eigen::Vector3d ray_origin(const LidarModel& model, const LidarRays& rays, std::size_t ray);
/// Whether nothing can return from a ray of the model: is_blind() of a Lidar's; no ray of a list is.
[[nodiscard]] bool is_blind(const LidarModel& model, const LidarRays& rays, std::size_t ray);
/// Whether what a ray returns is of the vehicle itself (BlindArc::own_returns), and no part of any scene.
[[nodiscard]] bool hits_ego_vehicle(const LidarModel& model, const LidarRays& rays, std::size_t ray);
/// Distances are how far light went: what particles are made of and compared with (Sweep). What a sensor
/// states of them, in its files and in LidarFrame, is off by its row's range bias. m, of a ray that returned.
[[nodiscard]] float stated_range(const LidarModel& model,
                                 const LidarRays& rays,
                                 std::size_t ray,
                                 float distance_m);
[[nodiscard]] float distance_of(const LidarModel& model,
                                const LidarRays& rays,
                                std::size_t ray,
                                float stated_range_m);
/// The list with measured angles and times instead of its own.
[[nodiscard]] RayList with_rays(RayList list, const LidarRays& rays);

void validate(const LidarModel& model, const std::string& file);

}  // namespace simuli
