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
/// Smallest and largest range, m.
[[nodiscard]] double range_min(const LidarModel& model);
[[nodiscard]] double range_max(const LidarModel& model);

/// Duration of a frame in seconds.
[[nodiscard]] double sweep_s(const LidarModel& model);

/// The nominal rays of one frame.
[[nodiscard]] LidarRays nominal_rays(const LidarModel& model);
/// Origin of a ray in the sensor frame, m; `rays` are nominal or measured.
[[nodiscard]] Eigen::Vector3d ray_origin(const LidarModel& model, const LidarRays& rays, std::size_t ray);
/// Whether a ray cannot return: is_blind() of a Lidar; never for a list.
[[nodiscard]] bool is_blind(const LidarModel& model, const LidarRays& rays, std::size_t ray);
/// Whether a ray's returns belong to the ego vehicle (BlindArc::own_returns) and to no scene.
[[nodiscard]] bool hits_ego_vehicle(const LidarModel& model, const LidarRays& rays, std::size_t ray);
/// Converts between true distances, which particles are made of and compared with (Sweep), and the ranges that
/// the sensor reports in its files and in LidarFrame, which include the row's range bias. m, for a returned
/// ray.
[[nodiscard]] float stated_range(const LidarModel& model,
                                 const LidarRays& rays,
                                 std::size_t ray,
                                 float distance_m);
[[nodiscard]] float distance_of(const LidarModel& model,
                                const LidarRays& rays,
                                std::size_t ray,
                                float stated_range_m);
/// Returns the list with measured angles and times.
[[nodiscard]] RayList with_rays(RayList list, const LidarRays& rays);

void validate(const LidarModel& model, const std::string& file);

}  // namespace simuli
