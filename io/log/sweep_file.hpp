#pragma once
// The two halves of read_sweep(): what a file holds, and what a LiDAR's model makes of it.
#include <cstddef>
#include <filesystem>
#include <string>

#include "io/log/log.hpp"

namespace simuli {

/// What a LiDAR's sweeps must be.
struct SweepShape {
  std::string lidar;
  std::size_t rows = 0, columns = 0;
};
[[nodiscard]] SweepShape sweep_shape(const LidarModel& lidar);

/// Ranges as recorded. Error{kInput} as read_sweep().
[[nodiscard]] Sweep read_recorded_sweep(const std::filesystem::path& file, const SweepShape& shape);
/// Ranges as distances: without the rows' biases, and without returns from the vehicle itself.
/// Error{kInput} naming `file` when one is not above 0 then.
[[nodiscard]] Sweep as_measured(Sweep recorded, const std::filesystem::path& file, const LidarModel& lidar);

}  // namespace simuli
