#pragma once
// Poses between named frames as NCore has them. For io/ncore, io/import/ncore and tests.
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/core/base/pose.hpp"
#include "io/base/json_reader.hpp"

namespace simuli::ncore {

/// "('rig', 'world')", and back. Error{kInput} naming file and field for what is no pair of names.
[[nodiscard]] std::string key_of(const std::string& source, const std::string& target);
[[nodiscard]] std::pair<std::string, std::string> frames_of(const std::string& key, const std::string& file);

/// 4 x 4 numbers. Error{kInput} for what is no rigid transform.
[[nodiscard]] Pose pose_of(const Json& matrix, const std::string& file, const std::string& field);

struct StampedPose {
  std::uint64_t stamp_us = 0;
  Pose pose;
};

class PoseTable {
 public:
  /// Adds what a poses component says: its attributes of static_poses and of dynamic_poses. Error{kInput}
  /// naming `file` for what is damaged, not in time's order, or said twice.
  void add_static(const Json& attributes, const std::string& file);
  void add_dynamic(const Json& attributes, const std::string& file);

  /// Where frame b is in frame a, through links that don't move; nothing where there is no such way.
  [[nodiscard]] std::optional<Pose> fixed(const std::string& a, const std::string& b) const;
  /// world_from_rig in time's order, through one link that moves; empty where there is none.
  [[nodiscard]] std::vector<StampedPose> path(const std::string& world, const std::string& rig) const;
  /// All pairs, for messages.
  [[nodiscard]] std::string pairs() const;

 private:
  struct Static {
    std::string source, target;
    Pose target_from_source;
  };
  struct Dynamic {
    std::string source, target;
    std::vector<StampedPose> target_from_source;
  };
  std::vector<Static> static_;
  std::vector<Dynamic> dynamic_;
};

/// Euler angles about fixed axes x, y, z, one after the other, as boxes have them: rad.
[[nodiscard]] Eigen::Quaterniond rotation_of_euler(const Eigen::Vector3d& xyz_rad);
[[nodiscard]] Eigen::Vector3d euler_of(const Eigen::Quaterniond& rotation);

}  // namespace simuli::ncore
