#include "io/import/ros2/transform_tree.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <set>

#include "host/core/base/error.hpp"

namespace simuli::ros2 {
namespace {

/// Interpolates between the poses around a stamp; clamps at the ends.
Pose at(const std::vector<StampedPose>& poses, std::int64_t stamp_ns) {
  const auto after =
      std::lower_bound(poses.begin(), poses.end(), stamp_ns, [](const StampedPose& p, std::int64_t ns) {
        return p.stamp_ns < ns;
      });
  if (after == poses.end()) return poses.back().pose;
  if (after == poses.begin() || after->stamp_ns == stamp_ns) return after->pose;
  const StampedPose& before = *(after - 1);
  const double share = static_cast<double>(stamp_ns - before.stamp_ns) /
                       static_cast<double>(after->stamp_ns - before.stamp_ns);
  return interpolate(before.pose, after->pose, share);
}

/// Whether the parent's origin is the centre of the earth (REP 105's earth frame, of any name): its distance
/// along the child's z agrees with the earth's radius. UTM northings are as large, but horizontal.
bool is_on_earth(const Pose& pose) {
  constexpr double kLeast_m = 6.33e6;  // polar radius minus 20 km
  constexpr double kMost_m = 6.40e6;   // equatorial radius plus 20 km
  constexpr double kLeastCosine = 0.8;
  const double distance_m = pose.translation.norm();
  const double along_z_m = std::abs(pose.translation.dot(pose.rotation * Eigen::Vector3d::UnitZ()));
  return distance_m > kLeast_m && distance_m < kMost_m && along_z_m > kLeastCosine * distance_m;
}

bool are_one(const std::vector<StampedPose>& poses) {
  constexpr double kSame = 1e-6;  // m, rad: rounding of equal poses by a publisher
  const Pose& first = poses.front().pose;
  return std::all_of(poses.begin(), poses.end(), [&](const StampedPose& p) {
    return (p.pose.translation - first.translation).norm() <= kSame &&
           p.pose.rotation.angularDistance(first.rotation) <= kSame;
  });
}

}  // namespace

std::string frame_name(const std::string& frame_id) {
  return frame_id.starts_with('/') ? frame_id.substr(1) : frame_id;
}

void sort_by_stamp(std::vector<StampedPose>& poses) {
  std::stable_sort(poses.begin(), poses.end(), [](const StampedPose& a, const StampedPose& b) {
    return a.stamp_ns < b.stamp_ns;
  });
  std::vector<StampedPose> kept;
  for (const StampedPose& pose : poses) {
    if (!kept.empty() && kept.back().stamp_ns == pose.stamp_ns) kept.pop_back();
    kept.push_back(pose);
  }
  poses = std::move(kept);
}

void TransformTree::add(const TransformMessage& transform) {
  constexpr std::size_t kMost = 10'000'000;
  if (++count_ > kMost) throw_input_error(file_, "/tf", "more transforms", fmt::format("at most {}", kMost));
  const std::string parent = frame_name(transform.header.frame_id),
                    child = frame_name(transform.child_frame_id);
  std::vector<Link>& links = links_[child];
  auto link = std::find_if(links.begin(), links.end(), [&](const Link& l) { return l.parent == parent; });
  if (link == links.end()) link = links.insert(links.end(), Link{parent, {}});
  link->poses.push_back({transform.header.stamp_ns, transform.parent_from_child});
}

void TransformTree::finish() {
  for (auto& [child, links] : links_) {
    for (Link& link : links) {
      sort_by_stamp(link.poses);
      link.is_fixed = are_one(link.poses);
    }
    std::stable_sort(links.begin(), links.end(), [](const Link& a, const Link& b) {
      return a.poses.back().stamp_ns < b.poses.back().stamp_ns;
    });
  }
}

bool TransformTree::has(const std::string& frame) const {
  return links_.count(frame) != 0 || std::any_of(links_.begin(), links_.end(), [&](const auto& child) {
           return std::any_of(child.second.begin(), child.second.end(), [&](const Link& link) {
             return link.parent == frame;
           });
         });
}

std::vector<std::string> TransformTree::ambiguous() const {
  std::vector<std::string> names;
  for (const auto& [child, links] : links_) {
    if (links.size() > 1) names.push_back(child);
  }
  return names;
}

std::string TransformTree::frames() const {
  std::set<std::string> names;
  for (const auto& [child, links] : links_) {
    for (const Link& link : links) names.insert({child, link.parent});
  }
  return names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "));
}

bool TransformTree::leads(const std::string& frame,
                          const std::set<std::string>& wanted,
                          std::set<std::string>& seen) const {
  if (wanted.count(frame) != 0) return true;
  const auto links = links_.find(frame);
  if (links == links_.end() || !seen.insert(frame).second) return false;
  return std::any_of(links->second.begin(), links->second.end(), [&](const Link& link) {
    return leads(link.parent, wanted, seen);
  });
}

std::vector<const TransformTree::Link*> TransformTree::above(const std::string& frame,
                                                             const std::set<std::string>& wanted) const {
  std::vector<const Link*> way;
  for (auto links = links_.find(frame); links != links_.end(); links = links_.find(way.back()->parent)) {
    const Link* next = &links->second.back();
    for (const Link& link : links->second) {
      std::set<std::string> seen;
      if (links->second.size() > 1 && leads(link.parent, wanted, seen)) next = &link;
    }
    way.push_back(next);
    if (way.size() > links_.size())
      throw_input_error(file_, "/tf: frame " + frame, "in itself, by way of others", "in a tree of frames");
  }
  return way;
}

std::optional<Pose> TransformTree::fixed(const std::string& a, const std::string& b) const {
  std::map<std::string, Pose> from_b;  // a_from_b of frames b
  Pose up;
  from_b[b] = up;
  for (const Link* link : above(b, {a})) {
    if (!link->is_fixed) break;
    up = link->poses.front().pose * up;
    from_b[link->parent] = up;
  }
  Pose from_a;
  if (from_b.count(a) != 0) return from_b[a];
  std::set<std::string> common_with;
  for (const auto& [frame, unused] : from_b) common_with.insert(frame);
  for (const Link* link : above(a, common_with)) {
    if (!link->is_fixed) break;
    from_a = link->poses.front().pose * from_a;
    const auto common = from_b.find(link->parent);
    if (common != from_b.end()) return from_a.inverse() * common->second;
  }
  return {};
}

std::vector<StampedPose> TransformTree::path(const std::string& frame, std::string& world) const {
  std::vector<const Link*> links;
  bool is_found = world.empty() || world == frame;
  for (const Link* link : above(frame, {world})) {
    if (!world.empty() && is_found) break;
    links.push_back(link);
    is_found = is_found || link->parent == world;
  }
  if (!is_found)
    throw_input_error(file_, "/tf: frame " + frame, "not in " + world, "one that it is in: " + frames());
  if (world.empty()) {
    const auto moves = [](const Link* link) { return !link->is_fixed; };
    const auto earth = std::find_if(
        links.begin(), links.end(), [](const Link* link) { return is_on_earth(link->poses.front().pose); });
    if (earth != links.end() && std::any_of(earth, links.end(), moves) &&
        std::none_of(links.begin(), earth, moves)) {
      throw_input_error(file_,
                        "/tf: frame " + frame,
                        "moved in " + (*earth)->parent + " alone, from the centre of the earth",
                        "a frame between whose z is up, or --world-frame");
    }
    links.erase(earth, links.end());
    if (!links.empty()) world = links.back()->parent;
  }
  const Link* fastest = nullptr;
  for (const Link* link : links) {
    if (!link->is_fixed && (fastest == nullptr || link->poses.size() > fastest->poses.size())) fastest = link;
  }
  if (fastest == nullptr) return {};
  std::vector<StampedPose> path;
  for (const StampedPose& sample : fastest->poses) {
    const bool is_known = std::all_of(links.begin(), links.end(), [&](const Link* link) {
      return link->is_fixed || (link->poses.front().stamp_ns <= sample.stamp_ns &&
                                sample.stamp_ns <= link->poses.back().stamp_ns);
    });
    if (!is_known) continue;
    Pose up;
    for (const Link* link : links) up = at(link->poses, sample.stamp_ns) * up;
    path.push_back({sample.stamp_ns, up});
  }
  return path;
}

}  // namespace simuli::ros2
