#include "io/import/nuscenes/nuscenes.hpp"

#include <algorithm>
#include <cstdint>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <map>
#include <set>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "host/core/base/error.hpp"
#include "host/core/base/names.hpp"
#include "io/base/file.hpp"
#include "io/base/json_reader.hpp"
#include "io/import/nuscenes/nuscenes_sweep.hpp"
#include "io/log/new_log.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;

constexpr const char* kLidar = "LIDAR_TOP";
// The lowest rows of the back camera show the ego vehicle; neurad-studio crops them.
constexpr const char* kSeesVehicle = "CAM_BACK";
constexpr double kVehicle = 80.0 / 900.0;

/// Reads a table: entries by token, each with the function `read`.
template <class Read>
void read_table(const fs::path& folder, const char* name, Read&& read) {
  const fs::path path = folder / (std::string(name) + ".json");
  read_json_entries(read_file(path), path.string(), [&](JsonObject& entry) {
    entry.ignore_other_keys();
    read(entry);
  });
}

Pose pose_of(JsonObject& entry) {
  const Eigen::Vector4d q = entry.vector<4>("rotation");
  if (!(q.norm() > 0.5 && q.norm() < 2.0)) {
    throw_input_error(entry.file(), entry.field("rotation"), "no rotation", "a unit quaternion");
  }
  return {Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized(), entry.vector<3>("translation")};
}

/// Returns the value for a token that another table contains.
template <class T>
const T& linked(const std::map<std::string, T>& table, JsonObject& entry, const char* key) {
  const auto found = table.find(entry.text(key));
  if (found != table.end()) return found->second;
  throw_input_error(entry.file(), entry.field(key), "a token of no entry", "one of the table it leads to");
}

struct Sensor {
  std::string channel, modality;
};
struct Mounted {
  Sensor sensor;
  Pose rig_from_sensor;
  std::vector<double> intrinsic;  // 3 x 3; empty for LiDARs
};
struct Recording {
  std::string channel, file;
  std::string calibration;  // token
  std::int64_t time_ns = 0;
  int width = 0, height = 0;
};

struct Tables {
  std::map<std::string, Mounted> mounted;  // by token of calibrated_sensor
  std::vector<Recording> recordings;       // of the scene, in time order
  std::vector<TimedPose> path;
  std::vector<Actor> actors;
  std::string scene;
  std::int64_t start_ns = 0;
};

fs::path table_folder(const NuscenesOptions& options) {
  if (!options.version.empty()) return options.root / options.version;
  std::vector<std::string> found;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(options.root, error)) {
    // Includes cyclic links, which are reported when they are read.
    if (is_there(entry.path() / "sample_data.json")) found.push_back(entry.path().filename().string());
  }
  std::sort(found.begin(), found.end());
  if (found.size() == 1) return options.root / found.front();
  throw_input_error(options.root.string(),
                    "folders of tables",
                    found.empty() ? "none" : fmt::format("{}", fmt::join(found, ", ")),
                    found.empty() ? "one such as v1.0-mini" : "one of them as --version");
}

/// Returns the token of the requested scene.
std::string find_scene(const fs::path& folder, const NuscenesOptions& options, Tables& tables) {
  std::map<std::string, std::string> token_of;
  read_table(folder, "scene", [&](JsonObject& s) { token_of[s.text("name")] = s.text("token"); });
  std::vector<std::string> names;
  for (const auto& [name, token] : token_of) names.push_back(name);
  const bool only = options.scene.empty() && names.size() == 1;
  tables.scene = only ? names.front() : options.scene;
  const auto found = token_of.find(tables.scene);
  if (found != token_of.end()) return found->second;
  throw_input_error((folder / "scene.json").string(),
                    "scene",
                    '"' + options.scene + '"',
                    names.empty() ? "at least one" : fmt::format("--scene {}", fmt::join(names, ", ")));
}

std::int64_t time_ns(JsonObject& entry) {
  constexpr std::int64_t kMost_us = 4'000'000'000'000'000;  // 2096
  return 1000 * entry.integer("timestamp", 0, kMost_us);
}

