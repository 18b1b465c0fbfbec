#include "io/log/log_json.hpp"

#include <charconv>
#include <cmath>
#include <cstdint>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <set>
#include <string>
#include <system_error>
#include <vector>

#include "host/core/base/error.hpp"
#include "host/core/base/names.hpp"
#include "io/log/sensor_json.hpp"

namespace simuli {
namespace {

constexpr double kLongestLog_s = 3.8e9;                           // 120 years
constexpr std::int64_t kLatest_ns = 4'000'000'000'000'000'000LL;  // differences of two still fit int64
constexpr double kUnitNormTolerance = 1e-3;  // a quaternion printed with 4 digits is still one

Json array_of(const Eigen::Ref<const Eigen::VectorXd>& values) {
  Json array = Json::array();
  for (const double value : values) array.push_back(value);
  return array;
}

}  // namespace

Json to_json(const Pose& a_from_b) {
  const Eigen::Quaterniond& q = a_from_b.rotation;
  if (!(a_from_b.translation.allFinite() && std::abs(q.norm() - 1.0) <= kUnitNormTolerance)) {
    throw_input_error("pose", "value", "NaN, Inf or no unit quaternion", "a rigid transform");
  }
  return {{"position_m", array_of(a_from_b.translation)},
          {"rotation_wxyz", Json::array({q.w(), q.x(), q.y(), q.z()})}};
}

Pose pose_from_json(JsonObject& object) {
  Pose a_from_b;
  a_from_b.translation = object.vector<3>("position_m");
  const Eigen::Vector4d wxyz = object.vector<4>("rotation_wxyz");
  if (!(std::abs(wxyz.norm() - 1.0) <= kUnitNormTolerance)) {
    throw_input_error(object.file(),
                      object.field("rotation_wxyz"),
                      fmt::format("length {}", wxyz.norm()),
                      "a unit quaternion");
  }
  a_from_b.rotation = Eigen::Quaterniond(wxyz[0], wxyz[1], wxyz[2], wxyz[3]).normalized();
  return a_from_b;
}

Json to_json(const LogCamera& camera) {
  Json json = to_json(camera.model);
  json["rig_from_camera"] = to_json(camera.rig_from_camera);
  return json;
}

LogCamera camera_from_json(JsonObject& object) {
  LogCamera camera;
  camera.model = camera_model_from_json(object);
  camera.rig_from_camera = object.object("rig_from_camera", pose_from_json);
  return camera;
}

Json to_json(const LogLidar& lidar) {
  Json json = to_json(lidar.model);
  json["rig_from_lidar"] = to_json(lidar.rig_from_lidar);
  return json;
}

LogLidar lidar_from_json(JsonObject& object) {
  LogLidar lidar;
  lidar.model = lidar_model_from_json(object);
  lidar.rig_from_lidar = object.object("rig_from_lidar", pose_from_json);
  return lidar;
}

void add_sensors(Json& object, const std::vector<LogCamera>& cameras, const std::vector<LogLidar>& lidars) {
  object["cameras"] = Json::array();
  object["lidars"] = Json::array();
  for (const LogCamera& camera : cameras) {
    validate(camera.model, "sensors to write");
    object["cameras"].push_back(to_json(camera));
  }
  for (const LogLidar& lidar : lidars) {
    validate(lidar.model, "sensors to write");
    object["lidars"].push_back(to_json(lidar));
  }
}

void read_sensors(JsonObject& object, std::vector<LogCamera>& cameras, std::vector<LogLidar>& lidars) {
  cameras = object.objects("cameras", camera_from_json);
  lidars = object.objects("lidars", lidar_from_json);
  std::set<std::string> names;
  const auto need_new = [&](const std::string& name, const char* key) {
    if (names.insert(name).second) return;
    throw_input_error(
        object.file(), object.field(key), "the name \"" + name + "\" twice", "one name per sensor");
  };
  for (const LogCamera& camera : cameras) need_new(camera.model.name, "cameras");
  for (const LogLidar& lidar : lidars) need_new(name_of(lidar.model), "lidars");
}

Json to_json(const Trajectory& world_from_rig, std::int64_t start_ns) {
  Json poses = Json::array();
  for (const TimedPose& timed : world_from_rig.poses()) {
    Json entry{{"time_ns", to_ns(timed.time_s, start_ns, "world_from_rig")}};
    entry.update(to_json(timed.pose));
    poses.push_back(std::move(entry));
  }
  return poses;
}

Trajectory trajectory_from_json(JsonObject& parent, const std::string& key, std::int64_t start_ns) {
  std::vector<TimedPose> poses = parent.objects(key, [&](JsonObject& object) {
    const double time_s = read_time_s(object, "time_ns", start_ns);
    return TimedPose{time_s, pose_from_json(object)};
  });
  return with_context("reading " + parent.file() + ": " + parent.field(key),
                      [&] { return Trajectory(std::move(poses)); });
}

namespace {

constexpr double kMicrometre = 1e-6;

/// Knots are written as text rows of whole micrometres: one number per line would take ten times the space of the track.
Json to_json(const Deformation& shape, std::int64_t start_ns, const std::string& name) {
  const std::size_t row = 3 * shape.node_count();
  Json knots = Json::array();
  for (std::size_t knot = 0; knot < shape.knots(); ++knot) {
    std::vector<std::int64_t> rounded;
    for (std::size_t i = 0; i < row; ++i)
      rounded.push_back(std::llround(shape.offsets_m[knot * row + i] / kMicrometre));
    knots.push_back(fmt::format("{}", fmt::join(rounded, " ")));
  }
  return {{"nodes", shape.nodes},
          {"time_ns", to_ns(shape.start_s, start_ns, name)},
          {"interval_s", shape.interval_s},
          {"knots_um", std::move(knots)}};
}

Deformation read_deformation(JsonObject& object, std::int64_t start_ns) {
  Deformation shape;
  const auto nodes = object.vector<3>("nodes");
  for (Eigen::Index k = 0; k < 3; ++k) {
    if (!(nodes(k) >= 2.0 && nodes(k) <= kMostDeformationNodes && nodes(k) == std::floor(nodes(k)))) {
      throw_input_error(object.file(),
                        object.field("nodes"),
                        fmt::format("{}", nodes(k)),
                        fmt::format("whole numbers from 2 to {}", kMostDeformationNodes));
    }
    shape.nodes[static_cast<std::size_t>(k)] = static_cast<int>(nodes(k));
  }
  shape.start_s = read_time_s(object, "time_ns", start_ns);
  shape.interval_s = object.number("interval_s");
  const Json& knots = object.get("knots_um");
  const std::size_t row = 3 * shape.node_count();
  const auto refuse = [&](const std::string& found) {
    throw_input_error(
        object.file(), object.field("knots_um"), found, fmt::format("rows of {} whole numbers", row));
  };
  if (!knots.is_array() || knots.empty()) refuse("none");
  for (const Json& knot : knots) {
    if (!knot.is_string()) refuse("no text");
    const auto& text = knot.get_ref<const std::string&>();
    const std::size_t before = shape.offsets_m.size();
    const char* const end = text.data() + text.size();
    for (const char* at = text.data(); at != end && shape.offsets_m.size() < before + row;) {
      std::int32_t value = 0;
      const auto [next, error] = std::from_chars(at, end, value);
      const bool parted = next == end || (*next == ' ' && next + 1 != end);
      if (error != std::errc() || !parted) refuse('"' + text.substr(0, 40) + '"');
      shape.offsets_m.push_back(kMicrometre * value);
      at = next == end ? end : next + 1;
      if (shape.offsets_m.size() == before + row && at != end) refuse("more");
    }
    if (shape.offsets_m.size() != before + row) refuse(fmt::format("{}", shape.offsets_m.size() - before));
  }
  return shape;
}

}  // namespace

Json to_json(const std::vector<Actor>& actors, std::int64_t start_ns) {
  Json out = Json::array();
  for (const Actor& actor : actors) {
    validate(actor, "actors to write");
    Json track = Json::array();
    for (const KeyPose& key : actor.track) {
      Json entry{{"time_ns", to_ns(key.time_s, start_ns, actor.name)}};
      entry.update(to_json(key.world_from_actor));
      if (!(key.shift_m.isZero(0.0) && key.turn_rad.isZero(0.0))) {
        entry["shift_m"] = array_of(key.shift_m);
        entry["turn_rad"] = array_of(key.turn_rad);
      }
      track.push_back(std::move(entry));
    }
    out.push_back({{"name", actor.name},
                   {"kind", actor.kind},
                   {"length_m", actor.size_m.x()},
                   {"width_m", actor.size_m.y()},
                   {"height_m", actor.size_m.z()},
                   {"track", std::move(track)}});
    if (!actor.deformation.empty())
      out.back()["deformation"] = to_json(actor.deformation, start_ns, actor.name);
  }
  return out;
}

std::vector<Actor> actors_from_json(JsonObject& parent, const std::string& key, std::int64_t start_ns) {
  std::set<std::string> names;
  return parent.objects(key, [&](JsonObject& object) {
    Actor actor;
    actor.name = object.text("name");
    need_name(actor.name, object.file(), object.field("name"));
    actor.kind = object.text("kind");
    actor.size_m = {object.number("length_m"), object.number("width_m"), object.number("height_m")};
    actor.track = object.objects("track", [&](JsonObject& entry) {
      KeyPose pose;
      pose.time_s = read_time_s(entry, "time_ns", start_ns);
      pose.world_from_actor = pose_from_json(entry);
      if (entry.has("shift_m")) pose.shift_m = entry.vector<3>("shift_m");
      if (entry.has("turn_rad")) pose.turn_rad = entry.vector<3>("turn_rad");
      return pose;
    });
    if (object.has("deformation")) {
      actor.deformation =
          object.object("deformation", [&](JsonObject& shape) { return read_deformation(shape, start_ns); });
    }
    validate(actor, object.file());
    if (!names.insert(actor.name).second) {
      throw_input_error(
          object.file(), object.field("name"), '"' + actor.name + "\" twice", "one name per actor");
    }
    return actor;
  });
}

Json to_json(const FrameSpan& span, std::int64_t start_ns, const std::string& field) {
  return {{"time_start_ns", to_ns(span.time_start_s, start_ns, field)},
          {"time_end_ns", to_ns(span.time_end_s, start_ns, field)}};
}

FrameSpan frame_span_from_json(JsonObject& object, std::int64_t start_ns) {
  const FrameSpan span{read_time_s(object, "time_start_ns", start_ns),
                       read_time_s(object, "time_end_ns", start_ns)};
  if (!(span.time_end_s >= span.time_start_s)) {
    throw_input_error(object.file(),
                      object.field("time_end_ns"),
                      fmt::format("{} ns before the start", (span.time_start_s - span.time_end_s) * 1e9),
                      "not before time_start_ns");
  }
  return span;
}

std::int64_t to_ns(double time_s, std::int64_t start_ns, const std::string& field) {
  if (!(std::abs(time_s) <= kLongestLog_s)) {
    throw_input_error("log", field, fmt::format("{} s", time_s), "at most 120 years from the log's start");
  }
  return start_ns + static_cast<std::int64_t>(std::llround(time_s * 1e9));
}

std::int64_t read_time_ns(JsonObject& object, const std::string& key) {
  return object.integer(key, -kLatest_ns, kLatest_ns);
}

double read_time_s(JsonObject& object, const std::string& key, std::int64_t start_ns) {
  return static_cast<double>(read_time_ns(object, key) - start_ns) * 1e-9;
}

}  // namespace simuli
