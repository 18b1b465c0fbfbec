#include "host/apps/serve/session/served_scene.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <set>
#include <utility>

#include "host/apps/serve/session/refusal.hpp"
#include "host/core/base/error.hpp"

namespace simuli::serve {
namespace {

/// Limit of cached sensors by client-defined names (modes of built-in LiDARs).
constexpr std::size_t kMostLidars = 16;

}  // namespace

std::vector<SceneSource> scene_sources(const std::vector<std::string>& arguments) {
  std::vector<SceneSource> sources;
  std::set<std::string> names;
  for (const std::string& argument : arguments) {
    const std::size_t equals = argument.find('=');
    const bool is_named = equals != std::string::npos && argument.find('/') > equals;
    SceneSource source{is_named ? argument.substr(0, equals) : scene_id_of(argument),
                       is_named ? argument.substr(equals + 1) : argument};
    if (source.id.empty() || source.path.empty()) {
      throw Error(ErrorKind::kUsage,
                  fmt::format("SCENE: found \"{}\", allowed a path, or ID=PATH", argument));
    }
    if (!names.insert(source.id).second) {
      throw Error(
          ErrorKind::kUsage,
          fmt::format("SCENE: found two named \"{}\", allowed names of their own: ID=PATH", source.id));
    }
    sources.push_back(std::move(source));
  }
  if (sources.empty()) throw Error(ErrorKind::kUsage, "SCENE: found none, allowed one at least");
  return sources;
}

ServedScene::ServedScene(const SceneSource& source) : id_(source.id) {
  SceneFile file = read_scene(source.path);
  notes_ = file.splats.notes();
  rig_ = SensorRig(file);
  rig_.refuse_files();
  for (const LogCamera& camera : file.cameras) cameras_.push_back(rig_.find(camera.model.name));
  world_from_rig_ = std::move(file.world_from_rig);
  clock_ = SceneClock(world_from_rig_);
  scene_ = std::make_shared<const Scene>(std::move(file.scene));
}

ServedScene::ServedScene(const ServedScene& base, std::shared_ptr<const Scene> scene)
    : id_(base.id_),
      rig_(base.rig_),
      cameras_(base.cameras_),
      world_from_rig_(base.world_from_rig_),
      scene_(std::move(scene)),
      clock_(base.clock_) {}

std::unique_ptr<ServedScene> ServedScene::edited(const SceneEdit& edit) const {
  auto scene = std::make_shared<Scene>(*scene_);
  edit.apply(*scene);
  std::unique_ptr<ServedScene> out(new ServedScene(*this, std::move(scene)));
  out->original_ = is_edited() ? original_ : scene_;
  out->external_ = external_;
  out->external_.insert(edit.external.begin(), edit.external.end());
  out->inserted_ = inserted_;
  out->inserted_.insert(edit.inserted.begin(), edit.inserted.end());
  return out;
}

std::unique_ptr<ServedScene> ServedScene::restored() const {
  return std::unique_ptr<ServedScene>(new ServedScene(*this, is_edited() ? original_ : scene_));
}

const Sensor* ServedScene::find_camera(const std::string& name) const {
  const auto found =
      std::find_if(cameras_.begin(), cameras_.end(), [&](const Sensor& s) { return s.name() == name; });
  return found == cameras_.end() ? nullptr : &*found;
}

Sensor ServedScene::lidar(const std::string& name) const {
  const std::lock_guard lock(lidars_mutex_);
  if (const auto kept = lidars_.find(name); kept != lidars_.end()) return kept->second;
  const auto found = [&] {
    try {
      return rig_.find(name, Pose{});
    } catch (const Error& error) {
      throw Refusal(RefusalKind::kNotFound, error.what());
    }
  }();
  if (found.is_camera()) {
    throw Refusal(RefusalKind::kNotFound,
                  fmt::format("sensor: found \"{}\", a camera, allowed a LiDAR", name));
  }
  if (lidars_.size() == kMostLidars) lidars_.clear();
  return lidars_.emplace(name, found).first->second;
}

double ServedScene::seconds(std::uint64_t time_us, const std::string& field) const {
  constexpr std::uint64_t kLatest_us = std::uint64_t{1} << 52U;  // exact in a double
  const auto refuse_time = [&](const std::string& allowed) {
    throw Refusal(RefusalKind::kOutOfRange,
                  fmt::format("{}: found {} us, allowed {}", field, time_us, allowed));
  };
  if (time_us > kLatest_us) refuse_time(fmt::format("at most {}", kLatest_us));
  const double time_s = clock_.seconds(time_us);
  if (world_from_rig_.poses().empty()) return time_s;
  if (!world_from_rig_.covers(time_s)) {
    refuse_time(fmt::format("{} to {} us, give or take {} s",
                            microseconds(world_from_rig_.start_s()),
                            microseconds(world_from_rig_.end_s()),
                            Trajectory::kExtrapolation_s));
  }
  return time_s;
}

Pose ServedScene::local(Pose world) const {
  world.translation -= scene_->origin;
  return world;
}

Pose ServedScene::world(Pose local) const {
  local.translation += scene_->origin;
  return local;
}

}  // namespace simuli::serve
