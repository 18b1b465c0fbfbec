#pragma once
// The bare points of a recording's clouds: what a beam table is fitted to before there is one to import with.
#include <Eigen/Core>
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace simuli {

using BarePoints = std::vector<Eigen::Vector3d>;  // m, in the clouds' own frame

/// Clouds of one topic, points without a return left out.
struct Ros2Clouds {
  std::vector<BarePoints> first;   // those that follow each other from the start on
  std::vector<BarePoints> spread;  // over all of the recording, evenly
};

/// At most so many of either. Error{kInput} naming file, topic and field for what is damaged; Error{kUsage}
/// for a topic that has none, naming those that have.
[[nodiscard]] Ros2Clouds read_ros2_clouds(const std::filesystem::path& recording,
                                          const std::string& topic,
                                          std::size_t most_first,
                                          std::size_t most_spread);

}  // namespace simuli
