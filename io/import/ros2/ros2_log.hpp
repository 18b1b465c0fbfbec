#pragma once
// Import of drives recorded with ROS 2: MCAP files, rosbag2's SQLite databases, folders of either.
//   sensor_msgs/PointCloud2             one LiDAR each; fields: io/import/ros2/cloud_fields.hpp
//   sensor_msgs/Image, CompressedImage  with the CameraInfo beside them: /front/image_raw, /front/camera_info
//   tf2_msgs/TFMessage                  mountings, and the rig's trajectory in its parent frame
//   nav_msgs/Odometry                   the trajectory, if no transform contains it
// Sensors are named after their topics' parents: /sensing/front/image_raw is camera sensing_front.
#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "host/core/scene/mounting.hpp"
#include "host/core/sensors/camera.hpp"
#include "host/core/sensors/lidar_library.hpp"
#include "io/import/points/point_grid.hpp"
#include "io/log/log.hpp"
#include "io/log/sensor_file.hpp"

namespace simuli {

struct Ros2Lidar {
  std::string topic;
  Lidar table;             // beams, columns and range of the sensor, which a recording does not contain
  std::string frame = {};  // frame of the table's axes; empty: the clouds'
  std::vector<LidarMode> modes = {};  // possible modes; the points determine others
  bool is_mode_given = false;         // other modes are refused
};

struct Ros2Shutter {
  ShutterKind kind = ShutterKind::kGlobal;
  double readout_s = 0.0;
};

struct Ros2Options {
  std::filesystem::path recording;
  std::filesystem::path output;
  std::vector<Ros2Lidar> lidars;  // required for all cloud topics in use
  bool without_lidars = false;
  std::vector<std::string> cameras;  // picture topics; empty: all with a CameraInfo
  std::vector<std::string> topics;   // topics to read, of all types; empty: all except `ignore`
  std::vector<std::string> ignore;   // topics to skip
  std::string rig_frame = "base_link";
  std::string world_frame;                      // empty: the topmost frame above the rig
  std::string odometry;                         // topic; empty: transforms, else the only odometry
  bool without_poses = false;                   // a static rig; simuli align finds the trajectory
  std::map<std::string, Mounting> mounts;       // by topic; take precedence over transforms
  std::map<std::string, Ros2Shutter> shutters;  // by topic; others are global, or as in `lenses`
  std::map<std::string, CameraFile> lenses;     // by topic; replace a CameraInfo
  std::string stamp;       // "start" or "end" of a sweep; takes precedence over the points' times
  std::string point_time;  // as in CloudFieldOptions::time
  std::string intensity;   // as in CloudFieldOptions::intensity
};

struct Ros2Report {
  PointReport points;
  std::size_t sweeps = 0, pictures = 0;  // in the log
  std::size_t unposed = 0;               // outside the trajectory; left out
  std::size_t twice = 0;                 // with the stamp of another message of the sensor; left out
  std::vector<std::string> notes;        // interpretation of the data, and parts left out
};

/// Throws Error{kInput} naming file, topic and field for damaged or inconsistent data, for ambiguities that an
/// option must resolve, and if more than 5 % of all points are left out, which indicates a wrong table. Throws
/// Error{kUsage} for options of unknown topics. Without an output it returns a survey, which reads no pictures
/// and few points: the notes begin with a line for each topic of sensors and poses (messages, rate, first and
/// last stamp, frame) and one for the transforms' frames; an Error{kInput} or Error{kNothing} becomes the last
/// note, with an empty log.
Log import_ros2(const Ros2Options& options, const FrameProgress& progress, Ros2Report& report);

// Points of a recording's clouds, for fitting a beam table before the import.

using BarePoints = std::vector<Eigen::Vector3d>;  // m, in the clouds' own frame

/// Clouds of one topic, without points that mean no return.
struct Ros2Clouds {
  std::vector<BarePoints> first;   // consecutive clouds from the start
  std::vector<BarePoints> spread;  // evenly spaced over the recording
};

/// Returns at most the given numbers of either. Throws Error{kInput} naming file, topic and field for damaged
/// data; Error{kUsage} for a topic without clouds, naming topics with clouds.
[[nodiscard]] Ros2Clouds read_ros2_clouds(const std::filesystem::path& recording,
                                          const std::string& topic,
                                          std::size_t most_first,
                                          std::size_t most_spread);

}  // namespace simuli
