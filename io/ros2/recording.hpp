#pragma once
// A drive as a ROS 2 recording in an MCAP file:
//   /tf_static                  tf2_msgs/TFMessage              base_link from each sensor, once
//   /tf                         tf2_msgs/TFMessage              map from base_link, at each pose of the trajectory
//   /NAME/image_raw             sensor_msgs/Image               rgb8; or
//   /NAME/image_raw/compressed  sensor_msgs/CompressedImage     png, jpeg
//   /NAME/camera_info           sensor_msgs/CameraInfo          with each picture
//   /NAME/points                sensor_msgs/PointCloud2         a sweep
//   /actors                     visualization_msgs/MarkerArray  boxes, at each sweep (else picture)
// Frames: map is the world, base_link the rig (x forward, y left, z up), NAME a LiDAR, NAME_optical_frame a
// camera (x right, y down, z forward). Messages have the start time of their frame as stamp and log time. Points
// are little endian, 24 bytes each: x y z (float32, m, offsets 0 4 8, in the LiDAR's frame at the measurement),
// intensity (float32, 12, 0 to 255), ring (uint16, 16, the beam counted from the top; for LiDARs with beams) and
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
  std::vector<Sensor> sensors;  // with unique names
  std::vector<Actor> actors;
  /// Nanoseconds since 1970 of the drive's time 0.
  std::int64_t start_ns = 0;
};

/// Returns the start of a drive without a date, such that all times are at least a second after 1970: ROS
/// interprets time 0 as "the latest".
[[nodiscard]] std::int64_t usual_start_ns(const Trajectory& world_from_rig);

/// Writes frames in the order of their start times; frames out of order are valid, but slow to find for players.
/// The file is complete after finish(); until then it has a temporary name (io/base/file.hpp).
class Ros2Recording {
 public:
  /// Throws Error{kInput} for names that are invalid in ROS topics, and for times outside the range of ROS stamps.
  Ros2Recording(const std::filesystem::path& file, Ros2Drive drive, McapWriter::Compression compression);

  /// Adds a picture with 3 channels of the named camera.
  void add_picture(const std::string& camera, double time_start_s, const Image& image, BagPictures as);
  /// Adds the columns x y z intensity time, and ring if present, of the named LiDAR; leaves out other columns.
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
  double last_s_ = std::numeric_limits<double>::lowest();  // end of the last frame
  std::map<std::string, std::uint16_t> channels_;
};

}  // namespace simuli
