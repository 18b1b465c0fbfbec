#pragma once
// Name and clock of a scene for simulators, equal in archives and in the server.
#include <cstdint>
#include <filesystem>
#include <string>

#include "host/core/sensors/trajectory.hpp"

namespace simuli {

/// Returns the name of a scene's folder or file without the extension.
[[nodiscard]] std::string scene_id_of(std::filesystem::path path);

/// Converts times to whole microseconds from the log's start; if the trajectory begins before it, from a whole
/// number of seconds before it, so that all times of the trajectory are non-negative.
class SceneClock {
 public:
  SceneClock() = default;
  /// The trajectory may be empty.
  explicit SceneClock(const Trajectory& world_from_rig);

  /// Earlier times become 0.
  [[nodiscard]] std::uint64_t microseconds(double time_s) const;
  /// time_us: at most 2^52, which a double represents exactly.
  [[nodiscard]] double seconds(std::uint64_t time_us) const;

 private:
  std::int64_t start_us_ = 0;  // in the log's clock; at most 0
};

}  // namespace simuli
