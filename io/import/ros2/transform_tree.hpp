#pragma once
// Poses between frames over time from TF messages, for io/import/ros2/*.cpp and tests.
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "host/core/base/pose.hpp"
#include "io/ros2/messages.hpp"

namespace simuli::ros2 {

struct StampedPose {
  std::int64_t stamp_ns = 0;
  Pose pose;
};

/// Sorts strictly by time; of poses with equal stamps the last is kept.
void sort_by_stamp(std::vector<StampedPose>& poses);

class TransformTree {
 public:
  explicit TransformTree(std::string file) : file_(std::move(file)) {}

  /// Adds a transform. A frame may have several parents. Throws Error{kInput} for more than 10 million
  /// transforms.
  void add(const TransformMessage& transform);
  /// Called after all add(), before any query.
  void finish();

  [[nodiscard]] bool has(const std::string& frame) const;
  /// Returns the names of frames with several parents.
  [[nodiscard]] std::vector<std::string> ambiguous() const;
  /// Returns all names, for messages.
  [[nodiscard]] std::string frames() const;
  /// Returns the pose of frame b in frame a through links with constant transforms; no value without a
  /// connection.
  [[nodiscard]] std::optional<Pose> fixed(const std::string& a, const std::string& b) const;
  /// Returns world_from_frame at the stamps of the link with the most, in time order. Empty `world`: the root,
  /// or the frame below it if the root is the centre of the earth; `world` is set to it. Empty if no link
  /// moves. Throws Error{kInput} if `world` is not above the frame, and if only links to an earth frame move.
  [[nodiscard]] std::vector<StampedPose> path(const std::string& frame, std::string& world) const;

 private:
  struct Link {
    std::string parent;
    std::vector<StampedPose> poses;  // parent_from_child
    bool is_fixed = false;
  };
  /// Returns the links from a frame up to its root; of several parents the one that leads to a frame in
  /// `wanted`, else the latest, as in tf2. Throws Error{kInput} for a cycle.
  [[nodiscard]] std::vector<const Link*> above(const std::string& frame,
                                               const std::set<std::string>& wanted) const;
  [[nodiscard]] bool leads(const std::string& frame,
                           const std::set<std::string>& wanted,
                           std::set<std::string>& seen) const;

  std::string file_;
  std::map<std::string, std::vector<Link>> links_;  // by child; sorted by their last stamp
  std::size_t count_ = 0;
};

/// Returns a frame's name without the leading slash of older programs.
[[nodiscard]] std::string frame_name(const std::string& frame_id);

}  // namespace simuli::ros2
