#include "host/apps/cli/view/view_parts.hpp"

#include <cstdint>
#include <utility>

#include "optim/init/initialize_views.hpp"

namespace simuli::cli {
namespace {

/// Returns 1 + the index of the first actor whose box contains the point at that share of the frame; 0: none.
std::size_t actor_at(const Eigen::Vector3d& point,
                     const std::vector<Actor>& actors,
                     const std::vector<ActorView>& views,
                     float share) {
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!views[i].is_there) continue;
    const Pose scene_from_actor =
        interpolate(views[i].scene_from_actor_start, views[i].scene_from_actor_end, share);
    const Eigen::Vector3d inside = scene_from_actor.inverse() * point;
    if ((inside.cwiseAbs().array() <= 0.5 * actors[i].size_m.array()).all()) return i + 1;
  }
  return 0;
}

/// Returns directions around the picture's edge where the lens has rays.
Json outline_of(const Camera& camera) {
  constexpr int kSteps = 8;  // points per side, because distortion bends edges
  Json out = Json::array();
  for (int i = 0; i < 4 * kSteps; ++i) {
    const double at = static_cast<double>(i % kSteps) / kSteps;
    const Eigen::Vector2d corners[] = {{at, 0.0}, {1.0, at}, {1.0 - at, 1.0}, {0.0, 1.0 - at}};
    const Eigen::Vector2d share = corners[i / kSteps];
    const Eigen::Vector3d ray = camera.unproject({share.x() * camera.width, share.y() * camera.height});
    if (!ray.isZero()) out.push_back(json_of(ray));
  }
  return out;
}

}  // namespace

Json json_of(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
Json json_of(const Pose& pose) {
  const Eigen::Quaterniond& q = pose.rotation;
  return {{"t", json_of(pose.translation)}, {"q", {q.w(), q.x(), q.y(), q.z()}}};
}

std::string reply(const Json& info, const void* payload, std::size_t bytes) {
  const std::string text = info.dump();
  const auto length = static_cast<std::uint32_t>(text.size());
  std::string out;
  for (unsigned shift = 0; shift < 32; shift += 8) out += static_cast<char>(length >> shift & 0xFFU);
  out += text;
  out.resize((out.size() + 3) / 4 * 4, '\0');
  out.append(static_cast<const char*>(payload), bytes);
  return out;
}

Json json_of_drive(const std::vector<LogCamera>& cameras,
                   const std::vector<LogLidar>& lidars,
                   const Trajectory& world_from_rig,
                   const FrameSpans& frames,
                   const Eigen::Vector3d& origin) {
  Json out = {{"cameras", Json::array()},
              {"lidars", Json::array()},
              {"frames", Json::object()},
              {"mountings", Json::object()},
              {"poses", Json::array()},
              {"time_start_s", world_from_rig.start_s()},
              {"time_end_s", world_from_rig.end_s()}};
  for (const LogCamera& c : cameras) {
    out["cameras"].push_back(c.model.name);
    out["mountings"][c.model.name] = {{"rig_from_camera", json_of(c.rig_from_camera)},
                                      {"outline", outline_of(c.model)}};
  }
  for (const LogLidar& l : lidars) out["lidars"].push_back(name_of(l.model));
  for (const auto& [name, spans] : frames) {
    Json& times = out["frames"][name] = Json::array();
    for (const FrameSpan& span : spans) times.push_back({span.time_start_s, span.time_end_s});
  }
  for (const TimedPose& p : world_from_rig.poses()) {
    Json pose = json_of(Pose{p.pose.rotation, p.pose.translation - origin});
    pose["time_s"] = p.time_s;
    out["poses"].push_back(std::move(pose));
  }
  return out;
}

Json json_of_actors(const std::vector<Actor>& actors) {
  Json out = Json::array();
  for (const Actor& a : actors) {
    out.push_back({{"name", a.name}, {"kind", a.kind}, {"size_m", json_of(a.size_m)}});
  }
  return out;
}

Json json_of_boxes(const std::vector<Actor>& actors, const std::vector<ActorView>& views) {
  Json out = Json::array();
  for (std::size_t i = 0; i < views.size(); ++i) {
    Json entry = json_of(views[i].scene_from_actor_start);
    entry["name"] = actors[i].name;
    entry["size"] = json_of(actors[i].size_m);
    entry["is_there"] = views[i].is_there;
    out.push_back(std::move(entry));
  }
  return out;
}

Json json_of_outlines(const Camera& camera,
                      const Shot& in_scene,
                      const std::vector<Actor>& actors,
                      const std::vector<ActorView>& views) {
  constexpr int kPieces = 24;  // points per edge, because lenses bend it and it may leave the picture
  const ImageView view(camera, in_scene.world_from_sensor_start, in_scene.world_from_sensor_end);
  Json out = Json::array();
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!views[i].is_there) continue;
    const Pose scene_from_actor =
        interpolate(views[i].scene_from_actor_start, views[i].scene_from_actor_end, 0.5);
    Json lines = Json::array();
    for (int edge = 0; edge < 12; ++edge) {
      const int along = edge / 4;
      Eigen::Vector3d at;
      at[(along + 1) % 3] = edge % 2 == 0 ? -0.5 : 0.5;
      at[(along + 2) % 3] = edge % 4 < 2 ? -0.5 : 0.5;
      Json line = Json::array();
      for (int k = 0; k <= kPieces; ++k) {
        at[along] = static_cast<double>(k) / kPieces - 0.5;
        Eigen::Vector2d pixel;
        double range_m = 0.0;
        if (view.project(scene_from_actor * at.cwiseProduct(actors[i].size_m), pixel, range_m)) {
          line.push_back(pixel.x() / camera.width);
          line.push_back(pixel.y() / camera.height);
        } else if (!line.empty()) {
          lines.push_back(std::exchange(line, Json::array()));
        }
      }
      if (!line.empty()) lines.push_back(std::move(line));
    }
    if (!lines.empty()) out.push_back({{"name", actors[i].name}, {"lines", std::move(lines)}});
  }
  return out;
}

