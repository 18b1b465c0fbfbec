#include "io/scene/scene_folder.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <limits>
#include <system_error>
#include <utility>

#include "host/core/base/error.hpp"
#include "host/core/base/names.hpp"
#include "host/core/scene/occluders.hpp"
#include "host/core/scene/particle_order.hpp"
#include "io/base/file.hpp"
#include "io/base/json_reader.hpp"
#include "io/base/output.hpp"
#include "io/log/log_json.hpp"
#include "io/scene/scene_parts.hpp"
#include "io/scene/splat_scene.hpp"
#include "io/splat/ply.hpp"
#include "io/splat/splat_file.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSceneFormat = "simuli scene";
constexpr int kSceneVersion = 1;
constexpr int kSceneVersionOfShapes = 2;          // has non-rigid actors
constexpr int kSceneVersionOfOccluders = 3;       // has disoccluded and inpainted Gaussians
constexpr int kSceneVersionOfVisibilitySets = 4;  // has visibility sets of chunks
constexpr int kSceneVersionOfHidden = 5;          // has actors that hide parts of visibility sets
constexpr int kSceneVersionOfWidth = 6;           // has a camera filter other than that of 3DGS
constexpr const char* kFilterKey = "camera_filter_px2";
constexpr double kWidestFilter_px2 = 100.0;
constexpr const char* kSceneName = "scene.json";
constexpr const char* kCameraName = "camera.ply";
constexpr const char* kLidarName = "lidar.ply";

/// Entry of a set of Gaussians in scene.json.
struct SetEntry {
  std::int64_t gaussians = 0;
  int sh_degree = 0;
  std::array<float, 3> background{};
};

Json set_to_json(const GaussianSet& set, const std::array<float, 3>& background) {
  return {{"gaussians", set.size()}, {"sh_degree", set.sh_degree}, {"background", background}};
}

SetEntry read_set(JsonObject& object) {
  SetEntry entry;
  entry.gaussians = object.integer("gaussians", 0);
  entry.sh_degree = static_cast<int>(object.integer("sh_degree", 0, 3));
  const Eigen::Vector3d background = object.vector<3>("background");
  constexpr double kLargest = std::numeric_limits<float>::max();
  if (!(background.cwiseAbs().maxCoeff() <= kLargest)) {
    throw_input_error(
        object.file(), object.field("background"), "a number beyond float", "numbers in its range");
  }
  for (std::size_t i = 0; i < 3; ++i) {
    entry.background[i] = static_cast<float>(background[static_cast<Eigen::Index>(i)]);
  }
  return entry;
}

Json to_json(const std::vector<RayDrop>& all) {
  Json out = Json::array();
  for (const RayDrop& drop : all) {
    out.push_back({{"lidar", drop.lidar}, {"parameters", drop.parameters}});
  }
  return out;
}

RayDrop read_ray_drop(JsonObject& object) {
  RayDrop drop;
  drop.lidar = object.text("lidar");
  const auto parameters = object.vector<static_cast<int>(RayDrop::kParameters)>("parameters");
  std::copy(parameters.begin(), parameters.end(), drop.parameters.begin());
  return drop;
}

Json to_json(const std::vector<VisibilitySet>& all) {
  Json out = Json::array();
  for (const VisibilitySet& visibility_set : all) {
    Json path = Json::array();
    for (const Eigen::Vector3d& place : visibility_set.path_m) {
      for (const double x : place) path.push_back(x);
    }
    out.push_back({{"path_m", std::move(path)}});
    if (!visibility_set.occluders.empty()) out.back()["occluders"] = to_json(visibility_set.occluders, 0);
  }
  return out;
}

VisibilitySet read_visibility_set(JsonObject& object) {
  const std::vector<double> numbers = object.numbers("path_m");
  if (numbers.empty() || numbers.size() % 3 != 0) {
    throw_input_error(object.file(),
                      object.field("path_m"),
                      fmt::format("{} numbers", numbers.size()),
                      "x, y, z of one place or more, one after the other");
  }
  VisibilitySet visibility_set;
  for (std::size_t i = 0; i < numbers.size(); i += 3) {
    visibility_set.path_m.emplace_back(numbers[i], numbers[i + 1], numbers[i + 2]);
  }
  if (object.has("occluders")) visibility_set.occluders = actors_from_json(object, "occluders", 0);
  return visibility_set;
}

