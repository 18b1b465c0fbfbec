#pragma once
// Which field of a PointCloud2 is what, as drivers of LiDARs name them:
//   time    time       float32  s after the stamp        Velodyne; what simuli writes
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

/// As asked for; empty: as the table above says.
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
  double time_unit_s = 0.0;       // 0: s or ns, whichever is near the stamp
  bool time_is_absolute = false;  // since 1970, not after the stamp
  double intensity_most = 255.0;

  /// "ring, time (s), intensity to 255"
  [[nodiscard]] std::string told() const;
};

/// A point with numbers.
struct CloudPoint {
  Eigen::Vector3d position;                                  // m, as in the message
  float intensity = 0.0F;                                    // [0, 1]
  int ring = -1;                                             // below 0: not told
  double time_s = std::numeric_limits<double>::quiet_NaN();  // after the message's stamp; NaN: not told
};

/// Error{kInput} naming `file`, `where` and the option for a time or an intensity that can't be told by the
/// fields' names and types, for coordinates that are none, and fields that the options name and it lacks.
[[nodiscard]] CloudFields find_cloud_fields(const PointCloudMessage& message,
                                            const CloudFieldOptions& options,
                                            const std::string& file,
                                            const std::string& where);

/// The coordinates alone.
[[nodiscard]] CloudFields find_cloud_places(const PointCloudMessage& message,
                                            const std::string& file,
                                            const std::string& where);

/// Points at the sensor itself and such with NaN returned nothing and are left out. Error{kInput} for times
/// that are not within 10 s of the stamp, and intensities above the most.
[[nodiscard]] std::vector<CloudPoint> points_of(const PointCloudMessage& message,
                                                const CloudFields& fields,
                                                const std::string& file,
                                                const std::string& where);

}  // namespace simuli::ros2
