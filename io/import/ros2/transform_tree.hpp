#pragma once
// Which frame is where in another, and when: what TF messages tell. For io/import/ros2/*.cpp and tests.
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

/// Strictly increasing in time; of poses with one stamp the last.
void sort_by_stamp(std::vector<StampedPose>& poses);

class TransformTree {
 public:
  explicit TransformTree(std::string file) : file_(std::move(file)) {}

  /// A frame may have several parents. Error{kInput} for more transforms than 10 million.
  void add(const TransformMessage& transform);
  /// Once all have been added, before anything is asked.
  void finish();

  [[nodiscard]] bool has(const std::string& frame) const;
  /// Names of those that have several parents.
  [[nodiscard]] std::vector<std::string> ambiguous() const;
  /// All names, for messages.
  [[nodiscard]] std::string frames() const;
  /// Where frame b is in frame a, if it doesn't move there: through links whose transforms are all one.
  /// Nothing where there is no such way.
  [[nodiscard]] std::optional<Pose> fixed(const std::string& a, const std::string& b) const;
  /// world_from_frame at the stamps of the link that has most, in time's order; `world` empty: the root,
  /// or what is below it where that is the centre of the earth, which is then told. Empty where nothing on the
  /// way moves. Error{kInput} where `world` is not above it, or where nothing moves but in an earth.
  [[nodiscard]] std::vector<StampedPose> path(const std::string& frame, std::string& world) const;

 private:
  struct Link {
    std::string parent;
    std::vector<StampedPose> poses;  // parent_from_child
    bool is_fixed = false;
  };
  /// The links from a frame up to its root; of several parents the one that leads to one of `wanted`, else the
  /// one told of last, as tf2 has it. Error{kInput} for a circle.
  [[nodiscard]] std::vector<const Link*> above(const std::string& frame,
                                               const std::set<std::string>& wanted) const;
  [[nodiscard]] bool leads(const std::string& frame,
                           const std::set<std::string>& wanted,
                           std::set<std::string>& seen) const;

  std::string file_;
  std::map<std::string, std::vector<Link>> links_;  // by child; by their last stamp
  std::size_t count_ = 0;
};

/// A frame's name without the slash that older programs begin it with.
[[nodiscard]] std::string frame_name(const std::string& frame_id);

}  // namespace simuli::ros2
