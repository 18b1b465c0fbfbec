#pragma once
// Drives recorded with ROS 2: MCAP files, rosbag2's SQLite databases, folders of either.
//   sensor_msgs/PointCloud2             a LiDAR each; fields: io/import/ros2/cloud_fields.hpp
//   sensor_msgs/Image, CompressedImage  with the CameraInfo beside them: /front/image_raw, /front/camera_info
//   tf2_msgs/TFMessage                  mountings, and the rig's path in the frame above it
//   nav_msgs/Odometry                   the path, where no transform tells it
// Sensors are called what their topics are below: /sensing/front/image_raw is camera sensing_front.
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
  Lidar table;                        // beams, columns and range of the sensor: a recording has no such thing
  std::string frame = {};             // that the table's axes are; empty: the clouds' own
  std::vector<LidarMode> modes = {};  // that it may have run in; others by what points say
  bool is_mode_given = false;         // others are refused
};

struct Ros2Shutter {
  ShutterKind kind = ShutterKind::kGlobal;
  double readout_s = 0.0;
};

struct Ros2Options {
  std::filesystem::path recording;
  std::filesystem::path output;
  std::vector<Ros2Lidar> lidars;  // of all topics of clouds these
  bool without_lidars = false;
  std::vector<std::string> cameras;  // topics of pictures; empty: all that have a CameraInfo
  std::vector<std::string> topics;   // that alone are read, of all types; empty: all but
  std::vector<std::string> ignore;   // these
  std::string rig_frame = "base_link";
  std::string world_frame;                      // empty: the uppermost that the rig is in
  std::string odometry;                         // topic; empty: transforms, or else the only one
  bool without_poses = false;                   // a rig at rest; simuli align finds the path
  std::map<std::string, Mounting> mounts;       // by topic, before what transforms say
  std::map<std::string, Ros2Shutter> shutters;  // by topic; others are global, or as in `lenses`
  std::map<std::string, CameraFile> lenses;     // by topic, instead of a CameraInfo
  std::string stamp;                            // "start" or "end" of a sweep, before what points' times say
  std::string point_time;                       // as CloudFieldOptions::time
  std::string intensity;                        // as CloudFieldOptions::intensity
};

struct Ros2Report {
  PointReport points;
  std::size_t sweeps = 0, pictures = 0;  // in the log
  std::size_t unposed = 0;               // beside the path; left out
  std::size_t twice = 0;                 // of a stamp that the sensor's other one has; left out
  std::vector<std::string> notes;        // what was taken for what, and what was left out
};

/// Error{kInput} naming file, topic and field for what is damaged or does not fit, for what has to be said by
/// an option, and for more than 5 % of all points unplaced: another sensor than the table says. Error{kUsage}
/// for options of topics that the recording has not. Without an output it is a survey, which reads no pictures and
/// few points: in front of the notes a line for each topic of sensors and poses (messages, rate, first and last stamp,
/// frame) and one for the frames of transforms; what Error{kInput} and Error{kNothing} would say is the last, with a
/// log that is empty.
Log import_ros2(const Ros2Options& options,
                const FrameProgress& progress,
                Ros2Report& report);

}  // namespace simuli
