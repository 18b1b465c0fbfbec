#pragma once
// Points of a recording's clouds, for fitting a beam table before the import.
#include <Eigen/Core>
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace simuli {

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