void append_points(const LidarModel& lidar,
                   const LidarFrame& frame,
                   const Shot& in_scene,
                   const std::vector<Actor>& actors,
                   const std::vector<ActorView>& views,
                   std::size_t every,
                   std::vector<float>& points) {
  const std::vector<Eigen::Vector3d> ends = points_of(lidar, frame, in_scene, PointFrame::kWorld);
  const auto columns = static_cast<std::size_t>(frame.rays.columns);  // of a ray list: all
  for (std::size_t i = 0, returns = 0; i < ends.size(); ++i) {
    if (!frame.is_return(i) || returns++ % every != 0) continue;
    for (const double value : ends[i]) points.push_back(static_cast<float>(value));
    const float share = frame.rays.time_fraction[i];
    points.push_back(frame.intensity[i]);
    points.push_back(static_cast<float>(i / columns));
    points.push_back(share);
    points.push_back(static_cast<float>(actor_at(ends[i], actors, views, share)));
  }
}

std::vector<float> seen_points(const Camera& camera, const Shot& in_scene, const std::vector<float>& points) {
  const ImageView view(camera, in_scene.world_from_sensor_start, in_scene.world_from_sensor_end);
  std::vector<float> out;
  for (auto p = points.begin(); p != points.end(); p += kPointValues) {
    Eigen::Vector2d pixel;
    double range_m = 0.0;
    if (!view.project(Eigen::Vector3d(p[0], p[1], p[2]), pixel, range_m)) continue;
    out.insert(out.end(), p, p + kPointValues);
    out.push_back(static_cast<float>(pixel.x() / camera.width));
    out.push_back(static_cast<float>(pixel.y() / camera.height));
  }
  return out;
}

std::string with_points(const std::vector<float>& points, const std::string& picture) {
  return std::string(reinterpret_cast<const char*>(points.data()), points.size() * sizeof(float)) + picture;
}

}  // namespace simuli::cli
