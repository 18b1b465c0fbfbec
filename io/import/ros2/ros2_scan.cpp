#include "io/import/ros2/ros2_scan.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "host/core/base/error.hpp"
#include "io/import/ros2/ros2_frames.hpp"

namespace simuli::ros2 {
namespace {

constexpr std::size_t kFirstSweeps = 4;  // enough to sample every ring at all azimuths
constexpr std::size_t kMostMessages = 10'000'000;

class Scanner {
 public:
  Scanner(const Ros2Options& options, std::string file)
      : scan(file), options_(options), file_(std::move(file)) {}

  void take(const BagChannel& channel, std::string_view data) {
    if (++messages_ > kMostMessages)
      throw_input_error(
          file_, "messages", "more", fmt::format("at most {} of sensors and poses", kMostMessages));
    std::vector<TransformMessage> transforms;
    try {
      read(channel, data, transforms);
    } catch (const Error& error) {
      if (error.kind() == ErrorKind::kUsage) throw;  // error of an option, not of a message
      Damage& damage = scan.damaged[channel.topic];
      if (damage.count++ == 0) damage.first = error.what();
    }
    for (const TransformMessage& transform : transforms) scan.transforms.add(transform);
  }

  Scan scan;

 private:
  void read(const BagChannel& channel, std::string_view data, std::vector<TransformMessage>& transforms) {
    if (channel.encoding != "cdr") {
      throw_input_error(
          file_, channel.topic + ": message encoding", '"' + channel.encoding + '"', "cdr: ROS 2's");
    }
    const CdrReader in = reader_of(channel, data, file_);
    const std::string& type = channel.type;
    if (type == kTfMessage) {
      transforms = read_transforms(in, scan.bad_transforms);
    } else if (type == kCameraInfo) {
      take_info(channel, read_camera_info(in));
    } else if (type == kOdometry) {
      if (!options_.odometry.empty() && options_.odometry != channel.topic) return;
      try {
        const OdometryMessage pose = read_odometry(in);
        scan.odometry[channel.topic].push_back({pose.header.stamp_ns, pose.parent_from_child});
        scan.odometry_frames.emplace(channel.topic, pose);
      } catch (const Error&) {
        ++scan.bad_transforms;
      }
    } else if (type == kPointCloud2) {
      take_cloud(channel, in);
    } else {
      const Header header = read_header_of(in);
      SensorTopic& topic = scan.pictures[channel.topic];
      if (topic.stamps_ns.empty()) topic.unreadable = why_unreadable(channel, in);
      take_stamp(topic, channel, header);
    }
  }

  static void take_stamp(SensorTopic& topic, const BagChannel& channel, const Header& header) {
    if (topic.stamps_ns.empty()) {
      topic.type = channel.type;
      topic.frame_id = frame_name(header.frame_id);
    }
    topic.stamps_ns.push_back(header.stamp_ns);
  }

  /// Ignores a damaged message, which is reported when it is read.
  static std::string why_unreadable(const BagChannel& channel, const CdrReader& in) try {
    if (channel.type == kImage) {
      const std::string encoding(read_image_message(in).encoding);
      if (is_known_encoding(encoding)) return "";
      return fmt::format("pictures of encoding \"{}\", which has no colours", encoding);
    }
    const CompressedImageMessage message = read_compressed_image(in);
    if (!picture_ending(message).empty()) return "";
    return fmt::format("pictures of format \"{}\", neither JPEG, PNG nor WebP", message.format);
  } catch (const Error&) {
    return "";
  }

  void take_info(const BagChannel& channel, const CameraInfoMessage& info) {
    const auto [known, is_new] = scan.infos.emplace(channel.topic, info);
    const CameraInfoMessage& first = known->second;
    // also equal for NaN, which is refused when it is read
    const auto same = [](const auto& a, const auto& b) {
      return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](double x, double y) {
        return x == y || (std::isnan(x) && std::isnan(y));
      });
    };
    const bool is_same = first.width == info.width && first.height == info.height && same(first.k, info.k) &&
                         same(first.d, info.d) && first.distortion_model == info.distortion_model;
    if (!is_same) scan.changing.insert(channel.topic);
  }

  void take_cloud(const BagChannel& channel, const CdrReader& in) {
    const Header header = read_header_of(in);
    SensorTopic& topic = scan.clouds[channel.topic];
    take_stamp(topic, channel, header);
    const bool is_requested =
        std::any_of(options_.lidars.begin(), options_.lidars.end(), [&](const Ros2Lidar& lidar) {
          return lidar.topic == channel.topic;
        });
    if (!is_requested || topic.first_sweeps.size() >= kFirstSweeps) return;
    try {
      const PointCloudMessage cloud = read_point_cloud(in);
      // For each message, because layouts may differ.
      const CloudFields fields = find_cloud_fields(cloud, field_options(options_), file_, channel.topic);
      std::vector<CloudPoint> points = points_of(cloud, fields, file_, channel.topic);
      if (!topic.fields) topic.fields = fields;
      if (!points.empty()) topic.first_sweeps.push_back(std::move(points));
    } catch (const Error& error) {
      if (error.kind() == ErrorKind::kUsage) throw;  // error of an option, not of a message
      if (topic.unreadable.empty()) topic.unreadable = error.what();
    }
  }

  const Ros2Options& options_;
  std::string file_;
  std::size_t messages_ = 0;
};

}  // namespace

CdrReader reader_of(const BagChannel& channel, std::string_view data, const std::string& file) {
  return {data, file, channel.topic};
}

Scan scan_bag(const Bag& bag, const Ros2Options& options) {
  Scanner scanner(options, options.recording.string());
  const auto has = [](const std::vector<std::string>& topics, const std::string& topic) {
    return std::find(topics.begin(), topics.end(), topic) != topics.end();
  };
  const auto is_wanted = [&](const BagChannel& channel) {
    scanner.scan.topics.insert(channel.topic);
    if (has(options.ignore, channel.topic)) return false;
    if (!options.topics.empty() && !has(options.topics, channel.topic)) return false;
    const std::string& t = channel.type;
    return t == kTfMessage || t == kCameraInfo || t == kOdometry || t == kPointCloud2 || t == kImage ||
           t == kCompressedImage;
  };
  bag.read(is_wanted, [&](const BagChannel& channel, std::uint64_t, std::string_view data) {
    scanner.take(channel, data);
  });
  scanner.scan.transforms.finish();
  return std::move(scanner.scan);
}

}  // namespace simuli::ros2
