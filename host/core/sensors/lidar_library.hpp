#pragma once
// The built-in LiDAR models by name. A name may choose one of the sensor's modes of operation:
//   "hesai_xt32"        the first mode listed by `simuli info hesai_xt32`
//   "hesai_xt32@20"     the first mode at 20 turns per second
//   "ouster_os1_128@2048x10"  2048 columns at 10 turns per second
#include <string>
#include <vector>

#include "host/core/sensors/lidar.hpp"

namespace simuli {

/// A spin rate and the number of columns fired in one turn (or one pass of a partial field of view).
struct LidarMode {
  double spin_hz = 0.0;
  int columns = 0;
};

/// What is known of a model beside its geometry.
struct LidarFacts {
  std::string source;                  // where the numbers come from
  std::string licence;                 // under which terms the source offers them
  std::string note;                    // may be empty
  LidarMode mode;                      // of this model; spin_hz 0: not stated
  std::vector<LidarMode> modes;        // that the sensor offers, the default first; may be empty
  double divergence_horizontal = 0.0;  // rad, full angles; 0: unknown. The model's is their geometric mean
  double divergence_vertical = 0.0;    // rad
};

struct BuiltinLidar {
  Lidar model;
  LidarFacts facts;
};

/// A built-in model by name or "name@mode". Error{kUsage} naming the closest names for one that is not
/// there, and the sensor's modes for a mode that it has not.
[[nodiscard]] BuiltinLidar builtin_lidar_with_facts(const std::string& name);

/// The same sensor at that rate with that many columns: a beam that fires later fires where the head has turned
/// to by then, and a turn that began half a column behind the back does.
[[nodiscard]] Lidar in_mode(Lidar lidar, const LidarMode& mode);

}  // namespace simuli
