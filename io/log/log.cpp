#include "io/log/log.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <utility>
#include <variant>

#include "host/core/base/error.hpp"
#include "host/core/base/names.hpp"
#include "host/core/base/spread.hpp"
#include "io/base/file.hpp"
#include "io/base/json_reader.hpp"
#include "io/log/camera_mask.hpp"
#include "io/log/log_json.hpp"
#include "io/log/new_log.hpp"
#include "io/picture/sized_image.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;

constexpr int kLogVersion = 1;
constexpr const char* kLogFormat = "simuli log";

const std::string& name_in(const LogCamera& camera) { return camera.model.name; }
const std::string& name_in(const LogLidar& lidar) { return name_of(lidar.model); }

template <class Sensor>
const Sensor& find_sensor(const std::vector<Sensor>& sensors,
                          const std::string& name,
                          const Log& log,
                          const char* field) {
  std::string known;
  for (const Sensor& sensor : sensors) {
    if (name_in(sensor) == name) return sensor;
    known += (known.empty() ? "" : ", ") + name_in(sensor);
  }
  throw_input_error(
      (log.folder / "log.json").string(), field, '"' + name + '"', known.empty() ? "none" : known);
}

/// Reads the name of a file in the log folder. Error{kInput} for a path out of the folder and for a missing file.
std::string read_file_name(JsonObject& object, const fs::path& folder, const char* key = "file") {
  std::string name = object.text(key);
  const fs::path path = inside(folder, name, object.file(), object.field(key));
  std::error_code status;
  if (!fs::is_regular_file(path, status)) {
    need_regular_file(path);
    throw_input_error(object.file(), object.field(key), '"' + name + "\", which is not there", "a file");
  }
  return name;
}

/// Reads the times and the file name of a picture or a sweep.
template <class Frame>
void read_frame(JsonObject& object, const Log& log, Frame& frame) {
  frame.file = read_file_name(object, log.folder);
  const FrameSpan span = frame_span_from_json(object, log.start_ns);
  frame.time_start_s = span.time_start_s;
  frame.time_end_s = span.time_end_s;
  const Trajectory& path = log.world_from_rig;
  if (!path.covers(frame.time_start_s) || !path.covers(frame.time_end_s)) {
    throw_input_error(object.file(),
                      object.field("time_start_ns"),
                      fmt::format("{} to {} s", frame.time_start_s, frame.time_end_s),
                      fmt::format("{} to {} s, the span of world_from_rig, and {} s beyond either end",
                                  path.start_s(),
                                  path.end_s(),
                                  Trajectory::kExtrapolation_s));
  }
}

template <class Frame>
Json frame_to_json(const Frame& frame,
                   const char* sensor_key,
                   const std::string& sensor,
                   std::int64_t start_ns) {
  Json json{{sensor_key, sensor}, {"file", frame.file}};
  json.update(to_json(FrameSpan{frame.time_start_s, frame.time_end_s}, start_ns, frame.file));
  return json;
}

/// Whether the log has sweeps of the LiDAR, whose durations determine its revolution.
bool has_sweeps(const Log& log, const LidarModel& lidar) {
  return std::any_of(log.sweeps.begin(), log.sweeps.end(), [&](const SweepFrame& frame) {
    return frame.lidar == name_of(lidar);
  });
}

/// Sets each LiDAR's revolution to the median duration of its recorded sweeps: spin rates in drives differ from the
/// sensor's nominal rate.
void set_sweep_durations(Log& log) {
  for (LogLidar& lidar : log.lidars) {
    std::vector<std::int64_t> durations_ns;
    for (const SweepFrame& frame : log.sweeps) {
      if (frame.lidar != name_of(lidar.model)) continue;
      durations_ns.push_back(std::llround((frame.time_end_s - frame.time_start_s) * 1e9));
    }
    if (durations_ns.empty()) continue;
    const auto usual_ns = static_cast<double>(upper_median(std::move(durations_ns)));
    const double sweep_s = std::min(usual_ns / 1e9, kLongestSweep_s);
    std::visit([&](auto& model) { model.sweep_s = sweep_s; }, lidar.model);
  }
}