/// Returns the boxes of the scene's samples, one actor per instance, named "car_3" in table order.
std::vector<Actor> read_actors(const fs::path& folder,
                               const std::map<std::string, std::int64_t>& sample_ns,
                               std::int64_t start_ns,
                               LabelReport& report) {
  std::map<std::string, std::string> category;
  read_table(folder, "category", [&](JsonObject& c) { category[c.text("token")] = c.text("name"); });
  std::map<std::string, std::string> kind;  // by instance
  read_table(folder, "instance", [&](JsonObject& i) {
    kind[i.text("token")] = linked(category, i, "category_token");
  });
  LabelTracks tracks;
  read_table(folder, "sample_annotation", [&](JsonObject& a) {
    const auto sample = sample_ns.find(a.text("sample_token"));
    if (sample == sample_ns.end()) return;             // of another scene
    const Eigen::Vector3d size = a.vector<3>("size");  // width, length, height
    tracks.add(a.text("instance_token"),
               linked(kind, a, "instance_token"),
               {static_cast<double>(sample->second - start_ns) * 1e-9, pose_of(a)},
               {size[1], size[0], size[2]});
  });
  return tracks.take((folder / "sample_annotation.json").string(), report);
}

Tables read_tables(const NuscenesOptions& options, LabelReport& labels) {
  const fs::path folder = table_folder(options);
  Tables t;
  const std::string scene = find_scene(folder, options, t);
  std::map<std::string, std::int64_t> sample_ns;
  read_table(folder, "sample", [&](JsonObject& s) {
    if (s.text("scene_token") == scene) sample_ns[s.text("token")] = time_ns(s);
  });
  std::map<std::string, Sensor> sensors;
  read_table(folder, "sensor", [&](JsonObject& s) {
    need_name(s.text("channel"), s.file(), s.field("channel"));
    sensors[s.text("token")] = {s.text("channel"), s.text("modality")};
  });
  read_table(folder, "calibrated_sensor", [&](JsonObject& c) {
    Mounted m{linked(sensors, c, "sensor_token"), pose_of(c), {}};
    if (m.sensor.modality == "camera") {
      for (const Json& row : c.get("camera_intrinsic")) {
        for (const Json& value : row) m.intrinsic.push_back(value.is_number() ? value.get<double>() : 0.0);
      }
      if (m.intrinsic.size() != 9) {
        throw_input_error(c.file(), c.field("camera_intrinsic"), "another shape", "3 x 3 numbers");
      }
    }
    t.mounted[c.text("token")] = std::move(m);
  });
  std::map<std::string, std::int64_t> pose_ns;  // of the required ego poses
  read_table(folder, "sample_data", [&](JsonObject& d) {
    if (!sample_ns.contains(d.text("sample_token"))) return;
    const Mounted& m = linked(t.mounted, d, "calibrated_sensor_token");
    const bool is_camera = m.sensor.modality == "camera";
    if (!is_camera && m.sensor.channel != kLidar) return;  // radars
    (void)below(options.root, d.text("filename"), d.file(), d.field("filename"));
    Recording r{m.sensor.channel, d.text("filename"), d.text("calibrated_sensor_token"), time_ns(d), 0, 0};
    if (is_camera) {
      r.width = static_cast<int>(d.integer("width", 1, 65536));
      r.height = static_cast<int>(d.integer("height", 1, 65536));
    }
    pose_ns[d.text("ego_pose_token")] = r.time_ns;
    t.recordings.push_back(std::move(r));
  });
  if (t.recordings.empty()) {
    throw_input_error((folder / "sample_data.json").string(), "entries of " + t.scene, "none", "some");
  }
  std::stable_sort(t.recordings.begin(), t.recordings.end(), [](const Recording& a, const Recording& b) {
    return a.time_ns < b.time_ns;
  });
  t.start_ns = t.recordings.front().time_ns;
  std::map<std::int64_t, Pose> path;
  read_table(folder, "ego_pose", [&](JsonObject& p) {
    const auto found = pose_ns.find(p.text("token"));
    if (found != pose_ns.end()) path[found->second] = pose_of(p);
  });
  for (const auto& [ns, pose] : path) {
    t.path.push_back({static_cast<double>(ns - t.start_ns) * 1e-9, pose});
  }
  t.actors = read_actors(folder, sample_ns, t.start_ns, labels);
  return t;
}

