#pragma once
// The built-in LiDAR models by name. A name may select one of the sensor's modes:
//   "hesai_xt32"        the first mode listed by `simuli info hesai_xt32`
//   "hesai_xt32@20"     the first mode at 20 revolutions per second
//   "ouster_os1_128@2048x10"  2048 columns at 10 revolutions per second
#include <string>
#include <vector>

#include "host/core/sensors/lidar.hpp"

namespace simuli {

/// A spin rate and the number of columns per revolution (or per pass of a partial field of view).
struct LidarMode {
  double spin_hz = 0.0;
  int columns = 0;
};

/// Facts about a model in addition to its geometry.
struct LidarFacts {
  std::string source;                  // where the numbers come from
  std::string licence;  // licence of the source
  std::string note;                    // may be empty
  LidarMode mode;  // of this model; spin_hz 0: unknown
  std::vector<LidarMode> modes;  // of the sensor, the default first; may be empty
  double divergence_horizontal = 0.0;  // rad, full angles; 0: unknown. The model uses their geometric mean
  double divergence_vertical = 0.0;    // rad
};

struct BuiltinLidar {
  Lidar model;
  LidarFacts facts;
};

/// Returns a built-in model by "name" or "name@mode". Throws Error{kUsage} with similar names, or with the
/// sensor's modes for an unknown mode.
[[nodiscard]] BuiltinLidar builtin_lidar_with_facts(const std::string& name);

/// Returns the sensor at that rate with that many columns: beams with a time offset fire at the head's angle at
/// that time, and a sweep that began half a column after the back still does.
[[nodiscard]] Lidar in_mode(Lidar lidar, const LidarMode& mode);

}  // namespace simuli