/// Returns the text of log.json.
std::string text_of(const Log& log) {
  try {
    return to_json(log).dump(1) + '\n';
  } catch (const Json::exception& error) {
    throw_input_error((log.folder / "log.json").string(), "JSON", error.what(), "names in UTF-8");
  }
}

}  // namespace

Log log_from_json(JsonObject& root, const fs::path& folder) {
  Log log;
  log.folder = folder;
  if (root.text("format") != kLogFormat) {
    throw_input_error(
        root.file(), "format", '"' + root.text("format") + '"', std::string("\"") + kLogFormat + '"');
  }
  (void)root.integer("version", kLogVersion, kLogVersion);
  log.name = root.text("name");
  if (!log.name.empty()) need_name(log.name, root.file(), "name");
  log.start_ns = read_time_ns(root, "start_ns");
  read_sensors(root, log.cameras, log.lidars);
  log.world_from_rig = trajectory_from_json(root, "world_from_rig", log.start_ns);
  log.images = root.objects("images", [&](JsonObject& object) {
    ImageFrame frame;
    frame.camera = object.text("camera");
    (void)find_sensor(log.cameras, frame.camera, log, object.field("camera").c_str());
    read_frame(object, log, frame);
    return frame;
  });
  log.sweeps = root.objects("sweeps", [&](JsonObject& object) {
    SweepFrame frame;
    frame.lidar = object.text("lidar");
    (void)find_sensor(log.lidars, frame.lidar, log, object.field("lidar").c_str());
    read_frame(object, log, frame);
    if (!(frame.time_end_s > frame.time_start_s)) {
      throw_input_error(root.file(), object.field("time_end_ns"), "the start time", "after time_start_ns");
    }
    return frame;
  });
  if (root.has("points")) log.points = read_file_name(root, log.folder, "points");
  if (root.has("masks")) {
    log.masks = root.objects("masks", [&](JsonObject& object) {
      LogMask mask;
      mask.camera = object.text("camera");
      (void)find_sensor(log.cameras, mask.camera, log, object.field("camera").c_str());
      mask.file = read_file_name(object, log.folder, "file");
      return mask;
    });
  }
  if (root.has("actors")) log.actors = actors_from_json(root, "actors", log.start_ns);
  need_time_order(log.images, root.file(), "images");
  need_time_order(log.sweeps, root.file(), "sweeps");
  set_sweep_durations(log);
  return log;
}

const Lidar& LogLidar::with_rows() const {
  if (const auto* const lidar = std::get_if<Lidar>(&model)) return *lidar;
  throw_input_error("lidar " + name_of(model), "kind", "ray_list", "lidar: this needs its rows and columns");
}

const LogCamera& Log::camera(const std::string& camera_name) const {
  return find_sensor(cameras, camera_name, *this, "camera");
}

const LogLidar& Log::lidar(const std::string& lidar_name) const {
  return find_sensor(lidars, lidar_name, *this, "lidar");
}

Log read_log(const fs::path& folder) {
  if (!is_there(folder / "log.json") && is_there(folder / "scene.json")) {
    throw_input_error(folder.string(), "log", "a scene", "a log's folder: simuli import --help");
  }
  const fs::path file = inside(folder, "log.json", folder.string(), "file");
  Log log = read_json_text(
      read_file(file), file.string(), [&](JsonObject& root) { return log_from_json(root, folder); });
  read_masks(log);
  return log;
}

void read_masks(Log& log) {
  std::map<std::string, CameraMask> all;
  for (const LogMask& mask : log.masks) {
    CameraMask own = read_camera_mask(log.folder / mask.file, log.camera(mask.camera).model);
    const auto [there, is_first] = all.try_emplace(mask.camera, std::move(own));
    if (!is_first) there->second.add(own);
  }
  log.hidden.clear();
  for (auto& [camera, mask] : all) log.hidden[camera] = std::make_shared<const CameraMask>(std::move(mask));
}

