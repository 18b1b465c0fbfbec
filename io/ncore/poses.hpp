#pragma once
// NCore's poses between named frames, for io/ncore, io/import/ncore and tests.
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/core/base/pose.hpp"
#include "io/base/json_reader.hpp"

namespace simuli::ncore {

/// Converts between "('rig', 'world')" and a pair of names. Throws Error{kInput} naming file and field for an
/// invalid key.
[[nodiscard]] std::string key_of(const std::string& source, const std::string& target);
[[nodiscard]] std::pair<std::string, std::string> frames_of(const std::string& key, const std::string& file);

/// Parses a 4 x 4 matrix. Throws Error{kInput} unless it is a rigid transform.
[[nodiscard]] Pose pose_of(const Json& matrix, const std::string& file, const std::string& field);

struct StampedPose {
  std::uint64_t stamp_us = 0;
  Pose pose;
};

class PoseTable {
 public:
  /// Adds the attributes static_poses and dynamic_poses of a poses component. Throws Error{kInput} naming
  /// `file` for damaged, unsorted or repeated entries.
  void add_static(const Json& attributes, const std::string& file);
  void add_dynamic(const Json& attributes, const std::string& file);

  /// Returns the pose of frame b in frame a through static links; no value without a connection.
  [[nodiscard]] std::optional<Pose> fixed(const std::string& a, const std::string& b) const;
  /// Returns world_from_rig in time order through one dynamic link; empty without one.
  [[nodiscard]] std::vector<StampedPose> path(const std::string& world, const std::string& rig) const;
  /// Returns all pairs, for messages.
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

/// Converts extrinsic Euler angles x, y, z in rad, as in boxes.
[[nodiscard]] Eigen::Quaterniond rotation_of_euler(const Eigen::Vector3d& xyz_rad);
[[nodiscard]] Eigen::Vector3d euler_of(const Eigen::Quaterniond& rotation);

}  // namespace simuli::ncore
