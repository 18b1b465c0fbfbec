#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "host/core/base/angles.hpp"
#include "host/core/base/error.hpp"
#include "io/base/file.hpp"
#include "io/base/json_reader.hpp"
#include "io/import/pandaset/pandaset_parts.hpp"

namespace simuli::pandaset {
namespace {

namespace fs = std::filesystem;

constexpr double kLast_s = 4e9;       // 2096
constexpr double kFarthest_m = 1e5;   // from the sequence's origin
constexpr double kBrightest = 255.0;  // column i

Pose pose_of(JsonObject& entry) {
  entry.ignore_other_keys();
  Eigen::Vector4d q;
  Eigen::Vector3d position;
  entry.object("heading", [&](JsonObject& heading) {
    q = {heading.number("w"), heading.number("x"), heading.number("y"), heading.number("z")};
  });
  entry.object("position", [&](JsonObject& p) {
    position = {p.number("x", -kFarthest_m, kFarthest_m),
                p.number("y", -kFarthest_m, kFarthest_m),
                p.number("z", -kFarthest_m, kFarthest_m)};
  });
  if (!(q.norm() > 0.5 && q.norm() < 2.0))
    throw_input_error(entry.file(), entry.field("heading"), "no rotation", "a unit quaternion");
  return {Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized(), position};
}

/// Returns a non-empty JSON array.
Json read_array(const std::string& file) {
  Json root = parse_json(read_file(file), file);
  if (!root.is_array() || root.empty()) throw_input_error(file, "root", "no array, or none in it", "[...]");
  return root;
}

std::int64_t nanoseconds(double time_s) { return std::llround(1e9 * time_s); }

}  // namespace

// docs/static_extrinsic_calibration.yaml of the data set's devkit (CC BY 4.0). Camera transforms are from the
// Pandar64; that of front_gt is to it: seen from this position, the PandarGT's scan lines are continuous across
// range discontinuities.
Pose camera_from_pandar64() {
  return {
      Eigen::Quaterniond(0.016213200031258722, 0.0030578899383849464, 0.7114721800418571, -0.7025205466606356)
          .normalized(),
      {0.0002585796504896516, -0.03907777167811011, -0.0440125762408362}};
}
Pose pandar64_from_pandargt() {
  return {
      Eigen::Quaterniond(0.021475754959146356, -0.002060907279494794, 0.01134678181520767, 0.9997028534282365)
          .normalized(),
      {-0.000451117754, -0.605646431446, -0.301525235176}};
}

// The vehicle drives along -y of its Pandar64.
Pose rig_from_pandar64() {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(0.5 * kPi, Eigen::Vector3d::UnitZ())),
          Eigen::Vector3d::Zero()};
}

Posed read_posed(const fs::path& folder) {
  const std::string pose_file = (folder / "poses.json").string();
  const std::string time_file = (folder / "timestamps.json").string();
  const Json poses = read_array(pose_file), times = read_array(time_file);
  if (poses.size() != times.size()) {
    throw_input_error(time_file,
                      "times",
                      fmt::format("{}", times.size()),
                      fmt::format("{}, one for each pose of poses.json", poses.size()));
  }
  Posed out;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const std::string where = fmt::format("[{}]", i);
    JsonObject entry(pose_file, where, poses[i]);
    out.poses.push_back(pose_of(entry));
    const double time_s = times[i].is_number() ? times[i].get<double>() : -1.0;
    if (!(time_s >= 0.0 && time_s <= kLast_s))
      throw_input_error(time_file, where, "no time", "seconds, to 2096");
    out.times_ns.push_back(nanoseconds(time_s));
    if (i > 0 && out.times_ns[i] <= out.times_ns[i - 1])
      throw_input_error(time_file, where, "a time not after the one above", "times that rise");
  }
  return out;
}

double PointFrame::first_s() const { return *std::min_element(time_s.begin(), time_s.end()); }
double PointFrame::last_s() const { return *std::max_element(time_s.begin(), time_s.end()); }

std::map<PointSource, PointFrame> read_points(const fs::path& file, const Frame& frame) {
  const DataFrame table(file);
  const std::vector<double> x = table.numbers("x"), y = table.numbers("y"), z = table.numbers("z"),
                            intensity = table.numbers("i"), time_s = table.numbers("t"),
                            sensor = table.numbers("d");
  std::map<PointSource, PointFrame> out;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const auto need = [&](const char* column, double found, double low, double high) {
      if (found >= low && found <= high) return;
      throw_input_error(file.string(),
                        fmt::format("point {}: {}", i, column),
                        fmt::format("{}", found),
                        fmt::format("{} to {}", low, high));
    };
    need("x", x[i], -kFarthest_m, kFarthest_m);
    need("y", y[i], -kFarthest_m, kFarthest_m);
    need("z", z[i], -kFarthest_m, kFarthest_m);
    need("i", intensity[i], 0.0, kBrightest);
    need("t", time_s[i], 0.0, kLast_s);
    if (sensor[i] != 0.0) need("d", sensor[i], 1.0, 1.0);
    PointFrame& own = out[sensor[i] == 0.0 ? PointSource::kPandar64 : PointSource::kPandarGt];
    own.position.push_back(frame.world_from_theirs * Eigen::Vector3d(x[i], y[i], z[i]));
    own.intensity.push_back(static_cast<float>(intensity[i] / kBrightest));
    own.time_s.push_back(frame.seconds(nanoseconds(time_s[i])));
  }
  return out;
}

}  // namespace simuli::pandaset