Json to_json(const FrameSpans& recorded) {
  Json out = Json::array();
  for (const auto& [sensor, spans] : recorded) {
    Json frames = Json::array();
    for (const FrameSpan& span : spans) frames.push_back(to_json(span, 0, "recorded_frames of " + sensor));
    out.push_back({{"sensor", sensor}, {"frames", std::move(frames)}});
  }
  return out;
}

FrameSpans read_recorded_frames(JsonObject& root, const SceneFile& scene) {
  FrameSpans recorded;
  (void)root.objects("recorded_frames", [&](JsonObject& object) {
    const std::string sensor = object.text("sensor");
    if (scene.find_camera(sensor) == nullptr && scene.find_lidar(sensor) == nullptr) {
      throw_input_error(object.file(), object.field("sensor"), '"' + sensor + '"', "a sensor of the scene");
    }
    const auto [entry, is_new] = recorded.try_emplace(sensor);
    if (!is_new) {
      throw_input_error(object.file(), object.field("sensor"), '"' + sensor + "\" twice", "once per sensor");
    }
    entry->second =
        object.objects("frames", [](JsonObject& frame) { return frame_span_from_json(frame, 0); });
    need_time_order(entry->second, object.file(), object.field("frames"));
    if (entry->second.empty()) {
      throw_input_error(
          object.file(), object.field("frames"), "none", "at least one, or no such sensor here");
    }
    return 0;
  });
  return recorded;
}

struct Contents {
  SceneFile scene;  // without the Gaussians
  SetEntry camera_set;
  SetEntry lidar_set;
  std::shared_ptr<SupportRecord> support;  // without cells
};

Contents parse_scene(const std::string& text, const std::string& file) {
  Contents contents;
  read_json_text(text, file, [&](JsonObject& root) {
    const std::string format = root.text("format");
    if (format != kSceneFormat) {
      throw_input_error(file, "format", '"' + format + '"', fmt::format("\"{}\"", kSceneFormat));
    }
    (void)root.integer("version", kSceneVersion, kSceneVersionOfWidth);
    SceneFile& scene = contents.scene;
    scene.scene.name = root.text("name");
    if (!scene.scene.name.empty()) need_name(scene.scene.name, file, "name");
    scene.scene.origin = root.vector<3>("origin_m");
    if (const double far_m = scene.scene.origin.cwiseAbs().maxCoeff(); far_m > kFarthestPosition_m) {
      throw_input_error(
          file, "origin_m", fmt::format("{} m", far_m), fmt::format("up to {} m", kFarthestPosition_m));
    }
    contents.camera_set = root.object("camera_set", read_set);
    contents.lidar_set = root.object("lidar_set", read_set);
    scene.scene.camera_background = contents.camera_set.background;
    scene.scene.lidar_background = contents.lidar_set.background;
    scene.scene.camera_filter_px2 =
        root.has(kFilterKey) ? root.number(kFilterKey, 0.0, kWidestFilter_px2) : kSplatVariance_px2;
    read_appearance(root, scene.scene);
    read_sensors(root, scene.cameras, scene.lidars);
    if (root.has("ray_drop")) scene.scene.ray_drop = root.objects("ray_drop", read_ray_drop);
    if (root.has("actors")) scene.scene.actors = actors_from_json(root, "actors", 0);
    if (root.has("vistas")) scene.scene.visibility_sets = root.objects("vistas", read_visibility_set);
    if (root.has("occluders")) scene.scene.occluders = actors_from_json(root, "occluders", 0);
    if (root.has("world_from_rig")) scene.world_from_rig = trajectory_from_json(root, "world_from_rig", 0);
    if (root.has("recorded_frames")) scene.recorded_frames = read_recorded_frames(root, scene);
    if (root.has("training")) scene.training = root.object("training", training_from_json);
    contents.support = read_support(root);
  });
  return contents;
}

