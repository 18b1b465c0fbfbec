#pragma once
// Sweeps of nuScenes' HDL-32E. For io/import/nuscenes/nuscenes.cpp and tests.
#include <filesystem>
#include <string>
#include <vector>

#include "io/log/log.hpp"

namespace simuli::nuscenes {

/// The sensor of these files, in the data set's frame (x right, y forward): the built-in beam table, and as
/// many firings as all of them have; the one or two more that some have are not imported.
[[nodiscard]] Lidar lidar_of(const std::vector<std::filesystem::path>& files, const std::string& name);

/// A file's firing grid: float32 x y z intensity ring, 32 beams a firing, the lowest first. The points are
/// stored as seen from the end of the turn; `start_from_end`, how the sensor moved during it, takes that off.
/// Error{kInput} for other sizes and rings, NaN, Inf.
[[nodiscard]] Sweep read_turn(const std::filesystem::path& file,
                              const Lidar& lidar,
                              const Pose& start_from_end);

}  // namespace simuli::nuscenes