Camera camera_of(const Recording& r, const Mounted& m) {
  Camera c;
  c.name = r.channel;
  c.width = r.width;
  c.height = r.height;
  c.fx = m.intrinsic[0];
  c.fy = m.intrinsic[4];
  c.cx = m.intrinsic[2] + 0.5;  // principal points are relative to the centre of the first pixel
  c.cy = m.intrinsic[5] + 0.5;
  validate(c, "calibrated_sensor.json");
  return c;
}

}  // namespace

Log import_nuscenes(const NuscenesOptions& options, const FrameProgress& progress, NuscenesReport& report) {
  Tables t = read_tables(options, report.labels);
  Log log;
  log.name = name_from(t.scene);
  log.start_ns = t.start_ns;
  log.actors = std::move(t.actors);
  std::error_code ignored;
  report.absent = std::erase_if(
      t.recordings, [&](const Recording& r) { return !fs::exists(options.root / r.file, ignored); });
  std::vector<const Recording*> pictures, turns;
  std::set<std::string> known;
  for (const Recording& r : t.recordings) {
    (r.channel == kLidar ? turns : pictures).push_back(&r);
    const Mounted& m = t.mounted.at(r.calibration);
    if (r.channel != kLidar && known.insert(r.channel).second) {
      log.cameras.push_back({camera_of(r, m), m.rig_from_sensor});
    }
  }
  if (pictures.empty() && turns.empty()) {
    throw_nothing_left(
        options.root.string(), "files", fmt::format("none of {}", report.absent), "at least one");
  }
  const auto seconds = [&](const Recording* r) {
    return static_cast<double>(r->time_ns - t.start_ns) * 1e-9;
  };
  constexpr double kRevolution_s = 0.05;
  std::vector<double> ends_s;
  for (const Recording* r : turns) ends_s.push_back(seconds(r));
  const std::vector<FrameSpan> spans = sweep_spans(ends_s, kRevolution_s, SweepStamp::kEnd);
  log.world_from_rig = Trajectory(std::move(t.path));
  if (!turns.empty()) {
    std::vector<fs::path> files;
    for (const Recording* r : turns) files.push_back(options.root / r->file);
    log.lidars = {
        {nuscenes::lidar_of(files, kLidar), t.mounted.at(turns.front()->calibration).rig_from_sensor}};
  }

  return make_import(options.output, log, [&] {
    LogMaker maker(log, progress, pictures.size() + turns.size());
    for (std::size_t i = 0; i < pictures.size(); ++i) {
      const Recording& r = *pictures[i];
      maker.add_picture(log.camera(r.channel).model,
                        fmt::format("{}_{:06}", r.channel, i),
                        options.root / r.file,
                        "sample_data.json",
                        {seconds(&r), seconds(&r)});
      maker.step();
    }
    report.hidden = hide_lowest(log, kSeesVehicle, kVehicle);
    for (std::size_t i = 0; i < turns.size(); ++i) {
      const Pose& mount = log.lidars[0].rig_from_lidar;
      const Trajectory& path = log.world_from_rig;
      const Pose start_from_end =
          (path.at(spans[i].time_start_s) * mount).inverse() * (path.at(spans[i].time_end_s) * mount);
      const Sweep sweep =
          nuscenes::read_turn(options.root / turns[i]->file, log.lidars[0].with_rows(), start_from_end);
      maker.add_sweep(kLidar, fmt::format("{:06}", i), sweep, spans[i]);
      maker.step();
    }
    report.rays = maker.rays();
    report.returned = maker.returned();
  });
}

}  // namespace simuli
