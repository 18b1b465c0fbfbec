#include "io/ncore/poses.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <map>

#include "host/core/base/error.hpp"

namespace simuli::ncore {
namespace {

constexpr std::uint64_t kLatest_us = std::uint64_t{1} << 53U;  // the year 2255

/// Parses a Python string of a key at `at`: in single or double quotes, with backslash escapes.
std::string quoted(const std::string& key, std::size_t& at, const std::string& file) {
  const auto refuse = [&] {
    throw_input_error(file, key.substr(0, 100), "no pair of frames", "a key such as ('rig', 'world')");
  };
  const char quote = at < key.size() ? key[at] : ' ';
  if (quote != '\'' && quote != '"') refuse();
  std::string out;
  for (++at; at < key.size() && key[at] != quote; ++at) {
    if (key[at] == '\\') ++at;
    if (at < key.size()) out.push_back(key[at]);
  }
  if (at >= key.size() || out.empty()) refuse();
  ++at;
  return out;
}

std::string in_quotes(const std::string& name) {
  std::string out = "'";
  for (const char c : name) {
    if (c == '\'' || c == '\\') out.push_back('\\');
    out.push_back(c);
  }
  return out + '\'';
}

}  // namespace

std::string key_of(const std::string& source, const std::string& target) {
  return '(' + in_quotes(source) + ", " + in_quotes(target) + ')';
}

std::pair<std::string, std::string> frames_of(const std::string& key, const std::string& file) {
  std::size_t at = 1;
  const std::string source = quoted(key, at, file);
  while (at < key.size() && (key[at] == ',' || key[at] == ' ')) ++at;
  return {source, quoted(key, at, file)};
}

Pose pose_of(const Json& matrix, const std::string& file, const std::string& field) {
  Eigen::Matrix4d values;
  const bool is_square =
      matrix.is_array() && matrix.size() == 4 &&
      std::all_of(matrix.begin(), matrix.end(), [](const Json& row) {
        return row.is_array() && row.size() == 4 &&
               std::all_of(row.begin(), row.end(), [](const Json& n) { return n.is_number(); });
      });
  if (!is_square) throw_input_error(file, field, "no matrix", "4 x 4 numbers");
  for (int r = 0; r < 4; ++r) {
    for (int c = 0; c < 4; ++c)
      values(r, c) = matrix[static_cast<std::size_t>(r)][static_cast<std::size_t>(c)].get<double>();
  }
  if (!values.allFinite() || values.row(3) != Eigen::RowVector4d(0.0, 0.0, 0.0, 1.0))
    throw_input_error(file, field, "no rigid transform", "rows of a rotation and a place, 0 0 0 1 the last");
  try {
    return Pose::from_matrix(values.topRows<3>());
  } catch (const Error&) {
    throw_input_error(file, field, "no rotation", "a rotation within 1 %");
  }
}

void PoseTable::add_static(const Json& attributes, const std::string& file) {
  for (const auto& item : attributes.items()) {
    const auto [source, target] = frames_of(item.key(), file);
    JsonObject entry(file, item.key(), item.value());
    static_.push_back({source, target, pose_of(entry.get("pose"), file, entry.field("pose"))});
  }
}

void PoseTable::add_dynamic(const Json& attributes, const std::string& file) {
  for (const auto& item : attributes.items()) {
    const auto [source, target] = frames_of(item.key(), file);
    JsonObject entry(file, item.key(), item.value());
    const Json &poses = entry.get("poses"), &stamps = entry.get("timestamps_us");
    if (!poses.is_array() || !stamps.is_array() || poses.size() != stamps.size() || poses.empty())
      throw_input_error(file, entry.field("poses"), "other numbers than timestamps_us", "one for each");
    Dynamic link{source, target, {}};
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const std::string at = fmt::format("{}[{}]", entry.field("timestamps_us"), i);
      if (!stamps[i].is_number_unsigned() || stamps[i].get<std::uint64_t>() > kLatest_us ||
          (i > 0 && stamps[i].get<std::uint64_t>() <= link.target_from_source.back().stamp_us))
        throw_input_error(file, at, "another value", "whole microseconds, each later than the one before");
      link.target_from_source.push_back(
          {stamps[i].get<std::uint64_t>(),
           pose_of(poses[i], file, fmt::format("{}[{}]", entry.field("poses"), i))});
    }
    dynamic_.push_back(std::move(link));
  }
}

std::optional<Pose> PoseTable::fixed(const std::string& a, const std::string& b) const {
  std::map<std::string, Pose> known{{a, Pose{}}};  // a_from_x
  for (bool grew = true; grew && known.find(b) == known.end();) {
    grew = false;
    for (const Static& link : static_) {
      const auto source = known.find(link.source), target = known.find(link.target);
      if (target != known.end() && source == known.end()) {
        grew = known.emplace(link.source, target->second * link.target_from_source).second;
      } else if (source != known.end() && target == known.end()) {
        grew = known.emplace(link.target, source->second * link.target_from_source.inverse()).second;
      }
    }
  }
  const auto found = known.find(b);
  if (found == known.end()) return std::nullopt;
  return found->second;
}

std::vector<StampedPose> PoseTable::path(const std::string& world, const std::string& rig) const {
  for (const bool direct : {true, false}) {
    for (const Dynamic& link : dynamic_) {
      const bool is_named = link.source == rig && link.target == world;
      if (direct != is_named) continue;
      if (direct) return link.target_from_source;
      const bool is_turned = !fixed(world, link.target);
      const std::optional<Pose> world_from_upper = fixed(world, is_turned ? link.source : link.target),
                                lower_from_rig = fixed(is_turned ? link.target : link.source, rig);
      if (!world_from_upper || !lower_from_rig) continue;
      std::vector<StampedPose> out;
      for (const StampedPose& p : link.target_from_source) {
        out.push_back(
            {p.stamp_us, *world_from_upper * (is_turned ? p.pose.inverse() : p.pose) * *lower_from_rig});
      }
      return out;
    }
  }
  return {};
}

std::string PoseTable::pairs() const {
  std::string out;
  const auto add = [&](const std::string& source, const std::string& target) {
    constexpr std::size_t kLongest = 300;
    if (out.size() > kLongest) return;
    out += (out.empty() ? "" : ", ") + source.substr(0, 60) + " to " + target.substr(0, 60);
  };
  for (const Dynamic& link : dynamic_) add(link.source, link.target);
  for (const Static& link : static_) add(link.source, link.target);
  return out.empty() ? "none" : out;
}

Eigen::Quaterniond rotation_of_euler(const Eigen::Vector3d& xyz_rad) {
  return Eigen::AngleAxisd(xyz_rad.z(), Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(xyz_rad.y(), Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(xyz_rad.x(), Eigen::Vector3d::UnitX());
}

Eigen::Vector3d euler_of(const Eigen::Quaterniond& rotation) {
  const Eigen::Matrix3d m = rotation.toRotationMatrix();
  const double across = std::hypot(m(0, 0), m(1, 0));
  // In gimbal lock, roll and yaw are the same rotation; it is returned as yaw.
  if (across < 1e-12) return {0.0, std::atan2(-m(2, 0), across), std::atan2(-m(0, 1), m(1, 1))};
  return {std::atan2(m(2, 1), m(2, 2)), std::atan2(-m(2, 0), across), std::atan2(m(1, 0), m(0, 0))};
}

}  // namespace simuli::ncore
