#pragma once
// ROS 2 messages of drives with their fields and CDR encoding, for io/ros2/*.cpp, io/import/ros2/*.cpp and
// tests.
#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "host/core/base/pose.hpp"
#include "io/ros2/cdr.hpp"

namespace simuli::ros2 {

struct Header {
  std::int64_t stamp_ns = 0;  // in the message: 32-bit seconds and nanoseconds
  std::string frame_id;
};

/// sensor_msgs/msg/Image
struct ImageMessage {
  Header header;
  std::uint32_t height = 0, width = 0;
  std::string encoding;
  bool is_bigendian = false;
  std::uint32_t step = 0;  // bytes per row
  std::string_view data;   // refers to the message or to the caller's data
};

/// sensor_msgs/msg/CompressedImage
struct CompressedImageMessage {
  Header header;
  std::string format;
  std::string_view data;
};

/// sensor_msgs/msg/CameraInfo
struct CameraInfoMessage {
  Header header;
  std::uint32_t height = 0, width = 0;
  std::string distortion_model;
  std::vector<double> d;
  std::array<double, 9> k{};
  std::array<double, 9> r{};
  std::array<double, 12> p{};
  std::uint32_t binning_x = 0, binning_y = 0;
  std::uint32_t roi_x_offset = 0, roi_y_offset = 0, roi_height = 0, roi_width = 0;
  bool roi_do_rectify = false;
};

/// sensor_msgs/msg/PointField
struct PointField {
  enum Type : std::uint8_t {
    kInt8 = 1,
    kUint8 = 2,
    kInt16 = 3,
    kUint16 = 4,
    kInt32 = 5,
    kUint32 = 6,
    kFloat32 = 7,
    kFloat64 = 8
  };
  std::string name;
  std::uint32_t offset = 0;
  std::uint8_t datatype = 0;
  std::uint32_t count = 1;
};

/// sensor_msgs/msg/PointCloud2
struct PointCloudMessage {
  Header header;
  std::uint32_t height = 0, width = 0;
  std::vector<PointField> fields;
  bool is_bigendian = false;
  std::uint32_t point_step = 0, row_step = 0;
  std::string_view data;
  bool is_dense = true;
};

/// geometry_msgs/msg/TransformStamped: header.frame_id from child_frame_id.
struct TransformMessage {
  Header header;
  std::string child_frame_id;
  Pose parent_from_child;
};

/// nav_msgs/msg/Odometry without covariances and velocities.
struct OdometryMessage {
  Header header;
  std::string child_frame_id;
  Pose parent_from_child;
};

/// A box of visualization_msgs/msg/Marker.
struct BoxMarker {
  Header header;
  std::string name;     // its namespace
  Pose frame_from_box;  // of its centre
  std::array<double, 3> size_m{};
  std::array<float, 4> rgba{};
  std::int64_t lifetime_ns = 0;
};

inline constexpr char kImage[] = "sensor_msgs/msg/Image";
inline constexpr char kCompressedImage[] = "sensor_msgs/msg/CompressedImage";
inline constexpr char kCameraInfo[] = "sensor_msgs/msg/CameraInfo";
inline constexpr char kPointCloud2[] = "sensor_msgs/msg/PointCloud2";
inline constexpr char kTfMessage[] = "tf2_msgs/msg/TFMessage";
inline constexpr char kOdometry[] = "nav_msgs/msg/Odometry";
inline constexpr char kMarkerArray[] = "visualization_msgs/msg/MarkerArray";

[[nodiscard]] std::string to_cdr(const ImageMessage& message);
[[nodiscard]] std::string to_cdr(const CompressedImageMessage& message);
[[nodiscard]] std::string to_cdr(const CameraInfoMessage& message);
[[nodiscard]] std::string to_cdr(const PointCloudMessage& message);
[[nodiscard]] std::string to_cdr(const std::vector<TransformMessage>& transforms);  // TFMessage
[[nodiscard]] std::string to_cdr(const OdometryMessage& message);
[[nodiscard]] std::string to_cdr(const std::vector<BoxMarker>& markers);  // MarkerArray

/// Errors as in CdrReader; also for a height, step or fields that exceed the data, and for invalid poses.
[[nodiscard]] ImageMessage read_image_message(CdrReader in);
[[nodiscard]] CompressedImageMessage read_compressed_image(CdrReader in);
[[nodiscard]] CameraInfoMessage read_camera_info(CdrReader in);
[[nodiscard]] PointCloudMessage read_point_cloud(CdrReader in);
/// Leaves out and counts invalid transforms (NaN, beyond 1e9 m, a quaternion norm that differs from 1 by 1 %),
/// as tf2 does.
[[nodiscard]] std::vector<TransformMessage> read_transforms(CdrReader in, std::size_t& left_out);
/// Reads the header with which Image, CompressedImage and PointCloud2 begin.
[[nodiscard]] Header read_header_of(CdrReader in);
[[nodiscard]] OdometryMessage read_odometry(CdrReader in);

/// Returns the bytes of one value; 0 for an unknown type.
[[nodiscard]] std::size_t bytes_of(std::uint8_t datatype);
/// Returns the definition of a message type with all its parts in MCAP's encoding "ros2msg".
[[nodiscard]] std::string definition_of(std::string_view type);

}  // namespace simuli::ros2
