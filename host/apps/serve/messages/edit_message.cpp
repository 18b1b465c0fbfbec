#include "host/apps/serve/messages/edit_message.hpp"

#include <cmath>
#include <fmt/format.h>
#include <optional>
#include <utility>

#include "host/apps/serve/messages/shot_message.hpp"
#include "host/apps/serve/session/refusal.hpp"
#include "host/core/base/close_names.hpp"
#include "host/core/base/names.hpp"
#include "host/core/base/one_line.hpp"
#include "host/core/scene/edit.hpp"

namespace simuli::serve {
namespace {

constexpr int kMostEdits = 256;  // per request

std::int64_t particles_of(const Scene& scene) {
  return static_cast<std::int64_t>(scene.camera.size()) + static_cast<std::int64_t>(scene.lidar.size());
}

const Actor& actor_of(const Scene& scene, const std::string& name, const std::string& field) {
  if (has_actor(scene.actors, name)) return scene.actors[find_actor(scene.actors, name)];
  std::vector<std::string> known;
  for (const Actor& actor : scene.actors) known.push_back(actor.name);
  refuse(
      field,
      fmt::format("\"{}\"", name),
      fmt::format("{}one of the {} that get_dynamic_objects lists", did_you_mean(name, known), known.size()));
}

/// Returns the size factor relative to `of`; 1 without a size. All sides must have the same factor, within
/// single precision and the centimetres of labels.
double factor_of(const proto_common::AABB& size, const Actor& of, const std::string& field) {
  constexpr double kTolerance = 0.01;
  const Eigen::Vector3d sides(size.size_x(), size.size_y(), size.size_z());
  if (sides.isZero(0.0)) return 1.0;
  const Eigen::Array3d factors = sides.array() / of.size_m.array();
  const double mean = factors.mean();
  if (!(factors > 0.0).all() || !std::isfinite(mean) || !((factors / mean - 1.0).abs() <= kTolerance).all()) {
    refuse(field,
           fmt::format("{} x {} x {} m", sides.x(), sides.y(), sides.z()),
           fmt::format("none, or the {:.3f} x {:.3f} x {:.3f} m of \"{}\" times one factor",
                       of.size_m.x(),
                       of.size_m.y(),
                       of.size_m.z(),
                       of.name));
  }
  return mean;
}

std::vector<KeyPose> track_of(const ServedScene& scene,
                              const proto_common::Trajectory& trajectory,
                              const std::string& field) {
  std::vector<KeyPose> track;
  for (int i = 0; i < trajectory.poses_size(); ++i) {
    const proto_common::PoseAtTime& pose = trajectory.poses(i);
    const std::string name = fmt::format("{}.poses {}", field, i);
    const double time_s = scene.seconds(pose.timestamp_us(), name + ".timestamp_us");
    if (!track.empty() && time_s <= track.back().time_s) {
      refuse(
          name + ".timestamp_us", fmt::format("{}", pose.timestamp_us()), "later ones behind earlier ones");
    }
    track.push_back({time_s, scene.world(pose_of(pose.pose(), name + ".pose"))});
  }
  return track;
}

void replace(Scene& scene, const proto::ReplaceAssetAction& action, const std::string& field) {
  const Actor original = actor_of(scene, action.original_id(), field + ".original_id");
  const Actor other = actor_of(scene, action.replacement_id(), field + ".replacement_id");
  if (original.name == other.name) {
    refuse(field + ".replacement_id", fmt::format("\"{}\" for itself", other.name), "another actor");
  }
  const double factor = factor_of(action.object_size(), other, field + ".object_size");
  remove_actor(scene, original.name);
  duplicate_actor(scene, other.name, original.name);
  retrack_actor(scene, original.name, original.track);
  // Tracks refer to the boxes' centres, and both actors touch the ground.
  move_actor(scene, original.name, {0.0, 0.0, 0.5 * (other.size_m.z() - original.size_m.z())});
  if (factor != 1.0) resize_actor(scene, original.name, factor);
}

void insert(Scene& scene,
            const proto::DynamicObjectTrack& object,
            const std::vector<KeyPose>& track,
            const std::string& field) {
  const Actor asset = actor_of(scene, object.asset_id(), field + ".asset_id");
  need_name(object.id(), "edit_assets", field + ".id");
  if (has_actor(scene.actors, object.id())) {
    refuse(field + ".id", fmt::format("\"{}\"", object.id()), "a name that no actor has");
  }
  const double factor = factor_of(object.object_size(), asset, field + ".object_size");
  duplicate_actor(scene, asset.name, object.id());
  if (factor != 1.0) resize_actor(scene, object.id(), factor);
  if (!track.empty()) retrack_actor(scene, object.id(), track);
  if (!object.semantic_class().empty()) scene.actors.back().kind = on_one_line(object.semantic_class());
}

}  // namespace

SceneEdit edit_of(const ServedScene& scene, const proto::EditAssetsRequest& request, std::int64_t most_more) {
  const int count = request.replace_size() + request.insert_size();
  if (count > kMostEdits) {
    refuse("replace, insert", fmt::format("{} edits", count), fmt::format("at most {}", kMostEdits));
  }
  SceneEdit edit;
  std::vector<std::vector<KeyPose>> tracks;
  for (const proto::ReplaceAssetAction& action : request.replace())
    edit.external.push_back(action.original_id());
  for (int i = 0; i < request.insert_size(); ++i) {
    const proto::DynamicObjectTrack& object = request.insert(i);
    edit.external.push_back(object.id());
    edit.inserted.push_back(object.id());
    tracks.push_back(track_of(scene, object.trajectory(), fmt::format("insert {}.trajectory", i)));
  }
  const std::int64_t most = particles_of(scene.original()) * 2 + most_more;
  proto::EditAssetsRequest actions = request;  // only the required parts
  actions.DiscardUnknownFields();
  for (proto::DynamicObjectTrack& object : *actions.mutable_insert()) object.clear_trajectory();
  edit.bytes = actions.SpaceUsedLong();
  for (const std::vector<KeyPose>& track : tracks) edit.bytes += track.size() * sizeof(KeyPose);
  edit.apply = [request = std::move(actions), tracks = std::move(tracks), most](Scene& changed) {
    const auto need_room = [&] {
      if (particles_of(changed) <= most) return;
      throw Refusal(
          RefusalKind::kExhausted,
          fmt::format("insert: found {} particles in all, allowed {}", particles_of(changed), most));
    };
    for (int i = 0; i < request.replace_size(); ++i) {
      replace(changed, request.replace(i), fmt::format("replace {}", i));
      need_room();
    }
    for (int i = 0; i < request.insert_size(); ++i) {
      insert(changed, request.insert(i), tracks[static_cast<std::size_t>(i)], fmt::format("insert {}", i));
      need_room();
    }
  };
  return edit;
}

}  // namespace simuli::serve
