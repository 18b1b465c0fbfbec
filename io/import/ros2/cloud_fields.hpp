#pragma once
// Fields of PointCloud2 by the names that LiDAR drivers use:
//   time    time       float32  s after the stamp        Velodyne; simuli
//           t          uint32   ns after the stamp       Ouster
//           time_stamp uint32   ns after the stamp       Nebula (Autoware)
//           offset_time uint32  ns after the stamp       Livox
//           timestamp  float64  s to ns since 1970       Hesai, RoboSense (s), Livox (ns): the nearest
//   ring    ring, else channel; any unsigned type
//   intensity  intensity, 0 to 255; of clouds with t: reflectivity, as Ouster's intensity has no upper end
// For io/import/ros2/*.cpp and tests.
#include <Eigen/Core>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "io/ros2/messages.hpp"

namespace simuli::ros2 {

/// Requested fields; empty: as in the table above.
struct CloudFieldOptions {
  std::string time;       // "FIELD:UNIT" or "FIELD:UNIT:absolute"; UNIT s, ms, us or ns
  std::string intensity;  // "FIELD:MOST"
};

struct CloudField {
  std::string name;
  std::size_t offset = 0;
  std::uint8_t datatype = 0;
};

struct CloudFields {
  CloudField xyz[3];
  std::optional<CloudField> ring, time, intensity;
  double time_unit_s = 0.0;       // 0: s or ns, whichever is closer to the stamp
  bool time_is_absolute = false;  // since 1970, not relative to the stamp
  double intensity_most = 255.0;

  /// "ring, time (s), intensity to 255"
  [[nodiscard]] std::string reported() const;
};

/// A point with values.
struct CloudPoint {
  Eigen::Vector3d position;                                  // m, as in the message
  float intensity = 0.0F;                                    // [0, 1]
  int ring = -1;                                             // negative: unknown
  double time_s = std::numeric_limits<double>::quiet_NaN();  // after the message's stamp; NaN: unknown
};

/// Throws Error{kInput} naming `file`, `where` and the option for a time or an intensity that the fields' names
/// and types do not determine, for invalid coordinates, and for missing fields of the options.
[[nodiscard]] CloudFields find_cloud_fields(const PointCloudMessage& message,
                                            const CloudFieldOptions& options,
                                            const std::string& file,
                                            const std::string& where);

/// Finds the coordinates only.
[[nodiscard]] CloudFields find_cloud_places(const PointCloudMessage& message,
                                            const std::string& file,
                                            const std::string& where);

/// Returns the points; leaves out points at the sensor and with NaN, which mean no return. Throws Error{kInput}
/// for times more than 10 s from the stamp, and intensities above the maximum.
[[nodiscard]] std::vector<CloudPoint> points_of(const PointCloudMessage& message,
                                                const CloudFields& fields,
                                                const std::string& file,
                                                const std::string& where);

}  // namespace simuli::ros2
