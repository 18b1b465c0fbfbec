#pragma once
// What simulators know a scene by: its name and its clock, the same in an archive as over the wire.
#include <cstdint>
#include <filesystem>
#include <string>

#include "host/core/sensors/trajectory.hpp"

namespace simuli {

/// The name of a scene's folder or file without the extension.
[[nodiscard]] std::string scene_id_of(std::filesystem::path path);

/// Whole microseconds from the log's start; where the path begins before it, from a whole number of seconds
/// before it, so that no time of the path is negative.
class SceneClock {
 public:
  SceneClock() = default;
  /// Of a path that may be empty.
  explicit SceneClock(const Trajectory& world_from_rig);

  /// Of earlier times 0.
  [[nodiscard]] std::uint64_t microseconds(double time_s) const;
  /// time_us: at most 2^52, which is exact in a double.
  [[nodiscard]] double seconds(std::uint64_t time_us) const;

 private:
  std::int64_t start_us_ = 0;  // at or below 0: of the log's clock
};

}  // namespace simuli
