#pragma once
// The two steps of read_sweep(): reading a file, and applying the LiDAR's model to it.
#include <cstddef>
#include <filesystem>
#include <string>

#include "io/log/log.hpp"

namespace simuli {

/// The size of a LiDAR's sweeps.
struct SweepShape {
  std::string lidar;
  std::size_t rows = 0, columns = 0;
};
[[nodiscard]] SweepShape sweep_shape(const LidarModel& lidar);

/// Reads a sweep with its ranges as recorded. Error{kInput} as read_sweep().
[[nodiscard]] Sweep read_recorded_sweep(const std::filesystem::path& file, const SweepShape& shape);
/// Converts recorded ranges to distances: subtracts the range biases of the rows and removes returns from the ego
/// vehicle. Error{kInput} naming `file` if a distance is not above 0.
[[nodiscard]] Sweep as_measured(Sweep recorded, const std::filesystem::path& file, const LidarModel& lidar);

}  // namespace simuli
