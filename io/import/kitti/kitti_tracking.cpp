// Boxes of the KITTI tracking benchmark as actors.
#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <numbers>
#include <sstream>

#include "host/core/base/error.hpp"
#include "host/core/base/names.hpp"
#include "io/import/kitti/kitti_parts.hpp"

namespace simuli::kitti {
namespace {

namespace fs = std::filesystem;

/// frame, track id, type, truncated, occluded, alpha, left, top, right, bottom, height, width, length, x, y,
/// z, rotation_y (development kit of the benchmark).
constexpr std::size_t kColumns = 17;
constexpr int kNumbersFrom = 3;  // index of the first number, after the type

struct Label {
  int frame = 0;
  int track = 0;
  std::string type;
  Eigen::Vector3d size_m;  // length, width, height
  Pose rect00_from_box;
};

int parse_index(const std::string& text, const fs::path& file, const std::string& field) {
  int value = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || stop != text.data() + text.size() || value < -1) {
    throw_input_error(file.string(), field, '"' + text.substr(0, 40) + '"', "a whole number");
  }
  return value;
}

Label parse_label(const std::string& line, const fs::path& file, const std::string& where) {
  std::istringstream words(line);
  std::array<std::string, kNumbersFrom> head;
  words >> head[0] >> head[1] >> head[2];
  std::string rest;
  std::getline(words, rest);
  const std::vector<double> v = parse_numbers(rest, kColumns - kNumbersFrom, file, where);
  Label label;
  label.frame = parse_index(head[0], file, where + ": frame");
  label.track = parse_index(head[1], file, where + ": track id");
  label.type = head[2];
  label.size_m = {v[9], v[8], v[7]};
  // The x axis of the box is its length, rotated about the camera's y (down); the labelled point is the bottom
  // centre.
  const double yaw = v[13];
  Eigen::Matrix<double, 3, 4> rect00_from_box;
  rect00_from_box.col(0) << std::cos(yaw), 0.0, -std::sin(yaw);
  rect00_from_box.col(2) << 0.0, -1.0, 0.0;
  rect00_from_box.col(1) = rect00_from_box.col(2).head<3>().cross(rect00_from_box.col(0).head<3>());
  rect00_from_box.col(3) << v[10], v[11] - 0.5 * label.size_m.z(), v[12];
  label.rect00_from_box = Pose::from_matrix(rect00_from_box);
  return label;
}

/// Returns the time at which the LiDAR, clockwise from behind, scans the box's centre.
double time_met(const Eigen::Vector3d& p_velo, double start_s, double end_s) {
  const double azimuth = std::atan2(p_velo.y(), p_velo.x());
  return start_s + (std::numbers::pi - azimuth) / (2.0 * std::numbers::pi) * (end_s - start_s);
}

}  // namespace

std::vector<Actor> read_tracking(const fs::path& file,
                                 const Pose& rect00_from_velo,
                                 const SweepTimes& sweeps,
                                 LabelReport& report) {
  const Pose velo_from_rect00 = rect00_from_velo.inverse();
  std::map<int, std::vector<std::pair<KeyPose, Label>>> objects;  // by track id
  for (const auto& [number, line] : numbered_lines(file)) {
    const std::string where = fmt::format("line {}", number);
    Label label = parse_label(line, file, where);
    // Index of the frame among the sweeps; frames before the first wrap to a large number.
    const std::size_t frame = static_cast<std::size_t>(label.frame) - sweeps.first;
    if (label.type == "DontCare" || frame >= sweeps.start_s.size()) continue;
    const Pose velo_from_box = velo_from_rect00 * label.rect00_from_box;
    KeyPose key;
    key.time_s = time_met(velo_from_box.translation, sweeps.start_s[frame], sweeps.end_s[frame]);
    key.world_from_actor = sweeps.world_from_velo.at(key.time_s) * velo_from_box;
    std::transform(label.type.begin(), label.type.end(), label.type.begin(), [](unsigned char letter) {
      return static_cast<char>(std::tolower(letter));
    });
    objects[label.track].emplace_back(key, std::move(label));
  }
  LabelTracks tracks;
  for (const auto& [track, labels] : objects) {
    const std::string id = std::to_string(track);
    for (const auto& [key, label] : labels)
      tracks.add(id, label.type, key, label.size_m, name_from(label.type + "_" + id));
  }
  return tracks.take(file.string(), report);
}

}  // namespace simuli::kitti