Json to_json(const Log& log) {
  Json root{{"format", kLogFormat}, {"version", kLogVersion}, {"name", log.name}, {"start_ns", log.start_ns}};
  std::vector<LogLidar> lidars = log.lidars;
  for (LogLidar& lidar : lidars) {
    if (!has_sweeps(log, lidar.model)) continue;
    std::visit([](auto& model) { model.sweep_s = kUsualSweep_s; },
               lidar.model);  // the default is not written
  }
  add_sensors(root, log.cameras, lidars);
  root["world_from_rig"] = to_json(log.world_from_rig, log.start_ns);
  root["images"] = Json::array();
  root["sweeps"] = Json::array();
  for (const ImageFrame& frame : log.images) {
    root["images"].push_back(frame_to_json(frame, "camera", frame.camera, log.start_ns));
  }
  for (const SweepFrame& frame : log.sweeps) {
    root["sweeps"].push_back(frame_to_json(frame, "lidar", frame.lidar, log.start_ns));
  }
  if (!log.points.empty()) root["points"] = log.points;
  for (const LogMask& mask : log.masks)
    root["masks"].push_back({{"camera", mask.camera}, {"file", mask.file}});
  if (!log.actors.empty()) root["actors"] = to_json(log.actors, log.start_ns);
  return root;
}

void write_log(const Log& log) { write_file_atomically(log.folder / "log.json", text_of(log)); }

Log copy_log(const Log& log, const fs::path& folder, const std::map<std::string, fs::path>& files) {
  Log copy = log;
  return make_log(folder, copy, [&] {
    const auto bring = [&](const std::string& file) {
      const auto elsewhere = files.find(file);
      const fs::path from = elsewhere == files.end() ? log.folder / file : elsewhere->second;
      const fs::path to = copy.folder / file;
      fs::create_directories(to.parent_path());
      std::error_code failed;
      if (elsewhere == files.end()) fs::create_hard_link(from, to, failed);
      if (failed || elsewhere != files.end()) write_file_atomically(to, read_file(from));
    };
    for (const ImageFrame& frame : log.images) bring(frame.file);
    for (const SweepFrame& frame : log.sweeps) bring(frame.file);
    if (!log.points.empty()) bring(log.points);
    for (const LogMask& mask : log.masks) bring(mask.file);
  });
}

void sort_by_time(Log& log) {
  const auto is_earlier = [](const auto& a, const auto& b) { return a.time_start_s < b.time_start_s; };
  std::stable_sort(log.images.begin(), log.images.end(), is_earlier);
  std::stable_sort(log.sweeps.begin(), log.sweeps.end(), is_earlier);
}

Log on_path(Log log, const Trajectory& world_from_rig) {
  for (Actor& actor : log.actors) {
    for (KeyPose& key : actor.track) {
      const Pose change = world_from_rig.at(key.time_s) * log.world_from_rig.at(key.time_s).inverse();
      key.world_from_actor = change * key.world_from_actor;
      key.shift_m = change.rotation * key.shift_m;
      key.turn_rad = change.rotation * key.turn_rad;
    }
  }
  log.world_from_rig = world_from_rig;
  return log;
}

std::string log_hash(const Log& log) {
  std::string text = text_of(log);
  const auto add_size = [&](const std::string& file) {
    std::error_code absent;  // counts as empty; reading the frame reports the error
    const std::uintmax_t bytes = fs::file_size(log.folder / file, absent);
    text += fmt::format("{}\n", absent ? 0 : bytes);
  };
  for (const ImageFrame& frame : log.images) add_size(frame.file);
  for (const SweepFrame& frame : log.sweeps) add_size(frame.file);
  if (!log.points.empty()) add_size(log.points);
  for (const LogMask& mask : log.masks) add_size(mask.file);
  std::uint64_t hash = 0xcbf29ce484222325U;  // FNV-1a
  for (const char c : text) {
    hash ^= static_cast<unsigned char>(c);
    hash *= 0x100000001b3U;
  }
  return fmt::format("{:016x}", hash);
}

void copy_picture(const fs::path& from, const fs::path& to, const Camera& camera, const std::string& source) {
  (void)read_image(from, camera.width, camera.height, source);
  write_file_atomically(to, read_file(from));
}

}  // namespace simuli
