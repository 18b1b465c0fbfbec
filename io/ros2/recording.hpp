#pragma once
// A drive as ROS 2 would have recorded it, in an MCAP file:
//   /tf_static                  tf2_msgs/TFMessage              base_link from each sensor, once
//   /tf                         tf2_msgs/TFMessage              map from base_link, at each pose of the path
//   /NAME/image_raw             sensor_msgs/Image               rgb8; or
//   /NAME/image_raw/compressed  sensor_msgs/CompressedImage     png, jpeg
//   /NAME/camera_info           sensor_msgs/CameraInfo          with each picture
//   /NAME/points                sensor_msgs/PointCloud2         a sweep
//   /actors                     visualization_msgs/MarkerArray  boxes, at each sweep (else picture)
// Frames: map is the world, base_link the rig (x forward, y left, z up), NAME a LiDAR, NAME_optical_frame a
// camera (x right, y down, z forward). A message is stamped and logged when its frame begins. Points are
// little endian, 24 bytes each: x y z (float32, m, offsets 0 4 8, in the LiDAR's frame when measured),
// intensity (float32, 12, 0 to 255), ring (uint16, 16, the row counted from the top; of LiDARs with rows) and
// time (float32, 20, s since the stamp).
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "host/core/base/image.hpp"
#include "host/core/base/point_cloud.hpp"
#include "host/core/scene/actor.hpp"
#include "host/core/sensors/sensor.hpp"
#include "host/core/sensors/trajectory.hpp"
#include "io/bag/mcap_writer.hpp"

namespace simuli {

enum class BagPictures { kRaw, kPng, kJpeg };

struct Ros2Drive {
  Trajectory world_from_rig;
  std::vector<Sensor> sensors;  // with names of their own
  std::vector<Actor> actors;
  /// Nanoseconds since 1970 of the drive's time 0.
  std::int64_t start_ns = 0;
};

/// The start of a drive that has none: so that all of it is a second after 1970 at least. ROS takes time 0
/// for "the latest".
[[nodiscard]] std::int64_t usual_start_ns(const Trajectory& world_from_rig);

/// Writes the file as frames are added, in the order of their starts: what comes later is found, too, but
/// players have to look for it. Whole once finish() has returned; under a temporary name until then
/// (io/base/file.hpp).
class Ros2Recording {
 public:
  /// Error{kInput} for names that are none of a ROS topic, and times that its stamps can't hold.
  Ros2Recording(const std::filesystem::path& file, Ros2Drive drive, McapWriter::Compression compression);

  /// Of 3 channels, of a camera of that name.
  void add_picture(const std::string& camera, double time_start_s, const Image& image, BagPictures as);
  /// Columns x y z intensity time, and ring where there is one, of a LiDAR of that name; others are left out.
  void add_cloud(const std::string& lidar, double time_start_s, const PointCloud& cloud);
  void finish();

 private:
  [[nodiscard]] std::int64_t stamp(double time_s) const;
  void write(const std::string& topic, const char* type, std::int64_t stamp_ns, const std::string& message);
  void write_path_until(double time_s);
  void write_actors(double time_s);

  McapWriter mcap_;
  Ros2Drive drive_;
  std::size_t poses_written_ = 0;
  bool has_lidars_ = false;
  double last_s_ = std::numeric_limits<double>::lowest();  // when the last frame ended
  std::map<std::string, std::uint16_t> channels_;
};

}  // namespace simuli
