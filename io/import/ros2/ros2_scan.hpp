#pragma once
// Content of a recording, found in one pass, for io/import/ros2/*.cpp.
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "io/bag/bag.hpp"
#include "io/import/ros2/cloud_fields.hpp"
#include "io/import/ros2/ros2_log.hpp"
#include "io/import/ros2/transform_tree.hpp"
#include "io/ros2/messages.hpp"

namespace simuli::ros2 {

/// One topic of clouds or pictures.
struct SensorTopic {
  std::string type;
  std::string frame_id;    // of the first message
  std::string unreadable;  // why the first picture is unsupported; for clouds the first error
  std::vector<std::int64_t> stamps_ns;
  std::vector<std::vector<CloudPoint>> first_sweeps;  // of cloud topics in options.lidars
  std::optional<CloudFields> fields;                  // of these topics
};

/// Unreadable messages of one topic.
struct Damage {
  std::size_t count = 0, of = 0;
  std::string first;  // first error
};

struct Scan {
  explicit Scan(const std::string& file) : transforms(file) {}

  std::map<std::string, SensorTopic> clouds, pictures;       // by topic
  std::map<std::string, CameraInfoMessage> infos;            // by topic, the first message
  std::map<std::string, std::vector<StampedPose>> odometry;  // by topic, header.frame_id from child_frame_id
  std::map<std::string, OdometryMessage> odometry_frames;    // the first message of each
  TransformTree transforms;
  std::set<std::string> changing;         // topics of CameraInfo whose calibration changes
  std::set<std::string> topics;           // all topics of the recording
  std::size_t bad_transforms = 0;         // invalid transforms and odometry poses; left out
  std::map<std::string, Damage> damaged;  // by topic; read only up to the detection of the damage
};

/// Returns a reader for a message of the channel.
[[nodiscard]] CdrReader reader_of(const BagChannel& channel, std::string_view data, const std::string& file);

/// Errors as in import_ros2().
[[nodiscard]] Scan scan_bag(const Bag& bag, const Ros2Options& options);

[[nodiscard]] inline CloudFieldOptions field_options(const Ros2Options& options) {
  return {options.point_time, options.intensity};
}

}  // namespace simuli::ros2