/// Returns the lowest version that describes the scene, so that older programs can read it if possible.
int version_of(const Scene& scene) {
  if (scene.camera_filter_px2 != kSplatVariance_px2) return kSceneVersionOfWidth;
  const auto hides = [](const VisibilitySet& visibility_set) { return !visibility_set.occluders.empty(); };
  if (std::any_of(scene.visibility_sets.begin(), scene.visibility_sets.end(), hides))
    return kSceneVersionOfHidden;
  if (!scene.visibility_sets.empty()) return kSceneVersionOfVisibilitySets;
  if (!scene.occluders.empty()) return kSceneVersionOfOccluders;
  const bool shapes = std::any_of(scene.actors.begin(), scene.actors.end(), [](const Actor& actor) {
    return !actor.deformation.empty();
  });
  return shapes ? kSceneVersionOfShapes : kSceneVersion;
}

std::string to_text(const SceneFile& scene, const std::string& file) {
  const Eigen::Vector3d& origin = scene.scene.origin;
  Json root{{"format", kSceneFormat},
            {"version", version_of(scene.scene)},
            {"name", scene.scene.name},
            {"origin_m", {origin.x(), origin.y(), origin.z()}},
            {"camera_set", set_to_json(scene.scene.camera, scene.scene.camera_background)},
            {"lidar_set", set_to_json(scene.scene.lidar, scene.scene.lidar_background)}};
  if (scene.scene.camera_filter_px2 != kSplatVariance_px2) {
    root[kFilterKey] = scene.scene.camera_filter_px2;
  }
  add_appearance(root, scene.scene);
  if (!scene.scene.ray_drop.empty()) root["ray_drop"] = to_json(scene.scene.ray_drop);
  if (scene.training) root["training"] = to_json(*scene.training);
  add_sensors(root, scene.cameras, scene.lidars);
  if (!scene.world_from_rig.poses().empty()) root["world_from_rig"] = to_json(scene.world_from_rig, 0);
  if (!scene.recorded_frames.empty()) root["recorded_frames"] = to_json(scene.recorded_frames);
  if (!scene.scene.actors.empty()) root["actors"] = to_json(scene.scene.actors, 0);
  if (!scene.scene.visibility_sets.empty()) root["vistas"] = to_json(scene.scene.visibility_sets);
  if (!scene.scene.occluders.empty()) root["occluders"] = to_json(scene.scene.occluders, 0);
  add_support(root, scene.support.get());
  try {
    return root.dump(1) + '\n';
  } catch (const Json::exception& error) {
    throw_input_error(file, "JSON", error.what(), "names in UTF-8");
  }
}

/// Reads a set and checks that it agrees with scene.json.
GaussianSet read_set_file(const fs::path& file, SetKind kind, const SetEntry& entry) {
  GaussianSet set = read_gaussians_ply(file, kind);
  if (set.size() != entry.gaussians) {
    throw_input_error(file.string(),
                      "count",
                      fmt::format("{} Gaussians", set.size()),
                      fmt::format("{}, as {} says", entry.gaussians, kSceneName));
  }
  if (set.sh_degree != entry.sh_degree) {
    throw_input_error(file.string(),
                      "SH degree",
                      fmt::format("{}", set.sh_degree),
                      fmt::format("{}, as {} says", entry.sh_degree, kSceneName));
  }
  return set;
}

/// Checks that every particle's actor exists in the scene.
void check_actors(const GaussianSet& set, const Scene& scene, const fs::path& file) {
  for (std::size_t v = 0; v < set.actor.size(); ++v) {
    if (set.actor[v] <= most_numbers(scene)) continue;
    throw_input_error(file.string(),
                      fmt::format("vertex {}: actor", v),
                      fmt::format("{}", set.actor[v]),
                      fmt::format("0 to {}, as many as there are actors", most_numbers(scene)));
  }
}

void check_kinds(const Scene& scene, const fs::path& folder) {
  if (scene.camera.kind != SetKind::kCamera) {
    throw_input_error((folder / kCameraName).string(), "kind", "a LiDAR set", "a camera set");
  }
  if (scene.lidar.kind != SetKind::kLidar) {
    throw_input_error((folder / kLidarName).string(), "kind", "a camera set", "a LiDAR set");
  }
}

bool is_scene_file(const std::string& name) {
  return name == kSceneName || name == kCameraName || name == kLidarName || is_appearance_file(name) ||
         is_support_file(name);
}

}  // namespace

void need_scene_output(const fs::path& folder) { need_replaceable(folder, is_scene_file); }

