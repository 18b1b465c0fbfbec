#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <optional>
#include <set>

#include "host/core/base/angles.hpp"
#include "host/core/base/error.hpp"
#include "host/core/base/spread.hpp"
#include "io/import/pandaset/pandaset_parts.hpp"

namespace simuli::pandaset {
namespace {

/// Column cuboids.sensor_id: -1, seen by one LiDAR only; 0, label of the Pandar64; 1, label of the PandarGT.
constexpr double kSeenByPandarGt = 1.0;

struct Label {
  std::string object, kind;
  PointSource source = PointSource::kPandar64;
  Eigen::Vector3d size_m;  // length, width, height
  Pose world_from_box;
};

/// Returns the median time of the points inside a box; no value without points.
std::optional<double> time_inside(const PointFrame& points, const Label& label) {
  const Pose box_from_world = label.world_from_box.inverse();
  const Eigen::Vector3d half = 0.5 * label.size_m;
  const double reach = half.squaredNorm();
  std::vector<double> times;
  for (std::size_t i = 0; i < points.position.size(); ++i) {
    if ((points.position[i] - label.world_from_box.translation).squaredNorm() > reach) continue;
    const Eigen::Vector3d p = box_from_world * points.position[i];
    if ((p.cwiseAbs().array() <= half.array()).all()) times.push_back(points.time_s[i]);
  }
  if (times.empty()) return {};
  return upper_median(std::move(times));
}

std::vector<Label> labels_of(const DataFrame& table, const std::string& file, const Frame& frame) {
  const auto numbers = [&](const char* column) { return table.numbers(column); };
  const std::vector<std::string> uuid = table.texts("uuid"), kind = table.texts("label");
  const std::vector<double> yaw = numbers("yaw"), x = numbers("position.x"), y = numbers("position.y"),
                            z = numbers("position.z"), width = numbers("dimensions.x"),
                            length = numbers("dimensions.y"), height = numbers("dimensions.z");
  std::vector<double> sensor;
  std::vector<std::string> sibling;
  if (table.has("cuboids.sensor_id") && table.has("cuboids.sibling_id")) {
    sensor = numbers("cuboids.sensor_id");
    sibling = table.texts("cuboids.sibling_id");
  }
  const std::set<std::string> here(uuid.begin(), uuid.end());
  std::vector<Label> out;
  for (std::size_t i = 0; i < uuid.size(); ++i) {
    if (!std::isfinite(yaw[i])) throw_input_error(file, fmt::format("yaw of box {}", i), "no number", "rad");
    Label label{uuid[i], kind[i], PointSource::kPandar64, {length[i], width[i], height[i]}, {}};
    if (!sensor.empty() && sensor[i] == kSeenByPandarGt) {
      label.source = PointSource::kPandarGt;
      const bool is_known = !sibling[i].empty() && sibling[i] != "-";
      if (is_known) label.object = sibling[i];
    }
    // The y axis of PandaSet's boxes is along the object.
    const Pose theirs{Eigen::Quaterniond(Eigen::AngleAxisd(yaw[i] + 0.5 * kPi, Eigen::Vector3d::UnitZ())),
                      {x[i], y[i], z[i]}};
    label.world_from_box = frame.world_from_theirs * theirs;
    out.push_back(std::move(label));
  }
  return out;
}

}  // namespace

void Boxes::add(const DataFrame& table,
                const std::string& file,
                const std::map<PointSource, PointFrame>& points,
                const Frame& frame,
                double front_s) {
  const std::vector<Label> labels = labels_of(table, file, frame);
  std::set<std::string> seen;  // by the Pandar64
  for (const Label& label : labels) {
    if (label.source == PointSource::kPandar64) seen.insert(label.object);
  }
  for (const Label& label : labels) {
    if (label.source == PointSource::kPandarGt && seen.contains(label.object)) {
      ++twice_;
      continue;
    }
    std::optional<double> time_s;
    // Labels seen by one LiDAR do not specify which.
    for (const PointSource source : {label.source, PointSource::kPandar64, PointSource::kPandarGt}) {
      const auto own = points.find(source);
      if (!time_s && own != points.end()) time_s = time_inside(own->second, label);
    }
    if (!time_s) ++by_front_;
    tracks_.add(label.object, label.kind, {time_s.value_or(front_s), label.world_from_box}, label.size_m);
  }
}

std::vector<Actor> Boxes::take(const std::string& file, PandasetReport& report) {
  report.boxes_twice = twice_;
  report.boxes_by_front = by_front_;
  return tracks_.take(file, report.labels);
}

}  // namespace simuli::pandaset
