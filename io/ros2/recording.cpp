#include "io/ros2/recording.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <set>
#include <utility>

#include "host/core/base/error.hpp"
#include "io/picture/image.hpp"
#include "io/ros2/camera_info.hpp"
#include "io/ros2/messages.hpp"

namespace simuli {
namespace {

using ros2::PointField;

constexpr char kWorld[] = "map", kRig[] = "base_link";
constexpr double kIntensityMost = 255.0;
constexpr double kNanoseconds = 1e9;

/// Returns a valid part of a topic: letters, digits and underscores, not beginning with a digit.
std::string topic_part(const std::string& name) {
  std::string part = name;
  for (char& c : part) {
    const bool is_allowed = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    if (!is_allowed) c = '_';
  }
  return part[0] >= '0' && part[0] <= '9' ? "sensor_" + part : part;
}

std::string frame_of(const Sensor& sensor) {
  return topic_part(sensor.name()) + (sensor.is_camera() ? "_optical_frame" : "");
}

const Sensor& find(const std::vector<Sensor>& sensors, const std::string& name) {
  const auto found =
      std::find_if(sensors.begin(), sensors.end(), [&](const Sensor& s) { return s.name() == name; });
  if (found == sensors.end()) throw Error(ErrorKind::kInternal, "recording: no sensor " + name);
  return *found;
}

/// Returns the QoS profile in rosbag2's format.
std::string quality_of_service(bool is_latched) {
  constexpr int kReliable = 1, kTransientLocal = 1, kVolatile = 2, kKeepLast = 1;
  return fmt::format(
      "- history: {}\n  depth: {}\n  reliability: {}\n  durability: {}\n"
      "  deadline:\n    sec: 9223372036\n    nsec: 854775807\n"
      "  lifespan:\n    sec: 9223372036\n    nsec: 854775807\n"
      "  liveliness: 1\n  liveliness_lease_duration:\n    sec: 9223372036\n    nsec: 854775807\n"
      "  avoid_ros_namespace_conventions: false",
      kKeepLast,
      is_latched ? 1 : 10,
      kReliable,
      is_latched ? kTransientLocal : kVolatile);
}

template <class T>
void put(std::string& to, std::size_t at, T value) {
  std::memcpy(to.data() + at, &value, sizeof value);
}

/// Returns a column's index in a cloud; negative if it is missing.
Eigen::Index column(const PointCloud& cloud, const char* name) {
  const auto found = std::find(cloud.columns.begin(), cloud.columns.end(), name);
  return found == cloud.columns.end() ? -1 : found - cloud.columns.begin();
}

}  // namespace

std::int64_t usual_start_ns(const Trajectory& world_from_rig) {
  constexpr std::int64_t kSecond_ns = 1'000'000'000;
  const double before_s = std::max(0.0, -world_from_rig.start_s());
  return kSecond_ns * (1 + static_cast<std::int64_t>(std::ceil(before_s)));
}

Ros2Recording::Ros2Recording(const std::filesystem::path& file,
                             Ros2Drive drive,
                             McapWriter::Compression compression)
    : mcap_(file, "ros2", compression), drive_(std::move(drive)) {
  std::set<std::string> parts;
  std::vector<ros2::TransformMessage> mounts;
  for (const Sensor& sensor : drive_.sensors) {
    if (!parts.insert(topic_part(sensor.name())).second) {
      throw_input_error(file.string(),
                        "sensors",
                        fmt::format("another one whose topics are /{}/...", topic_part(sensor.name())),
                        "names that differ in letters and digits");
    }
    has_lidars_ = has_lidars_ || !sensor.is_camera();
    mounts.push_back(
        {{stamp(drive_.world_from_rig.start_s()), kRig}, frame_of(sensor), sensor.rig_from_sensor()});
  }
  if (mounts.empty()) throw_input_error(file.string(), "sensors", "none", "at least one");
  write("/tf_static", ros2::kTfMessage, mounts.front().header.stamp_ns, ros2::to_cdr(mounts));
}

std::int64_t Ros2Recording::stamp(double time_s) const {
  const std::int64_t ns = drive_.start_ns + static_cast<std::int64_t>(std::llround(time_s * kNanoseconds));
  constexpr std::int64_t kLast_ns = std::int64_t{std::numeric_limits<std::int32_t>::max()} * 1'000'000'000;
  if (ns < 0 || ns > kLast_ns) {
    throw_input_error(
        "recording", "time", fmt::format("{} ns", ns), "0 to the 19th of January 2038 since 1970");
  }
  return ns;
}

void Ros2Recording::write(const std::string& topic,
                          const char* type,
                          std::int64_t stamp_ns,
                          const std::string& message) {
  auto channel = channels_.find(topic);
  if (channel == channels_.end()) {
    const std::uint16_t id =
        mcap_.add_channel({topic,
                           type,
                           "ros2msg",
                           ros2::definition_of(type),
                           "cdr",
                           {{"offered_qos_profiles", quality_of_service(topic == "/tf_static")}}});
    channel = channels_.emplace(topic, id).first;
  }
  mcap_.add_message(channel->second, static_cast<std::uint64_t>(stamp_ns), message);
}

void Ros2Recording::write_path_until(double time_s) {
  const std::vector<TimedPose>& poses = drive_.world_from_rig.poses();
  if (poses_written_ == 0) {  // from the last pose before the first frame
    while (poses_written_ + 1 < poses.size() && poses[poses_written_ + 1].time_s <= time_s) ++poses_written_;
  }
  const auto is_due = [&] { return poses[poses_written_].time_s <= time_s; };
  for (; poses_written_ < poses.size() && is_due(); ++poses_written_) {
    const std::int64_t ns = stamp(poses[poses_written_].time_s);
    write(
        "/tf",
        ros2::kTfMessage,
        ns,
        ros2::to_cdr(std::vector<ros2::TransformMessage>{{{ns, kWorld}, kRig, poses[poses_written_].pose}}));
  }
}

void Ros2Recording::write_actors(double time_s) {
  constexpr std::int64_t kLifetime_ns = 150'000'000;  // 1.5 frames at 10 Hz
  std::vector<ros2::BoxMarker> boxes;
  for (const Actor& actor : drive_.actors) {
    if (!actor.is_there(time_s)) continue;
    boxes.push_back({{stamp(time_s), kWorld},
                     actor.name,
                     actor.at(time_s),
                     {actor.size_m.x(), actor.size_m.y(), actor.size_m.z()},
                     {1.0F, 0.6F, 0.1F, 0.4F},
                     kLifetime_ns});
  }
  if (!boxes.empty()) write("/actors", ros2::kMarkerArray, stamp(time_s), ros2::to_cdr(boxes));
}

void Ros2Recording::add_picture(const std::string& camera,
                                double time_start_s,
                                const Image& image,
                                BagPictures as) {
  const Sensor& sensor = find(drive_.sensors, camera);
  write_path_until(time_start_s);
  if (!has_lidars_) write_actors(time_start_s);
  last_s_ = std::max(last_s_, time_start_s + sensor.duration_s());
  const ros2::Header header{stamp(time_start_s), frame_of(sensor)};
  const std::string topic = "/" + topic_part(camera);
  ros2::CameraInfoMessage info = ros2::camera_info_of(sensor.camera());
  info.header = header;
  write(topic + "/camera_info", ros2::kCameraInfo, header.stamp_ns, ros2::to_cdr(info));
  if (as != BagPictures::kRaw) {
    const bool is_png = as == BagPictures::kPng;
    const std::string bytes = encode_image(image, is_png ? ImageCode::kPng : ImageCode::kJpeg);
    return write(topic + "/image_raw/compressed",
                 ros2::kCompressedImage,
                 header.stamp_ns,
                 ros2::to_cdr(ros2::CompressedImageMessage{header, is_png ? "png" : "jpeg", bytes}));
  }
  constexpr int kChannels = 3;
  if (image.channels != kChannels) throw Error(ErrorKind::kInternal, "recording: a picture without colours");
  std::string bytes(image.data.size(), '\0');
  to_bytes(image.data, {reinterpret_cast<unsigned char*>(bytes.data()), bytes.size()});
  ros2::ImageMessage message{header,
                             static_cast<std::uint32_t>(image.height),
                             static_cast<std::uint32_t>(image.width),
                             "rgb8",
                             false,
                             static_cast<std::uint32_t>(kChannels * image.width),
                             bytes};
  write(topic + "/image_raw", ros2::kImage, header.stamp_ns, ros2::to_cdr(message));
}

void Ros2Recording::add_cloud(const std::string& lidar, double time_start_s, const PointCloud& cloud) {
  const Sensor& sensor = find(drive_.sensors, lidar);
  write_path_until(time_start_s);
  write_actors(time_start_s);
  last_s_ = std::max(last_s_, time_start_s + sensor.duration_s());
  constexpr std::size_t kIntensityAt = 12, kRingAt = 16, kTimeAt = 20, kStep = 24;
  const Eigen::Index ring = column(cloud, "ring"), intensity = column(cloud, "intensity"),
                     time = column(cloud, "time");
  const Eigen::Index xyz[] = {column(cloud, "x"), column(cloud, "y"), column(cloud, "z")};
  const auto count = static_cast<std::size_t>(cloud.values.rows());
  std::string data(count * kStep, '\0');
  for (std::size_t i = 0; i < count; ++i) {
    const auto row = cloud.values.row(static_cast<Eigen::Index>(i));
    const std::size_t at = i * kStep;
    for (std::size_t k = 0; k < 3; ++k) put(data, at + 4 * k, static_cast<float>(row[xyz[k]]));
    put(data, at + kIntensityAt, static_cast<float>(kIntensityMost * row[intensity]));
    if (ring >= 0) put(data, at + kRingAt, static_cast<std::uint16_t>(row[ring]));
    put(data, at + kTimeAt, static_cast<float>(row[time]));
  }
  ros2::PointCloudMessage message;
  message.header = {stamp(time_start_s), frame_of(sensor)};
  message.height = 1;
  message.width = static_cast<std::uint32_t>(count);
  message.fields = {{"x", 0, PointField::kFloat32},
                    {"y", 4, PointField::kFloat32},
                    {"z", 8, PointField::kFloat32},
                    {"intensity", kIntensityAt, PointField::kFloat32}};
  if (ring >= 0) message.fields.push_back({"ring", kRingAt, PointField::kUint16});
  message.fields.push_back({"time", kTimeAt, PointField::kFloat32});
  message.point_step = kStep;
  message.row_step = static_cast<std::uint32_t>(count * kStep);
  message.data = data;
  write("/" + topic_part(lidar) + "/points",
        ros2::kPointCloud2,
        message.header.stamp_ns,
        ros2::to_cdr(message));
}

void Ros2Recording::finish() {
  const std::vector<TimedPose>& poses = drive_.world_from_rig.poses();
  // Up to the first pose at or after the last frame's end.
  const auto last = std::lower_bound(
      poses.begin(), poses.end(), last_s_, [](const TimedPose& pose, double s) { return pose.time_s < s; });
  write_path_until(last == poses.end() ? poses.back().time_s : last->time_s);
  mcap_.finish();
}

}  // namespace simuli