const LogCamera* SceneFile::find_camera(const std::string& name) const {
  const auto found =
      std::find_if(cameras.begin(), cameras.end(), [&](const LogCamera& c) { return c.model.name == name; });
  return found == cameras.end() ? nullptr : &*found;
}

const LogLidar* SceneFile::find_lidar(const std::string& name) const {
  const auto found =
      std::find_if(lidars.begin(), lidars.end(), [&](const LogLidar& l) { return name_of(l.model) == name; });
  return found == lidars.end() ? nullptr : &*found;
}

namespace {

SceneFile in_order(SceneFile file) {
  file.scene = in_coherent_order(std::move(file.scene));
  return file;
}

}  // namespace

void aim_color_grids(SceneFile& file) {
  ColorGrids& grids = file.scene.color_grids;
  const Trajectory& path = file.world_from_rig;
  grids.cameras.clear();
  grids.looks.clear();
  std::vector<Eigen::Quaterniond> looks;
  for (const ColorGrids::Frame& frame : grids.frames) {
    const LogCamera* camera = file.find_camera(frame.camera);
    if (camera == nullptr || !path.covers(frame.time_s)) return;
    looks.push_back((path.at(frame.time_s) * camera->rig_from_camera).rotation);
  }
  grids.looks = std::move(looks);
  for (const LogCamera& camera : file.cameras) grids.cameras.push_back(camera.model);
}

SceneFile read_scene(const fs::path& folder) {
  if (is_splat_file(folder)) return in_order(scene_of_splats(folder));
  std::error_code ignored;
  if (fs::is_regular_file(folder, ignored)) {
    throw_input_error(folder.string(), "scene", "a file", "a scene's folder, or splats: .ply, .spz, .glb");
  }
  if (!is_there(folder / kSceneName) && is_there(folder / "log.json")) {
    throw_input_error(folder.string(), "scene", "a log", "a scene's folder: simuli train LOG -o SCENE");
  }
  const auto own = [&](const char* name) { return inside(folder, name, folder.string(), "file"); };
  const fs::path file = own(kSceneName);
  Contents contents = parse_scene(read_file(file), file.string());
  Scene& scene = contents.scene.scene;
  scene.camera = read_set_file(own(kCameraName), SetKind::kCamera, contents.camera_set);
  scene.lidar = read_set_file(own(kLidarName), SetKind::kLidar, contents.lidar_set);
  read_appearance_files(folder, scene);
  aim_color_grids(contents.scene);
  if (contents.support) read_support_cells(folder, *contents.support);
  check_actors(scene.camera, scene, folder / kCameraName);
  check_actors(scene.lidar, scene, folder / kLidarName);
  scene = in_coherent_order(std::move(scene));
  contents.scene.support = std::move(contents.support);
  return std::move(contents.scene);
}

void write_scene(const fs::path& folder, const SceneFile& scene) {
  const fs::path file = folder / kSceneName;
  check_kinds(scene.scene, folder);
  const std::string text = to_text(scene, file.string());
  validate(scene.scene.camera, (folder / kCameraName).string());
  validate(scene.scene.lidar, (folder / kLidarName).string());
  check_actors(scene.scene.camera, scene.scene, folder / kCameraName);
  check_actors(scene.scene.lidar, scene.scene, folder / kLidarName);
  (void)parse_scene(text, file.string());  // refuses NaN, repeated names, impossible sensors
  replace_folder_atomically(folder, is_scene_file, [&](const fs::path& beside) {
    write_gaussians_ply(beside / kCameraName, scene.scene.camera);
    write_gaussians_ply(beside / kLidarName, scene.scene.lidar);
    write_appearance(beside, scene.scene);
    write_support_cells(beside, scene.support.get());
    write_file_atomically(beside / kSceneName, text);
  });
}

void rewrite_scene_json(const fs::path& folder, const SceneFile& scene) {
  const fs::path file = folder / kSceneName;
  const std::string text = to_text(scene, file.string());
  (void)parse_scene(text, file.string());
  write_file_atomically(file, text);
}

SceneOutput::SceneOutput(const std::filesystem::path& folder, bool overwrite)
    : lock_(std::make_unique<OutputLock>(folder)) {
  if (!overwrite) need_new_path(folder);
  need_scene_output(folder);
}

SceneOutput::~SceneOutput() = default;

}  // namespace simuli
