#include <algorithm>
#include <fmt/format.h>
#include <set>

#include "host/core/base/error.hpp"
#include "io/bag/bag.hpp"
#include "io/import/ros2/cloud_fields.hpp"
#include "io/import/ros2/ros2_log.hpp"
#include "io/import/ros2/ros2_scan.hpp"

namespace simuli {

Ros2Clouds read_ros2_clouds(const std::filesystem::path& recording,
                            const std::string& topic,
                            std::size_t most_first,
                            std::size_t most_spread) {
  const std::string file = recording.string();
  const auto bag = open_bag(recording);
  std::set<std::string> topics;
  std::size_t count = 0;
  const auto is_wanted = [&](const BagChannel& channel) {
    if (channel.type != ros2::kPointCloud2) return false;
    topics.insert(channel.topic);
    return channel.topic == topic;
  };
  bag->read(is_wanted, [&](const BagChannel&, std::uint64_t, std::string_view) { ++count; });
  if (count == 0) {
    throw Error(ErrorKind::kUsage,
                fmt::format("--topic: found \"{}\", allowed a topic of clouds of {}: {}",
                            topic,
                            file,
                            topics.empty() ? "it has none" : fmt::format("{}", fmt::join(topics, ", "))));
  }
  const std::size_t spread = std::min(count, most_spread);
  Ros2Clouds clouds;
  std::size_t i = 0;
  bag->read(is_wanted, [&](const BagChannel& channel, std::uint64_t, std::string_view data) {
    const bool is_first = i < most_first;
    const std::size_t next = clouds.spread.size();
    const bool is_spread = next < spread && i == next * count / spread;
    ++i;
    if (!is_first && !is_spread) return;
    const ros2::PointCloudMessage cloud = ros2::read_point_cloud(ros2::reader_of(channel, data, file));
    const ros2::CloudFields places = ros2::find_cloud_places(cloud, file, channel.topic);
    BarePoints points;
    for (const ros2::CloudPoint& point : ros2::points_of(cloud, places, file, channel.topic))
      points.push_back(point.position);
    if (is_first) clouds.first.push_back(points);
    if (is_spread) clouds.spread.push_back(std::move(points));
  });
  return clouds;
}

}  // namespace simuli
